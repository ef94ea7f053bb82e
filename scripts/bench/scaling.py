"""Cost against contacts, with fitted exponents, memory, and what ends each ladder."""

import math

import pandas as pd

from bench import stats
from bench.chart import Chart, Panel, from_cells
from bench.paper import variants
from bench.section import Cell, Section, Table, interval, si

SIZES_MIN = 3  # of verified sizes, for an exponent
OWN = "scaling"
PANELS = 9  # of the figure


def ladders(cells: pd.DataFrame) -> list[tuple[str, str, pd.DataFrame]]:
    """[(family, combination, its cells)] of every ladder of sizes that was asked for and is defined
    somewhere."""
    some = cells[(cells["formulation"] != "") & ~cells["status"].isin(["unsupported", "skipped"])]
    return [
        (family, combo, g)
        for (family, combo), g in some.groupby(["problem_family", "combination"])
        if g["problem"].nunique() >= SIZES_MIN
    ]


def ends(g: pd.DataFrame) -> Cell:
    """Why the ladder ends: the smallest problem that was not solved, and how; nothing when all
    were."""
    bad = g[~g["good"]]
    if bad.empty:
        return Cell("all sizes verified", "good")
    top = g[g["good"]]["p"].max()
    first = bad.sort_values("p", na_position="last").iloc[0]
    at = f" at {first['p']:g}" if first["p"] == first["p"] else ""
    beyond = (
        "" if not top == top or not first["p"] <= top else f" (larger ones to {top:g} are solved)"
    )
    return Cell(
        f"{first['status']}{at}{beyond}", "bad", f"{first['problem']}: {first.get('note', '')}"
    )


def exponent(good: pd.DataFrame, column: str) -> tuple[float, float, float, float]:
    """Over the larger half of the sizes, or over all where that has too few for a fit."""
    fit = stats.fit_exponent(
        *good[good["p"] >= good["p"].median()][["p", column]].to_numpy(float).T
    )
    return stats.fit_exponent(*good[["p", column]].to_numpy(float).T) if math.isnan(fit[0]) else fit


def line(family: str, combo: str, g: pd.DataFrame) -> list[Cell | str]:
    good = g[g["good"]]
    fit, memory = exponent(good, "t_total_step_s"), exponent(good, "rss_peak_B")
    if good.empty:
        return [family, combo, "none", "", "", "", "", ends(g)]
    top = good.loc[good["p"].idxmax()]
    return [
        family,
        combo,
        f"{good['p'].min():g} to {top['p']:g}",
        Cell(interval(*fit[:3]) or "too few sizes", sort=fit[0] if fit[0] == fit[0] else None),
        Cell(si(top["t_total_step_s"], "s"), sort=top["t_total_step_s"]),
        Cell(si(top.get("rss_peak_B"), "B"), sort=top.get("rss_peak_B")),
        interval(*memory[:3]) if memory[0] == memory[0] else "",
        ends(g),
    ]


def section(cells: pd.DataFrame) -> Section:
    own = cells[cells["campaign"].str.startswith(OWN) & (cells["start"] != "previous")]
    cells = own if len(own) else cells
    table, lines = [], {}
    index = variants(cells)
    found = ladders(cells)
    for family, combo, g in found:
        table.append(line(family, combo, g))
        good = g[g["good"]]
        if good["p"].nunique() >= SIZES_MIN:
            lines.setdefault((family, g["solver"].iloc[0]), []).append(
                from_cells(
                    good.assign(ms=good["t_total_step_s"] * 1e3),
                    g[~g["good"]].assign(ms=g["t_total_step_s"] * 1e3),
                    "p",
                    "ms",
                    g["label"].iloc[0],
                    variant=index[g["label"].iloc[0]],
                )
            )
    if not table:
        return None
    panels = [
        Panel(
            each,
            title=f"{f.replace('_', ' ')}, {s}",
            xlabel="contacts",
            ylabel="time per step [ms]",
            xlog=10,
        )
        for (f, s), each in sorted(lines.items())
    ]
    shown = (
        f" The first {PANELS} of {len(panels)} panels; the table has all."
        if len(panels) > PANELS
        else ""
    )
    largest = max(
        (float(g[g["good"]]["p"].max()) for _, _, g in found if g["good"].any()), default=math.nan
    )
    return Section(
        "scaling",
        "Cost against contacts",
        f"To {largest:g} contacts in these rows. Exponents b of time per step = a p^b over the"
        f" larger half of the verified sizes (over all where the half has fewer than {SIZES_MIN}),"
        " with 95 % bootstrap intervals; memory is the peak of the whole process, some megabytes"
        " of which are there before it begins.",
        (
            [
                Chart(
                    "scaling",
                    "Time per step against contacts; a cross is a size that was not solved."
                    + shown,
                    panels[:PANELS],
                    columns=3,
                    height=1.95,
                )
            ]
            if panels
            else []
        ),
        [
            Table(
                "scaling",
                "Fitted exponents, cost and memory at the largest verified size, and what ends the"
                " ladder.",
                [
                    "scene",
                    "combination",
                    "contacts",
                    "exponent of time",
                    "time per step at the largest",
                    "memory there",
                    "exponent of memory",
                    "ends",
                ],
                table,
            )
        ],
        {"ScalingLargest": f"{largest:g}"},
    )

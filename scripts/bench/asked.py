"""Error asked, error got, time: the section of the page about the rows of scripts/bench_error."""

from __future__ import annotations

import csv
import math
import pathlib
import statistics

from bench.chart import Chart, Line, Panel
from bench.section import Cell, Section, Table, error, si

FILE = "error/table.tsv"  # below the folder of the rows
NEAR = 1.5  # times the cheapest
FLOOR = 1e-8  # drawn, not computed: an exact answer has no place on a logarithmic axis
NUMBERS = (
    *("error", "sure", "promised", "err_estimate", "err_got"),
    *("t_chosen_s", "t_best_s", "t_even_s", "t_hand_s", "hand_got"),
    "t_checked_s",
)
Row = dict[str, str | float]


def read(path: pathlib.Path) -> list[Row]:
    """One row a scene and an error; ValueError: not the columns of scripts/bench_error."""
    with path.open(newline="", encoding="utf-8") as file:
        rows: list[Row] = list(csv.DictReader(file, delimiter="\t"))
    for row in rows:
        for name in NUMBERS:
            if name not in row:
                raise ValueError(f"{path}: no column {name}; measure again with bench_error")
            row[name] = float(row[name] or math.nan)
    return rows


def promised(rows: list[Row]) -> list[Row]:
    return [r for r in rows if r["promised"] == 1]


def got(rows: list[Row]) -> Panel:
    """One point a run, and the line on which error got is error asked."""
    some = [r for r in promised(rows) if math.isfinite(r["err_got"])]
    asked = sorted({r["error"] for r in rows})
    return Panel(
        [
            Line("asked", asked, asked, kind="front"),
            Line(
                "got",
                [r["error"] for r in some],
                [max(r["err_got"], FLOOR) for r in some],
                hover=[f"{r['problem']}: {r['chosen']}" for r in some],
                kind="points",
            ),
        ],
        title="error got",
        xlabel="error asked, over the scale of the scene",
        ylabel="error got, over that scale",
    )


def cost(rows: list[Row]) -> Panel:
    """All runs and trials together, over the best even steps, which are known afterwards only."""
    some = [r for r in promised(rows) if r["t_even_s"] > 0]
    asked = sorted({r["error"] for r in rows})
    return Panel(
        [
            Line("best even steps", asked, [1.0] * len(asked), kind="front"),
            Line(
                "chosen",
                [r["error"] for r in some],
                [r["t_chosen_s"] / r["t_even_s"] for r in some],
                hover=[f"{r['problem']}: {r['chosen']}" for r in some],
                kind="points",
            ),
        ],
        title="time",
        xlabel="error asked, over the scale of the scene",
        ylabel="time over that of the best even steps",
    )


def cheapest(r: Row) -> float:
    """Time [s] of the best even steps, or of the best combination that is given --error, if less;
    which of them it is only a search with the answer in hand finds. NaN: neither keeps it."""
    return min((t for t in (r["t_even_s"], r["t_best_s"]) if t > 0), default=math.nan)


def over(r: Row) -> float:
    return r["t_chosen_s"] / cheapest(r)


def times(ratio: float) -> str:
    return f"{ratio:.0f}" if ratio >= 10 else f"{ratio:.2g}"


def median_over(rows: list[Row], name: str) -> Cell:
    ratios = [r["t_chosen_s"] / r[name] for r in rows if r[name] > 0]
    return Cell(f"{statistics.median(ratios):.2g}" if ratios else "")


def by_error(rows: list[Row]) -> Table:
    """One row an error: what of its promises holds, and what they take."""
    body = []
    for asked in sorted({r["error"] for r in rows}, reverse=True):
        mine = [r for r in rows if r["error"] == asked]
        said = promised(mine)
        timed = [r for r in said if math.isfinite(over(r))]
        dearest = max(timed, key=over, default=None)
        body.append(
            [
                Cell(f"{asked:g}", sort=asked),
                f"{len(said)} of {len(mine)}",
                f"{sum(r['err_got'] <= asked for r in said)} of {len(said)}",
                median_over(said, "t_even_s"),
                median_over(said, "t_best_s"),
                f"{sum(over(r) <= NEAR for r in timed)} of {len(mine)}",
                median_over(said, "t_hand_s"),
                f"{sum(r['hand_got'] <= asked for r in said)} of {len(said)}",
                f"{dearest['problem']}: {times(over(dearest))}" if dearest else "",
            ]
        )
    head = ["asked", "promised", "kept", "over even steps", "over the best combination"]
    head += [f"within {NEAR}", "over halving by hand", "kept by hand", "dearest"]
    caption = (
        "By the error asked: times over those of the best even steps and of the best combination"
        f" with --error (medians), how many are within {NEAR} of the cheaper of the two, time over"
        " that of even steps halved by hand until two runs differ by at most E (median), how many"
        " of these keep it, and the dearest scene."
    )
    return Table("asked_by_error", caption, head, body, paper=False)


def table(rows: list[Row]) -> Table:
    body = [
        [
            r["problem"],
            Cell(f"{r['error']:g}", sort=r["error"]),
            r["chosen"],
            "yes" if r["promised"] == 1 else "no",
            Cell(error(r["err_got"]), sort=r["err_got"]) if math.isfinite(r["err_got"]) else "",
            Cell(si(r["t_chosen_s"], "s"), sort=r["t_chosen_s"]),
            Cell(si(r["t_even_s"], "s"), sort=r["t_even_s"]) if r["t_even_s"] > 0 else "",
        ]
        for r in rows
    ]
    head = ["scene", "asked", "chosen", "promised", "got", "time", "even steps"]
    return Table(
        "asked",
        "Error asked, error got, time, and that of the best even steps.",
        head,
        body,
        paper=False,
    )


def section(rows: list[Row]) -> Section | None:
    """The section of the page; None without rows."""
    if not rows:
        return None
    said = promised(rows)
    kept = [r for r in said if r["err_got"] <= r["error"]]
    ratios = [r["t_chosen_s"] / r["t_even_s"] for r in said if r["t_even_s"] > 0]
    near = sum(over(r) <= NEAR for r in said)
    dearest = max((over(r) for r in said if math.isfinite(over(r))), default=math.nan)
    hand = [r for r in said if r["t_hand_s"] > 0]
    missed = sum(not r["hand_got"] <= r["error"] for r in said)
    longer = statistics.median(r["t_hand_s"] / r["t_chosen_s"] for r in hand) if hand else 0.0
    told = sum(r["t_checked_s"] > 0 for r in said)
    by_hand = (
        " Somebody who does not know the answer may halve even steps until two runs differ by no"
        f" more than E: that takes {times(longer)}"
        f" times as long (median), and {missed} of {len(said)} miss E or come to no end."
        if hand
        else ""
    )
    dear = (
        f" A run takes {statistics.median(ratios):.2g} times (median) the time of the best even"
        f" steps, which only a search with the answer in hand finds. {near} are within {NEAR} times"
        f" the cheaper of these and of the best combination; the dearest takes {times(dearest)}"
        " times as long. Half as many of the best even steps beside them, which is one way to show"
        f" that these keep E, differ by no more than E in {told} of {len(said)}."
        if ratios
        else ""
    )
    drawn = Chart(
        "asked",
        "Error asked against error got, and the time of simulate --error E, which chooses"
        " formulation, solver and steps from rows of other scenes, all its runs and trials"
        " included, over that of the best even steps of the best combination.",
        [got(rows), cost(rows)],
        columns=2,
    )
    return Section(
        "asked",
        "Accuracy in, motion out",
        f"Of {len(rows)} runs {len(said)} promise the error asked for, and {len(kept)} of these"
        " keep it." + dear + by_hand,
        [drawn],
        [by_error(rows), table(rows)],
    )

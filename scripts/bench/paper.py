"""Charts of the `paper` campaign: how large, how long, how wrong, formulation against
formulation."""

import pandas as pd

from bench import registry, style
from bench.chart import Chart, Line, Panel, from_cells
from bench.section import Table, si

LADDER_MIN = 3  # sizes that make a ladder of contacts
FLOOR = 1e-16  # drawn, not computed: an exact answer has no place on a logarithmic axis


def own(cells: pd.DataFrame) -> pd.DataFrame:
    """The scenes of the campaign `paper`, cold."""
    some = cells[cells["campaign"].str.startswith("paper") & (cells["formulation"] != "")]
    return some[some["start"] != "previous"]  # a start is an axis; figures show one value of it


def variants(cells: pd.DataFrame) -> dict[str, int]:
    """label -> index among the variants of one formulation (different dashes and markers)."""
    seen, index = {}, {}
    for form, label in sorted(set(zip(cells["formulation"], cells["label"], strict=True))):
        index[label] = seen.get(form, 0)
        seen[form] = index[label] + 1
    return index


def ladder(cells: pd.DataFrame) -> pd.DataFrame:
    """The cells of the family with the most sizes; nothing when no family has LADDER_MIN of
    them."""
    some = cells[cells["p"] > 0]
    sizes = (
        some.groupby("problem_family")["p"].nunique().sort_values(ascending=False, kind="stable")
    )
    if sizes.empty or sizes.iloc[0] < LADDER_MIN:
        return some[:0]
    return some[some["problem_family"] == sizes.index[0]]


def solvers_of(cells: pd.DataFrame) -> list[str]:
    return registry.by_solver(set(cells["solver"]))


def dimension(cells: pd.DataFrame) -> Chart:
    cells = ladder(cells[cells["good"] & (cells["lcp_dim"] > 0)])
    if cells.empty:
        return None
    # settings that pose the same sizes share a name, formulations that do so a line
    base = cells["label"].str.partition(" (")[0]
    alike = cells.groupby([base, "p"])["lcp_dim"].nunique().groupby(level=0).max() == 1
    lines = {}
    for label, group in cells.groupby(base.where(base.map(alike), cells["label"])):
        lines.setdefault(tuple(group.groupby("p")["lcp_dim"].max().items()), []).append(label)
    out = []
    for points, labels in sorted(lines.items(), key=lambda kv: kv[0][-1]):
        per = sorted({round(b / a, 2) for a, b in points})
        factor = f"{per[0]:g} p" if len(per) == 1 else f"{per[0]:g} to {per[-1]:g} p"
        out.append(
            Line(
                " = ".join(labels),
                *map(list, zip(*points, strict=True)),
                look_as=labels[0],
                end_label=f"{merge(labels)}: {'p' if factor == '1 p' else factor}",
            )
        )
    family = cells["problem_family"].iloc[0]
    return Chart(
        "dimension",
        f"Unknowns of the complementarity problem against contacts p ({family}). "
        "Formulations that pose the same size share a line.",
        [
            Panel(
                out,
                xlabel="contacts p",
                ylabel="unknowns of the LCP",
                xlog=2,
                xticks=sorted(cells["p"].unique().tolist()),
            )
        ],
        width=style.COLUMN,
        height=2.3,
        end_labels=True,
    )


def merge(labels: list[str]) -> str:
    """['position, 4 facets', 'velocity, 4 facets'] -> 'position, velocity' over '4 facets'"""
    tails = sorted({label.partition(", ")[2] for label in labels})
    if len(tails) == 1:
        return "\n".join(
            filter(None, [", ".join(label.partition(", ")[0] for label in labels), tails[0]])
        )
    return "\n".join(labels)


def time_and_error(cells: pd.DataFrame) -> Chart:
    cells = ladder(cells)
    if cells.empty:
        return None
    cells = cells.assign(**{c: cells[c] * 1e3 for c in cells if c.startswith("t_solve_step_s")})
    index, panels = variants(cells), []
    solvers, every = solvers_of(cells)[:3], solvers_of(cells)
    shown = (
        "" if len(every) == len(solvers) else f" The first {len(solvers)} of {len(every)} solvers."
    )
    times = cells[cells["t_solve_step_s"] > 0]["t_solve_step_s"]
    for solver in solvers:
        here = cells[cells["solver"] == solver]
        panels.append(
            Panel(
                [
                    from_cells(
                        g[g["good"]],
                        g[~g["good"]],
                        "p",
                        "t_solve_step_s",
                        label,
                        variant=index[label],
                    )
                    for label, g in here.groupby("label")
                ],
                title=solver,
                xlabel="contacts",
                ylabel="solve time per step [ms]",
                xlog=2,
                xticks=sorted(cells["p"].unique().tolist()),
                ylim=(times.min() / 2, times.max() * 2),
            )
        )
    first = cells[cells["solver"] == solvers[0]]
    exact = not (
        first["err_ref"] > 0
    ).any()  # a scene at rest: what is left is rounding, against the tolerances of its predictions
    column, what = (
        ("err_worst", "worst error / its tolerance")
        if exact
        else ("err_ref", "error of the trajectory")
    )
    first = first[first[column].notna()].assign(drawn=first[column].clip(lower=FLOOR))
    panels.append(
        Panel(
            [
                from_cells(g[g["good"]], g[~g["good"]], "p", "drawn", label, variant=index[label])
                for label, g in first.groupby("label")
            ],
            title=f"error, {solvers[0]}",
            xlabel="contacts",
            ylabel=what,
            xlog=2,
            xticks=sorted(cells["p"].unique().tolist()),
        )
    )
    family = cells["problem_family"].iloc[0]
    return Chart(
        "time_and_error",
        "Solve time per step (median, 95 % interval) and error of the trajectory against contacts"
        f" ({family}). A cross is a run that was not solved or whose claim the judge did not"
        f" confirm. Errors below {FLOOR:g} are drawn there.{shown}",
        panels,
        columns=len(panels),
        height=2.1,
    )


def spread(cells: pd.DataFrame) -> str:
    """How far the formulations are apart at one step, in words: where their lines lie on each
    other."""
    good = cells[cells["good"]].groupby("step_s")["err_ref"]
    if good.max().max() < 1e-12:
        return "rounding only"
    ratio = float((good.max() / good.min()).max())
    if ratio < 1.0001:
        return "all alike"
    return f"within {100 * (ratio - 1):.2g} %" if ratio < 2 else f"within a factor {ratio:.2g}"


def error_against_step(cells: pd.DataFrame, most: int = 6) -> Chart | None:
    """One panel a scene, one line a formulation, over the steps that were run."""
    cells = cells[(cells["err_ref"] > 0) & (cells["step_s"] > 0)]
    counts = cells.groupby("problem_family")["step_s"].nunique()
    scenes = sorted(f for f in counts.index if counts[f] >= 2)
    if not scenes:
        return None
    index, panels = variants(cells), []
    shown = f" The first {most} of {len(scenes)} scenes." if len(scenes) > most else ""
    for scene in scenes[:most]:
        here = cells[cells["problem_family"] == scene].assign(step_ms=lambda c: c["step_s"] * 1e3)
        panels.append(
            Panel(
                [
                    from_cells(
                        g[g["good"]],
                        g[~g["good"]],
                        "step_ms",
                        "err_ref",
                        label,
                        variant=index[label],
                    )
                    for label, g in here.groupby("label")
                ],
                title=f"{scene.replace('_', ' ')} ({spread(here)})",
                xlabel="step [ms]",
                ylabel="error of the trajectory",
                xticks=sorted(here["step_ms"].unique().tolist()),
            )
        )
    return Chart(
        "error_against_step",
        "Error of the trajectory against the step, per scene; in brackets how far the formulations"
        " are apart at one step." + shown,
        panels,
        columns=3,
        share_x=True,
        height=1.9,
    )


def summary(cells: pd.DataFrame) -> Table:
    """Unknowns and time of a step against contacts for the first solver: the table of the
    README."""
    cells = ladder(cells)
    if cells.empty:
        return None
    cells = cells[cells["solver"] == solvers_of(cells)[0]]
    unknowns = cells.groupby("label")["lcp_dim"].max()
    labels = sorted(
        set(cells["label"]), key=lambda label: (unknowns[label], label)
    )  # the smallest problem first
    rows = []
    for p, here in cells.groupby("p"):
        row = [f"{p:g}"]
        for label in labels:
            one = here[here["label"] == label]
            row.append(
                "not run"
                if one.empty
                else (
                    f"{one['lcp_dim'].iloc[0]:g}, {si(one['t_total_step_s'].iloc[0], 's')}"
                    if one["good"].all()
                    else str(one["status"].iloc[0])
                )
            )
        rows.append(row)
    family, solver = cells["problem_family"].iloc[0], cells["solver"].iloc[0]
    return Table(
        "summary",
        f"Unknowns of the LCP and time of a whole step against contacts ({family}, {solver},"
        " median).",
        ["contacts"] + labels,
        rows,
    )


CHARTS = [dimension, time_and_error, error_against_step]

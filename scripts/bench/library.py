"""Solvers on a library of problems: profiles with failures in the denominator, and a summary per
solver."""

import re

import numpy as np
import pandas as pd

from bench import stats
from bench.chart import Chart, Line, Panel
from bench.profiles import NOISE, matrix
from bench.section import Cell, Section, Table, si


def corners(x: np.ndarray, *curves: np.ndarray) -> list[list[float]]:
    """The points of curves of steps where one of them changes, the first and the last: they look
    the same and take a fraction of the page."""
    keep = [
        i for i in range(len(x)) if i in (0, len(x) - 1) or any(c[i] != c[i - 1] for c in curves)
    ]
    return [[float(c[i]) for i in keep] for c in (x, *curves)]


def fields(cells: pd.DataFrame) -> list[tuple[str, pd.DataFrame]]:
    """[(name, cells)]: parts whose problems were given to the same solvers. A solver of cones and
    one of polyhedral problems were never in the same race."""
    asked = {}
    for part, g in cells.groupby(["campaign", "part"]):
        asked.setdefault(tuple(sorted(set(g["combination"]))), []).append(part)
    out = []
    for parts in asked.values():
        mine = [key in parts for key in zip(cells["campaign"], cells["part"], strict=True)]
        out.append((", ".join(dict.fromkeys(part for _, part in parts)), cells[mine]))
    return sorted(out, key=lambda field: (-field[1]["combination"].nunique(), field[0]))


def variants(combinations: list[str]) -> dict[str, int]:
    """combination -> its number among those of the same solver (their lines differ in dashes)."""
    seen = {}
    return {
        c: seen.setdefault(c.partition(":")[0], []).append(c) or len(seen[c.partition(":")[0]]) - 1
        for c in combinations
    }


def data_profile(products: np.ndarray | None, solvers: list[str]) -> list[Line]:
    """More & Wild (2009): share of all problems solved within so many products with the matrix, for
    the solvers that are counted in them."""
    lines, variant = [], variants(solvers)
    if products is None:
        return lines
    for j, s in enumerate(solvers):
        mine = products[:, j]
        if np.isfinite(mine).any() and mine[np.isfinite(mine)].max() > 0:
            grid = np.unique(np.maximum(mine[np.isfinite(mine)], 1.0))
            lines.append(
                Line(
                    s,
                    grid.tolist(),
                    stats.absolute_profile(mine[:, None], grid)[:, 0].tolist(),
                    kind="steps",
                    variant=variant[s],
                )
            )
    return lines


def profiles(
    name: str,
    cost: np.ndarray,
    families: list[str],
    solvers: list[str],
    noise: float,
    products: np.ndarray | None = None,
) -> Chart:
    finite = stats.ratios(cost)
    finite = finite[np.isfinite(finite)]
    top = max(4.0, float(finite.max()) * 1.1) if len(finite) else 4.0
    tau = np.geomspace(1, top, 120)
    rel = stats.relative_profile(cost, tau, noise)
    low, high = stats.profile_band(
        lambda c: stats.relative_profile(c, tau, noise), cost, families, draws=200
    )
    times = np.sort(cost[np.isfinite(cost)])
    grid = np.geomspace(times[0], times[-1], 120) if len(times) else np.array([1.0])
    absolute = stats.absolute_profile(cost, grid)
    left, right, variant = [], [], variants(solvers)
    most = sorted(range(len(solvers)), key=lambda j: (-rel[-1, j], -rel[:, j].mean()))[
        :3
    ]  # a band for each would hide the lines
    for j, s in enumerate(solvers):
        left.append(
            Line(
                s,
                *(
                    corners(tau, rel[:, j], low[:, j], high[:, j])
                    if j in most
                    else corners(tau, rel[:, j])
                ),
                kind="steps",
                variant=variant[s],
            )
        )
        right.append(
            Line(s, *corners(grid * 1e3, absolute[:, j]), kind="steps", variant=variant[s])
        )
    panels = [
        Panel(
            left,
            title="within a factor of the best",
            xlabel="time / best time τ",
            ylabel="share of problems",
            xlog=2,
            ylog=0,
            ylim=(0, 1.02),
        ),
        Panel(
            right,
            title="within a time",
            xlabel="time [ms]",
            ylabel="share of problems",
            xlog=10,
            ylog=0,
            ylim=(0, 1.02),
        ),
    ]
    counted = data_profile(products, solvers)
    if counted:
        panels.append(
            Panel(
                counted,
                title="within matrix products",
                xlabel="matrix products",
                ylabel="share of problems",
                xlog=10,
                ylog=0,
                ylim=(0, 1.02),
            )
        )
    three = "" if len(solvers) <= 3 else " of the three best"
    return Chart(
        "profiles_" + re.sub(r"[^a-z0-9]+", "_", name.lower()),
        f"Performance profiles, {name}: share of {len(cost)} problems solved within τ times the"
        f" best (left; ties within {100 * (noise - 1):.0f} %, band{three}: 95 % bootstrap by"
        " family), within a time"
        + (
            ", and within so many products with the matrix (data profile; only solvers that are"
            " counted in them)"
            if counted
            else ""
        )
        + ". Failures and combinations that are not defined stay in the denominator.",
        panels,
        columns=len(panels),
        height=2.3,
    )


ENDS = {
    "false claims": ["unverified"],
    "limits": ["timeout", "time_limit", "max_iter", "budget", "stalled", "near"],
    "rays": ["ray", "infeasible"],
    "breakdowns": ["crash", "oom", "numerical", "error", "no_output", "flood"],
    "not defined": ["unsupported", "skipped"],
}


def ends(cells: pd.DataFrame) -> dict[str, int]:
    """How many of the cells that are not verified ended in which way; the rest were solved to less
    than the judge asks."""
    bad = cells[~cells["good"]]
    found = {name: int(bad["status"].isin(words).sum()) for name, words in ENDS.items()}
    return found | {"otherwise": len(bad) - sum(found.values())}


def lines_of(
    name: str, cells: pd.DataFrame, cost: np.ndarray, solvers: list[str], noise: float
) -> tuple[list[list[Cell | str]], float]:
    """Rows of the summary, one a solver, and the shift of their means."""
    r = stats.ratios(cost)
    shift = float(np.median(cost[np.isfinite(cost)])) if np.isfinite(cost).any() else 1e-3
    limit = float(np.max(cost[np.isfinite(cost)])) if np.isfinite(cost).any() else None
    rows = []
    for j, s in enumerate(solvers):
        mine = cells[cells["combination"] == s]
        solved = int(np.isfinite(cost[:, j]).sum())
        rows.append(
            [
                name,
                s,
                Cell(
                    f"{solved} of {len(cost)}", "good" if solved == len(cost) else "", sort=solved
                ),
                *(
                    Cell(str(n), "bad" if n and name == "false claims" else "")
                    for name, n in ends(mine).items()
                ),
                Cell(f"{np.mean(r[:, j] <= noise):.0%}", sort=float(np.mean(r[:, j] <= noise))),
                Cell(
                    si(stats.geometric_mean_shifted(cost[:, j], shift, limit), "s"),
                    sort=stats.geometric_mean_shifted(cost[:, j], shift, limit),
                ),
            ]
        )
    return rows, shift


def section(cells: pd.DataFrame, noise: float = NOISE) -> Section:
    own = cells[cells["formulation"] == ""]
    if own.empty or own["combination"].nunique() < 2:
        return None
    charts, table, shifts = [], [], []
    for name, some in fields(own):
        cost, _, families, solvers = matrix(some)
        if len(solvers) > 1 and np.isfinite(cost).any():
            charts.append(
                profiles(name, cost, families, solvers, noise, matrix(some, "n_matvec")[0])
            )
        rows, shift = lines_of(name, some, cost, solvers, noise)
        table += rows
        shifts.append(f"{name} {si(shift, 's')}")
    return Section(
        "library",
        "Solvers on the problem library",
        "Problems by themselves, without a simulation: generated families, imported files, friction"
        " problems on cones and on facets. Solvers are compared on the problems that all of them"
        " were given.",
        charts,
        [
            Table(
                "solvers",
                "Solvers on the problems of the library, by the problems that they were given.",
                [
                    "problems",
                    "solver",
                    "verified",
                    *ENDS,
                    "otherwise",
                    "fastest or tied",
                    "shifted geometric mean",
                ],
                table,
                note=(
                    f"Shift: median solved time ({', '.join(shifts)}); a failure counts 10 times"
                    " the longest solved time. A combination that is not defined counts as not"
                    " solved. Limits: of time or iterations, stalled, or near; rays: ended on a"
                    " ray or called infeasible; breakdowns: a crash, no memory, numerical trouble,"
                    " an error of a library."
                ),
            )
        ],
    )

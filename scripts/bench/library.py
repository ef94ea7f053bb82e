"""Solvers on a library of problems: profiles with failures in the denominator, and a summary per solver."""
import numpy as np

from bench import stats, style
from bench.chart import Chart, Line, Panel
from bench.section import Cell, Section, Table, si

NOISE = 1.05  # ratio of times that counts as a tie when the machine's own noise floor is not known


def matrix(cells, column="cost"):
    """Problems x solvers: median time of a verified answer, inf otherwise. Combinations that are not defined are failures of
    nobody: problems are kept only where at least one solver was asked. Returns cost, problems, families, solvers."""
    solvers = sorted(cells["combination"].unique())
    key = [f"{problem}|{step:.17g}" for problem, step in zip(cells["problem"], cells["step_s"].astype(float))]  # no step: nan, like any other
    problems = sorted(set(key))
    at = {p: i for i, p in enumerate(problems)}
    cost = np.full((len(problems), len(solvers)), np.inf)
    families = [""] * len(problems)
    for k, family, combo, value, good in zip(key, cells["problem_family"], cells["combination"], cells[column], cells["good"]):
        families[at[k]] = family
        if good and np.isfinite(value):
            cost[at[k], solvers.index(combo)] = value
    return cost, problems, families, solvers


def data_profile(products, solvers):
    """More & Wild (2009): share of all problems solved within so many products with the matrix, for the solvers that are counted in them."""
    lines = []
    if products is None:
        return lines
    for j, s in enumerate(solvers):
        mine = products[:, j]
        if np.isfinite(mine).any() and mine[np.isfinite(mine)].max() > 0:
            grid = np.unique(np.maximum(mine[np.isfinite(mine)], 1.0))
            lines.append(Line(s, grid.tolist(), stats.absolute_profile(mine[:, None], grid)[:, 0].tolist(), kind="steps", variant=j // 9))
    return lines


def profiles(cost, families, solvers, noise, products=None):
    finite = stats.ratios(cost)
    finite = finite[np.isfinite(finite)]
    top = max(4.0, float(finite.max()) * 1.1) if len(finite) else 4.0
    tau = np.geomspace(1, top, 120)
    rel = stats.relative_profile(cost, tau, noise)
    low, high = stats.profile_band(lambda c: stats.relative_profile(c, tau, noise), cost, families, draws=200)
    times = np.sort(cost[np.isfinite(cost)])
    grid = np.geomspace(times[0], times[-1], 120) if len(times) else np.array([1.0])
    absolute = stats.absolute_profile(cost, grid)
    left, right = [], []
    most = sorted(range(len(solvers)), key=lambda j: (-rel[-1, j], -rel[:, j].mean()))[:3]  # a band for each would hide the lines
    for j, s in enumerate(solvers):
        name = s
        left.append(Line(name, tau.tolist(), rel[:, j].tolist(), low[:, j].tolist() if j in most else None, high[:, j].tolist() if j in most else None, kind="steps", variant=j // 9))
        right.append(Line(name, (grid * 1e3).tolist(), absolute[:, j].tolist(), kind="steps", variant=j // 9))
    panels = [Panel(left, title="relative", xlabel="time / best time τ", ylabel="share of problems", xlog=2, ylog=0, ylim=(0, 1.02)),
              Panel(right, title="absolute", xlabel="time [ms]", ylabel="share of problems", xlog=10, ylog=0, ylim=(0, 1.02))]
    counted = data_profile(products, solvers)
    if counted:
        panels.append(Panel(counted, title="data", xlabel="matrix products", ylabel="share of problems", xlog=10, ylog=0, ylim=(0, 1.02)))
    return Chart("profiles", f"Performance profiles over {len(cost)} problems: share solved within τ times the best (left; ties within {100 * (noise - 1):.0f} %, band of the "
                 "three best: 95 % bootstrap by family) within a time, and within so many products with the matrix (data profile; only solvers that are counted in them). Failures stay in the denominator.",
                 panels, columns=len(panels), height=2.3)


def summary(cells, cost, solvers, noise):
    asked = cells[~cells["status"].isin(["unsupported", "skipped"])]
    r = stats.ratios(cost)
    shift = float(np.median(cost[np.isfinite(cost)])) if np.isfinite(cost).any() else 1e-3
    limit = float(np.max(cost[np.isfinite(cost)])) if np.isfinite(cost).any() else None
    rows = []
    for j, s in enumerate(solvers):
        mine = asked[asked["combination"] == s]
        solved = int(np.isfinite(cost[:, j]).sum())
        rows.append([s, Cell(f"{solved} of {len(cost)}", "good" if solved == len(cost) else "", sort=solved),
                     Cell(str(int((mine["status"] == "unverified").sum())), "bad" if (mine["status"] == "unverified").any() else ""),
                     str(int(mine["status"].isin(["timeout", "time_limit", "max_iter", "stalled", "near"]).sum())),
                     str(int(mine["status"].isin(["crash", "oom", "numerical", "error", "no_output", "flood"]).sum())),
                     Cell(f"{np.mean(r[:, j] <= noise):.0%}", sort=float(np.mean(r[:, j] <= noise))),
                     Cell(si(stats.geometric_mean_shifted(cost[:, j], shift, limit), "s"), sort=stats.geometric_mean_shifted(cost[:, j], shift, limit))])
    return Table("solvers", "Solvers on all problems of the library.",
                 ["solver", "verified", "false claims", "limits", "breakdowns", "fastest or tied", "shifted geometric mean"], rows,
                 note=f"Shift {si(shift, 's')} (median solved time); a failure counts 10 times the longest solved time. A combination that is not defined counts as not solved.")


def section(cells, noise=NOISE):
    own = cells[cells["formulation"] == ""]
    if own.empty or own["combination"].nunique() < 2:
        return None
    cost, _, families, solvers = matrix(own)
    products = matrix(own, "n_matvec")[0]
    charts = [profiles(cost, families, solvers, noise, products)] if np.isfinite(cost).any() else []
    return Section("library", "Solvers on the problem library", "Complementarity problems by themselves: families, imported files, contact problems.",
                   charts, [summary(own, cost, solvers, noise)])

"""The claims made for one formulation, each with its evidence and a verdict computed from the rows.
Which one, and what it is held against, stands in scripts/experiments.toml; what else a claim speaks
of is told by traits."""

import math
from collections.abc import Callable

import numpy as np
import pandas as pd

from bench import experiments, registry, stats
from bench import rows as rows_
from bench.section import Cell, Section, Table, error, interval

KEY = [
    "campaign",
    "part",
    "problem",
    "duration_s",
    "tol",
    "solver",
    "solver_options",
    "step_s",
    "effects",
    "start",
]
MARK = {"holds": "good", "does not hold": "bad", "not measured": "none"}
OWN = (
    "paper",
    "accuracy",
    "scaling",
)  # campaigns that a claim is judged by; redundancy also by the ladders of `stability`


ASKED = experiments.of("claims")
SUBJECT, AGAINST = ASKED["formulation"], ASKED["against"]["formulation"]


def polyhedral() -> list[str]:
    """Time stepping with a cone of flat facets."""
    return [f for f in registry.with_trait("polyhedral") if not registry.trait(f, "forces")]


def facets(opts: str) -> int:
    """Facets of a cell with a polyhedral cone; the option's default is 4 when it is not written."""
    return int(rows_.options(opts).get("facets", 4))


def pairs(cells: pd.DataFrame, other: str, reference: str = SUBJECT) -> pd.DataFrame:
    """Cells of `reference` beside cells of `other` that differ in the formulation only."""
    left = cells[(cells["formulation"] == reference) & (cells["formulation_options"] == "")]
    if left.empty:
        left = cells[cells["formulation"] == reference]
    return left.merge(cells[cells["formulation"] == other], on=KEY, suffixes=("", "_other"))


def verdict(share: float, when: str = "") -> str:
    """All pairs, some pairs, or few: in words."""
    if not math.isfinite(share):
        return "not measured"
    if share >= 1:
        return "holds"
    return f"holds when {when}" if when else "does not hold"


def dimension(cells: pd.DataFrame) -> tuple[str, str] | None:
    p = pairs(cells, AGAINST)
    p = p[(p["lcp_dim"] > 0) & (p["lcp_dim_other"] > 0)]
    if p.empty:
        return None
    planar = ~p["effects"].str.contains("spatial")  # two directions, whatever the facets
    nd = np.where(planar, 2, [facets(o) for o in p["formulation_options_other"]])
    fits = p["lcp_dim_other"] == p["lcp_dim"] * (nd + 2)
    frictionless = p["lcp_dim_other"] == p["lcp_dim"]
    count = int((fits | frictionless).sum())
    more = int((p["lcp_dim"] > p["lcp_dim_other"]).sum())
    same = p["n_active"] == p["n_active_other"]
    word = verdict(
        count / len(p),
        "both pose the same contacts" if same.any() and (fits | frictionless)[same].all() else "",
    )
    return (
        word,
        (
            f"{count} of {len(p)} pairs of cells have p against p(nd+2) unknowns (as many where"
            f" nothing rubs); it has more in {more}"
        ),
    )


def told(ratio: float, low: float, high: float, pairs: int) -> str:
    """A mean with its interval, which one or two pairs do not have."""
    return (
        interval(ratio, low, high)
        if pairs >= 3
        else f"{ratio:.3g} ({pairs} pair{'s' if pairs > 1 else ''})"
    )


def sides(wins: pd.Series, sizes: pd.Series) -> tuple[float | None, float | None]:
    """(first size from which on most pairs win, first from which on most lose), None where there is
    none."""
    share = [float(wins[sizes == s].mean()) for s in sorted(set(sizes))]
    every = sorted(set(sizes))
    return tuple(
        next((s for i, s in enumerate(every) if all(test(x) for x in share[i:])), None)
        for test in (lambda x: x > 0.5, lambda x: x < 0.5)
    )


def faster(column: str, what: str) -> Callable[[pd.DataFrame], tuple[str, str] | None]:
    def claim(cells: pd.DataFrame):
        p = pairs(cells, AGAINST)
        p = p[p["good"] & p["good_other"] & p["p"].notna()]
        if p.empty:
            return None
        ratio, low, high, n = stats.paired_ratio(p[column + "_other"], p[column])
        wins = p[column] < p[column + "_other"]
        won_from, lost_from = sides(wins, p["p"])
        within = p if lost_from is None else p[p["p"] < lost_from]
        lost = sorted(f for f, g in within.groupby("problem_family") if wins[g.index].mean() < 0.5)
        if wins.all():
            word = "holds"
        elif wins.mean() > 0.5 and low > 1:
            when = ([f"p < {lost_from:g}"] if lost_from is not None else []) + (
                [f"the scene is none of: {', '.join(lost)}"] if lost else []
            )
            word = (
                "holds when " + " and ".join(when)
                if when
                else f"holds in {int(wins.sum())} of {n} pairs"
            )
        elif won_from is not None and won_from > p["p"].min():
            word = f"holds when p ≥ {won_from:g}"
        else:
            word = "does not hold"
        largest = p["p"].max()
        big = p[p["p"] == largest]
        by_solver = {
            s: stats.paired_ratio(g[column + "_other"], g[column])
            for s, g in p.groupby("solver")
            if len(g) >= 3
        }
        each = ", ".join(
            f"{s} {v[0]:.3g}" for s, v in sorted(by_solver.items(), key=lambda kv: -kv[1][3])
        )
        return (
            word,
            (
                f"{what}: {AGAINST} / {SUBJECT} = {told(ratio, low, high, n)} (geometric mean of"
                f" {n} pairs, 95 %), faster in {int(wins.sum())}; by solver {each}; at p ="
                f" {largest:g}: {told(*stats.paired_ratio(big[column + '_other'], big[column]))}"
            ),
        )

    return claim


def met(cell: pd.DataFrame, suffix: str = "") -> pd.Series:
    return (cell["n_predictions" + suffix] > 0) & (cell["n_predictions_missed" + suffix] == 0)


def agreement(cells: pd.DataFrame) -> tuple[str, str] | None:
    """Cell by cell against the same scene, step and solver with a polyhedral cone: does it meet the
    closed forms that the other meets, and is its error of the common quantity no larger than that
    plus the scene's tolerance?"""
    p = pd.concat([pairs(cells, other) for other in polyhedral()])
    p = p[
        p["good"]
        & p["good_other"]
        & (p["n_predictions"] > 0)
        & (p["n_predictions_other"] > 0)
        & ~p["converged"]
    ]
    if p.empty:
        return None
    worse = met(p, "_other") & ~met(p)
    better = met(p) & ~met(p, "_other")
    apart = p["err_ref"] > p["err_ref_other"] + p["err_tol"].clip(lower=1e-12)
    scenes = sorted(set(p[worse | apart]["problem"].str.split(":").str[0]))
    word = (
        "holds"
        if not scenes
        else (
            f"holds when the scene is none of: {', '.join(scenes)}"
            if (worse | apart).mean() < 0.2
            else "does not hold"
        )
    )
    return (
        word,
        (
            f"of {len(p)} pairs with a polyhedral cone: it misses a closed form that the other"
            f" meets in {int(worse.sum())}, meets one that the other misses in {int(better.sum())};"
            f" its error is larger by more than the scene's tolerance in {int(apart.sum())}"
        ),
    )


def impacts(cells: pd.DataFrame) -> tuple[str, str] | None:
    """h -> 0: the error at the smallest step against the largest, and the observed order."""
    hits = cells["problem_family"].map(registry.situation) == ASKED["impacts"]
    some = cells[
        (cells["formulation"] == SUBJECT) & cells["good"] & cells["err_ref"].notna() & hits
    ]
    orders, stuck = {}, []
    for (problem, _, _), g in some.groupby(["problem", "formulation_options", "solver"]):
        g = g.sort_values("step_s")
        if g["step_s"].nunique() < 3:
            continue
        first, last = g["err_ref"].iloc[0], g["err_ref"].iloc[-1]
        if last <= 1e-12 and first <= 1e-12:
            orders.setdefault(problem, []).append(math.inf)  # exact at every step
        elif first > last * 1.001 or first > 0.5 * last:
            stuck.append(problem)
        else:
            orders.setdefault(problem, []).append(
                stats.observed_order(g["step_s"], g["err_ref"].clip(lower=1e-16))
            )
    total = sum(map(len, orders.values())) + len(stuck)
    if not total:
        return None
    finite = [o for v in orders.values() for o in v if math.isfinite(o)]
    exact = sum(o == math.inf for v in orders.values() for o in v)
    word = (
        "holds"
        if not stuck
        else (
            f"holds when the scene is none of: {', '.join(sorted(set(stuck)))}"
            if len(stuck) < total / 2
            else "does not hold"
        )
    )
    middle = (
        f", observed order {np.median(finite):.2g} [{min(finite):.2g}, {max(finite):.2g}]"
        if finite
        else ""
    )
    return (
        word,
        (
            f"{total - len(stuck)} of {total} ladders of steps at impacts at least halve their"
            f" error from the largest step to the smallest or are exact ({exact}){middle}"
        ),
    )


def redundancy(cells: pd.DataFrame) -> tuple[str, str] | None:
    some = cells[
        (cells["formulation"] == SUBJECT)
        & cells["problem_family"].map(registry.redundant)
        & (cells["p"] >= 4)
    ]
    some = some[~some["status"].isin(["unsupported", "skipped"])]
    if some.empty:
        return None
    by = some.groupby("solver")["good"].agg(["sum", "count"])
    share = some["good"].mean()
    all_ok = sorted(by[by["sum"] == by["count"]].index)
    return (
        verdict(share, "the solver is " + " or ".join(all_ok) if all_ok else ""),
        "verified cells with more contacts than a body can tell apart: "
        + ", ".join(f"{s} {int(r['sum'])} of {int(r['count'])}" for s, r in by.iterrows()),
    )


# G/m_t from which impact friction counts as that of a hard cone (results/FORMAT.md,
# stiffness_ratio)
STIFF = 10


def stiffness(cells: pd.DataFrame) -> tuple[str, str] | None:
    """A ladder of fixed bristle stiffness against the hard cone on the same scene, step and solver:
    a rung is right where its error of the common quantity is no larger than that of the hard cone
    plus the scene's tolerance."""
    fixed = cells[
        (cells["formulation"] == SUBJECT)
        & (
            cells["formulation_options"].map(rows_.options).map(lambda o: o.get("stiffness"))
            == "fixed"
        )
    ]
    hard = cells[(cells["formulation"] == AGAINST) & cells["good"] & cells["err_ref"].notna()]
    p = fixed.merge(hard, on=KEY, suffixes=("", "_other"))
    p = p[(p["stiffness_ratio"] > 0) & (p["err_tol"] > 0)].sort_values(
        ["problem", "stiffness_ratio"]
    )
    above, right = (
        p["stiffness_ratio"] >= STIFF,
        p["good"] & (p["err_ref"] <= p["err_ref_other"] + p["err_tol"]),
    )
    if not above.any() or above.all():
        return None
    word = "holds" if right[above].all() and not right[~above].all() else "does not hold"
    told = []
    for problem, g in p.groupby("problem"):
        ladder = ", ".join(
            f"{r['stiffness_ratio']:.2g}: {error(r['err_ref']) if r['good'] else r['status']}"
            for _, r in g.iterrows()
        )
        told.append(
            f"{problem}, error of {g['err_quantity'].iloc[0]} by G/m_t: {ladder}; {AGAINST}"
            f" {error(g['err_ref_other'].iloc[0])}"
        )
    return (
        word,
        (
            f"with G/m_t ≥ {STIFF} {int(right[above].sum())} of {int(above.sum())} runs are as"
            f" right as {AGAINST}, below {int(right[~above].sum())} of {int((~above).sum())}"
            f" ({'; '.join(told)}). The impulse of an impact is finite in one step however short, a"
            " bristle gives at most G |v_t|, and G = h²k + hc vanishes with the step"
        ),
    )


def stiff(cells: pd.DataFrame) -> tuple[str, str] | None:
    """At the error of each run with compliant contact: the cheapest run of the claims' formulation
    that is at least as accurate, its time and its steps."""
    soft = registry.with_trait("compliant")
    time, work, lost, never = [], [], [], []
    for problem, g in cells[cells["err_ref"].notna() & cells["good"]].groupby("problem"):
        reg = g[g["formulation"] == SUBJECT]
        if reg.empty:
            continue
        for _, pen in g[g["formulation"].isin(soft)].iterrows():
            fit = reg[reg["err_ref"] <= max(pen["err_ref"], 1e-12)]
            if fit.empty:
                never.append(problem)
                continue
            best = fit.loc[fit["cost"].idxmin()]
            time.append(pen["cost"] / best["cost"])
            if pen.get("n_evaluations", 0) > 0:
                work.append(pen["n_evaluations"] / max(best["n_solves"], 1))
            if time[-1] <= 1:
                lost.append(problem)
    if not time and not never:
        return None
    total = len(time) + len(never)
    bad = sorted(set(lost + never))
    word = (
        "holds"
        if not bad
        else (
            f"holds when the scene is none of: {', '.join(bad)}"
            if len(lost) + len(never) < total / 2
            else "does not hold"
        )
    )
    ratio = (
        f"{math.exp(np.mean(np.log(time))):.3g} times the time" if time else "no time to compare"
    )
    evaluations = (
        f" and {math.exp(np.mean(np.log(work))):.3g} evaluations of its right-hand side for each"
        " complementarity problem solved"
        if work
        else ""
    )
    return (
        word,
        (
            f"at the error of {total} runs of {' and '.join(soft)}, compliant contact takes"
            f" {ratio}{evaluations} (geometric means of the {len(time)} that {SUBJECT} matches);"
            f" dearer in {len(time) - len(lost)}, never matched in {len(never)}"
        ),
    )


CLAIMS = [
    ("Its LCP has p unknowns where the polyhedral cone needs p(nd+2)", dimension),
    ("Its solves are faster", faster("t_solve_s", "time in the solver")),
    ("The whole step is faster", faster("t_total_s", "time of the run")),
    ("It agrees with the polyhedral cone and with closed forms", agreement),
    ("Its error falls with the step at impacts", impacts),
    ("Its friction at impacts needs stiffness: G of at least 10 m_t", stiffness),
    ("Redundant contacts do not harm it", redundancy),
    ("It avoids the stiff differential equation of compliant contact", stiff),
]


def section(cells: pd.DataFrame) -> Section:
    mechanical = cells[cells["formulation"] != ""]
    if mechanical.empty:
        return None
    own = mechanical[mechanical["campaign"].str.startswith(OWN)]
    table = []
    for title, judge in CLAIMS:
        found = judge(mechanical if judge is redundancy or own.empty else own)
        word, evidence = found if found else ("not measured", "no rows that could tell")
        table.append([title, Cell(word, MARK.get(word, "fair")), evidence])
    counts = pd.Series([row[1].text for row in table]).value_counts()
    return Section(
        "claims",
        f"The claims made for the {SUBJECT} formulation",
        "Each verdict is computed from the rows below; none is written by hand.",
        [],
        [
            Table(
                "claims", "Claims, verdicts and evidence.", ["claim", "verdict", "evidence"], table
            )
        ],
        {"ClaimsHolding": str(int(counts.get("holds", 0))), "ClaimsJudged": str(len(table))},
    )

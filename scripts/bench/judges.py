"""Judges of a claim about size, time and work: each takes the rows that the claim asks for and says
a word with its evidence, or None where no row could tell. A judge is of no use unless it can
refuse: tests/python/test_claims.py plants for each of them rows that turn its word.

Rows have a column `mine`: those of the formulation that the claim is made for, in one reading. A
win counts beyond the noise of its campaign and size (column `noise`); ratios are given for each
solver, never as a mean over solvers.
"""

import dataclasses
import itertools
import math

import numpy as np
import pandas as pd

from bench import registry, stats
from bench import rows as rows_
from bench.section import error, interval, si

HOLDS, EXCEPT, FAILS = "holds", "holds with exceptions", "does not hold"
UNMEASURED = "not measured"

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


@dataclasses.dataclass
class Verdict:
    word: str
    evidence: str
    sizes: str = ""  # the range that the word speaks for


Found = Verdict | None


def span(cells: pd.DataFrame) -> str:
    """'4 to 128 contacts'"""
    p = cells["p"][cells["p"] > 0]
    if p.empty:
        return ""
    more = f" to {p.max():g}" if p.max() > p.min() else ""
    return f"{p.min():g}{more} contact{'s' if p.max() > 1 else ''}"


def short(problems: pd.Series) -> str:
    """The scenes without their parameters, each once, at most eight."""
    names = sorted({str(p).rpartition("/")[2].split(":")[0].split(".")[0] for p in problems})
    return ", ".join(names[:8]) + (" ..." if len(names) > 8 else "")


def ran(cells: pd.DataFrame) -> pd.DataFrame:
    return cells[~cells["status"].isin(["unsupported", "skipped"])]


def pairs(cells: pd.DataFrame, other: pd.Series, key: list[str] = KEY) -> pd.DataFrame:
    """Cells of `mine` beside the other cells that agree with them in everything of the key."""
    known = cells.fillna({k: "" for k in key if cells[k].dtype == object})
    return known[known["mine"]].merge(
        known[other & ~known["mine"]], on=key, suffixes=("", "_other")
    )


def against(cells: pd.DataFrame, ask: dict) -> pd.Series:
    return cells["formulation"] == ask["against"]["formulation"]


def counted(wins: int, ties: int, losses: int) -> str:
    """A verdict from what was won and lost beyond the noise; a tie is neither."""
    if not losses:
        return HOLDS if wins else FAILS
    return EXCEPT if wins > losses else FAILS


def worst(words: list[str]) -> str:
    """All hold, all fail, or in between."""
    if all(w == HOLDS for w in words):
        return HOLDS
    return FAILS if all(w == FAILS for w in words) else EXCEPT


# ---- size ----------------------------------------------------------------------------------------


def dimension(cells: pd.DataFrame, ask: dict) -> Found:
    """p unknowns against p(nd + 2), where both pose the same contacts. What a solver of cones was
    given over cones, as many contacts are, is the same law in another form: it is counted apart."""
    over_cones = cells["mine"] & cells["solver"].map(registry.reads_cones)
    over_cones &= cells["lcp_dim"] > cells["n_active"]
    p = pairs(cells[~over_cones], against(cells, ask))
    p = p[(p["lcp_dim"] > 0) & (p["lcp_dim_other"] > 0)]
    if p.empty:
        return None
    planar = ~p["effects"].str.contains("spatial")  # two directions, whatever the facets
    given = [int(rows_.options(o).get("facets", 4)) for o in p["formulation_options_other"]]
    facets = np.where(planar, 2, given)
    fits = (p["lcp_dim_other"] == p["lcp_dim"] * (facets + 2)) & (p["lcp_dim"] == p["n_active"])
    same = p["n_active"] == p["n_active_other"]
    unlike = int((~same).sum())  # motions that went apart, as where one of them was not solved
    if not same.any():
        return None
    word = HOLDS if fits[same].all() else EXCEPT if fits[same].any() else FAILS
    return Verdict(
        word,
        f"{int(fits[same].sum())} of {int(same.sum())} pairs of cells have p against p(nd+2)"
        f" unknowns; it has more in {int((p['lcp_dim'] > p['lcp_dim_other']).sum())}"
        + (f"; {unlike} more have other contacts at the end" if unlike else "")
        + (f"; {int(over_cones.sum())} cells were posed over cones" if over_cones.any() else ""),
        span(p),
    )


# ---- time ----------------------------------------------------------------------------------------


def tie_of(p: pd.DataFrame) -> pd.Series:
    """The ratio up to which a pair is a tie: the noise of the noisier of its cells."""
    return p[["noise", "noise_other"]].max(axis=1)


def outcome(mine: pd.Series, other: pd.Series, tie: pd.Series) -> tuple[pd.Series, pd.Series]:
    """(won, lost), beyond the noise."""
    return other > tie * mine, mine > tie * other


def faster(cells: pd.DataFrame, ask: dict) -> Found:
    """Each solver by itself, each start by itself; a run that fails where the other solves is
    lost."""
    column = ask.get("column", "t_total_s")
    p = pairs(ran(cells), against(ran(cells), ask))
    p = p[p["good"] | p["good_other"]]
    if p.empty:
        return None
    mine = p[column].where(p["good"], math.inf)
    other = p[column + "_other"].where(p["good_other"], math.inf)
    won, lost = outcome(mine, other, tie_of(p))
    words, told = [], []
    for (solver, start), g in p.groupby(["solver", "start"]):
        w, x = int(won[g.index].sum()), int(lost[g.index].sum())
        both = g[g["good"] & g["good_other"]]
        ratio = stats.paired_ratio(both[column + "_other"], both[column])
        words.append(counted(w, len(g) - w - x, x))
        where = f" (lost on {short(g['problem'][lost[g.index]])})" if x else ""
        told.append(
            f"{solver}, {start}: {ratio_words(ratio)}, won {w}, tied {len(g) - w - x}, lost"
            f" {x}{where}"
        )
    return Verdict(
        worst(words),
        f"time of {ask['against']['formulation']} over its own: {'; '.join(told)}",
        by_size(p, won, lost),
    )


def by_size(p: pd.DataFrame, won: pd.Series, lost: pd.Series) -> str:
    """The range of sizes; where it spans several decades of contacts, each with its own word and
    the solvers that lose there: a verdict over all sizes says nothing of the largest."""
    sized = p[p["p"] > 0]
    decades = sized.groupby(np.floor(np.log10(sized["p"])))
    if len(decades) < 2:
        return span(p)
    told = []
    for _, some in decades:
        words = {
            solver: counted(
                int(won[g.index].sum()),
                int((~won[g.index] & ~lost[g.index]).sum()),
                int(lost[g.index].sum()),
            )
            for solver, g in some.groupby("solver")
        }
        losing = [solver for solver, word in words.items() if word == FAILS]
        word = worst(list(words.values()))
        but = f", not with {', '.join(losing)}" if losing and word != FAILS else ""
        told.append(f"{span(some)}: {word}{but}")
    return "; ".join(told)


def ratio_words(ratio: tuple[float, float, float, int]) -> str:
    mid, low, high, n = ratio
    if n == 0:
        return "no pair that both solve"
    return interval(mid, low, high) if n >= 3 else f"{mid:.3g} ({n} pair{'s' if n > 1 else ''})"


BUDGETS = {"share_1ms": "1 ms", "share_4ms": "4 ms", "share_16ms": "16 ms"}


def deadline(cells: pd.DataFrame, ask: dict) -> Found:
    """The most contacts of which 99 of 100 steps end within a budget, with the best solver of
    either side."""
    some = cells[cells["good"] & cells["share_16ms"].notna() & (cells["p"] > 0)]
    sides = {True: some[some["mine"]], False: some[against(some, ask)]}
    both = set(sides[True]["problem"]) & set(sides[False]["problem"])
    if not both:
        return None
    words, told = [], []
    for column, budget in BUDGETS.items():
        most = {}
        for mine, g in sides.items():
            g = g[g["problem"].isin(both) & (g[column] >= 0.99)]
            most[mine] = float(g["p"].max()) if len(g) else 0.0
        words.append(
            HOLDS if most[True] > most[False] else FAILS if most[True] < most[False] else EXCEPT
        )
        other = f"{ask['against']['formulation']} to {most[False]:g}"
        told.append(f"within {budget} to {most[True]:g} contacts, {other}")
    slow = {m: float(g["t_step_max_s"].max()) for m, g in sides.items()}
    told.append(f"longest step {si(slow[True], 's')} and {si(slow[False], 's')}")
    return Verdict(worst(words), "; ".join(told), span(some[some["problem"].isin(both)]))


WORK = {"n_solves": "solves", "n_factor": "factorisations", "n_fallback": "fallbacks"}


def simpler(cells: pd.DataFrame, ask: dict) -> Found:
    """Work a step beside the cone's: solves, factorisations, fallbacks, each by itself."""
    some = cells[cells["good"] & (cells["n_steps"] > 0)]
    at = ["problem", "step_s", "start"]
    sides = [
        side.assign(**{c: side[c].fillna(0) / side["n_steps"] for c in WORK})
        .groupby(at)[[*WORK, "p"]]
        .median()
        for side in (some[some["mine"]], some[against(some, ask)])
    ]
    p = sides[0].join(sides[1], rsuffix="_other", how="inner")
    if p.empty:
        return None
    words, told = [], []
    for c, name in WORK.items():
        less, more = int((p[c] < p[c + "_other"]).sum()), int((p[c] > p[c + "_other"]).sum())
        if less or more:
            words.append(counted(less, len(p) - less - more, more))
        told.append(
            f"{name} a step {p[c].median():.3g} against {p[c + '_other'].median():.3g}"
            f" (more in {more} of {len(p)})"
        )
    return Verdict(worst(words) if words else FAILS, ", ".join(told), span(p))


def improves(cells: pd.DataFrame, ask: dict) -> Found:
    """Solvers of one kind against one other on the same problems: what they solve that it does not,
    and what they solve faster, each by itself."""
    some = ran(cells)
    base = some[some["solver"] == ask["than"]["solver"]]
    key = [k for k in KEY if k not in ("solver", "solver_options", "part", "tol")]
    p = some[some["solver"] != ask["than"]["solver"]].merge(base, on=key, suffixes=("", "_other"))
    p = p[p["good"] | p["good_other"]]
    if p.empty:
        return None
    won, lost = outcome(p["cost"], p["cost_other"], tie_of(p))
    words, told = [], []
    for solver, g in p.groupby("solver"):
        w, x = int(won[g.index].sum()), int(lost[g.index].sum())
        words.append(counted(w, len(g) - w - x, x))
        more = int((g["good"] & ~g["good_other"]).sum())
        fewer = int((~g["good"] & g["good_other"]).sum())
        told.append(
            f"{solver}: faster in {w}, slower in {x} of {len(g)}, solves {more} more and {fewer}"
            " less"
        )
    return Verdict(worst(words), f"beside {ask['than']['solver']}: {'; '.join(told)}", span(p))


# ---- work against error --------------------------------------------------------------------------

LEVELS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)


def tolerances(cells: pd.DataFrame) -> int:
    """How many tolerances the integrator of these cells was asked for."""
    return len({rows_.options(o).get("rtol", "") for o in cells["formulation_options"]})


def stiff(cells: pd.DataFrame, ask: dict) -> Found:
    """At each error the cheapest of either side, over every setting of both: compliant contact also
    over the tolerance of its integrator. Rows of one tolerance cannot tell."""
    soft = registry.with_trait("compliant")
    some = cells[cells["good"] & cells["err_ref"].notna() & np.isfinite(cells["cost"])]
    won, lost, tied, told = [], [], 0, []
    for problem, g in some.groupby("problem"):
        mine, other = g[g["mine"]], g[g["formulation"].isin(soft)]
        if mine.empty or other.empty or tolerances(other) < 2:
            continue
        for level in LEVELS:
            a, b = (side[side["err_ref"] <= level] for side in (mine, other))
            if a.empty or b.empty:
                continue
            x, y = a.loc[a["cost"].idxmin()], b.loc[b["cost"].idxmin()]
            tie = max(x["noise"], y["noise"])
            if y["cost"] > tie * x["cost"]:
                won.append(problem)
            elif x["cost"] > tie * y["cost"]:
                lost.append(problem)
            else:
                tied += 1
            told.append(f"{problem} at {level:g}: {y['cost'] / x['cost']:.2g}")
    if not told:
        return None
    return Verdict(
        counted(len(won), tied, len(lost)),
        f"cheapest compliant run over the cheapest of its own: {'; '.join(told)}"
        + (f"; dearer on {short(pd.Series(lost))}" if lost else ""),
        span(some),
    )


def priced(cells: pd.DataFrame, ask: dict) -> Found:
    """Compliant contact: with stiffness the error falls and the work grows, at the same
    tolerance."""
    soft = cells[cells["formulation"].isin(registry.with_trait("compliant")) & cells["good"]]
    soft = soft[soft["err_ref"].notna() & (soft["n_evaluations"] > 0)]
    given = soft["formulation_options"].map(rows_.options)
    soft = soft.assign(
        k=given.map(lambda o: float(o.get("stiffness", "nan"))),
        rtol=given.map(lambda o: o.get("rtol", "")),
    ).dropna(subset=["k"])
    finest = min(soft["rtol"], key=lambda v: float(v or "inf"), default="")
    words, told = [], []
    for problem, g in soft[soft["rtol"] == finest].groupby("problem"):
        g = g.sort_values("k")
        if g["k"].nunique() < 2:
            continue
        first, last = g.iloc[0], g.iloc[-1]
        right = last["err_ref"] < first["err_ref"]
        dear = last["n_evaluations"] > first["n_evaluations"]
        words.append(HOLDS if right and dear else FAILS if not right and not dear else EXCEPT)
        told.append(
            f"{problem}: error {error(first['err_ref'])} to {error(last['err_ref'])}, evaluations"
            f" {first['n_evaluations']:g} to {last['n_evaluations']:g} from k = {first['k']:g} to"
            f" {last['k']:g}"
        )
    return Verdict(worst(words), "; ".join(told), span(soft)) if words else None


# ---- order of convergence ------------------------------------------------------------------------


def converges(cells: pd.DataFrame, ask: dict) -> Found:
    """The error falls with the step to the end of the ladder: the last three steps count, and a
    plateau is none."""
    some = cells[cells["mine"] & cells["good"] & cells["err_ref"].notna()]
    found = {}
    for (problem, _, _), g in some.groupby(["problem", "formulation_options", "solver"]):
        if g["step_s"].nunique() >= 3:
            word, order = stats.tail_order(g["step_s"], g["err_ref"])
            found.setdefault(word, []).append((problem, order, g))
    total = sum(map(len, found.values()))
    if not total:
        return None
    good = len(found.get("converges", [])) + len(found.get("exact", []))
    told = [
        f"{problem}: {word}"
        + (f" of order {order:.2g}" if math.isfinite(order) else "")
        + f" ({', '.join(error(e) for e in g.sort_values('step_s')['err_ref'][:3])})"
        for word, entries in sorted(found.items())
        for problem, order, g in itertools.islice(entries, 6)
    ]
    word = HOLDS if good == total else EXCEPT if good > total / 2 else FAILS
    return Verdict(
        word,
        f"{good} of {total} ladders fall to the last of their steps; errors at the three smallest:"
        f" {'; '.join(told)}",
        span(some),
    )

"""Judges of a claim about the answers: who agrees with what, what is solved, what penetrates, what
is restricted (bench/judges.py says what a judge is)."""

import math
from collections.abc import Callable

import numpy as np
import pandas as pd

from bench import registry
from bench import rows as rows_
from bench.judges import (
    EXCEPT,
    FAILS,
    HOLDS,
    UNMEASURED,
    Found,
    Verdict,
    against,
    pairs,
    ran,
    short,
    span,
)
from bench.section import error

MOST = 0.5  # a claim that holds on fewer than this share of its cells does not hold


def by_share(share: float) -> str:
    return HOLDS if share >= 1 else EXCEPT if share >= MOST else FAILS


# ---- closed forms --------------------------------------------------------------------------------


def met(cell: pd.DataFrame, suffix: str = "") -> pd.Series:
    return (cell["n_predictions" + suffix] > 0) & (cell["n_predictions_missed" + suffix] == 0)


def agreement(cells: pd.DataFrame, ask: dict) -> Found:
    """Cell by cell beside every formulation with a polyhedral cone: closed forms that it misses and
    the other meets, errors larger by more than the scene's tolerance. Who is asked fewer
    predictions is not said to agree: the share stands beside the result."""
    flat = [f for f in registry.with_trait("polyhedral") if not registry.trait(f, "forces")]
    p = pairs(cells, cells["formulation"].isin(flat))
    p = p[(p["n_predictions_other"] > 0) & ~p["converged"] & p["good_other"]]
    if p.empty:
        return None
    asked, most = int(p["n_predictions"].fillna(0).sum()), int(p["n_predictions_other"].sum())
    unsolved = ~p["good"]
    worse = p["good"] & met(p, "_other") & ~met(p)
    apart = p["good"] & (p["err_ref"] > p["err_ref_other"] + p["err_tol"].clip(lower=1e-12))
    bad = unsolved | worse | apart
    word = HOLDS if not bad.any() else EXCEPT if bad.mean() < 0.2 else FAILS
    if word == HOLDS and asked < most:
        word = EXCEPT
    return Verdict(
        word,
        f"of {len(p)} pairs with a polyhedral cone: not solved {int(unsolved.sum())}, misses a"
        f" closed form that the other meets in {int(worse.sum())}, error larger by more than the"
        f" scene's tolerance in {int(apart.sum())}"
        + (f" ({short(p['problem'][bad])})" if bad.any() else "")
        + f"; asked {asked} predictions where the others are asked {most}",
        span(p),
    )


def predictions(cells: pd.DataFrame, ask: dict) -> Found:
    """Closed forms met, by setting; what is not solved has met none."""
    some = ran(cells)
    some = some[(some["n_predictions"] > 0) | ~some["good"]]
    if some.empty:
        return None
    good = some["good"] & met(some)
    told = ", ".join(
        f"{label} {int(good[g.index].sum())} of {len(g)}" for label, g in some.groupby("label")
    )
    missing = f"; not on {short(some['problem'][~good])}" if not good.all() else ""
    return Verdict(by_share(good.mean()), f"runs that meet all: {told}{missing}", span(some))


# G/m_t from which friction at impacts counts as that of a hard cone (results/FORMAT.md,
# stiffness_ratio)
STIFF = 10


def stiffness(cells: pd.DataFrame, ask: dict) -> Found:
    """A ladder of fixed bristle stiffness against the hard cone on the same scene, step and solver:
    a rung is right where its error is no larger than that of the hard cone plus the scene's
    tolerance. Stiff rungs are right, soft ones are not: else stiffness is not what it takes."""
    hard_name = ask["against"]["formulation"]
    hard = against(cells, ask) & cells["good"] & cells["err_ref"].notna()
    p = pairs(cells, hard)
    p = p[(p["stiffness_ratio"] > 0) & (p["err_tol"] > 0)]
    p = p.sort_values(["problem", "stiffness_ratio"])
    above = p["stiffness_ratio"] >= STIFF
    right = p["good"] & (p["err_ref"] <= p["err_ref_other"] + p["err_tol"])
    if not above.any() or above.all():
        return None
    if right[above].all() and not right[~above].any():
        word = HOLDS
    else:
        word = EXCEPT if right[above].mean() > MOST > right[~above].mean() else FAILS
    told = []
    for problem, g in p.groupby("problem"):
        ladder = ", ".join(
            f"{r['stiffness_ratio']:.2g}: {error(r['err_ref']) if r['good'] else r['status']}"
            for _, r in g.iterrows()
        )
        told.append(
            f"{problem}, error of {g['err_quantity'].iloc[0]} by G/m_t: {ladder};"
            f" {hard_name} {error(g['err_ref_other'].iloc[0])}"
        )
    return Verdict(
        word,
        f"with G/m_t >= {STIFF} {int(right[above].sum())} of {int(above.sum())} runs are as right"
        f" as {hard_name}, below {int(right[~above].sum())} of {int((~above).sum())}"
        f" ({'; '.join(told)}). A bristle gives at most G |v_t| in a step, and G = h^2 k + h c"
        " vanishes with the step",
        span(p),
    )


# ---- solvability ---------------------------------------------------------------------------------


def solved(cells: pd.DataFrame, ask: dict) -> Found:
    """Verified cells of all that ran, by combination."""
    some = ran(cells)
    if some.empty:
        return None
    told = ", ".join(
        f"{name} {int(g['good'].sum())} of {len(g)}" for name, g in some.groupby(ask["by"])
    )
    bad = some[~some["good"]]
    where = f"; not {short(bad['problem'])} ({', '.join(sorted(set(bad['status'])))})"
    return Verdict(by_share(some["good"].mean()), told + (where if len(bad) else ""), span(some))


def always(cells: pd.DataFrame, ask: dict) -> Found:
    """A solution exists: no checked proof of the contrary, and on every problem some solver finds
    one. Scenes whose walls close in (no motion exists, b_n < 0) are told apart: a proof there is an
    exception to the sentence, not a fault."""
    some = ran(cells)
    moving = ~some["problem_family"].map(registry.solvable)
    rest = some[~moving]
    if rest.empty:
        return None
    found = rest.groupby("problem")["good"].any()
    proved = rest["status"] == "infeasible"
    apart = some[moving]
    refused = int((apart["status"] == "infeasible").sum())
    word = FAILS if proved.any() else by_share(found.mean())
    if word == HOLDS and refused:
        word = EXCEPT
    missing = found[~found].index.to_series()
    return Verdict(
        word,
        f"b_n >= 0: a verified solution of {int(found.sum())} of {len(found)} problems, proofs of"
        f" none {int(proved.sum())}"
        + (f", nothing found on {short(missing)}" if len(missing) else "")
        + (f"; b_n < 0: {refused} of {len(apart)} cells prove that none is" if len(apart) else ""),
        span(rest),
    )


def refused(cells: pd.DataFrame, ask: dict) -> Found:
    """Problems without a solution exist: proved, on rungs of a ladder whose mild end is solved. A
    failure without a proof tells nothing."""
    some = ran(cells)
    proved = some["status"] == "infeasible"
    failed = ~some["good"] & ~proved
    told = (
        f"{int(proved.sum())} of {len(some)} rungs are proved to have no solution"
        f" ({', '.join(some['problem'][proved]) or 'none'}), {int(some['good'].sum())} are solved,"
        f" {int(failed.sum())} fail without a proof"
    )
    if some.empty:
        return None
    if proved.any():
        return Verdict(HOLDS if some["good"].any() else EXCEPT, told, span(some))
    return Verdict(UNMEASURED if failed.any() else FAILS, told, span(some))


def spread(cells: pd.DataFrame, ask: dict) -> Found:
    """Several verified motions of one problem, which differ by the solver that found them: with
    what each finds (the claim), and with one choice among them beside it."""
    some = cells[cells["good"] & cells["end_value"].notna()]
    wide, told = {True: 0, False: 0}, []
    for (problem, options), g in some.groupby(["problem", "formulation_options"]):
        if g["solver"].nunique() < 2:
            continue
        own = ask["own"] in options
        scale = max(abs(g["end_value"].median()), ask["beyond"])
        found = (g["end_value"].max() - g["end_value"].min()) / scale
        wide[own] += found > ask["beyond"]
        told.append(f"{short(pd.Series([problem]))} {options.rpartition('=')[2]} {found:.2g}")
    if not any(ask["own"] in o for o in some["formulation_options"]) or not told:
        return None
    word = FAILS if not wide[True] else HOLDS if not wide[False] else EXCEPT
    return Verdict(
        word,
        f"spread of the end {some['end_quantity'].iloc[0]} over the solvers, of its size:"
        f" {', '.join(told)}",
        span(some),
    )


# ---- levels --------------------------------------------------------------------------------------


def agree(cells: pd.DataFrame, ask: dict) -> Found:
    """Formulations that end with the same value, to a share of the scene's size."""
    some = ran(cells)
    same, told, total = 0, [], 0
    for problem, g in some.groupby("problem"):
        total += 1
        good = g[g["good"] & g["end_value"].notna()]
        if good["formulation"].nunique() < max(2, g["formulation"].nunique()):
            told.append(f"{problem}: {len(g) - len(good)} not solved")
            continue
        scale = max(good["end_value"].abs().max(), 1e-3)
        found = (good["end_value"].max() - good["end_value"].min()) / scale
        same += found <= ask["within"]
        told.append(f"{problem}: {found:.1g}")
    if not total or some["formulation"].nunique() < 2:
        return None
    return Verdict(
        by_share(same / total), f"largest difference of the ends: {'; '.join(told)}", span(some)
    )


CLEAR = 1e-9  # an overlap that is rounding [m]


def penetrates(cells: pd.DataFrame, ask: dict) -> Found:
    """Overlap occurs, beyond rounding, where none was at the start."""
    return depth_words(cells, lambda deep: HOLDS if deep.any() else FAILS)


def clear(cells: pd.DataFrame, ask: dict) -> Found:
    """No overlap beyond rounding in any run."""
    return depth_words(cells, lambda deep: by_share(1 - deep.mean()))


def depth_words(cells: pd.DataFrame, word: Callable[[pd.Series], str]) -> Found:
    some = cells[cells["good"] & cells["penetration_m"].notna()]
    if some.empty:
        return None
    deep = some["penetration_m"] > CLEAR
    told = "; ".join(
        f"{problem}: "
        + ", ".join(
            f"{r['penetration_m']:.1g} m at h = {r['step_s']:g} s"
            for _, r in g.sort_values("step_s", ascending=False).iterrows()
        )
        for problem, g in some.groupby("problem")
    )
    return Verdict(
        word(deep), f"{int(deep.sum())} of {len(some)} runs penetrate ({told})", span(some)
    )


def restricted(cells: pd.DataFrame, ask: dict) -> Found:
    """A motion that is free, and that one level hinders: its error is larger than the other's by
    more than the scene's tolerance."""
    level, other = ask["level"]["formulation"], ask["against"]["formulation"]
    at = ["problem", "step_s", "solver"]
    good = cells[cells["good"] & cells["err_ref"].notna()]
    p = good[good["formulation"] == level].merge(
        good[good["formulation"] == other], on=at, suffixes=("", "_other")
    )
    if p.empty:
        return None
    more = p["err_ref"] > p["err_ref_other"] + p["err_tol"].fillna(0)
    told = "; ".join(
        f"{short(pd.Series([r['problem']]))}, h = {r['step_s']:g} s: {error(r['err_ref'])} against"
        f" {error(r['err_ref_other'])}"
        for _, r in p.iterrows()
    )
    return Verdict(
        HOLDS if more.any() else FAILS,
        f"error of {level} against {other} larger in {int(more.sum())} of {len(p)} runs ({told})",
        span(p),
    )


# ---- laws of compliant contact -------------------------------------------------------------------

GRAVITY = 9.81


def depth_of(k: float, exponent: float, height: float) -> float:
    """Deepest overlap of a point mass of 1 kg that falls from `height` on a spring F = k d^n: K
    d^(n+1)/(n+1) = g (height + d)."""
    low, high = 0.0, 1e3
    for _ in range(200):
        d = 0.5 * (low + high)
        if k * d ** (exponent + 1) / (exponent + 1) < GRAVITY * (height + d):
            low = d
        else:
            high = d
    return low


def power_law(cells: pd.DataFrame, ask: dict) -> Found:
    """The deepest overlap of one impact without damping against the balance of energy, by law."""
    right, told = [], []
    for _, r in cells[cells["good"]].iterrows():
        form = rows_.options(r["formulation_options"])
        scene = rows_.options(str(r["problem"]).partition(":")[2])
        exponent = ask["exponents"].get(form.get("law", ""))
        if exponent is None or "stiffness" not in form or "height" not in scene:
            continue
        expected = depth_of(float(form["stiffness"]), exponent, float(scene["height"]))
        off = abs(r["penetration_m"] / expected - 1)
        right.append(off <= ask["within"])
        told.append(
            f"{form['law']}, {scene['height']} m: {r['penetration_m']:.4g} m, off {off:.1g}"
        )
    if not right:
        return None
    missing = f"; exponents {ask['missing']} are in no law here" if ask.get("missing") else ""
    word = by_share(np.mean(right))
    return Verdict(EXCEPT if word == HOLDS and missing else word, "; ".join(told) + missing)


RADIUS = 0.1  # of the ball, where the scene does not say


def restitution_of(height: float, radius: float, drift: float) -> float:
    """What a ball that fell from `height` kept of its speed, from the energy after one impact: m g
    (r + e^2 H) of m g (r + H)."""
    kept = ((1 + drift) * (height + radius) - radius) / height
    return math.sqrt(max(kept, 0.0))


def realised(cells: pd.DataFrame, ask: dict) -> Found:
    """The restitution that a law of contact realises against the one that was asked for, over
    impact speeds; from the energy before and after, so that the time in contact does not count."""
    some = ran(cells)
    right, told = [], {}
    for r in some.to_dict("records"):
        scene = rows_.options(str(r["problem"]).partition(":")[2])
        if "height" not in scene or "restitution" not in scene:
            continue
        height, asked = float(scene["height"]), float(scene["restitution"])
        radius = float(scene.get("radius", RADIUS))
        got = restitution_of(height, radius, r["energy_drift_rel"]) if r["good"] else math.nan
        right.append(abs(got - asked) <= ask["within"])
        speed = math.sqrt(2 * GRAVITY * height)
        told.setdefault(r["label"], []).append(f"{asked:g} at {speed:.2g} m/s: {got:.3f}")
    if not right:
        return None
    each = "; ".join(f"{label}: {', '.join(found)}" for label, found in told.items())
    return Verdict(by_share(np.mean(right)), f"asked and got, by law: {each}", span(some))

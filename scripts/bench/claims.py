"""The claims made for the regularized formulation, each with its evidence and a verdict computed from the rows."""
import math

import numpy as np
import pandas as pd

from bench import rows as rows_, stats
from bench.section import Cell, Section, Table, interval

KEY = ["campaign", "part", "problem", "duration_s", "tol", "solver", "solver_options", "step_s", "effects", "start"]
MARK = {"holds": "good", "does not hold": "bad", "no rows": "none"}


def facets(opts):
    """Facets of a velocity or position cell; the option's default is 4 when it is not written."""
    return int(rows_.options(opts).get("facets", 4))


def pairs(cells, other, reference="regularized"):
    """Cells of `reference` beside cells of `other` that differ in the formulation only."""
    left = cells[(cells["formulation"] == reference) & (cells["formulation_options"] == "")]
    if left.empty:
        left = cells[cells["formulation"] == reference]
    return left.merge(cells[cells["formulation"] == other], on=KEY, suffixes=("", "_other"))


def verdict(share, when=""):
    """All pairs, some pairs, or few: in words."""
    if not math.isfinite(share):
        return "no rows"
    if share >= 1:
        return "holds"
    return f"holds when {when}" if when else "does not hold"


def dimension(cells):
    p = pairs(cells, "velocity")
    p = p[(p["lcp_dim"] > 0) & (p["lcp_dim_other"] > 0)]
    if p.empty:
        return None
    planar = p["n_dof"] == 3 * p["n_bodies"]
    nd = np.where(planar & (p["formulation_options_other"] == ""), 2, [facets(o) for o in p["formulation_options_other"]])
    fits = (p["lcp_dim_other"] == p["lcp_dim"] * (nd + 2)) | (planar & (p["lcp_dim_other"] == 4 * p["lcp_dim"]))
    frictionless = p["lcp_dim_other"] == p["lcp_dim"]
    count = int((fits | frictionless).sum())
    smaller = float((p["lcp_dim"] <= p["lcp_dim_other"]).mean())
    word = verdict(count / len(p), "all potential contacts are active" if smaller >= 1 else "")
    return word, f"{count} of {len(p)} pairs of cells have p against p(nd+2) unknowns (as many where nothing rubs); never more in {smaller:.0%}"


def faster(column, what):
    def claim(cells):
        p = pairs(cells, "velocity")
        p = p[p["good"] & p["good_other"]]
        if p.empty:
            return None
        ratio, low, high, n = stats.paired_ratio(p[column + "_other"], p[column])
        wins = p[p[column] < p[column + "_other"]]
        sizes = sorted(p["p"].dropna().unique())
        from_size = next((s for i, s in enumerate(sizes)
                          if all((p[p["p"] == t][column] < p[p["p"] == t][column + "_other"]).mean() > 0.5 for t in sizes[i:])), None)
        share = len(wins) / n if n else math.nan
        lost = sorted(f for f, g in p.groupby("problem_family") if (g[column] < g[column + "_other"]).mean() < 0.5)
        if share >= 1:
            word = "holds"
        elif share > 0.5 and low > 1:
            word = "holds in most pairs" + (f" (not: {', '.join(lost)})" if lost else "")
        elif from_size is not None and from_size > sizes[0]:
            word = f"holds when p ≥ {from_size:g} (in most pairs)"
        else:
            word = "does not hold"
        big = p[p["p"] == sizes[-1]] if sizes else p
        at_big = stats.paired_ratio(big[column + "_other"], big[column])
        return word, (f"{what}: velocity / regularized = {interval(ratio, low, high)} (geometric mean of {n} pairs, 95 %), "
                      f"faster in {len(wins)}; at p = {sizes[-1]:g}: {interval(*at_big[:3])}")
    return claim


def agreement(cells):
    some = cells[(cells["n_predictions"] > 0) & cells["good"]] if "n_predictions" in cells else cells[:0]
    out = []
    for form in ("regularized", "velocity", "position"):
        g = some[some["formulation"] == form]
        if len(g):
            out.append((form, int((g["n_predictions_missed"] == 0).sum()), len(g)))
    if not out or out[0][0] != "regularized":
        return None
    share = out[0][1] / out[0][2]
    others = max((k / n for _, k, n in out[1:]), default=0)
    missed = sorted(set(some[(some["formulation"] == "regularized") & (some["n_predictions_missed"] > 0)]["problem_family"]))
    word = "holds" if share >= 1 else ("holds when the scene is none of: " + ", ".join(missed) if share >= others - 0.05 and share > 0.5 else "does not hold")
    return word, "cells with every closed-form prediction met: " + ", ".join(f"{f} {k} of {n}" for f, k, n in out)


def impacts(cells):
    some = cells[(cells["formulation"] == "regularized") & cells["good"] & (cells["err_ref"] > 0) &
                 cells["problem_family"].str.contains("bounc|impact|rock|cradle|spin|drop|woodpecker")]
    found = {}
    for (problem, opts, solver), g in some.groupby(["problem", "formulation_options", "solver"]):
        g = g.sort_values("step_s")
        if g["step_s"].nunique() >= 2:
            found[(problem, opts)] = bool(g["err_ref"].iloc[0] <= g["err_ref"].iloc[-1] * 1.001)
    if not found:
        return None
    ok = sum(found.values())
    bad = sorted({p for (p, o), v in found.items() if not v})
    word = "holds" if ok == len(found) else "holds when the scene is none of: " + ", ".join(bad) if ok > len(found) / 2 else "does not hold"
    return word, f"{ok} of {len(found)} impact ladders have a smaller error at their smallest step than at their largest"


def redundancy(cells):
    some = cells[cells["problem_family"].str.contains("stack|redund|table|duplicate|grid|pile|peg") & (cells["p"] >= 4) & (cells["formulation"] == "regularized")]
    some = some[~some["status"].isin(["unsupported", "skipped"])]
    if some.empty:
        return None
    by = some.groupby("solver")["good"].agg(["sum", "count"])
    share = some["good"].mean()
    all_ok = sorted(by[by["sum"] == by["count"]].index)
    return (verdict(share, "the solver is " + " or ".join(all_ok) if all_ok else ""),
            "verified cells with redundant contacts: " + ", ".join(f"{s} {int(r['sum'])} of {int(r['count'])}" for s, r in by.iterrows()))


def stiff(cells):
    found = []
    for problem, g in cells[cells["err_ref"].notna() & cells["good"]].groupby("problem"):
        pen, reg = g[g["formulation"] == "penalty"], g[g["formulation"] == "regularized"]
        if pen.empty or reg.empty:
            continue
        level = max(pen["err_ref"].min(), reg["err_ref"].min())
        a, b = pen[pen["err_ref"] <= level], reg[reg["err_ref"] <= level]
        found.append((problem, a["cost"].min() / b["cost"].min()))
    if not found:
        return None
    wins = sum(r > 1 for _, r in found)
    ratio = math.exp(np.mean([math.log(r) for _, r in found]))
    lost = ", ".join(sorted(p for p, r in found if r <= 1))
    word = "holds" if wins == len(found) else f"holds when the scene is none of: {lost}" if wins > len(found) / 2 else "does not hold"
    return word, f"time of penalty / regularized at the error that both reach: {ratio:.3g} (geometric mean of {len(found)} scenes), above 1 in {wins}"


CLAIMS = [
    ("Its LCP has p unknowns where the polyhedral cone needs p(nd+2)", dimension),
    ("Its solves are faster", faster("t_solve_s", "time in the solver")),
    ("The whole step is faster", faster("t_total_s", "time of the run")),
    ("It agrees with closed forms as well as the others do", agreement),
    ("Its error falls with the step at impacts", impacts),
    ("Redundant contacts do not harm it", redundancy),
    ("It avoids the stiff differential equation of compliant contact", stiff),
]


def section(cells):
    mechanical = cells[cells["formulation"] != ""]
    if mechanical.empty:
        return None
    table = []
    for title, judge in CLAIMS:
        found = judge(mechanical)
        word, evidence = found if found else ("no rows", "this campaign has no rows that could tell")
        table.append([title, Cell(word, MARK.get(word, "fair")), evidence])
    counts = pd.Series([row[1].text.split(" ")[0] for row in table]).value_counts()
    return Section("claims", "The claims made for the regularized formulation",
                   "Each verdict is computed from the rows below; none is written by hand.", [],
                   [Table("claims", "Claims, verdicts and evidence.", ["claim", "verdict", "evidence"], table)],
                   {"ClaimsHolding": str(int(counts.get("holds", 0)))})

"""What the last answers are worth to the next problem: sequences of problems from warm starts
beside the same from zero, solver by solver, against the change of the active set."""

from __future__ import annotations

import math

import pandas as pd

from bench import judges, registry, stats
from bench.chart import Chart, Line, Panel
from bench.judges import FAILS, HOLDS, UNMEASURED, Found, Verdict
from bench.section import Cell, Section, Table

COLD, LAST = "cold", "previous"
KEY = ["campaign", "part", "problem", "solver", "solver_options", "tol"]
FLOOR = 1e-3  # drawn, not computed: a start that leaves no work has no place on such an axis
MARK = {HOLDS: "good", judges.EXCEPT: "fair", FAILS: "bad", UNMEASURED: "none"}
# classes of the mean share of rows that become active or cease to be from one problem to the next
CLASSES = (("still", 0.0), ("up to 5 %", 0.05), ("more", math.inf))
STATEMENTS = (
    ("work", "From the last answer a problem takes fewer iterations and pivots than from zero."),
    ("time", "From the last answer a problem takes less time than from zero."),
)


def of(cells: pd.DataFrame) -> pd.Series:
    """Which cells are sequences."""
    return cells["active_change"].notna() | ((cells["formulation"] == "") & (cells["start"] != ""))


def pairs(cells: pd.DataFrame) -> pd.DataFrame:
    """Each warm cell beside the cold one of its problem and solver, both solved and verified, with
    the ratios of work and time. A solver that fails from where it was solved from zero stays, with
    infinite ratios."""
    some = cells[of(cells) & ~cells["status"].isin(["unsupported", "skipped"])].copy()
    some["work"] = some["n_iter"].fillna(0) + some["n_pivot"].fillna(0)
    some["time"] = some["t_total_s"]
    known = some.fillna({k: "" for k in KEY if some[k].dtype == object})
    cold = known[(known["start"] == COLD) & known["good"]]
    p = known[known["start"] != COLD].merge(cold, on=KEY, suffixes=("", "_cold"))
    for cost in ("work", "time"):
        p[cost + "_ratio"] = (p[cost] / p[cost + "_cold"].replace(0, math.nan)).where(
            p["good"], math.inf
        )
    p["tie"] = p[["noise", "noise_cold"]].max(axis=1)
    return p


def saves(p: pd.DataFrame, cost: str) -> Found:
    """Each solver by itself. Work is exact: any difference counts; times count beyond the noise. A
    start that fails where zero does not is lost."""
    p = p[(p["start"] == LAST) & p[cost + "_ratio"].notna()]
    if p.empty:
        return None
    tie = p["tie"] if cost == "time" else 1.0
    won = p[cost + "_ratio"] * tie < 1.0
    lost = p[cost + "_ratio"] > tie
    words, told = [], []
    for solver in registry.by_solver(set(p["solver"])):
        g = p[p["solver"] == solver]
        w, x = int(won[g.index].sum()), int(lost[g.index].sum())
        ratio = stats.paired_ratio(g[cost + "_ratio"].clip(lower=FLOOR), [1.0] * len(g))
        words.append(judges.counted(w, len(g) - w - x, x))
        told.append(
            f"{solver}: {judges.ratio_words(ratio)}, won {w}, tied {len(g) - w - x}, lost {x}"
        )
    return Verdict(
        judges.worst(words),
        f"{cost} over that from zero, by solver: {'; '.join(told)}",
        judges.span(p),
    )


def verdicts(p: pd.DataFrame) -> list[tuple[str, Verdict]]:
    none = Verdict(UNMEASURED, "no pair of rows that could tell")
    return [(says, saves(p, cost) or none) for cost, says in STATEMENTS]


def panel(p: pd.DataFrame, cost: str) -> Panel:
    some = p[(p["start"] == LAST) & p["good"] & p[cost + "_ratio"].notna()]
    ends = [0.0, max(0.01, float(some["active_change"].max()))]
    lines = [Line("from zero", ends, [1.0, 1.0], kind="front")]
    for solver in registry.by_solver(set(some["solver"])):
        g = some[some["solver"] == solver]
        lines.append(
            Line(
                solver,
                g["active_change"].tolist(),
                g[cost + "_ratio"].clip(lower=FLOOR).tolist(),
                hover=g["problem"].tolist(),
                kind="points",
                hollow=[bool(d) for d in g["disturbed"]],
            )
        )
    return Panel(
        lines,
        title=cost,
        xlabel="change of the active set from problem to problem",
        ylabel=f"{cost} over that from zero",
        xlog=0,
    )


def classed(g: pd.DataFrame, ratio: str) -> list[Cell]:
    """Median ratio in each class of change."""
    out, low = [], -1.0
    for _, high in CLASSES:
        x = g[(g["active_change"] > low) & (g["active_change"] <= high)][ratio].dropna()
        mid = float(x.median()) if len(x) else math.nan
        text = "" if not len(x) else "fails" if math.isinf(mid) else f"{mid:.2g}"
        mark = "" if not len(x) else "good" if mid < 1 else "bad" if mid > 1 else ""
        out.append(Cell(text, mark, sort=mid if math.isfinite(mid) else math.inf))
        low = high
    return out


def share(count: pd.Series, of_: pd.Series) -> Cell:
    total = float(of_.sum())
    x = float(count.sum()) / total if total else math.nan
    return Cell("" if math.isnan(x) else f"{x:.1%}", sort=x)


def table(p: pd.DataFrame) -> Table:
    body = []
    for solver in registry.by_solver(set(p["solver"])):
        for start in dict.fromkeys(p["start"]):
            g = p[(p["solver"] == solver) & (p["start"] == start)]
            if g.empty:
                continue
            good = g[g["good"]]
            body.append(
                [
                    Cell(solver, look=solver),
                    start,
                    f"{len(good)} of {len(g)}",
                    *classed(g, "work_ratio"),
                    *classed(g, "time_ratio"),
                    share(good["regressions"], good["n_solves"]),
                    share(good["regressions_time"], good["n_solves"]),
                ]
            )
    names = [name for name, _ in CLASSES]
    return Table(
        "warm",
        "Work (iterations and pivots) and time over those from zero: medians of sequences whose"
        " active set stands still, changes by up to 5 % of its rows from one problem to the next,"
        " or by more.",
        ["solver", "start", "solved"]
        + [f"work, {n}" for n in names]
        + [f"time, {n}" for n in names]
        + ["problems with more work", "problems slower"],
        body,
        note="Slower: in each of five passes than in the slowest of five from zero.",
    )


def section(cells: pd.DataFrame) -> Section | None:
    """The section of the page; None without pairs."""
    p = pairs(cells)
    if p.empty:
        return None
    found = verdicts(p)
    n = p["problem"].nunique()
    solved = int(p.drop_duplicates("problem")["n_solves_cold"].sum())
    told = " ".join(f"{says} {v.word.capitalize()}." for says, v in found)
    drawn = Chart(
        "warm",
        "Each point is a sequence of problems with one solver: work and time from its last answer"
        f" over those from zero, drawn not below {FLOOR:g}.",
        [panel(p, cost) for cost, _ in STATEMENTS],
        columns=2,
    )
    judged = Table(
        "warmclaims",
        "What a warm start saves, judged solver by solver; times beyond the noise.",
        ["statement", "verdict", "evidence", "sizes"],
        [[says, Cell(v.word, MARK[v.word]), v.evidence, v.sizes] for says, v in found],
        paper=False,
    )
    return Section(
        "warm",
        "From problem to problem",
        f"{n} sequences with {solved} problems, each posed once and solved from different starts."
        f" {told}",
        [drawn],
        [judged, table(p)],
    )

"""What accuracy costs in time: error against time per scene, the Pareto front, the cheapest
combination per error."""

import collections
import itertools
import math
import re

import numpy as np
import pandas as pd

from bench import converged, registry, settings, stats
from bench import rows as rows_
from bench.chart import Chart, Line, Panel
from bench.paper import variants
from bench.section import Cell, Section, Table, error, si

# what the first screen asks for: a hundredth of a metre, of a metre a second, of a radian
LEVEL = 1e-2
LEVELS = (1e-1, 1e-2, 1e-3, 1e-4)
YARDSTICKS = {
    "trajectory": ("err_ref", "error of the trajectory"),
    "physical": ("res_ncp_rel", "residual of the exact Coulomb model"),
    "algebraic": ("rho", "residual of the complementarity problem"),
}


Scenes = list[tuple[str, pd.DataFrame]]  # (problem, its cells)


def own(cells: pd.DataFrame) -> pd.DataFrame:
    """Rows of the accuracy campaign; of all campaigns where there is none."""
    mine = cells[cells["campaign"].str.startswith("accuracy")]
    return confirmed(mine if len(mine) else cells)


def confirmed(cells: pd.DataFrame) -> pd.DataFrame:
    """A cell counts when the judge confirmed the solver's claim at the tolerance it was asked for:
    what that is worth, the error says. Experiments with effects are not answers to the scene as
    declared."""
    some = cells[~cells["command"].str.contains("--effects|--contact-order")]
    good = some["status"] == "ok"
    return kept_by_finer(
        some.assign(
            good=good, cost=some["t_total_s"].where(good & np.isfinite(some["t_total_s"]), np.inf)
        )
    )


LADDER = ["campaign", "part", "problem", "combination", "tol", "start", "duration_s", "effects"]


def kept_by_finer(cells: pd.DataFrame) -> pd.DataFrame:
    """Column `err_sure`: the largest error of the trajectory at this step and at every smaller one
    of the same settings, with the uncertainty of the reference added. An error that crosses zero
    between two larger ones is luck, and an error below the uncertainty is not known.
    """
    ladder = cells[cells["good"] & cells["err_ref"].notna()].sort_values("step_s")
    sure = ladder.groupby(LADDER, dropna=False)["err_ref"].cummax() + ladder["err_floor"]
    return cells.assign(err_sure=sure.reindex(cells.index))


def usable(cells: pd.DataFrame, column: str = "err_ref") -> pd.DataFrame:
    return cells[cells["good"] & np.isfinite(cells["cost"]) & cells[column].notna()]


def within(cells: pd.DataFrame, level: float, column: str = "err_ref") -> pd.DataFrame:
    """The usable cells that reach a level."""
    fit = usable(cells, column)
    return fit[fit["err_sure" if column == "err_ref" else column] <= level]


def cheapest(cells: pd.DataFrame, level: float, column: str = "err_ref") -> pd.Series | None:
    """The cell of least median time whose error is at most `level`; None when nothing gets
    there."""
    fit = within(cells, level, column)
    return None if fit.empty else fit.loc[fit["cost"].idxmin()]


def ties(cells: pd.DataFrame, best: pd.Series, level: float, column: str = "err_ref") -> list[str]:
    """Other combinations that get there in the same time: medians closer than the noise of their
    campaign and size, or intervals of the samples that overlap."""
    fit = within(cells, level, column)
    fit = fit[[rows_.tied(cell, best) for _, cell in fit.iterrows()]]
    return sorted(set(fit["combination"]) - {best["combination"]})


def scenes(cells: pd.DataFrame) -> Scenes:
    """Problems with an error to compare, in the order of their names: (problem, cells)."""
    some = cells[(cells["formulation"] != "") & cells["err_ref"].notna()]
    return [(p, g) for p, g in some.groupby("problem") if usable(g).shape[0] >= 2]


def drawn(cells: pd.DataFrame) -> np.ndarray:
    """Errors as they are drawn: what the reference does not resolve stands at half its uncertainty,
    in the middle of the band."""
    return np.where(cells["err_ref"] < cells["err_floor"], cells["err_floor"] / 2, cells["err_ref"])


def front(cells: pd.DataFrame) -> list[int]:
    """Indices of the cells that none beats in error and time; errors that are not resolved are
    equal."""
    return stats.pareto_front(np.maximum(cells["err_ref"], cells["err_floor"]), cells["cost"])


def spot(cell: pd.Series | dict) -> str:
    """A point of the figure in words."""
    error = (
        "not resolved" if cell["err_ref"] < cell["err_floor"] else f"error {cell['err_ref']:.2g}"
    )
    return (
        f"{cell['combination']}{rows_.from_last(cell['start'])}, h = {cell['step_s']:g} s, tol"
        f" {cell['tol']:.0e}: {error} ({cell['err_quantity']}), {si(cell['cost'], 's')}"
        + (f"; disturbed: {cell['disturbed']}" if cell["disturbed"] else "")
    )


# an uncertainty further below the least error is written, not drawn: the band would squeeze the
# points
NEAR = 0.03


def panel(problem: str, cells: pd.DataFrame, index: dict[str, int]) -> Panel:
    fit = usable(cells)
    y = fit["cost"].to_numpy(float) * 1e3
    best, floor = front(fit), float(fit["err_floor"].max())
    lines = (
        [Line("Pareto front", drawn(fit)[best].tolist(), y[best].tolist(), kind="front")]
        if best
        else []
    )
    if floor >= NEAR * drawn(fit).min():
        lines.append(
            Line(
                "not resolved: the reference is uncertain",
                [floor / 4, floor],
                [y.max(), y.max()],
                [y.min()] * 2,
                [y.max()] * 2,
                kind="band",
            )
        )
    for label, group in fit.groupby("label"):
        some = group.iloc[front(group)]
        low, high = (some["t_total_s" + e].to_numpy(float) * 1e3 for e in ("_low", "_high"))
        bad = cells[
            (cells["label"] == label)
            & ~cells["good"]
            & cells["t_total_s"].notna()
            & cells["err_ref"].notna()
        ]
        crosses = list(
            zip(drawn(bad).tolist(), (bad["t_total_s"].astype(float) * 1e3).tolist(), strict=True)
        )
        lines.append(
            Line(
                label,
                drawn(some).tolist(),
                (some["cost"].to_numpy(float) * 1e3).tolist(),
                low.tolist(),
                high.tolist(),
                crosses,
                hover=[spot(c) for c in some.to_dict("records")],
                hollow=[bool(d) for d in some["disturbed"]],
                variant=index.get(label, 0),
            )
        )
    xlabel = (
        f"error (reference ± {floor:.0e})" if fit["converged"].any() else "error of the trajectory"
    )
    return Panel(lines, title=short(problem), xlabel=xlabel, ylabel="time [ms]")


def short(problem: str) -> str:
    """A problem as a title of a panel: its first parameter is enough to tell it, or the name of
    its file."""
    path, _, options = problem.partition(":")
    name = path.rpartition("/")[2].removesuffix(".json")
    return f"{name}{':' if options else ''}{options.split(',')[0]}".replace("_", " ").replace(
        " deg=", "="
    )


def trades(found: Scenes) -> Scenes:
    """Scenes where accuracy is bought: more than one point on the front, and errors that are
    resolved."""
    return [
        (p, g)
        for p, g in found
        if (usable(g)["err_ref"] > usable(g)["err_floor"]).any() and len(front(usable(g))) >= 2
    ]


VALUES = 3  # of an option that figures tell apart: the two least and the largest


def drawn_values(values: set[str]) -> set[str]:
    """Which of an option's values are drawn: all where they are few or are words."""
    if len(values) <= VALUES or not all(v.isdigit() for v in values):
        return values
    ranked = sorted(values, key=int)
    return {*ranked[: VALUES - 1], ranked[-1]}


def tenths(cells: pd.DataFrame) -> list[tuple[float, str, pd.DataFrame]]:
    """[(times as long for a tenth of the error, problem, its front)] of the scenes whose front
    spans a decade of errors that are resolved."""
    out = []
    for problem, g in trades(scenes(cells)):
        fit = usable(g)
        fit = fit[fit["err_ref"] > fit["err_floor"]]
        best = fit.iloc[front(fit)]
        if len(best) < 2:
            continue
        decades = math.log10(best["err_ref"].max() / best["err_ref"].min())
        if decades >= 1:
            out.append(((best["cost"].max() / best["cost"].min()) ** (1 / decades), problem, best))
    return out


def kept(cells: pd.DataFrame) -> pd.DataFrame:
    """For a legible figure: a line for each formulation and each value of the options that it tells
    apart, over all of its other settings. The table and the page's rows have all of them."""
    given = [
        {o: v for o, v in rows_.options(text).items() if o in registry.apart(form)}
        for form, text in zip(cells["formulation"], cells["formulation_options"], strict=True)
    ]
    values = {}
    for form, options in zip(cells["formulation"], given, strict=True):
        for option, value in options.items():
            values.setdefault((form, option), set()).add(value)
    values = {key: drawn_values(found) for key, found in values.items()}
    shown = [
        all(v in values[form, o] for o, v in options.items())
        for form, options in zip(cells["formulation"], given, strict=True)
    ]
    configs = cells.get("formulation_config", cells["formulation"].map(lambda _: ""))
    labels = [
        rows_.formulation_label(form, ",".join(f"{o}={v}" for o, v in options.items()), config)
        for form, options, config in zip(cells["formulation"], given, configs, strict=True)
    ]
    return cells.assign(label=labels)[shown]


def price(cells: pd.DataFrame) -> float:
    """How many times the time of the cheapest point of the front its dearest takes."""
    fit = usable(cells)
    cost = fit.iloc[front(fit)]["cost"]
    return cost.max() / cost.min()


def picked(found: Scenes, most: int) -> Scenes:
    """Scenes for a figure: the situations in turn, in each those first where accuracy costs
    most."""
    queues = {s: [] for s in [*registry.situations(), ""]}
    for problem, group in sorted(found, key=lambda pg: (-price(pg[1]), pg[0])):
        queues[registry.situation(group["problem_family"].iloc[0])].append((problem, group))
    turns = [pg for turn in itertools.zip_longest(*queues.values()) for pg in turn if pg]
    return sorted(turns[:most], key=lambda pg: pg[0])


def chart(cells: pd.DataFrame, most: int = 12) -> Chart:
    found = trades(scenes(kept(cells)))
    shown = picked(found, most)
    if not shown:
        return None
    index = variants(kept(cells))
    return Chart(
        "accuracy_against_time",
        "What accuracy costs: total time against the error of the trajectory, one panel a scene"
        f" ({len(shown)} of the {len(found)} where accuracy has a price), for each formulation"
        " named below the settings that none of its own beats in both; grey: the front over them."
        " A cross is a run that was not solved, was cut short, or whose claim was not confirmed."
        " In the hatched band errors are below the uncertainty of the reference (rounding for a"
        " closed form, the spread of a converged run where there is none): not resolved, they"
        " stand in its middle.",
        [panel(p, g, index) for p, g in shown],
        columns=3,
        height=1.75,
    )


def level_cell(cells: pd.DataFrame, level: float, column: str = "err_ref") -> Cell:
    best = cheapest(cells, level, column)
    if best is None:
        if column == "err_ref" and usable(cells)["err_floor"].min() > level:
            return Cell(
                "not resolved",
                "none",
                f"the reference itself is uncertain by {error(usable(cells)['err_floor'].min())}",
            )
        return Cell(
            "not reached", "bad", f"the smallest is {error(usable(cells, column)[column].min())}"
        )
    same = ties(cells, best, level, column)
    more = f"\n= {len(same)} more" if same else ""
    return Cell(
        f"{best['combination']}{rows_.from_last(best['start'])}\nh = {best['step_s']:g} s,"
        f" {si(best['cost'], 's')}{more}",
        title=str(best.get("command", ""))
        + (f"\nin the same time: {', '.join(same)}" if same else ""),
        sort=best["cost"],
    )


def table(cells: pd.DataFrame) -> Table:
    rows = []
    for problem, group in scenes(cells):
        rows.append(
            [
                problem,
                (
                    group["err_quantity"].mode().iloc[0]
                    if "err_quantity" in group and len(group)
                    else ""
                ),
            ]
            + [level_cell(group, level) for level in LEVELS]
        )
    return Table(
        "cheapest",
        "Cheapest combination that reaches an error of the trajectory, per scene (error in the"
        " unit of the quantity; total time of the run). Reached: the error and the uncertainty of"
        ' the reference together stay below, at this step and at every smaller one. "= n more": so'
        " many others take the same time, to the noise of their campaign and size or to the spread"
        " of the samples. The command that reruns it is the tooltip; scripts/recommend prints it.",
        ["scene", "quantity"] + [f"error ≤ {v:g}" for v in LEVELS],
        rows,
    )


def yardsticks_table(cells: pd.DataFrame, level: float = 1e-3) -> Table:
    rows = []
    for problem, group in scenes(cells):
        rows.append(
            [problem] + [level_cell(group, level, column) for column, _ in YARDSTICKS.values()]
        )
    return Table(
        "yardsticks",
        f"Three yardsticks: the cheapest combination that stays below {level:g} by the trajectory,"
        " by the residual of the exact Coulomb model, and by the residual of its own problem."
        " Where they differ, a fast solver of an easier model is not a fast solver of the scene.",
        ["scene"] + [name for _, name in YARDSTICKS.values()],
        rows,
    )


def references_table(cells: pd.DataFrame) -> Table:
    """The converged runs that stand in for closed forms, and how close the nearest other
    formulation comes."""
    rows = []

    def told(value: float, ref: converged.Reference):
        return error(value) if value >= ref.uncertainty else "not resolved"

    for (problem, _, _), ref in sorted(
        converged.references(cells).items(), key=lambda kv: kv[0][0]
    ):
        judged = usable(cells[(cells["problem"] == problem) & cells["converged"]])
        near = judged.loc[judged["err_ref"].idxmin()] if len(judged) else None
        least = judged["step_s"].min()
        fine = judged[judged["step_s"] == least]["err_ref"]
        rows.append(
            [
                problem,
                f"end {ref.quantity}",
                f"{ref.value:.9g}",
                f"± {ref.uncertainty:.1g}",
                f"{ref.combination}, {ref.runs} runs, finest h = {ref.step:g} s",
                f"{ref.order:.2g}" if ref.order > 0 else "none",
                (
                    ""
                    if near is None
                    else (
                        f"{told(near['err_ref'], ref)} ({near['combination']}, h ="
                        f" {near['step_s']:g} s)"
                    )
                ),
                (
                    ""
                    if near is None
                    else (
                        " to ".join(dict.fromkeys((told(fine.min(), ref), told(fine.max(), ref))))
                        + f" at h = {least:g} s"
                    )
                ),
            ]
        )
    planned = cells[cells["part"].str.startswith(converged.PART)]
    for problem, runs in planned.groupby("problem"):
        if problem not in {row[0] for row in rows}:
            rows.append(
                [
                    problem,
                    "",
                    Cell("no reference", "bad"),
                    "",
                    (
                        f"{int(runs['good'].sum())} of {len(runs)} runs verified:"
                        f" {', '.join(sorted(set(runs['combination'])))}"
                    ),
                    "",
                    "",
                    "",
                ]
            )
    return Table(
        "references",
        "Converged references, for scenes without a closed form: the finest of a ladder of runs and"
        " its uncertainty (grid convergence index of Oberkampf & Roy 2010: the last difference of"
        " the ladder times a factor of safety, more where the observed order is not 1). The"
        " formulation that gives the reference is not judged by it.",
        [
            "scene",
            "quantity",
            "value",
            "uncertainty",
            "by",
            "observed order",
            "nearest other formulation",
            "errors at the smallest step",
        ],
        rows,
    )


# ---- the first screen ----------------------------------------------------------------------------


def plain(combination: str) -> str:
    """'regularized:ratio=100 + lemke' -> 'regularized + lemke': what is recommended; the options
    are in the example."""
    return " + ".join(part.split(":")[0] for part in combination.split(" + "))


def asked(here: Scenes) -> collections.Counter[str]:
    """combination -> how many of the scenes it was run on, to be measured"""
    out = collections.Counter()
    for _, group in here:
        tried = group[
            ~group["status"].isin(["unsupported", "skipped"])
            & ~group["part"].str.startswith(converged.PART)
            & ~(group["good"] & group["err_ref"].isna())
        ]
        out.update({plain(c) for c in tried["combination"]})
    return out


def candidates(here: Scenes, level: float) -> dict[str, dict[str, pd.Series]]:
    """combination -> {scene: its cheapest cell that reaches the level}"""
    out = {}
    for problem, group in here:
        fit = within(group, level)
        for name, g in fit.groupby([plain(c) for c in fit["combination"]]):
            out.setdefault(name, {})[problem] = g.loc[g["cost"].idxmin()]
    return out


# of the scenes of a kind that most combinations were run on: what was run on fewer is no general
# answer
WIDELY = 0.75


def choose(
    here: Scenes, level: float
) -> list[tuple[tuple[bool, float, float], str, dict[str, pd.Series]]]:
    """[((widely run, share missed, how much slower), combination, its cells)], the best first: what
    was run widely, reaches the level on the largest share of the scenes it was run on, and among
    those is the fastest (geometric mean of its time over the best's).
    """
    run = asked(here)
    found = {name: c for name, c in candidates(here, level).items() if run[name]}
    best = {
        p: min(c[p]["cost"] for c in found.values() if p in c)
        for p, _ in here
        if any(p in c for c in found.values())
    }
    score = {
        name: (
            run[name] < WIDELY * max(run.values()),
            1 - len(cells) / run[name],
            math.exp(np.mean([math.log(c["cost"] / best[p]) for p, c in cells.items()])),
        )
        for name, cells in found.items()
    }
    return sorted((s, name, found[name]) for name, s in score.items()) if score else []


def rival(
    won: dict[str, pd.Series], name: str, theirs: dict[str, pd.Series], run: int
) -> dict | None:
    """The next formulation against the winner, on the scenes that both reach: a mean over other
    scenes compares scenes, not methods."""
    both = sorted(set(won) & set(theirs))
    ratio, low, high, _ = stats.paired_ratio(
        [theirs[p]["cost"] for p in both], [won[p]["cost"] for p in both]
    )
    return {
        "name": name,
        "reached": len(theirs),
        "run": run,
        "both": len(both),
        "ratio": ratio,
        "low": low,
        "high": high,
        "noise": max([1.0] + [side[p]["noise"] for p in both for side in (won, theirs)]),
    }


def open_with(r: dict) -> bool:
    """Nobody can say who of the two is faster: within the noise, or 1 is in the interval."""
    low, high = (float(f"{r[k]:.2g}") for k in ("low", "high"))  # as printed: from 1 on: no order
    return 1 / r["noise"] <= r["ratio"] <= r["noise"] or (r["both"] > 1 and low <= 1 <= high)


def kind_of_rival(r: dict) -> str:
    """'open', 'slower', or 'few': who was run on too few of the scenes, or reaches none of the
    same."""
    if r["few"] or not r["both"]:
        return "few"
    return "open" if open_with(r) else "slower"


def times(ratio: float) -> str:
    return f"{ratio:.0f}" if ratio >= 100 else f"{ratio:.2g}"


def rival_words(r: dict, mark: str = "") -> str:
    """'velocity + lemke 3.1 [2.2, 4] on 4 (reaches 5 of 6)'; mark: what the name stands in."""
    name, reaches = f"{mark}{r['name']}{mark}", f"reaches {r['reached']} of {r['run']}"
    if not r["both"]:
        return f"{name} on none of the same ({reaches})"
    ratio, low, high = (times(r[k]) for k in ("ratio", "low", "high"))
    between = f" [{low}, {high}]" if r["both"] > 1 else ""
    return f"{name} {ratio}{between} on {r['both']} ({reaches})"


def rival_in_short(r: dict) -> str:
    """As much as a card holds: the interval where it decides nothing, the ratio where it does."""
    kind = kind_of_rival(r)
    if kind == "few":
        return r["name"]
    ratio, low, high = (times(r[k]) for k in ("ratio", "low", "high"))
    between = f" [{low}, {high}]" if kind == "open" and r["both"] > 1 else ""
    return f"{r['name']} {ratio}{between}"


def rivals_in_short(others: list[dict], kind: str) -> str:
    return ", ".join(rival_in_short(r) for r in others if kind_of_rival(r) == kind)


def rivals_words(others: list[dict], kind: str, mark: str = "") -> str:
    return ", ".join(rival_words(r, mark) for r in others if kind_of_rival(r) == kind)


MANY = 100  # contacts from which a scene has an answer of its own on the first screen


def tenth_words(group: pd.DataFrame, level: float) -> str:
    """What a tenth of the error costs on one scene."""
    best, next_ = cheapest(group, level), cheapest(group, level / 10)
    if next_ is None:
        return "a tenth of the error is not reached"
    if next_["cost"] <= max(best["noise"], next_["noise"]) * best["cost"]:
        return "a tenth of the error costs nothing more"
    return f"a tenth of the error takes {next_['cost'] / best['cost']:.2g} times as long"


def facets_of(combinations: list[str]) -> list[int]:
    """The numbers of facets that the polyhedral cones among these have."""
    found = {m.group(1) for c in combinations if (m := re.search(r"facets=(\d+)", c))}
    return sorted(int(n) for n in found)


def largest(here: Scenes, level: float) -> dict | None:
    """The cheapest on the scene of most contacts that is reached, where it has many: what wins on
    most scenes, small ones, need not win there."""
    found = [(p, g, best) for p, g in here if (best := cheapest(g, level)) is not None]
    sized = [f for f in found if f[2]["n_contacts"] >= MANY]
    if not sized:
        return None
    problem, group, best = max(sized, key=lambda f: f[2]["n_contacts"])
    first = (
        within(group, level)
        .sort_values("cost")
        .drop_duplicates("formulation")[["formulation", "combination", "cost"]]
    )
    others = first[first["formulation"] != best["formulation"]]
    same = ties(group, best, level)
    return {
        "use": best["combination"],
        "formulation": best["formulation"],
        "solver": best["solver"],
        "problem": problem,
        "contacts": best["n_contacts"],
        "step": best["step_s"],
        "start": best["start"],
        "per_step": best["cost"] / best["n_steps"],
        "error": best["err_ref"],
        "quantity": best["err_quantity"],
        "same": same,
        "facets": facets_of(first["combination"]),
        "others": [
            (r["combination"], r["cost"] / best["cost"])
            for r in others.to_dict("records")
            if r["combination"] not in same
        ],
        "tenth": tenth_words(group, level),
        "command": str(best.get("command", "")),
    }


def largest_words(large: dict | None) -> tuple[str, str]:
    """(the answer, what stands behind it) for a reader; nothing where no scene has many
    contacts."""
    if not large:
        return "", ""
    same = f"As fast: {', '.join(large['same'])}. " if large["same"] else ""
    slower = [f"{name} ({ratio:.2g} times the time)" for name, ratio in large["others"][:3]]
    unlike = (
        "The polyhedral cones have unlike facets, so their order is not one of formulations. "
        if len(large["facets"]) > 1
        else ""
    )
    return (
        f"{large['contacts']:g} contacts ({large['problem']}): {large['use']},"
        f" {si(large['per_step'], 's', 2)} a step",
        f"Of all settings that were run there. Steps of {large['step'] * 1e3:g}"
        f" ms{rows_.from_last(large['start'])}. {same}"
        + (f"Slower: {', '.join(slower)}. {unlike}" if slower else "")
        + f"Error {error(large['error'])} ({large['quantity']}); {large['tenth']}.",
    )


def below_many(here: Scenes) -> Scenes:
    """The scenes that are not large, all where there are no others: a mean over both is an answer
    for neither."""
    return [(p, g) for p, g in here if not g["n_contacts"].max() >= MANY] or here


def kind(a: dict) -> str:
    """'stack, below 100 contacts, cold': the scenes and the start that an answer is for; no start
    where the rows have one only."""
    below = f", below {MANY} contacts" if a.get("below") else ""
    return a["situation"] + below + (f", {a['steps']}" if a.get("steps") else "")


def answer(here: Scenes, level: float, forms: set[str]) -> dict:
    """What to use on these scenes, of one start and one setting a formulation, and every other
    formulation beside it; `forms`: whose absence from a scene is told."""
    ranked = choose(here, level)
    if not ranked:
        return {"use": "", "scenes": len(here), "others": []}
    (_, _, slower), name, won = ranked[0]
    run = asked(here)
    most = WIDELY * max(run.values())
    first = {}  # of each other formulation the combination that is ranked first
    for _, n, theirs in ranked[1:]:
        first.setdefault(n.split(" + ")[0], (n, theirs))
    first.pop(name.split(" + ")[0], None)
    others = [
        {**rival(won, n, theirs, run[n]), "few": run[n] < most} for n, theirs in first.values()
    ]
    tried = [g[~g["status"].isin(["unsupported", "skipped"])] for _, g in here]
    problem = max(
        won,
        key=lambda p: won[p]["n_contacts"] if won[p]["n_contacts"] == won[p]["n_contacts"] else 0,
    )
    cell = won[problem]
    return {
        "use": name,
        "of": len(here),
        "scenes": run[name],
        "reached": len(won),
        "slower": slower,
        "forms": len(forms),
        "all_ran": sum(forms <= set(g["formulation"]) for g in tried),
        "problem": problem,
        "step": cell["step_s"],
        "per_step": cell["cost"] / cell["n_steps"] if cell["n_steps"] else math.nan,
        "contacts": cell["n_contacts"],
        "error": cell["err_ref"],
        "physical": cell["res_ncp_rel"],
        "others": others,
        "command": str(cell.get("command", "")),
        "solver": name.split(" + ")[1],
        "formulation": name.split(" + ")[0],
    }


def advise(cells: pd.DataFrame, level: float = LEVEL) -> list[dict]:
    """What the first screen says: for each situation and start one answer, from one setting a
    formulation, and one for the largest scene where that has many contacts, from all that was run
    on it. From rows only."""
    cells = own(cells)
    starts = settings.measured(cells) or [""]
    kept = settings.one_each(cells)
    of_start = {s: settings.started(kept, s) if s else kept for s in starts}
    best = [cheapest(g, level) for some in of_start.values() for _, g in scenes(some)]
    forms = {b["formulation"] for b in best if b is not None}
    out = []
    for situation in registry.situations():

        def of(some: pd.DataFrame, situation: str = situation) -> Scenes:
            return [
                (p, g)
                for p, g in scenes(some)
                if registry.situation(g["problem_family"].iloc[0]) == situation
            ]

        large = largest(of(cells), level)
        made = []
        for start in starts:
            here = of(of_start[start])
            made.append(
                {
                    "situation": situation,
                    "start": start,
                    "steps": settings.STARTS[start] if len(starts) > 1 else "",
                    "below": bool(large),
                    "large": None,
                    **answer(below_many(here) if large else here, level, forms),
                }
            )
        at = [a for a in made if large and a["start"] == large["start"]] or made
        at[0]["large"] = large
        out += made
    return out


OTHERS = {"open": "open who is faster", "slower": "slower", "few": "run on too few to tell"}


def declared_words() -> str:
    """'`velocity:facets=8`, `position:facets=4`': where the declared setting has options."""
    return ", ".join(f"`{f}:{options}`" for f, options in sorted(settings.declared()) if options)


READ = (
    f"Each formulation has one setting, chosen here ({declared_words()}; of the others the"
    " program's own), with the solver that ranks first; its step is the cheapest that reaches"
    " the error. Behind each other formulation stand its time"
    " over that of the one to use, with the 95 % interval of the mean over scenes (a rough one"
    " where they are three), on how many scenes that is, those that both reach, and on how many"
    " of those that it was run on it reaches the error. Where the interval has 1 in it the rows"
    " do not tell who is faster. All: every formulation that is cheapest on some scene of any"
    " kind."
)


def all_ran_words(a: dict) -> str:
    """On how many scenes no win lacks its rival."""
    return f"all {a['forms']} ran on {a['all_ran']} of {a['of']}"


def advice(advised: list[dict], level: float = LEVEL) -> Table:
    """The same as a table, for the paper; `breaks`, where an entry has it, is what the stress tests
    say."""
    rows = []
    for a in advised:
        if not a["use"]:
            rows.append(
                [
                    kind(a),
                    Cell(
                        (
                            f"nothing reaches {level:g}"
                            if a["scenes"]
                            else "no scene of this kind in the rows"
                        ),
                        "bad",
                    ),
                    *[""] * 8,
                ]
            )
            continue
        rows.append(
            [
                kind(a),
                Cell(a["use"], "good"),
                (
                    f"{si(a['per_step'], 's')} a step of {a['step']:g} s with {a['contacts']:g}"
                    f" contacts ({a['problem']})"
                ),
                (
                    f"{a['reached']} of {a['scenes']} scenes it was run on, {a['slower']:.2g} times"
                    " the best"
                ),
                all_ran_words(a),
                rivals_words(a["others"], "open"),
                rivals_words(a["others"], "slower"),
                rivals_words(a["others"], "few"),
                a.get("breaks", ""),
                a["command"],
            ]
        )
    return Table(
        "advice",
        "Which formulation and solver to use: the combination that reaches an error of the"
        f" trajectory of at most {level:g} on the largest share of the scenes of a kind that it was"
        f" run on (at least {WIDELY:.0%} of them), and among those the fastest (geometric mean of"
        f" its time over the best time of each scene). {READ}",
        [
            "situation",
            "use",
            "cost",
            "reached",
            "rivals",
            *OTHERS.values(),
            "stress tests",
            "see it yourself",
        ],
        rows,
        code=9,
    )


def section(cells: pd.DataFrame) -> Section:
    cells = own(cells)
    found = scenes(cells)
    if not found:
        return None
    made = chart(cells)
    given = references_table(cells)
    reached = sum(all(cheapest(g, v) is not None for v in LEVELS) for _, g in found)
    return Section(
        "accuracy",
        "What accuracy costs in time",
        "Error against time over steps, facets, stiffness, tolerances and iteration limits. Left"
        " and low is better. A setting is joined when every solve of it was confirmed at the"
        f" tolerance it was asked for. {len(found)} scenes, {len(converged.references(cells))} of"
        f" them measured by a converged run of another method; {reached} reach all four levels.",
        [made] if made else [],
        [table(cells)] + ([given] if given.rows else []) + [yardsticks_table(cells)],
        {"AccuracyScenes": str(len(found)), "AccuracyScenesAll": str(reached)},
    )

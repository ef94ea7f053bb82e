"""What accuracy costs in time: error against time per scene, the Pareto front, the cheapest combination per error."""
import numpy as np

from bench import stats
from bench.chart import Chart, Line, Panel
from bench.paper import FLOOR, variants
from bench.section import Cell, Section, Table, error, si

LEVELS = (1e-1, 1e-2, 1e-3, 1e-4)
ROUNDING = 1e-12  # a scene whose every error is below has nothing to trade
YARDSTICKS = {"trajectory": ("err_ref", "error of the trajectory"), "physical": ("res_ncp_rel", "residual of the exact Coulomb model"),
              "algebraic": ("rho", "residual of the complementarity problem")}

# What a reader comes with, and the scenes of the catalogue that stand for it
SITUATIONS = {"stack": ("stack", "wall", "pyramid", "card_house", "arch", "sphere_pile", "pile3", "row", "granular_column"),
              "grasp": ("gripper", "vise", "wedge", "jam", "capstan"),
              "sliding": ("slide", "incline", "conveyor", "belt", "plank", "push", "tablecloth", "spin"),
              "impact": ("bounce", "impact", "drop", "cradle", "rocking", "tip")}


def usable(cells, column="err_ref"):
    return cells[cells["good"] & np.isfinite(cells["cost"]) & cells[column].notna()]


def cheapest(cells, level, column="err_ref"):
    """The cell of least median time whose error is at most `level`; None when nothing gets there."""
    fit = usable(cells, column)
    fit = fit[fit[column] <= level]
    return None if fit.empty else fit.loc[fit["cost"].idxmin()]


def situation_of(family):
    return next((s for s, names in SITUATIONS.items() if family in names), "")


def own(cells):
    """Rows of the accuracy campaign; of all campaigns where there is none."""
    mine = cells[cells["campaign"].str.startswith("accuracy")]
    some = mine if len(mine) else cells
    return some[~some["command"].str.contains("--effects")]


def scenes(cells):
    """Problems with an error to compare, in the order of their names: (problem, cells)."""
    some = cells[(cells["formulation"] != "") & cells["err_ref"].notna()]
    return [(p, g) for p, g in some.groupby("problem") if usable(g).shape[0] >= 2]


def panel(problem, cells, index):
    fit = usable(cells)
    x = np.maximum(fit["err_ref"].to_numpy(float), FLOOR)
    y = fit["cost"].to_numpy(float) * 1e3
    front = stats.pareto_front(x, y)
    lines = [Line("Pareto front", x[front].tolist(), y[front].tolist(), kind="front")] if front else []
    for label, group in fit.groupby("label"):
        gx = np.maximum(group["err_ref"].to_numpy(float), FLOOR)
        gy = group["cost"].to_numpy(float) * 1e3
        own = stats.pareto_front(gx, gy)
        names = [f"{c}, h = {h:g} s" for c, h in zip(group["combination"], group["step_s"])]
        low, high = (group["t_total_s" + e].to_numpy(float)[own] * 1e3 for e in ("_low", "_high"))
        bad = cells[(cells["label"] == label) & ~cells["good"] & cells["t_total_s"].notna() & cells["err_ref"].notna()]
        crosses = [(max(float(a), FLOOR), float(b) * 1e3) for a, b in zip(bad["err_ref"], bad["t_total_s"])]
        lines.append(Line(label, gx[own].tolist(), gy[own].tolist(), low.tolist(), high.tolist(), crosses,
                          hover=[names[i] for i in own], variant=index.get(label, 0)))
    return Panel(lines, title=problem.split(":")[0].replace("_", " "), xlabel="error of the trajectory", ylabel="time [ms]")


def chosen(cells, most):
    """One problem per family, the one with most cells."""
    best = {}
    for problem, group in scenes(cells):
        family = group["problem_family"].iloc[0]
        if family not in best or len(group) > len(best[family][1]):
            best[family] = (problem, group)
    return [best[f] for f in sorted(best)][:most]


def chart(cells, most=9):
    picked = [(p, g) for p, g in chosen(cells, 99) if usable(g)["err_ref"].max() > ROUNDING and len(stats.pareto_front(g["err_ref"], g["cost"])) >= 2][:most]
    if not picked:
        return None
    index = variants(cells)
    return Chart("accuracy_against_time", "What accuracy costs: total time against the error of the trajectory, one panel a scene, per "
                 "formulation the combinations that none of its own beats in both; grey: the front over all. A cross is a claim that was "
                 f"not verified. Errors below {FLOOR:g} are drawn there.",
                 [panel(p, g, index) for p, g in picked], columns=3, height=1.95)


def level_cell(cells, level, column="err_ref"):
    best = cheapest(cells, level, column)
    if best is None:
        return Cell("not reached", "bad")
    return Cell(f"{best['combination']}\nh = {best['step_s']:g} s, {si(best['cost'], 's')}", title=str(best.get("command", "")), sort=best["cost"])


def table(cells):
    rows = []
    for problem, group in scenes(cells):
        rows.append([problem] + [level_cell(group, level) for level in LEVELS])
    return Table("cheapest", "Cheapest verified combination that reaches an error of the trajectory, per scene (error in the unit of the scene's first prediction; total time of the run; the "
                 "command that reruns it is the tooltip, and scripts/recommend prints it).",
                 ["scene"] + [f"error ≤ {v:g}" for v in LEVELS], rows)


def advice(cells, level=1e-2):
    """The first screen: one line a situation, from rows only."""
    cells = own(cells)
    rows = []
    for situation in SITUATIONS:
        here = [(p, g) for p, g in scenes(cells) if situation_of(g["problem_family"].iloc[0]) == situation]
        if not here:
            rows.append([situation, Cell("no scene of this kind in the rows", "none"), "", "", "", ""])
            continue
        best = [(p, cheapest(g, level), g) for p, g in here]
        reached = [(p, b, g) for p, b, g in best if b is not None]
        if not reached:
            rows.append([situation, Cell(f"nothing reaches {level:g}", "bad"), "", "", f"0 of {len(here)} scenes", ""])
            continue
        votes = {}
        for p, b, _ in reached:
            votes.setdefault(b["combination"], []).append((p, b))
        name, won = sorted(votes.items(), key=lambda kv: (-len(kv[1]), sum(b["cost"] for _, b in kv[1])))[0]
        p, b = max(won, key=lambda w: w[1]["cost"])  # the largest of them as the example
        steps = b["n_steps"] if b.get("n_steps", 0) else np.nan
        rows.append([situation, Cell(name, "good"), f"{b['step_s']:g} s", si(b["cost"] / steps, "s"),
                     f"{len(won)} of {len(here)} scenes, e.g. {p} (error {error(b['err_ref'])})", str(b.get("command", ""))])
    return Table("advice", f"Which formulation and solver to use: the cheapest verified combination with an error of the trajectory of at most {level:g}, "
                 "as measured in this campaign.", ["situation", "use", "step", "time per step", "won on", "see it yourself"], rows, code=5)


def section(cells):
    cells = own(cells)
    if not scenes(cells):
        return None
    made = chart(cells)
    return Section("accuracy", "What accuracy costs in time",
                   "Error against time over steps, facets, stiffness and tolerances. Left and low is better. Only rows whose every solve was verified are joined.",
                   [made] if made else [], [table(cells)])

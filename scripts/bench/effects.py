"""What an effect is worth: everything on, as declared, and each declared effect dropped in turn."""
import re

from bench.chart import Chart, Line, Panel
from bench.section import Cell, Section, Table, error, si

MARKS = ["velocity", "regularized", "normal", "acceleration", "event", "boxed", "penalty"]


def kind(command):
    """What was asked for: the argument of --effects in the cell's command."""
    found = re.search(r"--effects '?([^' ]*)", command)
    text = found.group(1) if found else "declared"
    return {"declared": "as declared", "all": "everything on"}.get(text, text)


def chart(worth):
    """Time of a run relative to the one as declared, a row a scene, a mark for each change."""
    panels = []
    for combo, kinds in sorted(worth.items()):
        scenes = sorted({p for points in kinds.values() for p, _ in points})
        lines = [Line("as declared", [1.0] * len(scenes), list(range(len(scenes))), kind="points", look_as="coulomb")]
        for i, (name, points) in enumerate(sorted(kinds.items(), key=lambda kv: (kv[0] != "everything on", kv[0]))):
            lines.append(Line(name, [r for _, r in points], [scenes.index(p) for p, _ in points], kind="points", look_as=MARKS[i % len(MARKS)]))
        panels.append(Panel(lines, title=combo, xlabel="time of the run / as declared", xlog=2, ylog=0, yticks=[s.split(":")[0] for s in scenes]))
    return Chart("effects", "What an effect is worth: time of the run with everything on and with one declared effect dropped, relative to the run as "
                 "declared. Left is cheaper.", panels, columns=2, height=0.6 + 0.135 * max(len(p.yticks) for p in panels))


def section(cells):
    some = cells[cells["campaign"].str.startswith("effects")]
    if some.empty:
        return None
    table, worth = [], {}
    cheaper = compared = 0
    for (problem, combo, step), g in some.groupby(["problem", "combination", "step_s"]):
        g = g.assign(kind=[kind(c) for c in g["command"]])
        g = g[(g["kind"].isin(["as declared", "everything on"])) | ~g["effects"].isin(g[g["kind"] == "as declared"]["effects"])]
        declared = g[g["kind"] == "as declared"]
        base = declared["t_total_s"].iloc[0] if len(declared) else float("nan")
        everything = g[g["kind"] == "everything on"]
        if len(everything) and len(declared) and declared["good"].all() and everything["good"].all():
            compared += 1
            cheaper += bool(base <= everything["t_total_s"].iloc[0] * 1.02)
        order = {"everything on": 0, "as declared": 1}
        for _, c in g.assign(o=g["kind"].map(order).fillna(2)).sort_values(["o", "kind"]).iterrows():
            ratio = c["t_total_s"] / base
            if c["good"] and ratio == ratio and c["kind"] != "as declared":
                worth.setdefault(combo, {}).setdefault(c["kind"], []).append((problem, ratio))
            table.append([problem, combo, c["kind"], f"{c['n_dof']:g}", f"{c['lcp_dim']:g}", Cell(si(c["t_total_s"] / c["n_steps"], "s"), sort=c["t_total_s"]),
                          f"{ratio:.2f}" if ratio == ratio else "", Cell(error(c["err_ref"]), "" if c["good"] else "bad"), c["status"]])
    charts = [chart(worth)] if worth else []
    return Section("effects", "What an effect is worth",
                   f"A scene pays only for what it declares: as declared is at most 2 % dearer than everything on in {cheaper} of {compared} pairs.", charts,
                   [Table("effects", "Unknowns, time per step and error with everything on, as declared, and with each declared effect dropped.",
                          ["scene", "combination", "effects", "dofs", "LCP", "time per step", "time / declared", "error", "status"], table)],
                   {"EffectsCompared": str(compared), "EffectsCheaper": str(cheaper)})

"""What breaks first: every stressor against every combination, with the reason."""
import re

import numpy as np

from bench import rows as rows_
from bench.chart import Heat
from bench.section import Cell, Section, Table

# In the order of the questions asked of a cell; thresholds are part of the answer and printed beside the map.
DRIFT = 1e-2  # energy gained relative to the energy of the scene
DEEP = 1e-2  # penetration [m]
MARK = {"stable": "good", "misses": "fair", "penetrates": "fair", "gains energy": "bad", "false claim": "bad", "not defined": "none"}


def word(cell):
    """One word for how a run ended, and the longer reason."""
    if cell["status"] in ("unsupported", "skipped"):
        return "not defined", cell.get("note", "")
    if cell["status"] == "unverified":
        return "false claim", "claimed solved, the judge disagrees"
    if cell["status"] != "ok" or not cell["verified"]:
        return cell["status"], cell.get("note", "") or "fails, and says so"
    if np.isfinite(cell.get("energy_drift_rel", np.nan)) and cell["energy_drift_rel"] > DRIFT:
        return "gains energy", f"energy drift {cell['energy_drift_rel']:.2g}"
    if np.isfinite(cell.get("penetration_m", np.nan)) and cell["penetration_m"] > DEEP:
        return "penetrates", f"{cell['penetration_m']:.2g} m"
    if np.isfinite(cell.get("n_predictions_missed", np.nan)) and cell["n_predictions_missed"] > 0:
        return "misses", f"misses {cell['n_predictions_missed']:.0f} of {cell['n_predictions']:.0f} predictions ({cell.get('err_quantity', '')})"
    return "stable", ""


def severities(group):
    """What is turned up along a ladder, and how far: the numeric parameter that varies, else 1/h. (name, values)"""
    options = [rows_.options(str(p).partition(":")[2]) for p in group["problem"]]
    for name in dict.fromkeys(k for o in options for k in o):
        values = [o.get(name, "") for o in options]
        if len(set(values)) > 1 and all(re.fullmatch(r"[-+0-9.eE]+", v) for v in values):
            return name, [float(v) for v in values]
    return "1/h", [1 / h if h > 0 else 0.0 for h in group["step_s"]]


def summary(group):
    """Cell of the map: how many rungs stand, and what brings the first one down."""
    name, values = severities(group)
    rungs = [(value, name, *word(cell)) for value, (_, cell) in zip(values, group.iterrows())]
    rungs.sort(key=lambda r: r[0], reverse=name == "1/h")
    defined = [r for r in rungs if r[2] != "not defined"]
    if not defined:
        return Cell("–", "none", rungs[0][3] or "not defined for this combination")
    stands = [r for r in defined if r[2] == "stable"]
    if len(stands) == len(defined):
        return Cell(f"stable {len(stands)}/{len(defined)}", "good", "stands on every rung", sort=1.0)
    first = next(r for r in defined if r[2] != "stable")
    at = "" if not first[0] else f"h = {1 / first[0]:g} s" if first[1] == "1/h" else f"{first[1]} = {first[0]:g}"
    share = len(stands) / len(defined)
    return Cell(f"{first[2]} {len(stands)}/{len(defined)}", "fair" if share >= 0.5 else "bad", f"first at {at}: {first[3] or first[2]}", sort=share)


def section(cells):
    some = cells[cells["campaign"].str.startswith("stability")]
    if some.empty:
        return None
    some = some.assign(stressor=[f"{f}: {p}" if p else f for f, p in zip(some["problem_family"], some["part"])])
    families = sorted(some["stressor"].unique())
    combos = sorted(some["combination"].unique())
    table = []
    for combo in combos:
        here = some[some["combination"] == combo]
        table.append([combo] + [summary(g) if len(g := here[here["stressor"] == family]) else Cell("not run", "none", "no such cell in this campaign")
                                for family in families])
    defined = [r for r in table if any(c.sort is not None for c in r[1:])]
    heat = Heat("stability", "Stability map: how many rungs of each ladder stand and, if not all, what brings the first one down. Combinations that are "
                "not defined for any stressor are left out here and named in the table of the page.",
                [r[0] for r in defined], [f.replace(": ", "\n") for f in families], [[(c.text, c.sort) for c in r[1:]] for r in defined])
    total = sum(len(r) - 1 for r in table)
    blank = sum(c.text == "not run" for r in table for c in r[1:])
    return Section("stability", "What breaks first",
                   "Each stressor is a ladder. A cell says how many rungs stand and, if not all, in one word what the first failing rung does: "
                   f"misses (a prediction), penetrates (more than {DEEP:g} m), gains energy (more than {DRIFT:g} of it), false claim, or the status of an honest failure. "
                   "Tooltips name the rung.", [heat] if defined else [],
                   [Table("stability", f"Stability map: combinations against stressors ({total - blank} of {total} fields run).", ["combination"] + families, table)])

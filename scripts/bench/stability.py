"""What breaks first: every stressor against every combination, with the reason."""
import re

import numpy as np

from bench import rows as rows_
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


def severity(problem, family, step):
    """What is turned up: the last numeric parameter of the problem; the step where there is none."""
    text = str(problem).partition(":")[2]
    values = [(k, v) for k, v in rows_.options(text).items() if re.fullmatch(r"[-+0-9.eE]+", v)]
    return (values[-1][0], float(values[-1][1])) if values else ("h", 1 / step if step else 0.0)


def summary(group):
    """Cell of the map: how many rungs stand, and what brings the first one down."""
    rungs = []
    for _, cell in group.iterrows():
        name, value = severity(cell["problem"], cell["problem_family"], cell["step_s"])
        rungs.append((value, name, *word(cell)))
    rungs.sort(key=lambda r: r[0])
    defined = [r for r in rungs if r[2] != "not defined"]
    if not defined:
        return Cell("–", "none", rungs[0][3] or "not defined for this combination")
    stands = [r for r in defined if r[2] == "stable"]
    if len(stands) == len(defined):
        return Cell(f"stable {len(stands)}/{len(defined)}", "good", "stands on every rung", sort=1.0)
    first = next(r for r in defined if r[2] != "stable")
    at = f"1/h = {first[0]:g}" if first[1] == "h" else f"{first[1]} = {first[0]:g}"
    share = len(stands) / len(defined)
    return Cell(f"{first[2]} {len(stands)}/{len(defined)}", "fair" if share >= 0.5 else "bad", f"first at {at}: {first[3] or first[2]}", sort=share)


def section(cells):
    some = cells[cells["campaign"].str.startswith("stability")]
    if some.empty:
        return None
    families = sorted(some["problem_family"].unique())
    combos = sorted(some["combination"].unique())
    table = []
    for family in families:
        here = some[some["problem_family"] == family]
        table.append([family] + [summary(g) if len(g := here[here["combination"] == c]) else Cell("not run", "none", "no such cell in this campaign")
                                 for c in combos])
    total = sum(len(r) - 1 for r in table)
    blank = sum(c.text == "not run" for r in table for c in r[1:])
    return Section("stability", "What breaks first",
                   "Each stressor is a ladder. A cell says how many rungs stand and, if not all, in one word what the first failing rung does: "
                   f"misses (a prediction), penetrates (more than {DEEP:g} m), gains energy (more than {DRIFT:g} of it), false claim, or the status of an honest failure. "
                   "Tooltips name the rung.", [],
                   [Table("stability", f"Stability map: stressors against combinations ({total - blank} of {total} fields run).", ["stressor"] + combos, table)])

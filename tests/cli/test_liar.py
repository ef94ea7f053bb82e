"""A solver that returns z = 0 and claims success, from the campaign to the page: it scores as
failing everywhere."""

import json
import pathlib
import re
import subprocess

from support import FAULTY, Skip, campaign, rows, run, tap

ROOT = pathlib.Path(__file__).resolve().parents[2]
PYTHON = ROOT / ".venv/bin/python"
TEXT = """
name: library
limits: {time: 10s}
sampling: {processes: 1, samples: 2, max_samples: 2, inner: 0.0001s}
parts:
  - name: families
    problems: ["random_spd:n=20,seed={1,2}", "murty:n={4,6}", "tridiagonal:n=30"]
    solvers: [lemke, pgs, faulty_liar]
  - name: scenes
    problems: ["stack:n=2,duration=0.03", "incline:duration=0.03"]
    formulations: ["velocity:facets=4", regularized]
    solvers: [lemke, faulty_liar]
"""
SCORES = """
import json, sys
sys.path.insert(0, sys.argv[2])
from bench import library, rows, stats
import numpy as np
cells = rows.cells(rows.load(sys.argv[1]))
own = cells[cells["formulation"] == ""]
cost, _, families, solvers = library.matrix(own)
made = library.profiles("all", cost, families, solvers, 1.05)
shift, limit = 1e-3, float(np.max(cost[np.isfinite(cost)]))
good = {s: int(cells[cells["solver"] == s]["good"].sum()) for s in set(cells["solver"])}
sgm = [stats.geometric_mean_shifted(cost[:, j], shift, limit) for j in range(len(solvers))]
profile = {p.title: {line.name: max(line.y) for line in p.lines} for p in made.panels}
print(json.dumps({"good": good,
                  "solvers": list(solvers), "solved": np.isfinite(cost).sum(axis=0).tolist(),
                  "sgm": sgm, "limit": limit, "profile": profile}))
"""


def lying_campaign(d):
    run("run", campaign(d, TEXT), "--out", d / "runs/library", "--quiet", exe=FAULTY)
    return d / "runs"


def g2_liar_fails_in_the_rows(d):
    got = rows(lying_campaign(d) / "library")
    mine = [r for r in got if r["solver"] == "faulty_liar"]
    assert len(mine) == 9 and {r["status_claimed"] for r in mine} <= {"solved", "ok"}
    assert all(
        r["status"] == "unverified"
        and r["verified"] == "false"
        and r["t_total_s"] == ""
        and float(r["rho"]) > 1e-3
        for r in mine
    )
    assert all(
        r["status"] == "ok" and r["verified"] == "true" for r in got if r["solver"] == "lemke"
    )


def g2_liar_fails_in_every_score(d):
    if not PYTHON.exists():
        raise Skip("no .venv: scripts/setup python")
    folder = lying_campaign(d) / "library"
    done = subprocess.run(
        [PYTHON, "-c", SCORES, folder, ROOT / "scripts"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    got = json.loads(done.stdout)
    j = got["solvers"].index("faulty_liar")
    assert got["good"]["faulty_liar"] == 0 and got["solved"][j] == 0 and got["good"]["lemke"] == 9
    assert got["sgm"][j] >= 9.9 * got["limit"], "every problem counts as the penalty"
    for title, lines in got["profile"].items():
        assert lines["faulty_liar"] == 0 and lines["lemke"] == 1, (title, lines)


def g2_liar_fails_on_the_page(d):
    if not PYTHON.exists():
        raise Skip("no .venv: scripts/setup python")
    done = subprocess.run(
        [ROOT / "scripts/report", lying_campaign(d), "--out", d / "page"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    page = (d / "page/index.html").read_text()
    row = next(
        r
        for r in re.findall(r"<tr[^>]*>.*?(?=<tr|</tbody>)", page, re.S)
        if "faulty_liar" in r and "of 5" in r
    )
    cells = [re.sub(r"<[^>]*>", "", c).strip() for c in re.findall(r"<td[^>]*>[^<]*", row)]
    assert "0 of 5" in cells and "5" in cells and "0%" in cells, cells


tap([g2_liar_fails_in_the_rows, g2_liar_fails_in_every_score, g2_liar_fails_on_the_page])

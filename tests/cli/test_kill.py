"""Killed at random moments and started again: the same cells as an uninterrupted run, none twice, none torn."""
import collections
import csv
import random
import signal
import subprocess
import time

from support import FAULTY, campaign, diagonal, rows, run, tap

TEXT = """
name: kill
seed: 5
limits: {time: 10s, grace: 0.2s}
sampling: {processes: 3, samples: 2, max_samples: 2, inner: 0.0001s}
parts:
  - name: a
    problems: ["%s/*.M.mtx", "random_spd:n={3,4,5,6}"]
    solvers: [lemke, pgs]
  - name: b
    problems: ["%s/*.M.mtx"]
    solvers: ["faulty_steady:seconds={0.004,0.005}"]
"""
KILLS = 50


def fifty_kills(d):
    for n in (2, 3, 4, 5, 6, 7):
        diagonal(d, n)
    c = campaign(d, TEXT % (d, d))
    run("run", c, "--out", d / "whole", "--quiet", exe=FAULTY)
    whole = collections.Counter((r["cell_id"], r["process"], r["rep"]) for r in rows(d / "whole"))
    assert len(whole) == (10 * 2 + 6 * 2) * 3 * 2, len(whole)
    rng = random.Random(7)
    kills = 0
    for _ in range(KILLS):
        p = subprocess.Popen([FAULTY, "run", str(c), "--out", str(d / "killed"), "--quiet"],
                             stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(rng.uniform(0.005, 0.25))
        kills += p.poll() is None
        p.send_signal(signal.SIGKILL)
        p.wait()
        if (d / "killed/results.csv").exists():
            for r in csv.DictReader((d / "killed/results.csv").open(newline="")):
                assert None not in r and None not in r.values(), "a torn row"
    run("run", c, "--out", d / "killed", "--quiet", exe=FAULTY)
    got = collections.Counter((r["cell_id"], r["process"], r["rep"]) for r in rows(d / "killed"))
    assert got == whole, (len(got), len(whole))
    print(f"# {kills} of {KILLS} kills hit a running campaign")
    assert kills >= 5


tap([fifty_kills])

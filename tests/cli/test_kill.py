"""Killed at random moments and started again: the same cells as an uninterrupted run, none twice,
none torn."""

import collections
import csv
import json
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


def check_rows(folder):
    """The kernel may cut a write short where a page ends: only the last row can lack its end, which
    the next run drops."""
    if (folder / "results.csv").exists():
        whole = [line for line in (folder / "results.csv").open(newline="") if line.endswith("\n")]
        for r in csv.DictReader(whole):
            assert None not in r and None not in r.values(), "a torn row"


def size(out):
    return (out / "results.csv").stat().st_size if (out / "results.csv").exists() else 0


def wait_for_rows(p, out, had):
    """Until p has written a row or has ended; how long that takes depends on the machine."""
    while size(out) <= had and p.poll() is None:
        time.sleep(0.002)


def g4_fifty_kills_lose_nothing(d):
    """Every kill counted here hit a running campaign; a campaign that comes to its end in between
    is compared, and the next begun."""
    for n in (2, 3, 4, 5, 6, 7):
        diagonal(d, n)
    c = campaign(d, TEXT % (d, d))
    run("run", c, "--out", d / "whole", "--quiet", exe=FAULTY)
    whole = collections.Counter((r["cell_id"], r["process"], r["rep"]) for r in rows(d / "whole"))
    assert len(whole) == (10 * 2 + 6 * 2) * 3 * 2, len(whole)
    rng = random.Random(7)
    kills = 0
    behind = 0  # of them came behind rows of the same process
    folders = 1
    while kills < KILLS:
        out = d / f"killed{folders}"
        had = size(out)
        p = subprocess.Popen(
            [FAULTY, "run", str(c), "--out", str(out), "--quiet"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        if rng.random() < 0.5:
            wait_for_rows(p, out, had)
        time.sleep(rng.uniform(0.0, 0.1))
        hit = p.poll() is None
        p.send_signal(signal.SIGKILL)
        hit = p.wait() == -signal.SIGKILL and hit
        kills += hit
        behind += hit and size(out) > had
        folders += not hit
        check_rows(out)
    assert json.loads((d / "killed1/manifest.json").read_text())["campaign"]["seed"] == 5, (
        "the settings stand beside the rows from the start"
    )
    for k in range(1, folders + 1):
        out = d / f"killed{k}"
        run("run", c, "--out", out, "--quiet", exe=FAULTY)
        got = collections.Counter((r["cell_id"], r["process"], r["rep"]) for r in rows(out))
        assert got == whole, (k, len(got), len(whole))
    print(f"# {kills} kills hit a running campaign, {behind} behind its rows, {folders} campaigns")
    assert behind > KILLS // 4, "the kills came before anything was measured"


tap([g4_fifty_kills_lose_nothing])

"""A real Slurm on one machine (scripts/test_slurm starts it): an array killed in the middle and
submitted again, and a task that meets its time limit, both end with the rows of the built-in
runner."""

import re
import subprocess
import time

from engines import (
    SHARDS,
    TEXT,
    WHOLE_ROWS,
    built_in,
    merged_equals_built_in,
    rows_so_far,
    start,
    submit_words,
)

from support import FAULTY, campaign, diagonal, rows, run, tap


def slurm(*words):
    return subprocess.run(words, capture_output=True, text=True, check=True, timeout=60).stdout


def wait_until(what, seconds, why):
    give_up = time.time() + seconds
    while not what():
        assert time.time() < give_up, why
        time.sleep(0.05)


def array_killed_once(d):
    """SIGKILL for everything of the running task, the rest of the array cancelled; the same command
    again finishes it."""
    words = submit_words(d, built_in(d), "slurm")
    p = start(words)
    wait_until(
        lambda: (d / "many/shard.3/results.csv").exists() and rows(d / "many/shard.3"),
        120,
        "no third task",
    )
    running = slurm("squeue", "-h", "-t", "running", "-o", "%A %F").split()
    assert running, "it was over before it could be killed"
    slurm("scancel", "--full", "--signal=KILL", running[0])
    slurm("scancel", running[1])
    assert p.wait(timeout=60) == 4, "a killed array is not a complete campaign"
    before = rows_so_far(d)
    assert 0 < before < WHOLE_ROWS, before
    print(f"# killed at {before} of {WHOLE_ROWS} rows, in task 3 of {SHARDS}")
    p = start(words)
    assert p.wait(timeout=300) == 0
    merged_equals_built_in(d)


def cores_are_exclusive(d):
    """No two tasks of an array at the same time on a node."""
    run("submit", campaign(d, TEXT), "--engine", "slurm", "--shards", 2, "--out", d / "many")
    seen = 0
    while slurm("squeue", "-h", "-o", "%A"):
        running = slurm("squeue", "-h", "-t", "running", "-o", "%A").split()
        assert len(running) <= 1, running
        seen += len(running)
        time.sleep(0.1)
    assert seen > 0


LONG = """
name: long
limits: {time: 10s, grace: 0.5s}
sampling: {processes: 12, samples: 1, max_samples: 1, inner: 0.0001s}
parts:
  - name: a
    problems: ["%s"]
    solvers: ["faulty_sleeper:seconds={0.6,0.61}"]
"""


def limit_requeues(d):
    """A task longer than its limit: SIGTERM comes before the end, the rows are flushed, the task is
    queued again and goes on. A row takes 2.4 s, 24 of them a minute; Slurm looks for limits every
    30 s, so that the limit comes at least once and two restarts are usual."""
    c = campaign(d, LONG % diagonal(d, 3))
    run(
        "submit",
        c,
        "--engine",
        "slurm",
        "--shards",
        1,
        "--out",
        d / "many",
        "--slurm-time",
        "00:01:00",
        exe=FAULTY,
    )
    job = slurm("squeue", "-h", "-o", "%F").split()[0]
    restarts = 0
    give_up = time.time() + 300
    while slurm("squeue", "-h", "-o", "%A"):
        assert time.time() < give_up, slurm("scontrol", "show", "job", job)
        found = re.search(r"Restarts=(\d+)", slurm("scontrol", "show", "job", job))
        restarts = max(restarts, int(found.group(1)) if found else 0)
        time.sleep(0.2)
    assert restarts >= 1, "the limit never came"
    log = (d / "many/slurm.1.log").read_text()
    assert log.count("results.csv:") == restarts + 1, log
    got = [(r["cell_id"], r["process"]) for r in rows(d / "many/shard.1")]
    assert len(got) == len(set(got)) == 24, len(got)
    print(f"# {restarts} restarts")


tap([cores_are_exclusive, array_killed_once, limit_requeues])

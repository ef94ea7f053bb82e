"""What the tests of GNU parallel and of Slurm share: 200 cells, and what must come out of them
whoever started the shards."""

import os
import subprocess

from support import LCPBENCH, campaign, rows, run

NUMBERS = ",".join(str(n) for n in range(1, 51))
TEXT = (
    """
name: engines
limits: {time: 10s, grace: 0.5s}
sampling: {processes: 1, samples: 2, max_samples: 2, inner: 0.005s}
parts:
  - name: a
    problems: ["random_spd:n=20,seed={%s}"]
    solvers: [lemke, pgs, projected_gradient, apgd]
"""
    % NUMBERS
)
SHARDS = 6
WHOLE_ROWS = 400


def verdicts(folder):
    return {
        (
            r["cell_id"],
            r["process"],
            r["rep"],
            r["status"],
            r["solution_hash"],
            r["n_iter"],
            r["problem"],
            r["solver"],
        )
        for r in rows(folder)
    }


def built_in(d, text=TEXT):
    """The same campaign by the built-in runner, in d/one; the campaign's file."""
    c = campaign(d, text)
    run("run", c, "--out", d / "one", "--quiet")
    assert len({r["cell_id"] for r in rows(d / "one")}) == 200
    return c


def submit_words(d, c, engine, *more):
    return [
        "submit",
        c,
        "--engine",
        engine,
        "--shards",
        SHARDS,
        "--out",
        d / "many",
        "--wait",
        *more,
    ]


def start(words, path=None, stdout=subprocess.DEVNULL):
    env = dict(os.environ, OPENBLAS_NUM_THREADS="1")
    if path:
        env["PATH"] = f"{path}:{env['PATH']}"
    return subprocess.Popen(
        [LCPBENCH, *map(str, words)],
        stdout=stdout,
        stderr=subprocess.DEVNULL,
        env=env,
        start_new_session=True,
    )


def rows_so_far(d):
    return sum(len(rows(f)) for f in (d / "many").glob("shard.*") if (f / "results.csv").exists())


def merged_equals_built_in(d, shards=SHARDS):
    found = sorted((d / "many").glob("shard.*[0-9]"))
    assert len(found) == shards, found
    run("merge", *found, "--out", d / "merged")
    assert verdicts(d / "merged") == verdicts(d / "one")
    assert len(rows(d / "merged")) == len(rows(d / "one")), "a row stands twice"

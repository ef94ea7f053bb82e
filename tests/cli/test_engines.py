"""More than one machine: 200 cells through GNU parallel and through a Slurm array, killed in the
middle and started again, merge to the cells and verdicts of the built-in runner. Here an sbatch
that runs each array index stands in for Slurm; scripts/test_slurm does the same with a Slurm of its
own."""

import os
import pathlib
import shutil
import signal
import time

from engines import (
    TEXT,
    WHOLE_ROWS,
    built_in,
    merged_equals_built_in,
    rows_so_far,
    start,
    submit_words,
)

from support import Skip, campaign, one_line_error, run, tap

FAKE_SBATCH = """#!/bin/sh
# stands in for Slurm: runs the script once for every index of its array, one after the other
[ "$1" = --wait ] && shift
n=$(sed -n 's/^#SBATCH --array=1-//p' "$1")
code=0
for i in $(seq "$n"); do
  SLURM_ARRAY_TASK_ID=$i SLURM_ARRAY_JOB_ID=1 sh "$1" >/dev/null 2>&1 || code=1
done
exit $code
"""


SHORT = TEXT.replace("inner: 0.005s", "inner: 0.001s")  # no queue to wait for: less to measure
assert SHORT != TEXT


def killed_once_then_whole(d, engine, path=None):
    words = submit_words(d, built_in(d, SHORT), engine)
    p = start(words, path)
    give_up = time.time() + 60
    while time.time() < give_up and not any((d / "many").glob("shard.2/results.csv")):
        time.sleep(0.02)
    assert p.poll() is None, "it was over before it could be killed"
    os.killpg(p.pid, signal.SIGKILL)
    p.wait()
    assert 0 < rows_so_far(d) < WHOLE_ROWS
    p = start(words, path)
    assert p.wait(timeout=300) == 0
    merged_equals_built_in(d)


def gnu_parallel(d):
    if shutil.which("parallel") is None:
        raise Skip("GNU parallel is not installed")
    home = pathlib.Path.home() / ".parallel"
    home.mkdir(exist_ok=True)
    (home / "will-cite").touch()
    killed_once_then_whole(d, "parallel")


def slurm_stand_in(d):
    (d / "bin").mkdir()
    fake = d / "bin/sbatch"
    fake.write_text(FAKE_SBATCH)
    fake.chmod(0o755)
    killed_once_then_whole(d, "slurm", d / "bin")


def scripts_are_written(d):
    c = campaign(d, TEXT)
    run("submit", c, "--engine", "slurm", "--shards", 4, "--out", d / "o", "--dry-run")
    text = (d / "o/slurm.sh").read_text()
    for want in (
        "--array=1-4",
        "--exclusive",
        "--requeue",
        "--signal=B:TERM@60",
        '--shard "$SLURM_ARRAY_TASK_ID/4"',
        f"--output={d}/o/slurm.%a.log",
    ):
        assert want in text, want  # the log is no shard.*, which is what is merged
    one_line_error("submit", c, "--engine", "abacus", "--shards", 2, names=["abacus"])
    one_line_error("submit", c, "--engine", "slurm", "--shards", 0, names=["--shards"])
    one_line_error("submit", d / "no.yaml", "--engine", "slurm", "--shards", 2, names=["no.yaml"])


tap([scripts_are_written, gnu_parallel, slurm_stand_in])

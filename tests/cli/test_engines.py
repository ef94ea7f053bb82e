"""More than one machine: 200 cells through GNU parallel and through a Slurm array, killed in the middle and started again, merge
to the cells and verdicts of the built-in runner. Without Slurm, an sbatch that runs each array index stands in for it."""
import os
import pathlib
import shutil
import signal
import subprocess
import time

from support import LCPBENCH, Skip, campaign, one_line_error, rows, run, tap

NUMBERS = ",".join(str(n) for n in range(1, 51))
TEXT = """
name: engines
limits: {time: 10s, grace: 0.5s}
sampling: {processes: 1, samples: 2, max_samples: 2, inner: 0.005s}
parts:
  - name: a
    problems: ["random_spd:n=20,seed={%s}"]
    solvers: [lemke, pgs, projected_gradient, apgd]
""" % NUMBERS
SHARDS = 6
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


def verdicts(folder):
    return {(r["cell_id"], r["process"], r["rep"], r["status"], r["solution_hash"], r["n_iter"], r["problem"], r["solver"])
            for r in rows(folder)}


def start(words, path=None):
    env = dict(os.environ, OPENBLAS_NUM_THREADS="1")
    if path:
        env["PATH"] = f"{path}:{env['PATH']}"
    return subprocess.Popen([LCPBENCH, *map(str, words)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=env,
                            start_new_session=True)


def killed_once_then_whole(d, engine, path=None):
    c = campaign(d, TEXT)
    run("run", c, "--out", d / "one", "--quiet")
    assert len({r["cell_id"] for r in rows(d / "one")}) == 200
    words = ["submit", c, "--engine", engine, "--shards", SHARDS, "--out", d / "many", "--wait"]
    p = start(words, path)
    give_up = time.time() + 60
    while time.time() < give_up and not any((d / "many").glob("shard.2/results.csv")):
        time.sleep(0.02)
    assert p.poll() is None, "it was over before it could be killed"
    os.killpg(p.pid, signal.SIGKILL)
    p.wait()
    before = sum(len(rows(f)) for f in (d / "many").glob("shard.*") if (f / "results.csv").exists())
    assert 0 < before < 400, before
    p = start(words, path)
    assert p.wait(timeout=300) == 0
    shards = sorted((d / "many").glob("shard.*[0-9]"))
    assert len(shards) == SHARDS, shards
    run("merge", *shards, "--out", d / "merged")
    assert verdicts(d / "merged") == verdicts(d / "one")


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


def slurm_itself(d):
    """Only where a Slurm answers."""
    if shutil.which("sinfo") is None or subprocess.run(["sinfo"], capture_output=True).returncode != 0:
        raise Skip("no running Slurm on this machine")
    killed_once_then_whole(d, "slurm")


def scripts_are_written(d):
    c = campaign(d, TEXT)
    run("submit", c, "--engine", "slurm", "--shards", 4, "--out", d / "o", "--dry-run")
    text = (d / "o/slurm.sh").read_text()
    for want in ("--array=1-4", "--exclusive", "--requeue", "--signal=B:TERM@60", "--shard \"$SLURM_ARRAY_TASK_ID/4\""):
        assert want in text, want
    one_line_error("submit", c, "--engine", "abacus", "--shards", 2, names=["abacus"])
    one_line_error("submit", c, "--engine", "slurm", "--shards", 0, names=["--shards"])
    one_line_error("submit", d / "no.yaml", "--engine", "slurm", "--shards", 2, names=["no.yaml"])


tap([scripts_are_written, gnu_parallel, slurm_stand_in, slurm_itself])

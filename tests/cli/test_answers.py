"""The table of known answers, every line of it within what is allowed; and the table shows a miss
as one."""

import pathlib
import subprocess
import sys

from support import LCPBENCH, SANITIZED, Skip, tap

ANSWERS = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "bench" / "answers.py"


def every_answer_is_right(d):
    if SANITIZED:
        raise Skip("two hundred runs: too slow with sanitizers")
    done = subprocess.run(
        [sys.executable, ANSWERS, "--out", d / "table.md"],
        capture_output=True,
        text=True,
        env={"LCPBENCH": LCPBENCH, "PATH": ""},
    )
    lines = done.stdout.splitlines()
    assert done.returncode == 0 and lines[-1] == f"{len(lines) - 3} passed, 0 failed", (
        done.stdout + done.stderr
    )
    table = (d / "table.md").read_text().splitlines()
    assert table == lines[:-1] and len(table) > 40
    for what in (
        "three cylinders stand",
        "least mu on the ground",
        "omega after over before",
        "spinning box",
        "on the belt",
        "no acceleration exists",
        "limitation",
    ):
        assert what in done.stdout, what


def a_miss_is_shown(d):
    text = (
        ANSWERS.read_text()
        .replace("0.85)", "0.86)")
        .replace("(pile, rocking, spin, belt, painleve, cradle)", "(rocking,)")
    )
    (d / "wrong.py").write_text(text)
    env = {"LCPBENCH": LCPBENCH, "PATH": "", "PYTHONPATH": str(ANSWERS.parents[1])}
    done = subprocess.run([sys.executable, d / "wrong.py"], capture_output=True, text=True, env=env)
    assert (
        done.returncode == 1
        and done.stdout.splitlines()[-1] == "10 passed, 2 failed"
        and done.stdout.count("MISSED") == 2
    ), done.stdout


tap([every_answer_is_right, a_miss_is_shown])

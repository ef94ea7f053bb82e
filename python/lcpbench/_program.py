"""The program of the package, run as a process."""

from __future__ import annotations

import os
import pathlib
import subprocess
import sys

from lcpbench.errors import InvalidInput, LcpbenchError

FOLDER = pathlib.Path(__file__).resolve().parent
PROGRAM = FOLDER / "bin" / "lcpbench"
SCRIPTS = FOLDER / "share" / "lcpbench" / "scripts"
HONEST = 3  # not solved, or not verified: the output is there


def run(*words: object, stdin: str = "") -> str:
    """What `lcpbench WORDS` prints. InvalidInput: exit code 2, with its line."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("LCPBENCH_")}
    done = subprocess.run(
        [str(PROGRAM), *map(str, words)],
        input=stdin,
        capture_output=True,
        text=True,
        check=False,
        env={**environment, "LCPBENCH_PYTHON": sys.executable, "OPENBLAS_NUM_THREADS": "1"},
    )
    line = done.stderr.strip().removeprefix("lcpbench: ")
    if done.returncode == 2:
        raise InvalidInput(line)
    if done.returncode not in (0, HONEST):
        raise LcpbenchError(line or f"lcpbench {words[0]}: exit code {done.returncode}")
    return done.stdout

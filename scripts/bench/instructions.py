"""Instructions of a run, counted by callgrind: what else the machine does changes none."""

import os
import re
import subprocess
import sys
import tempfile

from bench.binary import LCPBENCH, Program

JUDGE = "lcp_judge"  # its test of an answer is no part of a step
RUN = "simulation_run"  # without it: the start of the program and the reading of the scene too


def count(
    *words: object,
    only: str | None = None,
    program: Program | None = None,
    exits: tuple[int, ...] | None = None,
) -> int | None:
    """Those of `lcpbench WORDS` but for its judge; of the function `only` and what it calls. None
    where the exit code is none of `exits`; ends the script where nothing was counted."""
    with tempfile.NamedTemporaryFile() as out:
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out.name}"]
        command += [f"--toggle-collect={f}" for f in (JUDGE, only) if f is not None]
        command += [f"--collect-atstart={'yes' if only is None else 'no'}"]
        command += [str(program or LCPBENCH), *map(str, words)]
        env = dict(os.environ, OPENBLAS_NUM_THREADS="1")
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=env)
    if exits is not None and done.returncode not in exits:
        return None
    said = re.search(r"Collected : (\d+)", done.stderr)
    if said is None or int(said[1]) == 0:
        sys.exit(f"{' '.join(command)}: nothing counted: {done.stderr.strip()[-300:]}")
    return int(said[1])

"""The lcpbench that scripts ask (LCPBENCH, or the one that is built), and where its cases are."""

import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
# the second is that of scripts/reproduce
BUILDS = [ROOT / folder / "lcpbench" for folder in ("build", "build-release")]
LCPBENCH = os.environ.get("LCPBENCH", str(next((b for b in BUILDS if b.exists()), BUILDS[0])))
CASES = ROOT / "tests" / "cases" / "cases.json"
HONEST = (0, 3)  # solved and verified, honest failure
Program = str | pathlib.Path


def ask(
    *args: object,
    exits: tuple[int, ...] = (0,),
    program: Program | None = None,
    before: tuple[str, ...] = (),
) -> dict | list:
    """The JSON that a command prints; ends the script with one line where it exits otherwise or
    prints nothing. before: a command that starts it (taskset ...)."""
    command = [*map(str, before), str(program or LCPBENCH), *map(str, args)]
    if not pathlib.Path(program or LCPBENCH).exists():
        sys.exit(
            f"{pathlib.Path(sys.argv[0]).stem}: no {program or LCPBENCH}: build it first"
            " (scripts/setup && scripts/configure build && ninja -C build)"
        )
    done = subprocess.run(
        command,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
        env=dict(os.environ, OPENBLAS_NUM_THREADS="1"),
    )
    if done.returncode not in exits or not done.stdout:
        sys.exit(
            f"{pathlib.Path(sys.argv[0]).stem}: {' '.join(command)}: exit {done.returncode}:"
            f" {done.stderr.strip()}"
        )
    return json.loads(done.stdout)


def simulate(
    scene: str | pathlib.Path,
    formulation: str,
    solver: str,
    *more: object,
    exits: tuple[int, ...] = HONEST,
    program: Program | None = None,
    before: tuple[str, ...] = (),
) -> dict:
    """One run as `lcpbench simulate` tells it."""
    return ask(
        "simulate",
        scene,
        "--formulation",
        formulation,
        "--solver",
        solver,
        *more,
        exits=exits,
        program=program,
        before=before,
    )


def listed(what: str) -> list[dict]:
    return ask("list", what, "--format", "json")

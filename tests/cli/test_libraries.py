"""Libraries that few runs need are loaded when they are asked for: a start does without them, and
what needs one that is not there says so in one line."""

import os
import re
import subprocess

from support import LCPBENCH, TESTS, campaign, rows, run, run_json, tap

LAZY = ("hdf5", "gsl", "nlopt", "cholmod")
FCLIB = next((TESTS / "data" / "fclib").rglob("*.hdf5"))
NEEDS = {  # what a command needs: one of them
    "nlopt": ("solve", "random_spd:n=5", "--solver", "sqp"),
    "gsl": ("simulate", "stack:n=1,duration=0.02", "--formulation", "penalty", "--solver", "lemke"),
    "hdf5": ("solve", FCLIB, "--solver", "nsgs"),
}
SCENE = ("simulate", "stack:n=1,duration=0.02", "--solver", "lemke", "--formulation")
ROWS = """
name: lazy
limits: {time: 20s, grace: 1s}
sampling: {processes: 1, samples: 2, max_samples: 2, inner: 1e-9s}
parts:
  - name: a
    problems: ["random_spd:n=5"]
    solvers: [sqp, lemke]
"""


def a_start_loads_none_of_them(d):
    env = dict(os.environ, LD_TRACE_LOADED_OBJECTS="1")
    done = subprocess.run([LCPBENCH], env=env, capture_output=True, text=True, check=True)
    names = [line.split()[0] for line in done.stdout.splitlines()]
    assert any("openblas" in n for n in names), names
    assert not [n for n in names if any(f"lib{word}" in n for word in LAZY)], names


def broken(d):
    """An environment in which each of them is a file that is no library. The names that the program
    asks for stand in it."""
    with open(LCPBENCH, "rb") as f:
        found = set(re.findall(rb"lib(?:hdf5|gsl|nlopt|cholmod)[\w.-]*\.so\.\d+", f.read()))
    assert len(found) == len(LAZY), found
    for name in found:
        (d / name.decode()).write_text("no library")
    return {"LD_LIBRARY_PATH": f"{d}:{os.environ.get('LD_LIBRARY_PATH', '')}"}


def what_needs_one_says_so(d):
    env = broken(d)
    for word, command in NEEDS.items():
        there = run(*command, code=None)  # it works, whatever comes of it
        assert there.stdout and there.stderr == "", there.stderr
        done = run(*command, code=1, **env)
        lines = done.stderr.strip().splitlines()
        assert len(lines) == 1 and f"lib{word}" in lines[0] and "cannot be loaded" in lines[0], (
            word,
            done.stderr,
        )
        assert done.stdout == "", done.stdout
    assert run_json("solve", "random_spd:n=5", "--solver", "lemke", **env)["status"] == "ok"


def a_step_that_needs_one_says_so(d):
    way = "regularized:form=mass,factor="
    assert run_json(*SCENE, way + "cholmod")["status"] == "ok"
    env = broken(d)
    told = run_json(*SCENE, way + "cholmod", code=3, **env)
    assert told["status"] != "ok" and told["steps"] == 0, told
    assert "libcholmod" in told["note"] and "cannot be loaded" in told["note"], told["note"]
    assert run_json(*SCENE, way + "envelope", **env)["status"] == "ok"


def a_campaign_goes_on_without(d):
    env = broken(d)
    run("run", campaign(d, ROWS), "--out", d / "out", "--quiet", **env)
    got = {r["solver"]: (r["status"], r["note"]) for r in rows(d / "out")}
    assert got["lemke"][0] == "ok", got
    assert got["sqp"][0] == "error" and "libnlopt" in got["sqp"][1], got


tap(
    [
        a_start_loads_none_of_them,
        what_needs_one_says_so,
        a_step_that_needs_one_says_so,
        a_campaign_goes_on_without,
    ]
)

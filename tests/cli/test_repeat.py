"""The commands that automatic choices print: pasted into a shell, they give the same run to the
bit, with nothing automatic in it."""

import json
import os
import shutil
import subprocess

from support import LCPBENCH, one_line_error, run_json, tap

THROWN = {
    "id": "thrown",
    "dim": 2,
    "T": 0.5,
    "gravity": [0, -9.81],
    "bodies": [
        {
            "name": "a",
            "shape": {"type": "box", "half": [0.2, 0.1]},
            "mass": 2,
            "pos": [0, 0.1],
            "vel": [1.5, 0],
        }
    ],
    "static": [{"name": "floor", "normal": [0, 1], "offset": 0}],
    "friction": {"default": 0.6},
    "observe": ["a.x"],
}


def pasted(command, d, code=None):
    """What a shell makes of it, in folder d."""
    shutil.rmtree(d / "bin", ignore_errors=True)
    (d / "bin").mkdir()
    (d / "bin" / "lcpbench").symlink_to(LCPBENCH)
    path = f"{d / 'bin'}:{os.environ['PATH']}"
    done = subprocess.run(
        ["sh", "-c", command],
        cwd=d,
        env=dict(os.environ, PATH=path),
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.stdout and (code is None or done.returncode == code), (command, done.stderr)
    return json.loads(done.stdout)


def same(d, *words, code=None):
    """A run with its steps written, and its command."""
    o = run_json(*words, "--write-steps", d / "it's the steps.txt", cwd=d, code=code)
    command = o["error"]["command"]
    assert "--error" not in command and "auto" not in command, command
    if "choice" in o:
        assert o["choice"]["repeat"] == command
    again = pasted(command, d)
    for key in ("solution_hash", "steps", "t_end_s", "status", "observables"):
        assert again[key] == o[key], (command, key, again[key], o[key])
    return o


def what_the_run_reads_is_in_it(d):
    same(d, "simulate", "sphere_pile:n=4,duration=0.2", "--error", "5%", "--islands", "on")
    same(d, "simulate", "slide", "--error", "1%", "--start", "previous", "--tol", "1e-11")
    same(d, "simulate", "slide", "--error", "1%", "--contact-order", "random:2")
    same(d, "simulate", "incline", "--error", "1%", "--effects", "-rotation")


def given_ways_have_one_too(d):
    way = ("--formulation", "coulomb:storage=dense", "--solver", "nsgs")
    o = same(d, "simulate", "slide", "--error", "1%", *way)
    assert "choice" not in o


def names_of_files_are_quoted(d):
    for name in ("it's a scene.json", "-dash.json", 'a $HOME `b` "c".json'):
        (d / name).write_text(json.dumps(THROWN))
        given = f"./{name}" if name[0] == "-" else name
        same(d, "simulate", given, "--error", "1%")
        o = run_json("choose", given, "--error", "1%", "--work", "1000", cwd=d)
        first = o["candidates"][0]
        again = pasted(first["command"], d)
        assert again["error"]["steps_limit"] == 1000
        assert again["formulation"] == first["formulation"].split(":")[0], first


def runs_that_end_early_end_there_again(d):
    """Shorter than the scene's step; cut by a limit; without an answer."""
    same(d, "simulate", "bounce", "--error", "1%", "--duration", "1e-3")
    o = same(d, "simulate", "granular_column", "--error", "1%", "--work", "300", code=3)
    assert o["t_end_s"] < 0.2 and not o["error"]["promised"]
    same(d, "simulate", "vise", "--error", "1%", code=3)


def a_limit_before_the_first_step_leaves_the_start(d):
    words = ("simulate", "bounce", "--error", "1%", "--work", "1")
    files = ("--trajectory", d / "t.csv", "--write-end", d / "end.json")
    o = run_json(*words, *files, code=3)
    assert o["steps"] == 0 and o["t_end_s"] == 0 and not o["error"]["promised"], o["error"]
    assert len({r.split(",")[0] for r in (d / "t.csv").read_text().splitlines()[1:]}) == 1
    assert (d / "end.json").exists()


def effects_have_theirs(d):
    """Steps are even, so that nothing automatic is left at all. Runs that came back to a step at
    which something had been left out went on from there without its last digits."""
    for scene, formulation, solver, E in (
        ("incline", "velocity", "lemke", "1e-3"),
        ("incline", "regularized", "lemke", "10"),
        ("capacity", "velocity", "lemke", "1e-2"),
        ("capacity", "coulomb", "cone_newton", "1e-2"),
        ("wall", "coulomb", "cone_newton", "1e-2"),
    ):
        way = ("--formulation", formulation, "--solver", solver, "--effects", f"auto:{E}")
        o = run_json("simulate", scene, *way, cwd=d, code=None)
        again = pasted(o["effects_auto"]["command"], d)
        assert "auto" not in o["effects_auto"]["command"]
        assert again["solution_hash"] == o["solution_hash"], (scene, o["effects_auto"])


def steps_that_were_not_looked_for_are_written_too(d):
    """Even ones, also where the last goes beyond the end, and given ones; with effects that change;
    of a run that gives up. Their file was empty."""
    steps, again, given = d / "s.txt", d / "again.txt", d / "given.txt"
    velocity = ("--formulation", "velocity", "--solver", "lemke")
    given.write_text("0.1\n0.15\n0.25\n")
    for scene, *more in (
        ("bounce", *velocity),
        ("bounce", *velocity, "--step", "0.03"),
        ("projectile", *velocity, "--duration", "0.5", "--steps", given),
        ("incline", *velocity, "--effects", "auto:1e-3"),
        ("vise", *velocity),
        ("bounce", "--formulation", "event", "--solver", "lemke", "--duration", "0.5"),
    ):
        o = run_json("simulate", scene, *more, "--write-steps", steps, code=None)
        lengths = [float(line) for line in steps.read_text().splitlines()]
        assert len(lengths) >= o["steps"] > 0 and max(lengths) == o["step_s"], (scene, more)
        words = [w for w in more if w not in ("--step", "0.03", "--steps", given)]
        o2 = run_json(
            "simulate", scene, *words, "--steps", steps, "--write-steps", again, code=None
        )
        for key in ("solution_hash", "steps", "t_end_s", "status", "observables"):
            assert o2[key] == o[key], (scene, more, key, o2[key], o[key])
        assert again.read_text() == steps.read_text()
        if "effects_auto" in o:
            assert f"--steps '{steps}'" in o["effects_auto"]["command"], o["effects_auto"]
            assert pasted(o["effects_auto"]["command"], d)["solution_hash"] == o["solution_hash"]


def steps_that_miss_the_end_are_refused(d):
    velocity = ("--formulation", "velocity", "--solver", "lemke", "--duration", "0.5")
    for lines in ("0.1\n0.3\n", "0.25\n0.25\n0.25\n", ""):
        (d / "s.txt").write_text(lines)
        words = ("simulate", "projectile", *velocity, "--steps", d / "s.txt")
        one_line_error(*words, names=["s.txt", "of a run of 0.5 s"])


tap(
    [
        what_the_run_reads_is_in_it,
        given_ways_have_one_too,
        names_of_files_are_quoted,
        runs_that_end_early_end_there_again,
        a_limit_before_the_first_step_leaves_the_start,
        effects_have_theirs,
        steps_that_were_not_looked_for_are_written_too,
        steps_that_miss_the_end_are_refused,
    ]
)

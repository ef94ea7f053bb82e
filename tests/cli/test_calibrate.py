"""Calibration: what it finds keeps the error, is not slower than the rule of thumb, and its command
repeats it."""

import json
import shlex

from support import SANITIZED, Skip, fewer, one_line_error, run, run_json, tap


def reaches_and_repeats(_):
    given = (
        ("regularized", "lemke"),
        ("regularized:stiffness=fixed,k=1e3,c=10", "lemke"),
        ("regularized:model=viscous,mode_iter=7", "pgs:omega=0.8,tol=1e-7"),
    )
    for form, solver in fewer(given):
        found = run_json(
            "calibrate",
            "gripper",
            "--error",
            "0.003",
            "--formulation",
            form,
            "--solver",
            solver,
            "--evaluations",
            15,
        )
        rule, best = found["rule"], found["best"]
        assert best["reaches"] and best["error"] <= 0.003, best
        assert not rule["reaches"] or best["t_total_s"] <= 1.5 * rule["t_total_s"], found
        again = json.loads(run(*shlex.split(best["command"])[1:], code=None).stdout)
        assert (
            again["trajectory_error"]["error"] == best["error"]
            and again["step_s"] == best["step_s"]
        ), (again["trajectory_error"], best)
        # options that the search leaves alone are those it ran with
        asked = dict(
            o.split("=") for part in (form, solver) for o in part.partition(":")[2].split(",") if o
        )
        used = dict(
            o.split("=")
            for o in f"{again['formulation_options']},{again['solver_options']}".split(",")
        )
        assert all(
            used[k] == v or float(used[k]) == float(v) for k, v in asked.items() if k not in best
        ), (asked, used)


def a_poor_start_is_left(_):
    """A contact so soft that the stick creeps: the search has to stiffen it."""
    if SANITIZED:
        raise Skip("hundreds of runs of what the first test runs")
    found = run_json(
        "calibrate",
        "incline:duration=0.2",
        "--error",
        "1e-5",
        "--step",
        "0.02",
        "--formulation",
        "regularized:ratio=0.05",
        "--evaluations",
        40,
    )
    assert not found["rule"]["reaches"] or found["rule"]["step_s"] < found["best"]["step_s"], found
    assert found["best"]["reaches"] and found["best"]["ratio"] > 0.05, found


def out_of_reach_is_said(_):
    found = run_json(
        "calibrate",
        "slide:speed=1",
        "--error",
        "1e-15",
        "--step",
        "0.05",
        "--evaluations",
        2,
        code=3,
    )
    assert (
        not found["best"]["reaches"] and found["best"]["step_s"] is None and found["gain"] is None
    ), found


def bad_input_is_named(_):
    one_line_error("calibrate", "slide", names=["--error"])
    one_line_error("calibrate", "slide", "--error", "-1", names=["--error"])
    one_line_error(
        "calibrate", "slide", "--error", "0.1", "--formulation", "velocity", names=["velocity"]
    )
    one_line_error(
        "calibrate", "slide", "--error", "0.1", "--yardstick", "x", names=["--yardstick"]
    )
    one_line_error(
        "calibrate", "slide", "--error", "0.1", "--evaluations", "-1", names=["--evaluations"]
    )


def what_cannot_be_calibrated_is_refused_before_a_run(_):
    """These took 902 simulations and ended with exit code 3."""
    for scene in ("sphere_pile", "vise", "granular_column"):
        one_line_error(
            "calibrate",
            scene,
            "--error",
            "1e-3",
            names=[scene, "predicts nothing", "--yardstick physical"],
            timeout=10,
        )
    one_line_error(
        "calibrate",
        "stack:n=10",
        "--error",
        "1",
        "--solver",
        "enumerate",
        names=["n = 40, at most 16"],
        timeout=10,
    )
    assert (
        run_json(
            "calibrate",
            "vise",
            "--error",
            "10",
            "--yardstick",
            "physical",
            "--evaluations",
            1,
            code=None,
        )["simulations"]
        > 0
    )


tap(
    [
        reaches_and_repeats,
        a_poor_start_is_left,
        out_of_reach_is_said,
        bad_input_is_named,
        what_cannot_be_calibrated_is_refused_before_a_run,
    ]
)

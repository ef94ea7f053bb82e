"""Effects chosen by a pilot: what it drops, what it keeps, and that the answer stays."""

import json
import math
import random

from support import one_line_error, run_json, tap

RUN = ("--formulation", "velocity", "--solver", "lemke")


def simulate(scene, effects, **kw):
    return run_json("simulate", scene, *RUN, "--effects", effects, **kw)


def a_straight_slide_needs_neither_rotation_nor_space(_):
    whole, auto = simulate("slide", "declared"), simulate("slide", "auto:1e-6")
    assert auto["effects_auto"]["dropped"] == "rotation spatial", auto["effects_auto"]
    assert (whole["n_dof"], auto["n_dof"]) == (6, 2) and auto["lcp_dim_max"] < whole["lcp_dim_max"]
    assert len(auto["predictions"]) == len(whole["predictions"]) > 0 and all(
        p["ok"] for p in auto["predictions"]
    )
    error = [next(p["error"] for p in r["predictions"]) for r in (whole, auto)]
    assert abs(error[0] - error[1]) < 1e-6, error


def what_matters_stays(_):
    auto = simulate("spin", "auto:1e-6")
    assert (
        auto["effects_auto"]["dropped"] == ""
        and auto["effects_simulated"] == auto["effects_declared"]
    ), auto["effects_auto"]


def what_may_come_later_is_not_asked_of_a_pilot(_):
    """The scenes' late contacts, loads, spins and joints: no pilot runs, nothing is left out."""
    for scene, rule in (
        ("bounce", "late"),
        ("clatter", "late"),
        ("sphere_pile", "late"),
        ("push", "loads"),
        ("top", "unstable"),
        ("tip", "unstable"),
        ("falling_rod", "unstable"),
    ):
        auto = simulate(scene, "auto:1e-6", code=None)["effects_auto"]
        assert f"({rule})" in auto["why"] and auto["dropped"] == "", (scene, auto)
        assert auto["pilot_steps"] == 0, (scene, auto)
    assert "friction (acts)" in simulate("slide", "auto:1e-6")["effects_auto"]["why"]


def late_scene(rng):
    """A block that slides or spins, and something that happens late: a second body lands, a wall
    stands in the way, a load grows, a spin turns over."""
    dim = rng.choice([2, 3])
    up, half = dim - 1, [rng.uniform(0.1, 0.3) for _ in range(dim)]
    pos = [0.0] * dim
    pos[up] = half[up]
    vel = [0.0] * dim
    vel[0] = rng.uniform(0.5, 3)
    box = {"type": "box", "half": half}
    bodies = [{"name": "a", "shape": box, "mass": 1.0, "pos": pos, "vel": vel}]
    floor = {"name": "floor", "normal": [0] * up + [1], "offset": 0}
    gravity = [0.0] * up + [-9.81]
    scene = {
        "id": "late",
        "dim": dim,
        "T": 1.0,
        "hs": [0.01],
        "gravity": gravity,
        "static": [floor],
    }
    scene["friction"] = {"default": 10 ** rng.uniform(-8, 0)}
    scene["observe"] = ["a.x", "a.vx"]
    kind = rng.choice(["lands", "wall", "load", "spin", "nothing"])
    if kind == "lands":
        above = [rng.uniform(-0.2, 0.5) for _ in range(dim)]
        above[up] = 2 * half[up] + rng.uniform(0.5, 3)
        bodies.append(dict(bodies[0], name="b", pos=above, vel=[0.0] * dim))
    elif kind == "wall":
        tilt = rng.uniform(-0.6, 0.6) if dim == 3 else 0.0
        normal = [-math.cos(tilt), math.sin(tilt), 0.0] if dim == 3 else [-1.0, 0.0]
        scene["static"].append({"name": "wall", "normal": normal, "offset": -rng.uniform(0.5, 2)})
    elif kind == "load":
        load = {
            "type": "force_ramp",
            "body": "a",
            "dir": [1] + [0] * up,
            "rate": rng.uniform(1, 20),
        }
        scene["loads"] = [load]
    elif kind == "spin" and dim == 3:
        pos[up] += 50
        bodies[0]["omega"] = [1e-6, rng.uniform(3, 9), 1e-6]
        scene["observe"] = ["a.omega.x", "a.omega.y"]
    scene["bodies"] = bodies
    return scene


def the_budget_is_kept_where_things_happen_late(d):
    """The change against the full run stays within E, in every scene, whatever comes."""
    rng, path, dropped = random.Random(7), d / "late.json", 0
    for case in range(60):
        path.write_text(json.dumps(late_scene(rng)))
        E = rng.choice([1e-2, 1e-4, 1e-6])
        full, auto = (simulate(path, e, code=None) for e in ("declared", f"auto:{E:g}"))
        for name, a in full["observables"].items():
            b = auto["observables"][name]["value"]
            assert abs(a["value"] - b) <= E * max(abs(a["value"]), 1.0), (
                case,
                name,
                a,
                b,
                path.read_text(),
            )
        dropped += auto["effects_auto"]["dropped"] != ""
    assert dropped > 3, dropped  # and something is left out where nothing happens


def loads_that_grow_are_not_judged_by_their_beginning(_):
    auto = simulate("push", "auto:1e-3")
    assert "loads" in auto["effects_simulated"] and all(p["ok"] for p in auto["predictions"]), auto[
        "effects_auto"
    ]


def the_level_decides(_):
    strict, loose = (
        simulate("roll:speed=2", "auto:1e-9"),
        simulate("roll:speed=2", "auto:1e9", code=None),
    )
    assert (
        "friction" not in strict["effects_auto"]["dropped"]
        and "friction" in loose["effects_auto"]["dropped"]
    )


def everything_on_is_judged_and_less_is_not(_):
    declared, everything, without = (
        simulate("slide", e, code=None) for e in ("declared", "all", "-friction")
    )
    assert [p["ok"] for p in everything["predictions"]] == [
        p["ok"] for p in declared["predictions"]
    ]
    assert without["predictions"] == []


def bad_levels_are_named(_):
    for text in ("auto", "auto:", "auto:0", "auto:-1", "auto:x"):
        one_line_error("simulate", "slide", *RUN, "--effects", text, names=["auto"])


def stiffness_stands_beside_the_result(d):
    """G/m_t of the run, where friction is regularised; nothing where it is not."""
    o = run_json(
        "simulate", "stack:n=2", "--formulation", "regularized:ratio=50", "--solver", "lemke"
    )
    assert abs(o["stiffness_ratio_min"] - 50) < 1e-6 and o["deflection_max_m"] > 0, o[
        "stiffness_ratio_min"
    ]
    o = run_json("simulate", "stack:n=2", "--formulation", "velocity", "--solver", "lemke")
    assert o["stiffness_ratio_min"] is None and o["deflection_max_m"] == 0


tap(
    [
        a_straight_slide_needs_neither_rotation_nor_space,
        what_matters_stays,
        what_may_come_later_is_not_asked_of_a_pilot,
        the_budget_is_kept_where_things_happen_late,
        loads_that_grow_are_not_judged_by_their_beginning,
        the_level_decides,
        everything_on_is_judged_and_less_is_not,
        bad_levels_are_named,
        stiffness_stands_beside_the_result,
    ]
)

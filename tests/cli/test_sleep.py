"""Bodies that lie still sleep until something reaches them (--effects +sleep, and auto:E)."""

import csv
import math
import random
import sys

from unseen_scenes import G, box, disc, plane, scene, written

from support import TESTS, one_line_error, run_json, tap

sys.path.insert(0, str(TESTS / "support"))
from late_scenes import settled_scene  # noqa: E402

WAYS = (("velocity", "lemke"), ("regularized", "lemke"), ("coulomb", "cone_newton"))
MOTION = ("x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s", "omega_z_rad_s")


def settled(name, *more, gravity=(0.0, -G), **kw):
    """Two boxes, one on the other, and what else is given."""
    bodies = [box("a", [0.2, 0.1], [0, 0.1]), box("b", [0.1, 0.1], [0, 0.3]), *more]
    s = scene(name, 2, 1.0, bodies, observe=["a.x", "b.x", "b.vx"])
    s |= {"gravity": list(gravity), "static": [plane("floor", [0, 1], 0.0)]}
    return s | {"friction": {"default": 0.5}} | kw


def ball(**more):
    return disc("z", 0.1, [-2.0, 0.1], vel=[3.0, 0.0], **more)


def run(path, way, effects, *more, **kw):
    words = ("--formulation", way[0], "--solver", way[1], "--effects", effects)
    return run_json("simulate", path, *words, *more, **kw)


def motion(d, path, way, effects):
    """The run, and what it says of each body after each step."""
    out = d / "motion.csv"
    o = run(path, way, effects, "--trajectory", out)
    with out.open() as f:
        rows = [r for r in csv.DictReader(f) if r["kind"] == "body"]
    return o, [[float(r[k]) for k in MOTION] for r in rows]


def apart(one, other):
    assert len(one) == len(other)
    return max(
        abs(x - y) for a, b in zip(one, other, strict=True) for x, y in zip(a, b, strict=True)
    )


def what_lies_still_has_no_rows_until_it_is_hit(d):
    """The motion is the same, on a slope by bristles too, which are as they were when it wakes."""
    for slope in (0.0, 0.3 * G):
        path = written(d, settled("hit", ball(), gravity=(slope, -G)))
        for way in WAYS:
            (whole, a), (less, b) = (motion(d, path, way, e) for e in ("declared", "+sleep"))
            assert apart(a, b) < 1e-7, (way, slope, apart(a, b))
            assert less["n_asleep_max"] == 2 and less["n_asleep"] > 20, (way, slope, less)
            assert less["n_pivot"] + less["n_iter"] < whole["n_pivot"] + whole["n_iter"], way


def nothing_sleeps_beside_what_may_change(d):
    """A load that grows, a belt, and a body that is driven and touches it. Until one comes that is
    driven elsewhere it sleeps."""
    ramp = {"type": "force_ramp", "body": "b", "dir": [1, 0], "rate": 0.1}
    belt = {"static": [plane("floor", [0, 1], 0.0, surface_velocity=[0.5, 0])]}
    held = {"bodies": [*settled("x")["bodies"], box("w", [0.05, 0.1], [0.3, 0.1])]}
    push = {"vel": [-0.001, 0]}
    cases = {
        "ramp": ({"loads": [ramp]}, 0),
        "belt": (belt | {"friction": {"default": 0.0, "pairs": [["a", "b", 0.5]]}}, 0),
        "touched": (
            {"bodies": [*held["bodies"], box("k", [0.05, 0.1], [0.4, 0.1], kinematic=push)]},
            2,
        ),
        "stands": (
            {"bodies": [*held["bodies"], box("k", [0.05, 0.1], [0.4, 0.1], kinematic={})]},
            3,
        ),
        "constant": ({"loads": [{"type": "constant_force", "body": "b", "force": [1, 0]}]}, 2),
    }
    for name, (more, n) in cases.items():
        o = run(written(d, settled(name) | more), WAYS[0], "+sleep")
        assert o["n_asleep_max"] == n, (name, o["n_asleep_max"])
    late = box("k", [0.05, 0.1], [-1.0, 0.1], kinematic={"vel": [0, 0], "acc": [2.0, 0]})
    path = written(d, settled("arrives", late))
    (_, a), (o, b) = (motion(d, path, WAYS[0], e) for e in ("declared", "+sleep"))
    assert o["n_asleep_max"] == 2 and o["n_asleep"] < 2 * 95 and apart(a, b) < 1e-9, (
        o,
        apart(a, b),
    )


def other_effects_wake_all(d):
    """What a body rests by may be left out: gravity, or the rotation of a box on one foot."""
    hangs = scene("hangs", 2, 1.0, [disc("a", 0.1, [0, 5.0])], observe=["a.y"])
    hangs |= {"gravity": [0, -G]}
    foot = plane("foot", [0, 1], 0.0)
    tips = scene(
        "tips", 2, 0.5, [box("a", [0.1, 0.4], [0, 0.4118], angle=0.3)], observe=["a.angle"]
    )
    tips |= {"gravity": [0, -G], "static": [foot], "friction": {"default": 0.5}}
    for s, out in ((hangs, "-gravity"), (tips, "-rotation")):
        path = written(d, s)
        plans = (f"{out}/40:declared", f"{out},+sleep/40:declared")
        whole, less = (run(path, WAYS[0], e) for e in plans)
        a, b = (o["observables"][s["observe"][0]]["value"] for o in (whole, less))
        assert less["n_asleep"] > 10, less["n_asleep"]
        assert abs(a - b) < 1e-9 and a not in (0.3, 5.0), (out, a, b)


def what_begins_to_fall_stays_awake(d):
    """A box on its edge, off its balance by 4e-13 rad, falls after some seconds. What drifts beside
    a large load on another body goes on."""
    half, angle = 0.1, 0.785398163397
    edge = scene("edge", 2, 4.0, [box("a", [half] * 2, [0, half * math.sqrt(2)], angle=angle)])
    edge |= {"gravity": [0, -G], "static": [plane("floor", [0, 1], 0.0)], "observe": ["a.angle"]}
    edge |= {"friction": {"default": 0.5}}
    drifts = scene(
        "drifts", 2, 1.0, [disc("a", 0.1, [0, 0], vel=[0.01, 0]), disc("b", 0.1, [9, 0])]
    )
    push = {"type": "constant_force", "body": "b", "force": [1e9, 0]}
    drifts |= {"gravity": [0, 0], "loads": [push], "observe": ["a.x"]}
    for s in (edge, drifts):
        path = written(d, s)
        for way in WAYS:
            ends = [run(path, way, e)["observables"] for e in ("declared", "+sleep")]
            a, b = (o[s["observe"][0]]["value"] for o in ends)
            assert abs(a - b) < 1e-6 and abs(a - angle) > 0.1, (s["id"], way, a, b)


def what_sleeps_is_seen_from_as_far_as_awake(d):
    """In long steps a box that came near is hit by a ball, and hits what sleeps in this step."""
    bodies = [box("b", [0.1, 0.1], [0, 0.1], vel=[0.05, 0]), box("c", [0.1, 0.1], [0.23, 0.1])]
    bodies.append(disc("a", 0.1, [-2.21, 0.1], vel=[5.0, 0]))
    s = scene("row", 2, 0.8, bodies, observe=["b.x", "c.x"])
    s |= {"hs": [0.02], "gravity": [0, -G], "static": [plane("floor", [0, 1], 0.0)]}
    (_, a), (o, b) = (motion(d, written(d, s), WAYS[0], e) for e in ("declared", "+sleep"))
    assert 5 < o["n_asleep"] < 18 and apart(a, b) < 1e-9, (o["n_asleep"], apart(a, b))


def held_axes_and_steps_that_change(d):
    """An axis that is held at a velocity of 0 stays where it is while its body sleeps; a memory of
    long steps wakes in short ones."""
    falls = scene(
        "falls", 2, 1.0, [box("a", [0.1, 0.1], [0, 0.3], prescribed={"x": {"v0": 0, "a": 0}})]
    )
    falls |= {"gravity": [0, -G], "static": [plane("floor", [0, 1], 0.0)], "observe": ["a.y"]}
    path = written(d, falls)
    whole, less = (run(path, ("acceleration", "lemke"), e) for e in ("declared", "+sleep"))
    a, b = (o["observables"]["a.y"]["value"] for o in (whole, less))
    assert less["n_asleep"] > 20 and abs(a - b) < 1e-9, (a, b, less["n_asleep"])
    steps = d / "steps.txt"
    steps.write_text("0.01\n" * 40 + "0.001\n" * 600)
    path = written(d, settled("hit", ball()))
    for way in WAYS:
        ends = [run(path, way, e, "--steps", steps)["observables"] for e in ("declared", "+sleep")]
        for name, one in ends[0].items():
            assert abs(one["value"] - ends[1][name]["value"]) < 1e-6, (way, name, ends)


def forces_and_energies_go_on(d):
    """What a scene predicts of contact forces holds; energy does not jump where bristles sleep."""
    for name in ("pile3", "stack:n=5", "arch"):
        o = run(name, WAYS[0], "+sleep")
        assert o["n_asleep"] > 0 and all(p["ok"] for p in o["predictions"]), (name, o)
        forces = [p for p in o["predictions"] if "force" in p["quantity"]]
        assert forces, name
    path = written(d, settled("energy", gravity=(0.3 * G, -G)))
    whole, less = (run(path, WAYS[1], e) for e in ("declared", "+sleep"))
    assert less["n_asleep"] > 0
    for key in ("energy_defect_J", "energy_drift_rel"):
        assert abs(whole[key] - less[key]) <= 1e-9 * max(abs(whole[key]), 1e-6), (
            key,
            whole[key],
            less[key],
        )


def auto_tells_that_bodies_slept_and_is_repeated(d):
    """To the bit, where it went back to a step in which others slept, too."""
    rng = random.Random(7)
    slept = back = 0
    for k in range(24):
        path = written(d, settled_scene(rng) | {"id": f"settled{k}"})
        auto = run(path, WAYS[2 * (k % 2)], "auto:1e-4", code=None)
        told = auto["effects_auto"]
        assert ("+sleep" in told["repeat"]) == (auto["n_asleep"] > 0), told
        again = run(path, WAYS[2 * (k % 2)], told["repeat"], code=None)
        assert again["solution_hash"] == auto["solution_hash"], (k, told)
        assert again.get("n_asleep", 0) == auto["n_asleep"], (k, told)
        slept += auto["n_asleep"] > 0
        back += auto["n_asleep"] > 0 and told["steps_repeated"] > 2
    assert slept > 12 and back > 0, (slept, back)


def what_sleep_cannot_do_is_said(d):
    path = written(d, settled("refused"))
    both = (
        "simulate",
        path,
        "--formulation",
        "velocity",
        "--solver",
        "lemke",
        "--effects",
        "+sleep",
    )
    one_line_error(*both, "--error", "1%", names=["+sleep: bodies sleep in given steps"])
    steps = d / "steps.txt"
    steps.write_text("0.5 extrapolated\n0.5\n")
    one_line_error(*both, "--steps", steps, names=["+sleep: bodies sleep in plain steps"])
    turns = ("--formulation", "velocity/50:boxed", "--solver", "lemke/50:newton")
    one_line_error("simulate", path, *turns, "--effects", "+sleep", names=["these change"])
    event = ("--formulation", "event", "--solver", "lemke")
    one_line_error(
        "simulate", path, *event, "--effects", "+sleep", names=["no memory to wake with"]
    )


if __name__ == "__main__":
    tap(
        [
            what_lies_still_has_no_rows_until_it_is_hit,
            nothing_sleeps_beside_what_may_change,
            other_effects_wake_all,
            what_begins_to_fall_stays_awake,
            what_sleeps_is_seen_from_as_far_as_awake,
            held_axes_and_steps_that_change,
            forces_and_energies_go_on,
            auto_tells_that_bodies_slept_and_is_repeated,
            what_sleep_cannot_do_is_said,
        ]
    )

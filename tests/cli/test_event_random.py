"""Random scenes, event by event: a run ends, or says which problem has no solution; nothing sinks
in, and no energy comes from nowhere. `test_event_random.py 0 300` runs the seeds 0 to 299.

Newton's law of impact with friction can add energy (MATHEMATICS 2.1), so that energy is judged
where there is no restitution or no friction. At acceleration level a problem need not have a
solution (MATHEMATICS 2.3.8), nor an impact with restitution where friction can jam it; and lemke
can fail. At most `unsolved` runs may end so, each with its status."""

import json
import math
import pathlib
import sys
import tempfile

from random_scenes import random_scene

from support import SANITIZED, Skip, run, tap

UNSOLVED = ("ray", "infeasible", "stalled", "unverified")


def troubles(seed: int, folder: pathlib.Path) -> tuple[str, str]:
    """Status of the run, and what it should not have done."""
    scene = random_scene(seed)
    lawful = scene["friction"]["default"] == 0 or scene["restitution"]["default"] == 0
    scene["checks"] = [
        {"type": "finite"},
        {"type": "energy_nonincrease", "tol": {"abs": 1e-7 if lawful else 1e3}},
        {"type": "max_penetration", "tol": {"abs": 1e-8}},
    ]
    path = folder / f"{seed}.json"
    path.write_text(json.dumps(scene))
    words = ("--formulation", "event", "--solver", "lemke", "--step", "0.02")
    said = json.loads(run("simulate", path, *words, code=None, timeout=300).stdout)
    if said["status"] in UNSOLVED:
        return said["status"], ""
    wrong = [f"{p['quantity']} = {p['value']}" for p in said["predictions"] if not p["ok"]]
    if said["status"] != "ok":
        wrong.append(f"{said['status']}: {said['note']}")
    return said["status"], "; ".join(wrong)


def judge(first: int, end: int, unsolved: int) -> None:
    found, without = [], []
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(first, end):
            status, wrong = troubles(seed, pathlib.Path(folder))
            if wrong:
                found.append(f"seed {seed}: {wrong}")
            if status in UNSOLVED:
                without.append(f"seed {seed}: {status}")
    assert not found, "\n".join(found)
    assert len(without) <= unsolved, "\n".join(without)


MASS, GRIP = 2.0, 0.5 * 9.81 * 2.0  # of the puck; what friction can hold


def load(t: float) -> tuple[float, float]:
    return 4.0 * t, 3.0 * math.sin(2.0 * t)


def where_the_puck_ends(end: float) -> tuple[float, float]:
    """Fourth-order steps of m v' = F - mu m g v/|v| from the instant at which F cannot be held; as
    long as v is too small to have a direction of its own it has that of F."""
    low, high = 0.0, end
    for _ in range(80):
        mid = 0.5 * (low + high)
        low, high = (low, mid) if math.hypot(*load(mid)) > GRIP else (mid, high)
    t, y = high, (0.0, 0.0, 0.0, 0.0)

    def rate(t: float, y: tuple) -> tuple:
        f = load(t)
        slip = math.hypot(y[2], y[3])
        d = (y[2] / slip, y[3] / slip) if slip > 1e-6 else [f[k] / math.hypot(*f) for k in (0, 1)]
        return (y[2], y[3], *((f[k] - GRIP * d[k]) / MASS for k in (0, 1)))

    def ahead(y: tuple, k: tuple, h: float) -> tuple:
        return tuple(a + h * b for a, b in zip(y, k, strict=True))

    while t < end:
        slip = math.hypot(y[2], y[3])
        h = min(end - t, 1e-5 if slip <= 1e-6 else min(1e-4, 0.2 * slip * MASS / GRIP))
        k1 = rate(t, y)
        k2 = rate(t + h / 2, ahead(y, k1, h / 2))
        k3 = rate(t + h / 2, ahead(y, k2, h / 2))
        k4 = rate(t + h, ahead(y, k3, h))
        mean = tuple((a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(k1, k2, k3, k4, strict=True))
        t, y = t + h, ahead(y, mean, h)
    return y[0], y[1]


def a_slip_begins_in_a_direction_that_turns(d):
    """Friction turns a slip into the direction of its load at a rate without bound where it begins:
    followed from 1e-10 m/s on, that is half a million evaluations and more in one step."""
    puck = {"name": "puck", "shape": {"type": "point"}, "mass": MASS, "inertia": [1, 1, 1]}
    scene = {
        "id": "onset",
        "dim": 3,
        "T": 2.6,
        "gravity": [0, 0, -9.81],
        "bodies": [puck | {"pos": [0, 0, 0], "lock": ["rot"]}],
        "static": [{"name": "floor", "type": "plane", "normal": [0, 0, 1], "offset": 0}],
        "friction": {"default": 0.5},
        "loads": [
            {"body": "puck", "type": "force_ramp", "dir": [1, 0, 0], "rate": 4.0},
            {
                "body": "puck",
                "type": "force_sine",
                "dir": [0, 1, 0],
                "amplitude": 3.0,
                "omega": 2.0,
                "phase": 0.0,
            },
        ],
        "observe": ["puck.x", "puck.y"],
    }
    (d / "onset.json").write_text(json.dumps(scene))
    exact = where_the_puck_ends(2.6)
    for step in ("0.02", "0.1"):
        words = ("--formulation", "event:max_evaluations=20000", "--solver", "lemke")
        said = json.loads(run("simulate", d / "onset.json", *words, "--step", step).stdout)
        assert said["status"] == "ok", said["note"]
        for name, x in zip(("puck.x", "puck.y"), exact, strict=True):
            got = said["observables"][name]["value"]
            assert abs(got - x) < 1e-8, (
                f"{name} = {got} at h = {step} s, {x} by another integration"
            )


def thirty_random_scenes_end(d):
    if SANITIZED:
        raise Skip("thirty runs under error control: too slow with sanitizers")
    judge(0, 30, 4)


if len(sys.argv) == 3:
    judge(int(sys.argv[1]), int(sys.argv[2]), int(sys.argv[2]))
else:
    tap([thirty_random_scenes_end, a_slip_begins_in_a_direction_that_turns])

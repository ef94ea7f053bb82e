"""Random scenes (trees and loops of joints, contacts with and without friction) step by step in
every formulation of speeds: each run ends in a documented way, most are solved, and one that is
called ok keeps its joints, stays on its side of the planes, gains no energy, and changes its
momentum by its weight and the printed contact forces. All of that is computed here from the printed
states, with nothing of the code under test. `event` and `penalty` integrate the same scenes.

`test_mechanisms.py 0 1000` runs the seeds 0 to 999."""

import csv
import json
import math
import pathlib
import sys
import tempfile
from collections import Counter, defaultdict

from random_scenes import Scene, random_scene

from support import SANITIZED, Skip, run, tap

STEP, DURATION = 0.005, 0.4
PAIRS = (
    ("velocity", "lemke"),
    ("position", "lemke"),
    ("regularized", "lemke"),
    ("regularized:pose=cone", "cone_newton"),
    ("boxed", "ppm"),
    ("coulomb", "cone_newton"),
)
# they integrate: joints and planes to the error that they control (compliant planes as the others),
# momentum to the turn of contact frames in a step, in which the impulses are given
INTEGRATED = (("event", "lemke"), ("penalty", "lemke"))
HONEST = ("ray", "infeasible", "stalled", "max_iter", "near", "unsupported", "unverified")
# Joints hold in speed, and drift by curvature: that often the square of the angle of a step, and of
# its way over 0.1 m, in m and rad.
JOINT_DRIFT = 2.0
MOMENTUM = 1e-7  # of the largest momentum or impulse of the step
ENERGY = 0.02  # of the energy at the start: semi-implicit steps of joints and tumbling

Vector = list[float]
State = dict[str, tuple[Vector, Vector, Vector, Vector]]  # x, quaternion, v, omega


def turn(q: Vector, x: Vector) -> Vector:
    w, u = q[0], q[1:]
    t = [2 * c for c in cross(u, x)]
    return [a + w * b + c for a, b, c in zip(x, t, cross(u, t), strict=True)]


def cross(a: Vector, b: Vector) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a: Vector, b: Vector) -> float:
    return sum(x * y for x, y in zip(a, b, strict=True))


def back(q: Vector) -> Vector:
    return [q[0], -q[1], -q[2], -q[3]]


def less(a: Vector, b: Vector) -> Vector:
    return [x - y for x, y in zip(a, b, strict=True)]


def space(v: Vector) -> Vector:
    return [*v, 0.0][:3]


def states(path: pathlib.Path) -> list[State]:
    found: dict[str, State] = defaultdict(dict)
    with path.open() as file:
        for r in csv.DictReader(file):
            if r["kind"] == "body":
                found[r["t_s"]][r["name"]] = (
                    [float(r[f"{k}_m"]) for k in "xyz"],
                    [float(r[f"q{k}"]) for k in "wxyz"],
                    [float(r[f"v{k}_m_s"]) for k in "xyz"],
                    [float(r[f"omega_{k}_rad_s"]) for k in "xyz"],
                )
    return [found[t] for t in sorted(found, key=float)]


# ---- joints --------------------------------------------------------------------------------------


class Held:
    """What a joint keeps, in the frames of its bodies at the start."""

    def __init__(self, joint: Scene, start: State) -> None:
        self.kind = joint["type"]
        self.names = (joint["body"], joint.get("other"))
        ends = (joint["anchor"], joint.get("other_anchor", joint["anchor"]))
        self.local = [
            self.into(start, name, space(end)) for name, end in zip(self.names, ends, strict=True)
        ]
        self.axis = self.carried(start, 1, space(joint["axis"]), -1)
        self.frames = [self.frame(start, k) for k in (0, 1)]
        self.length = math.dist(*self.ends(start))

    def frame(self, s: State, k: int) -> tuple[Vector, Vector]:
        name = self.names[k]
        return ([0.0] * 3, [1.0, 0.0, 0.0, 0.0]) if name is None else s[name][:2]

    def into(self, s: State, name: str | None, x: Vector) -> Vector:
        return x if name is None else turn(back(s[name][1]), less(x, s[name][0]))

    def carried(self, s: State, k: int, axis: Vector, way: int) -> Vector:
        q = self.frame(s, k)[1]
        return turn(q if way > 0 else back(q), axis)

    def ends(self, s: State) -> tuple[Vector, Vector]:
        x, y = (
            [
                a + b
                for a, b in zip(
                    self.frame(s, k)[0], turn(self.frame(s, k)[1], self.local[k]), strict=True
                )
            ]
            for k in (0, 1)
        )
        return x, y

    def turned(self, s: State, probe: Vector) -> float:
        """How far the one body has turned a direction away from where the other takes it."""
        moved = [turn(self.frame(s, k)[1], turn(back(self.frames[k][1]), probe)) for k in (0, 1)]
        return math.dist(*moved)

    def drift(self, s: State, dim: int) -> float:
        x, y = self.ends(s)
        gap = less(x, y)
        if self.kind == "distance":
            return abs(math.dist(x, y) - self.length)
        axis = self.carried(s, 1, self.axis, 1)
        off = [math.hypot(*gap)]
        if self.kind == "slider":
            off = [math.hypot(*less(gap, [dot(gap, axis) * a for a in axis]))]
        if self.kind in ("slider", "fixed"):
            off += [self.turned(s, [float(k == m) for m in range(3)]) for k in range(3)]
        if self.kind == "hinge" and dim == 3:
            start = turn(self.frames[1][1], self.axis)
            off.append(self.turned(s, start))
        return max(off)


# ---- planes and energy ---------------------------------------------------------------------------


def lowest(shape: Scene, q: Vector, normal: Vector) -> float:
    """How far the shape reaches from its centre against the normal."""
    n = turn(back(q), normal)
    if shape["type"] == "box":
        return dot([abs(c) for c in n], space(shape["half"]))
    return shape.get("half_length", 0.0) * abs(n[0]) + shape.get("r", 0.0)


def overlap(scene: Scene, s: State) -> float:
    return max(
        plane["offset"]
        - dot(space(plane["normal"]), s[b["name"]][0])
        + lowest(b["shape"], s[b["name"]][1], space(plane["normal"]))
        for plane in scene["static"]
        for b in scene["bodies"]
    )


def inertia(body: Scene, dim: int) -> Vector | None:
    """Of the homogeneous solid; None for the shapes that are not worth the formula."""
    shape, m = body["shape"], body["mass"]
    if shape["type"] in ("sphere", "disc"):
        return [m * shape["r"] ** 2 * (0.5 if dim == 2 else 0.4)] * 3
    if shape["type"] == "box":
        a, b, c = (h * h for h in space(shape["half"]))
        return [m / 3 * (b + c), m / 3 * (a + c), m / 3 * (a + b)]
    return None


def energy(scene: Scene, s: State) -> float:
    total = 0.0
    for b in scene["bodies"]:
        x, q, v, omega = s[b["name"]]
        local = turn(back(q), omega)
        moments = inertia(b, scene["dim"])
        assert moments is not None
        total += b["mass"] * (dot(v, v) / 2 - dot(space(scene["gravity"]), x))
        total += dot(moments, [w * w for w in local]) / 2
    return total


# ---- momentum ------------------------------------------------------------------------------------

Pushes = dict[str, list[tuple[str, str, Vector]]]  # time: (body, other, force on the first)


def pushes(path: pathlib.Path) -> Pushes:
    found: Pushes = defaultdict(list)
    with path.open() as file:
        for r in csv.DictReader(file):
            if r["kind"] == "contact":
                first, other = r["name"].split("|")
                found[r["t_s"]].append((first, other, [float(r[f"s{k}"]) for k in "xyz"]))
    return found


def groups(scene: Scene) -> list[set[str]]:
    """Bodies that joints tie to each other and not to the world: no joint pushes such a group."""
    found = [{b["name"]} for b in scene["bodies"]]
    tied = set()
    for j in scene["joints"]:
        ends = {j["body"], j.get("other")} - {None}
        if len(ends) == 1:
            tied |= ends
        meet = [g for g in found if g & ends]
        found = [g for g in found if not g & ends] + [set().union(*meet)]
    return [g for g in found if not g & tied]


def momentum_error(scene: Scene, path: pathlib.Path) -> float:
    """Largest change of a group's momentum in a step that its weight and its contacts do not
    explain, over the largest momentum and impulse of that step."""
    way, force = states(path), pushes(path)
    times = sorted({*force, *(r["t_s"] for r in csv.DictReader(path.open()))}, key=float)
    mass = {b["name"]: b["mass"] for b in scene["bodies"]}
    gravity, worst = space(scene["gravity"]), 0.0
    for n in range(1, len(way)):
        h = float(times[n]) - float(times[n - 1])
        for group in groups(scene):
            change = [0.0] * 3
            size = 1e-12
            for name in group:
                before, after = way[n - 1][name][2], way[n][name][2]
                for k in range(3):
                    change[k] += mass[name] * (after[k] - before[k] - h * gravity[k])
                size += mass[name] * (math.hypot(*before) + math.hypot(*after))
            for first, other, f in force[times[n]]:
                sign = (first in group) - (other in group)
                change = [c - sign * h * x for c, x in zip(change, f, strict=True)]
                size += abs(sign) * h * math.hypot(*f)
            worst = max(worst, math.hypot(*change) / size)
    return worst


# ---- runs ----------------------------------------------------------------------------------------


def wrong(scene: Scene, path: pathlib.Path, formulation: str) -> str:
    """What a run that was called ok did all the same."""
    way = states(path)
    assert len(way) > 1, path
    integrated = formulation in dict(INTEGRATED)
    held = [Held(j, way[0]) for j in scene["joints"]]
    drift = max((h.drift(s, scene["dim"]) for s in way for h in held), default=0.0)
    spin = max(math.hypot(*omega) for s in way for _, _, _, omega in s.values())
    speed = max(math.hypot(*v) for s in way for _, _, v, _ in s.values())
    turn_of_frames = STEP * (spin + speed / 0.05)
    off = momentum_error(scene, path)
    if not off < (1e-4 + turn_of_frames if integrated else MOMENTUM):
        return f"momentum out by {off:.3g} of what there is"
    drifts = 0.0 if integrated else JOINT_DRIFT * STEP**2 * (spin**2 + speed**2 / 0.1)
    if not drift < drifts + 1e-6:
        return f"joints apart by {drift:.3g}"
    fastest = max(math.hypot(*v) + 0.4 * math.hypot(*w) for s in way for _, _, v, w in s.values())
    deep = max(overlap(scene, s) for s in way)
    sinks = {"event": 0.0, "penalty": 2 * STEP * fastest + 1e-3}  # a spring under its load
    if not deep < sinks.get(formulation, 2 * STEP * fastest) + 1e-6:
        return f"{deep:.3g} m behind a plane"
    lawful = scene["friction"]["default"] == 0 or scene["restitution"]["default"] == 0
    if lawful and all(inertia(b, scene["dim"]) for b in scene["bodies"]):
        levels = [energy(scene, s) for s in way]
        floor = sum(9.81 * b["mass"] for b in scene["bodies"])  # a metre of height
        gain = max(b - a for a, b in zip(levels, levels[1:], strict=False))
        if formulation == "penalty":  # what springs of contacts took they give back
            gain = max(levels) - levels[0]
        if not gain < ENERGY * (abs(levels[0]) + floor):
            return f"{gain:.3g} J gained in a step, of {levels[0]:.3g}"
    return ""


Pairs = tuple[tuple[str, str], ...]


def judge(first: int, end: int, share: float, pairs: Pairs) -> None:
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    found = []
    with tempfile.TemporaryDirectory() as folder:
        scene_file, way = pathlib.Path(folder) / "scene.json", pathlib.Path(folder) / "way.csv"
        for seed in range(first, end):
            scene = random_scene(seed) | {"T": DURATION, "hs": [STEP]}
            scene_file.write_text(json.dumps(scene))
            for formulation, solver in pairs:
                words = ("--formulation", formulation, "--solver", solver, "--step", STEP)
                words += ("--trajectory", way)
                done = run("simulate", scene_file, *words, code=None, timeout=300)
                said = json.loads(done.stdout)
                counts[formulation][said["status"]] += 1
                if said["status"] == "ok":
                    trouble = wrong(scene, way, formulation)
                else:
                    trouble = "" if said["status"] in HONEST else said["note"]
                if trouble:
                    found.append(f"seed {seed}, {formulation}: {said['status']}: {trouble}")
    assert not found, "\n".join(found)
    for formulation, ends in counts.items():
        assert ends["ok"] >= share * (end - first), f"{formulation}: {dict(ends)}"
    if len(sys.argv) == 3:
        print("\n".join(f"{name}: {dict(ends)}" for name, ends in counts.items()))


def sixty_mechanisms_keep_their_laws(d):
    if SANITIZED:
        raise Skip("three hundred runs: too slow with sanitizers")
    judge(100, 160, 0.97, PAIRS)


def forty_mechanisms_are_integrated(d):
    if SANITIZED:
        raise Skip("eighty runs under error control: too slow with sanitizers")
    judge(0, 40, 0.9, INTEGRATED)


if len(sys.argv) == 3:
    judge(int(sys.argv[1]), int(sys.argv[2]), 0.97, PAIRS)
else:
    tap([sixty_mechanisms_keep_their_laws, forty_mechanisms_are_integrated])

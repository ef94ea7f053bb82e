"""What a motion must keep, computed from the printed states and forces alone, with nothing of the
code under test: joints and locks hold, no body goes behind a plane or into another, contacts push
and rub within the cone, the momentum of what is not held changes by weight and contact forces, no
energy is gained, and contacts take from the motion what friction and restitution say."""

import csv
import math
import pathlib
from collections import defaultdict
from dataclasses import dataclass

from overlaps import behind, between
from random_scenes import Scene
from vectors import Vector, back, cross, dot, less, more, space, turn

State = dict[str, tuple[Vector, Vector, Vector, Vector]]  # x, quaternion, v, omega
Push = tuple[str, str, Vector]  # body, other, force on the first


@dataclass(frozen=True)
class Slack:
    """What a way of simulating may be off by. Steps: joints hold in speed and drift by curvature,
    that often the square of the angle of a step, and of its way over 0.1 m, in m and rad."""

    drift: float = 2.0
    momentum: float = 1e-7  # of the largest momentum or impulse of the step
    turning: float = 0.0  # more, for each rad that contact frames turn in a step
    steps: float = 2.0  # ways of a step that a body may sink
    depth: float = 0.0  # more of it: m
    cone: float = 1.0  # friction over mu times the normal force
    energy: float = 0.02  # of the energy at the start: semi-implicit steps of joints and tumbling
    gives_back: bool = False  # springs of contacts do what they took
    rubs: float = 0.0  # of mu N times the speed of sliding, that friction takes at the least
    bounces: bool = False  # contacts that part at more than e times how they met do not push
    power: float = 1e-6  # of the energy there, that contacts may fall short of it by in a step


# integrated: joints and planes to the error that is controlled, momentum to the turn of contact
# frames in a step, in which the impulses are given; springs sink under their load
# steps: friction gives way (springs), or is decided by accelerations. Facets: the least friction of
# four along the diagonal
SLACKS = {
    "steps": Slack(),
    "cones": Slack(rubs=1.0, bounces=True),
    "facets": Slack(rubs=math.sqrt(0.5), bounces=True),
    "gaps": Slack(rubs=math.sqrt(0.5)),
    "boxes": Slack(cone=math.sqrt(2), rubs=1.0, bounces=True),
    "bristles": Slack(cone=math.sqrt(2)),
    "decided": Slack(cone=math.inf, energy=math.inf),  # stick and slip once a step, kept or not
    "arcs": Slack(drift=0.0, momentum=1e-4, turning=1.0, steps=0.0),
    "springs": Slack(drift=0.0, momentum=1e-4, turning=1.0, depth=1e-3, gives_back=True),
}


@dataclass
class Motion:
    """Of a file written by `simulate --trajectory`."""

    times: list[float]
    states: list[State]
    pushes: list[list[Push]]  # of the step that ends there
    points: list[list[Vector]]  # where they push, as the bodies were before the step

    @staticmethod
    def read(path: pathlib.Path) -> "Motion":
        states: dict[str, State] = {}
        pushes: dict[str, list[Push]] = defaultdict(list)
        points: dict[str, list[Vector]] = defaultdict(list)
        with path.open() as file:
            for r in csv.DictReader(file):
                t = r["t_s"]
                if r["kind"] == "body":
                    states.setdefault(t, {})[r["name"]] = (
                        [float(r[f"{k}_m"]) for k in "xyz"],
                        [float(r[f"q{k}"]) for k in "wxyz"],
                        [float(r[f"v{k}_m_s"]) for k in "xyz"],
                        [float(r[f"omega_{k}_rad_s"]) for k in "xyz"],
                    )
                elif r["kind"] == "contact":
                    first, other = r["name"].split("|")
                    pushes[t].append((first, other, [float(r[f"s{k}"]) for k in "xyz"]))
                    points[t].append([float(r[f"{k}_m"]) for k in "xyz"])
        words = sorted(states, key=float)
        return Motion(
            [float(t) for t in words],
            [states[t] for t in words],
            [pushes[t] for t in words],
            [points[t] for t in words],
        )


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


# ---- locks, planes, cones ------------------------------------------------------------------------

TRANSLATIONS, ROTATIONS = ("x", "y", "z"), ("rx", "ry", "rz")


def locked(body: Scene, words: tuple[str, ...]) -> list[bool]:
    lock = body.get("lock", [])
    return [w in lock or (w in ROTATIONS and "rot" in lock) for w in words]


def lock_speed(scene: Scene, s: State) -> float:
    """Largest speed in a direction that a lock takes away, in m/s and rad/s."""
    worst = 0.0
    for b in scene["bodies"]:
        _, _, v, omega = s[b["name"]]
        held = locked(b, TRANSLATIONS) + locked(b, ROTATIONS)
        worst = max([worst] + [abs(x) for x, h in zip(v + omega, held, strict=True) if h])
    return worst


def sunk(scene: Scene, s: State) -> float:
    """How far a body is behind a plane [m]."""
    return max(
        behind(b["shape"], *s[b["name"]][:2], space(plane["normal"]), plane["offset"])
        for plane in scene["static"]
        for b in scene["bodies"]
    )


def met(scene: Scene, way: list[State], allowed: float) -> float:
    """How far one body is in another [m], beyond what it was at the start; 0 where no more than
    allowed. Pairs that do not collide are left out."""
    bodies, apart = scene["bodies"], [set(pair) for pair in scene["no_collision"]]
    worst = 0.0
    for k, a in enumerate(bodies):
        for b in bodies[:k]:
            names = (a["name"], b["name"])
            if set(names) in apart:
                continue
            shapes = (scene["dim"], a["shape"], b["shape"])
            had = max(0.0, between(*shapes, *(way[0][n][:2] for n in names)))
            for s in way[1:]:
                worst = max(
                    worst, between(*shapes, *(s[n][:2] for n in names), had + allowed) - had
                )
    return worst if worst > allowed else 0.0


def out_of_cone(scene: Scene, pushes: list[Push], widened: float) -> float:
    """Largest force of a plane that pulls, or rubs more than friction lets it, over the largest
    force of the step, or a hundredth of all weights where that is more."""
    planes = {p["name"]: space(p["normal"]) for p in scene["static"]}
    mu, worst = scene["friction"]["default"], 0.0
    for _, other, f in pushes:
        if other in planes:
            normal = dot(f, planes[other])
            rubs = math.hypot(*less(f, [normal * n for n in planes[other]]))
            worst = max(worst, -normal, rubs - widened * mu * normal)
    weight = 9.81 * sum(b["mass"] for b in scene["bodies"])
    return worst / max([weight / 100] + [math.hypot(*f) for _, _, f in pushes])


# ---- energy and momentum -------------------------------------------------------------------------


def inertia(body: Scene, dim: int) -> Vector:
    """Of the homogeneous solid, about the axes of the body; in the plane the last counts."""
    shape, m = body["shape"], body["mass"]
    if shape["type"] in ("sphere", "disc"):
        return [m * shape["r"] ** 2 * (0.5 if dim == 2 else 0.4)] * 3
    if shape["type"] == "box":
        a, b, c = (h * h for h in space(shape["half"]))
        return [m / 3 * (b + c), m / 3 * (a + c), m / 3 * (a + b)]
    half, r = shape["half_length"], shape.get("r", 0.0)
    if dim == 2:  # a bar, and the two halves of a disc beyond its ends
        bar, ends = (1.0, 0.0) if r == 0 else (4 * half * r, math.pi * r * r)
        of_bar = (half**2 + r**2) / 3
        of_ends = r**2 / 2 + half**2 + 8 * half * r / (3 * math.pi)
        return [m * (bar * of_bar + ends * of_ends) / (bar + ends)] * 3
    bar, ends = 2 * half, 4 * r / 3  # times pi r^2: a cylinder, and the two halves of a ball
    along = bar * r**2 / 2 + ends * 0.4 * r**2
    across = bar * (r**2 / 4 + half**2 / 3) + ends * (0.4 * r**2 + half**2 + 0.75 * half * r)
    return [m * along / (bar + ends)] + [m * across / (bar + ends)] * 2


def energy(scene: Scene, s: State) -> float:
    total = 0.0
    for b in scene["bodies"]:
        x, q, v, omega = s[b["name"]]
        local = turn(back(q), omega)
        total += b["mass"] * (dot(v, v) / 2 - dot(space(scene["gravity"]), x))
        total += dot(inertia(b, scene["dim"]), [w * w for w in local]) / 2
    return total


def gained(scene: Scene, motion: Motion, gives_back: bool) -> float:
    """Most energy gained in a step, over what there is: that of the start and of a metre of height,
    more where the step before was not resolved, with bodies that turn by a radian in it. Of
    springs: gained since the start."""
    way, times = motion.states, motion.times
    levels = [energy(scene, s) for s in way]
    there = abs(levels[0]) + sum(9.81 * b["mass"] for b in scene["bodies"])
    if gives_back:
        return (max(levels) - levels[0]) / there
    worst = 0.0
    for n in range(1, len(way)):
        spin = max(math.hypot(*omega) for _, _, _, omega in way[n - 1].values())
        turned = spin * (times[n] - times[n - 1])
        worst = max(worst, (levels[n] - levels[n - 1]) / (there * (1 + turned**2)))
    return worst


def speed_at(point: Vector, before: Vector, v: Vector, omega: Vector) -> Vector:
    return more(v, 1.0, cross(omega, less(point, before)))


def unspent(scene: Scene, motion: Motion, slack: Slack) -> float:
    """Most energy that contacts with planes did not take in a step although their forces were
    there, over the energy of the start and of a metre of height.

    Of an impulse N n + F and the velocity u of its point after the step, as a step with these
    impulses has it: friction does the most that it can against the sliding (maximal dissipation),
    -F . u = max {-G . u: |G| <= mu N} = mu N |u_t|, with facets no less than the cosine of half
    their angle times it; and a contact that parts at more than e times the speed at which it met,
    u_n > e met with met = max(0, -u_n before), has N = 0 (Newton, and complementarity where it
    did not meet). Each contact falls short of that by max(0, mu N |u_t| + F . u_t) and
    N max(0, u_n - e met). An impulse in its cone that balances momentum and gains no energy may
    still be any multiple of what the motion can ask for: where it jams, even a small error of the
    speeds is more energy than there is."""
    planes = {p["name"]: space(p["normal"]) for p in scene["static"]}
    mu, e = scene["friction"]["default"], scene["restitution"]["default"]
    there = abs(energy(scene, motion.states[0])) + sum(9.81 * b["mass"] for b in scene["bodies"])
    worst = 0.0
    for n in range(1, len(motion.states)):
        h, total = motion.times[n] - motion.times[n - 1], 0.0
        for (body, other, f), point in zip(motion.pushes[n], motion.points[n], strict=True):
            if other not in planes:
                continue
            normal, (x, _, *had), has = (
                planes[other],
                motion.states[n - 1][body],
                motion.states[n][body][2:],
            )
            pressed = max(0.0, h * dot(f, normal))
            u, met = speed_at(point, x, *has), -dot(speed_at(point, x, *had), normal)
            parts = dot(u, normal)
            slides = more(u, -parts, normal)
            short = slack.rubs * mu * pressed * math.hypot(*slides) + h * dot(f, slides)
            total += max(0.0, short) if slack.rubs > 0 else 0.0
            total += pressed * max(0.0, parts - e * max(0.0, met)) if slack.bounces else 0.0
        worst = max(worst, total / there)
    return worst


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


def momentum_error(scene: Scene, motion: Motion) -> float:
    """Largest change of a group's momentum in a step that its weight and its contacts do not
    explain, over the largest momentum and impulse of that step; not along locked directions."""
    mass = {b["name"]: b["mass"] for b in scene["bodies"]}
    held = {b["name"]: locked(b, TRANSLATIONS) for b in scene["bodies"]}
    gravity, worst = space(scene["gravity"]), 0.0
    for n in range(1, len(motion.states)):
        h = motion.times[n] - motion.times[n - 1]
        for group in groups(scene):
            change = [0.0] * 3
            size = 1e-12
            for name in group:
                before, after = motion.states[n - 1][name][2], motion.states[n][name][2]
                for k in range(3):
                    change[k] += mass[name] * (after[k] - before[k] - h * gravity[k])
                size += mass[name] * (math.hypot(*before) + math.hypot(*after))
            for first, other, f in motion.pushes[n]:
                sign = (first in group) - (other in group)
                change = [c - sign * h * x for c, x in zip(change, f, strict=True)]
                size += abs(sign) * h * math.hypot(*f)
            free = [c for k, c in enumerate(change) if not any(held[name][k] for name in group)]
            worst = max(worst, math.hypot(*free) / size)
    return worst


# ---- all of them ---------------------------------------------------------------------------------


def broken(scene: Scene, motion: Motion, slack: Slack) -> str:
    """What a motion that was called right did all the same; empty where every law holds."""
    way, h = motion.states, max(b - a for a, b in zip(motion.times, motion.times[1:], strict=False))
    if not abs(motion.times[-1] - scene["T"]) < 1e-9 * scene["T"]:
        return f"ends at {motion.times[-1]:g} s"
    spin = max(math.hypot(*omega) for s in way for _, _, _, omega in s.values())
    speed = max(math.hypot(*v) for s in way for _, _, v, _ in s.values())
    fastest = max(math.hypot(*v) + 0.4 * math.hypot(*w) for s in way for _, _, v, w in s.values())
    off = momentum_error(scene, motion)
    if not off < slack.momentum + slack.turning * h * (spin + speed / 0.05):
        return f"momentum out by {off:.3g} of what there is"
    held = [Held(j, way[0]) for j in scene["joints"]]
    drift = max((joint.drift(s, scene["dim"]) for s in way for joint in held), default=0.0)
    if not drift < slack.drift * h**2 * (spin**2 + speed**2 / 0.1) + 1e-6:
        return f"joints apart by {drift:.3g}"
    moved = max(lock_speed(scene, s) for s in way)
    if not moved < 1e-9 * (1 + speed + spin):
        return f"{moved:.3g} m/s along a lock"
    allowed = slack.steps * h * fastest + slack.depth + 1e-6
    deep = max(sunk(scene, s) for s in way)
    if not deep < allowed:
        return f"{deep:.3g} m behind a plane"
    deep = met(scene, way, allowed)
    if not deep <= allowed:
        return f"{deep:.3g} m in another body"
    out = 0.0
    if slack.cone < math.inf:
        out = max(out_of_cone(scene, pushes, slack.cone) for pushes in motion.pushes)
    if not out < 1e-6 + slack.turning * h * (spin + speed / 0.05):
        return f"contact force out of its cone by {out:.3g}"
    short = unspent(scene, motion, slack)
    if not short < slack.power:
        return f"contacts take {short:.3g} of the energy less than their forces say"
    if scene["friction"]["default"] == 0 or scene["restitution"]["default"] == 0:
        gain = gained(scene, motion, slack.gives_back)
        if not gain < slack.energy:
            return f"{gain:.3g} of the energy gained in a step"
    return ""

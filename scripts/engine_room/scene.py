"""A scene as plain data, from `lcpbench export SCENE --format scene`: lengths in m, masses in kg,
vectors with three entries. What every engine has to do alike is done here once: planar scenes
become slabs, driven bodies stand still in a frame that moves with them."""

from __future__ import annotations

import dataclasses
import json
import subprocess

import numpy as np

DEPTH = 0.5  # half depth of a slab, in mean half sizes of the scene's bodies


class Unsupported(Exception):
    """The scene, or the engine, cannot express this; the text says what."""


@dataclasses.dataclass
class Part:
    """A convex piece of a body: "ball" with a radius, "box" with half sides, "hull" with points."""

    kind: str
    size: np.ndarray  # ball: r; box: three half sides [m]
    points: np.ndarray  # box and hull: corners in the body frame, (n, 3) [m]


@dataclasses.dataclass
class Body:
    name: str
    part: Part
    mass: float
    inertia: np.ndarray  # principal moments in body axes [kg m^2]
    pos: np.ndarray
    quat: np.ndarray  # w, x, y, z
    vel: np.ndarray
    omega: np.ndarray  # world axes [rad/s]
    force: np.ndarray  # constant, world axes, at the centre of mass [N]
    free: tuple[str, ...]  # of x, y, z, rx, ry, rz


@dataclasses.dataclass
class Plane:
    name: str
    up: np.ndarray  # unit; up . x >= offset is free
    offset: float


@dataclasses.dataclass
class Scene:
    name: str
    dim: int
    duration: float
    gravity: np.ndarray
    bodies: list[Body]
    planes: list[Plane]
    friction: float
    restitution: float
    apart: set[frozenset[str]]  # pairs that pass through each other
    checks: list[dict]
    drive: tuple[np.ndarray, np.ndarray]  # velocity and acceleration of the frame
    leads: str  # a driven body; "": none is
    has_work: bool  # loads or driven bodies do work: energy is no yardstick

    def holds(self, body: Body) -> str:
        """ "" of a body that is free, "turns" of one that only does not turn, "fixed", or the axis
        that is left: the ways to be held that the engines are given."""
        if len(body.free) == 6:
            return ""
        if set(body.free) == set(AXES):
            return "turns"
        if not body.free:
            return "fixed"
        if len(body.free) == 1 and body.free[0] in AXES:
            return body.free[0]
        raise Unsupported(f"{body.name}: free along {', '.join(body.free)} only")

    def driven(self) -> int | None:
        """A driven body, whose frame the engines' scene is in."""
        return self.index()[self.leads] if self.leads else None

    def index(self) -> dict[str, int]:
        return {b.name: i for i, b in enumerate(self.bodies)}

    def pairs(self) -> list[tuple[int, int]]:
        """Pairs of bodies that may touch."""
        n = len(self.bodies)
        return [
            (i, j)
            for i in range(n)
            for j in range(i + 1, n)
            if frozenset((self.bodies[i].name, self.bodies[j].name)) not in self.apart
        ]


AXES = ("x", "y", "z")
TURNS = ("rx", "ry", "rz")


def _three(values: list[float] | None) -> np.ndarray:
    return np.array(([*values] if values else []) + [0.0] * (3 - len(values or [])), dtype=float)


def _corners(half: np.ndarray) -> np.ndarray:
    signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)], dtype=float)
    return signs * half


def _slab(points: np.ndarray, depth: float) -> np.ndarray:
    flat = np.hstack([points, np.zeros((len(points), 1))])
    return np.vstack([flat + [0, 0, depth], flat - [0, 0, depth]])


def _part(shape: dict, dim: int, depth: float) -> Part:
    kind = shape["type"]
    if kind in ("sphere", "disc"):
        return Part("ball", np.array([shape["r"]]), np.zeros((1, 3)))
    if kind == "box":
        half = np.array([*shape["half"], depth] if dim == 2 else shape["half"], dtype=float)
        return Part("box", half, _corners(half))
    if kind == "polygon":
        corners = _slab(np.array(shape["vertices"], dtype=float), depth)
        return Part("hull", np.array([depth]), corners)
    raise Unsupported(f"a {kind}")


def _size(shape: dict) -> float:
    if "r" in shape:
        return shape["r"]
    points = shape.get("half") or np.abs(np.array(shape.get("vertices", [[1.0]]))).max(axis=0)
    return float(np.mean(points))


def _slab_inertia(about: float, mass: float, part: Part) -> np.ndarray:
    """Moments of a slab whose moment about its depth is given, as if its mass were spread over the
    corners' box; a ball keeps one moment."""
    if part.kind == "ball":
        return np.full(3, about)
    span = part.points.max(axis=0) - part.points.min(axis=0)
    return np.array(
        [
            mass * (span[1] ** 2 + span[2] ** 2) / 12.0,
            mass * (span[0] ** 2 + span[2] ** 2) / 12.0,
            about,
        ]
    )


def _body(entry: dict, dim: int, depth: float) -> Body:
    part = _part(entry["shape"], dim, depth)
    mass = entry.get("mass", 1.0)
    given = entry.get("inertia")
    if given is None:
        inertia = np.zeros(3)
    else:
        inertia = _slab_inertia(given, mass, part) if dim == 2 else np.array(given, dtype=float)
    driven = entry.get("kinematic", {})
    moving = driven or entry
    half = entry.get("angle", 0.0) / 2.0
    turned = [np.cos(half), 0.0, 0.0, np.sin(half)]
    spin = moving.get("omega", 0.0)
    return Body(
        entry["name"],
        part,
        mass,
        inertia,
        _three(entry["pos"]),
        np.array(entry.get("quat", turned), dtype=float),
        _three(moving.get("vel")),
        np.array([0.0, 0.0, spin]) if dim == 2 else _three(spin or None),
        np.zeros(3),
        _free(entry, dim),
    )


def _free(entry: dict, dim: int) -> tuple[str, ...]:
    """A planar body is held in its plane by nothing but what it rests on, for which a slab is wide
    enough; one that does not turn, or that moves along one axis only, is held as it is in space."""
    if "kinematic" in entry:
        return ()
    held = set(entry.get("lock", [])) | set(entry.get("prescribed", {}))
    if dim == 2 and "rz" in held:
        held |= {"rx", "ry"}
    if dim == 2 and held & {"x", "y"}:
        held |= {"z"}
    return tuple(a for a in (*AXES, *TURNS) if a not in held)


def _drives(data: dict) -> list[tuple[np.ndarray, np.ndarray]]:
    """Velocity and acceleration of every driven body; of a drive along some axes only, the others
    stand still."""
    found = []
    for entry in data["bodies"]:
        if "kinematic" in entry:
            k = entry["kinematic"]
            if np.any(k.get("omega", 0.0)):
                raise Unsupported("a driven turn")
            found.append((_three(k.get("vel")), _three(k.get("acc"))))
        elif "prescribed" in entry:
            motion = entry["prescribed"]
            if set(motion) - set(AXES):
                raise Unsupported("a driven turn")
            zero = {"v0": 0.0, "a": 0.0}
            along = [motion.get(a, zero) for a in AXES]
            found.append((np.array([m["v0"] for m in along]), np.array([m["a"] for m in along])))
    return found


def _drive(data: dict) -> tuple[np.ndarray, np.ndarray]:
    """The one motion that all driven bodies share; none is standing still."""
    drives = _drives(data)
    if not drives:
        return np.zeros(3), np.zeros(3)
    first = drives[0]
    if any(not np.allclose([*v, *a], [*first[0], *first[1]]) for v, a in drives):
        raise Unsupported("bodies driven along different ways")
    if np.any(first) and data["static"]:
        raise Unsupported("driven bodies beside a fixed one")
    return first


def _coefficient(data: dict, key: str) -> float:
    found = data.get(key, {"default": 0.0, "pairs": []})
    if any(value != found["default"] for _, _, value in found["pairs"]):
        raise Unsupported(f"{key} that differs from pair to pair")
    return found["default"]


def of(data: dict) -> Scene:
    """A scene from the object that `lcpbench export` writes; Unsupported names what no engine here
    is given."""
    dim = data["dim"]
    for key in ("joints", "rolling", "torsion", "friction_kinetic"):
        entry = data.get(key)
        if entry and (key == "joints" or entry["default"] > 0 or entry["pairs"]):
            raise Unsupported(key)
    if any(np.any(p.get("surface_velocity", 0.0)) for p in data["static"]):
        raise Unsupported("a moving surface")
    depth = DEPTH * float(np.mean([_size(b["shape"]) for b in data["bodies"]]))
    velocity, acceleration = _drive(data)
    bodies = [_body(entry, dim, depth) for entry in data["bodies"]]
    for entry, body in zip(data["bodies"], bodies, strict=True):
        body.vel = body.vel - velocity if body.free else np.zeros(3)
        if set(entry.get("prescribed", {})):  # its other axes start as they are given
            body.vel = np.array(
                [body.vel[i] if a in body.free else 0.0 for i, a in enumerate(AXES)]
            )
    for load in data["loads"]:
        if load["type"] != "constant_force" or np.any(load["torque"]):
            raise Unsupported(f"a load of type {load['type']}")
        bodies[[b.name for b in bodies].index(load["body"])].force += _three(load["force"])
    return Scene(
        data["id"],
        dim,
        data["T"],
        _three(data["gravity"]) - acceleration,
        bodies,
        [_plane(**p) for p in data["static"]],
        _coefficient(data, "friction"),
        _coefficient(data, "restitution"),
        {frozenset(pair) for pair in data["no_collision"]},
        data["checks"],
        (velocity, acceleration),
        next((b["name"] for b in data["bodies"] if {"kinematic", "prescribed"} & {*b}), ""),
        bool(data["loads"] or np.any(velocity) or np.any(acceleration)),
    )


def _plane(name: str, normal: list[float], offset: float, **_: object) -> Plane:
    return Plane(name, _three(normal), offset)


def load(binary: str, text: str) -> Scene:
    """The scene of a name with parameters, or of a file. Unsupported also: not a scene file."""
    done = subprocess.run(
        [binary, "export", text, "--format", "scene", "--out", "-"],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise Unsupported(done.stderr.strip() or f"lcpbench export: exit code {done.returncode}")
    return of(json.loads(done.stdout))

"""Scenes in which something happens late: what `--effects auto:E` must not have left out."""

from __future__ import annotations

import math
import random

KINDS = ("lands", "wall", "load", "spin", "nothing", "leans", "falls")


def sized(dim: int, rng: random.Random) -> list[float]:
    return [rng.uniform(0.1, 0.3) for _ in range(dim)]


def late_scene(rng: random.Random) -> dict:
    """A block that slides, and what comes: a second body lands, a wall stands in the way, a load
    grows, a spin turns over, a ball rolls into it, or nothing does. Or the block itself falls, flat
    or on an edge, and then stays or slides."""
    dim = rng.choice([2, 3])
    up, half = dim - 1, sized(dim, rng)
    pos, vel = [0.0] * dim, [0.0] * dim
    pos[up], vel[0] = half[up], rng.choice([0.0, rng.uniform(0.5, 3)])
    box = {"type": "box", "half": half}
    bodies = [{"name": "a", "shape": box, "mass": 1.0, "pos": pos, "vel": vel}]
    floor = {"name": "floor", "normal": [0] * up + [1], "offset": 0}
    scene = {"id": "late", "dim": dim, "T": 1.0, "hs": [0.01], "static": [floor]}
    scene["gravity"] = [0.0] * up + [-9.81]
    scene["friction"] = {"default": 10 ** rng.uniform(-8, 0)}
    scene["restitution"] = {"default": rng.choice([0.0, rng.uniform(0, 0.9)])}
    scene["observe"] = ["a.x", "a.vx"]
    kind = rng.choice(KINDS)
    if kind == "lands":
        above = [rng.uniform(-0.2, 0.5) for _ in range(dim)]
        above[up] = 2 * half[up] + rng.uniform(0.5, 3)
        bodies.append(dict(bodies[0], name="b", pos=above, vel=[0.0] * dim))
    elif kind == "wall":
        tilt = rng.uniform(-0.6, 0.6) if dim == 3 else 0.0
        normal = [-math.cos(tilt), math.sin(tilt), 0.0] if dim == 3 else [-1.0, 0.0]
        scene["static"].append({"name": "wall", "normal": normal, "offset": -rng.uniform(0.5, 2)})
    elif kind == "load":
        side = rng.choice([0, max(dim - 2, 0)])
        push = [1.0 if k == side else 0.0 for k in range(dim)]
        scene["loads"] = [
            {"type": "force_ramp", "body": "a", "dir": push, "rate": rng.uniform(1, 20)}
        ]
    elif kind == "spin" and dim == 3:
        pos[up] += 50
        bodies[0]["omega"] = [1e-6, rng.uniform(3, 9), 1e-6]
        scene["observe"] = ["a.omega.x", "a.omega.y"]
    elif kind == "leans":
        radius = rng.uniform(0.05, 0.2)
        ball = {"type": "sphere" if dim == 3 else "disc", "r": radius}
        start = [half[0] + radius + rng.uniform(0.0, 1.0)] + [0.0] * (dim - 1)
        start[up] = radius + rng.choice([0.0, rng.uniform(0.0, 0.5)])
        if dim == 3:
            start[1] = rng.choice([0.0, rng.uniform(-0.1, 0.1)])
        bodies.append({"name": "b", "shape": ball, "mass": 0.5, "pos": start, "vel": [0.0] * dim})
    elif kind == "falls":
        pos[up] += rng.uniform(0.01, 0.6)
        vel[0] = rng.choice([0.0, vel[0]])
        tilt = rng.choice([0.0, rng.uniform(-0.4, 0.4)])
        half_turn = [math.cos(tilt / 2), 0.0, math.sin(tilt / 2), 0.0]
        bodies[0] |= {"angle": tilt} if dim == 2 else {"quat": half_turn}
        pos[up] += half[0] * abs(math.sin(tilt))
    scene["bodies"] = bodies
    return scene

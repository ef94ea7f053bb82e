"""Bodies that one joint ties to the world while they lie on a floor, at times against a wall too:
the joint makes normal and tangent of a contact move as one, so that the motion does not say what
friction is."""

import math
import random

from random_scenes import Scene


def body(rng: random.Random, dim: int) -> Scene:
    """On the floor, at times turning or sliding on it as far as its joint lets it."""
    half, r = rng.uniform(0.1, 0.4), rng.uniform(0.01, 0.1)
    kind = rng.choice(("capsule", "box", "ball"))
    form: Scene = {"type": kind, "half_length": half, "r": r}
    if kind == "box":
        sides = [half, r] if dim == 2 else [half, rng.uniform(0.05, 0.3), r]
        form = {"type": kind, "half": sides}
    elif kind == "ball":
        form = {"type": "disc" if dim == 2 else "sphere", "r": r}
    made = {"name": "b", "shape": form, "mass": 1.0, "pos": [0.0] * (dim - 1) + [r]}
    if dim == 3 and rng.random() < 0.6:
        made["omega"] = [rng.choice((0.0, rng.uniform(-3, 3))) for _ in range(3)]
    if rng.random() < 0.4:
        made["vel"] = [rng.uniform(-1, 1) for _ in range(dim - 1)] + [0.0]
    return made


def reach(form: Scene) -> tuple[float, float]:
    """Half its length, and how far its surface is beyond the end of that."""
    if form["type"] == "box":
        return form["half"][0], 0.0
    return form.get("half_length", 0.0), form["r"]


def pin(rng: random.Random, held: Scene, dim: int) -> Scene:
    height, half = held["pos"][-1], sum(reach(held["shape"]))
    if held["shape"]["type"] == "capsule":
        half = held["shape"]["half_length"]
    anchor = [rng.choice((-1, -1, 0, -0.5)) * half] + [0.0] * (dim - 2)
    anchor.append(height + rng.choice((0, 0, -height / 2, height, 0.1, 0.3)))
    if dim == 3 and rng.random() < 0.5:
        anchor[1] = rng.uniform(-0.1, 0.1)
    axis = [rng.gauss(0, 1) for _ in range(dim)]
    if rng.random() < 0.5:
        axis = [float(k == rng.randrange(dim)) for k in range(dim)]
    axis = axis if any(axis) else [1.0] + [0.0] * (dim - 1)
    kind = rng.choice(("ball", "hinge", "slider", "distance"))
    made = {"name": "j", "type": kind, "body": "b", "anchor": anchor}
    made["axis"] = [x / math.hypot(*axis) for x in axis]
    if kind == "distance":
        made |= {"anchor": held["pos"], "other_anchor": [anchor[0] - 0.3, *anchor[1:]]}
    return made


def random_pinned(seed: int) -> Scene:
    rng = random.Random(f"pinned {seed}")
    dim, tilt = rng.choice((2, 3)), rng.choice((0.0, 0.0, rng.uniform(-0.5, 0.5)))
    held = body(rng, dim)
    up = [0.0] * (dim - 1) + [1.0]
    static = [{"name": "floor", "normal": up, "offset": 0.0}]
    if rng.random() < 0.3:
        back = [-1.0] + [0.0] * (dim - 1)
        static.append({"name": "wall", "normal": back, "offset": -sum(reach(held["shape"]))})
    return {
        **{"id": f"pinned{seed}", "dim": dim, "T": 0.2, "hs": [0.005]},
        **{"gravity": [9.81 * math.sin(tilt)] + [0.0] * (dim - 2) + [-9.81 * math.cos(tilt)]},
        **{"static": static, "bodies": [held], "joints": [pin(rng, held, dim)]},
        **{"no_collision": [], "restitution": {"default": 0.0}, "observe": ["b.pos"]},
        **{"friction": {"default": rng.choice((0.1, 0.3, 0.7, 1.0, 1.6))}},
        **{"checks": [{"type": "finite"}]},
    }

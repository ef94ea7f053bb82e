"""Random scenes of one to six bodies: spheres, boxes and rods over a floor, at times between walls,
with friction up to 2, restitution up to 1 and joints, some of them resting at the start."""

import json
import math
import pathlib
import random
from typing import Any

Scene = dict[str, Any]


def shape(rng: random.Random, dim: int) -> tuple[Scene, float]:
    """A shape and the radius about its centre that holds it."""
    kind = rng.choice(["ball", "box", "capsule"] if dim == 3 else ["ball", "box", "capsule", "rod"])
    size = rng.uniform(0.05, 0.2)
    if kind == "ball":
        return {"type": "disc" if dim == 2 else "sphere", "r": size}, size
    if kind == "rod":
        return {"type": kind, "half_length": size}, size
    if kind == "capsule":
        thick = size * rng.uniform(0.1, 0.5)
        return {"type": kind, "half_length": size, "r": thick}, size + thick
    half = [size * rng.uniform(0.4, 1) for _ in range(dim)]
    return {"type": kind, "half": half}, math.hypot(*half)


def turned(rng: random.Random, body: Scene, dim: int) -> None:
    if dim == 2:
        body["angle"] = rng.uniform(-3, 3)
        body["omega"] = rng.uniform(-5, 5)
        return
    q = [rng.gauss(0, 1) for _ in range(4)]
    norm = math.hypot(*q)
    body["quat"] = [x / norm for x in q]
    body["omega"] = [rng.uniform(-5, 5) for _ in range(3)]


def add_bodies(rng: random.Random, scene: Scene) -> list[float]:
    """A column of bodies that lean to one side; returns their radii."""
    dim, up, radii, height = scene["dim"], scene["dim"] - 1, [], 0.0
    calm = rng.random() < 0.3
    for i in range(rng.randint(1, 6)):
        form, radius = shape(rng, dim)
        rest = form["half"][up] if form["type"] == "box" else form.get("r", 0.0)
        pos = [rng.uniform(-0.1, 0.1) for _ in range(dim)]
        flat = calm and (i == 0 or rng.random() < 0.3)
        pos[up] = height + (rest if flat and i == 0 else radius + rng.uniform(0.001, 0.3))
        body = {"name": f"b{i}", "shape": form, "mass": 10 ** rng.uniform(-1, 1), "pos": pos}
        if not flat:
            turned(rng, body, dim)
            body["vel"] = [rng.uniform(-2, 2) for _ in range(dim)]
        elif rng.random() < 0.5:
            body["vel"] = [rng.uniform(-2, 2) if k != up else 0 for k in range(dim)]
        height = pos[up] + radius
        radii.append(radius)
        scene["bodies"].append(body)
    return radii


def add_joints(rng: random.Random, scene: Scene) -> None:
    """Joints of neighbours in the column, at times of the first with the world."""
    bodies, dim = scene["bodies"], scene["dim"]
    for i, body in enumerate(bodies):
        other = bodies[i - 1] if i > 0 else None
        if rng.random() > 0.5:
            continue
        kind = rng.choice(["ball", "hinge", "slider", "fixed", "distance"])
        at = body["pos"] if other is None else other["pos"]
        middle = [(x + y) / 2 for x, y in zip(body["pos"], at, strict=True)]
        joint = {"name": f"j{i}", "type": kind, "body": body["name"], "anchor": middle}
        if other is not None:
            joint["other"] = other["name"]
            if rng.random() < 0.6:
                scene["no_collision"].append([body["name"], other["name"]])
        if kind == "distance":
            joint["anchor"] = body["pos"]
            joint["other_anchor"] = at if other else [x + 0.5 for x in body["pos"]]
        axis = [rng.gauss(0, 1) for _ in range(dim)]
        joint["axis"] = [x / math.hypot(*axis) for x in axis]
        scene["joints"].append(joint)


def add_planes(rng: random.Random, scene: Scene) -> None:
    dim, up = scene["dim"], scene["dim"] - 1
    slope = rng.uniform(-0.4, 0.4) if rng.random() < 0.3 else 0.0
    normal = [0.0] * dim
    normal[up], normal[0] = math.cos(slope), math.sin(slope)
    scene["static"].append(
        {"name": "floor", "normal": normal, "offset": -0.3 * abs(math.sin(slope))}
    )
    for k in range(rng.choice([0, 0, 1, dim - 1])):
        normal = [0.0] * dim
        normal[k] = 1.0
        scene["static"].append({"name": f"wall{k}", "normal": normal, "offset": -0.4})


def random_scene(seed: int) -> Scene:
    rng = random.Random(seed)
    dim = rng.choice([2, 3])
    gravity = [0.0] * dim
    gravity[dim - 1] = -9.81
    scene: Scene = {
        "id": f"random{seed}",
        "dim": dim,
        "T": 1.0,
        "hs": [0.02],
        "gravity": gravity,
        "bodies": [],
        "static": [],
        "joints": [],
        "no_collision": [],
        "friction": {"default": rng.choice([0.0, rng.uniform(0, 1), rng.uniform(0, 2)])},
        "restitution": {"default": rng.choice([0.0, 0.0, rng.uniform(0, 1)])},
    }
    add_planes(rng, scene)
    add_bodies(rng, scene)
    if rng.random() < 0.5:
        add_joints(rng, scene)
    scene["observe"] = [f"{b['name']}.pos" for b in scene["bodies"]]
    scene["checks"] = [{"type": "finite"}]
    return scene


def random_file(folder: pathlib.Path, seed: int) -> pathlib.Path:
    """A random scene that looks at all centres."""
    scene = random_scene(seed)
    axes = "xyz"[: scene["dim"]]
    scene["observe"] = [f"{b['name']}.{x}" for b in scene["bodies"] for x in axes]
    path = folder / f"random{seed}.json"
    path.write_text(json.dumps(scene))
    return path

"""Random mechanisms of two to six bodies: trees and loops of all joint types, to each other and to
the world, with masses from 0.01 to 100 kg, locks, planes to land on, friction or none."""

import math
import random

from random_scenes import Scene, add_planes, random_scene, shape, turned

JOINTS = ("ball", "hinge", "slider", "fixed", "distance")
LOCKS = {2: ("x", "y", "rot"), 3: ("x", "y", "z", "rx", "ry", "rz", "rot")}


def lock(rng: random.Random, body: Scene, dim: int) -> None:
    """Takes one or two directions away from a body that stands straight."""
    words = rng.sample(LOCKS[dim], rng.choice((1, 1, 2)))
    body["lock"] = words
    vel = body.get("vel", [0.0] * dim)
    body["vel"] = [0.0 if axis in words else v for axis, v in zip("xyz", vel, strict=False)]
    for key in ("angle", "quat", "omega"):
        body.pop(key, None)


def add_bodies(rng: random.Random, scene: Scene) -> None:
    """A column that leans to one side, close enough to meet while it falls."""
    dim, up, height = scene["dim"], scene["dim"] - 1, 0.0
    for i in range(rng.randint(2, 6)):
        form, radius = shape(rng, dim)
        pos = [rng.uniform(-0.1, 0.1) for _ in range(dim)]
        pos[up] = height + radius + rng.choice((0.001, rng.uniform(0.001, 0.2)))
        body = {"name": f"b{i}", "shape": form, "mass": 10 ** rng.uniform(-2, 2), "pos": pos}
        if rng.random() < 0.7:
            turned(rng, body, dim)
            body["vel"] = [rng.uniform(-2, 2) for _ in range(dim)]
        if rng.random() < 0.15:
            lock(rng, body, dim)
        height = pos[up] + radius
        scene["bodies"].append(body)


def joint(rng: random.Random, scene: Scene, body: Scene, other: Scene | None) -> Scene:
    kind = rng.choice(JOINTS)
    at = body["pos"] if other is None else other["pos"]
    made = {"name": f"j{len(scene['joints'])}", "type": kind, "body": body["name"]}
    made["anchor"] = [(x + y) / 2 for x, y in zip(body["pos"], at, strict=True)]
    if other is not None:
        made["other"] = other["name"]
    if kind == "distance":
        made["anchor"] = body["pos"]
        made["other_anchor"] = at if other else [x + 0.5 for x in body["pos"]]
    axis = [rng.gauss(0, 1) for _ in range(scene["dim"])]
    made["axis"] = [x / math.hypot(*axis) for x in axis]
    return made


def add_joints(rng: random.Random, scene: Scene) -> None:
    """A tree, each body to an earlier one, to the world or free; and in every other scene one or
    two more joints, which close loops."""
    bodies: list[Scene] = scene["bodies"]
    tied: dict[tuple[str, str | None], None] = {}  # in order, which a set has not
    for i, body in enumerate(bodies):
        if rng.random() < 0.75:
            other = rng.choice([None, *bodies[:i]] if i > 0 else [None, None])
            tied[body["name"], other and other["name"]] = None
            scene["joints"].append(joint(rng, scene, body, other))
    for _ in range(rng.choice((0, 0, 1, 2))):
        i = rng.randrange(len(bodies))
        other = rng.choice([None, *bodies[:i]])
        if (bodies[i]["name"], other and other["name"]) not in tied:
            tied[bodies[i]["name"], other and other["name"]] = None
            scene["joints"].append(joint(rng, scene, bodies[i], other))
    scene["no_collision"] = [[a, b] for a, b in tied if b and rng.random() < 0.6]


def random_mechanism(seed: int) -> Scene:
    rng = random.Random(f"mechanism {seed}")
    scene = random_scene(seed) | {"id": f"mechanism{seed}"}
    scene |= {"dim": rng.choice((2, 3)), "static": [], "bodies": [], "joints": []}
    scene["gravity"] = [0.0] * (scene["dim"] - 1) + [-9.81]
    mu, e = (rng.uniform(0, 1), rng.uniform(0, 2)), rng.uniform(0, 1)
    scene["friction"] = {"default": rng.choice((0.0, *mu))}
    scene["restitution"] = {"default": rng.choice((0.0, 0.0, e))}
    add_planes(rng, scene)
    add_bodies(rng, scene)
    add_joints(rng, scene)
    scene["observe"] = [f"{b['name']}.pos" for b in scene["bodies"]]
    return scene

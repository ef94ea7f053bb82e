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


def shape_of(dim: int, rng: random.Random) -> tuple[dict, float, float]:
    """A box or a ball, half its width and half its height."""
    if rng.random() < 0.6:
        half = sized(dim, rng)
        return {"type": "box", "half": half}, half[0], half[-1]
    r = rng.uniform(0.08, 0.2)
    return {"type": "sphere" if dim == 3 else "disc", "r": r}, r, r


def crowd_scene(rng: random.Random) -> dict:
    """Two to five bodies in a row or above one another, light and heavy, some moving or turning,
    between walls or on a slope, with little friction, and now and then without gravity."""
    dim = rng.choice([2, 3])
    up = dim - 1
    statics = [{"name": "floor", "normal": [0] * up + [1], "offset": 0}]
    if rng.random() < 0.7:
        wall = {"name": "right", "normal": [-1] + [0] * up, "offset": -rng.uniform(1, 2.5)}
        statics.append(wall)
    if rng.random() < 0.4:
        statics.append({"name": "left", "normal": [1] + [0] * up, "offset": -rng.uniform(0.5, 1)})
    if rng.random() < 0.2:
        tilt = rng.uniform(0.2, 1.2)
        normal = [-math.sin(tilt)] + [0] * (dim - 2) + [math.cos(tilt)]
        offset = -rng.uniform(1, 2) * math.sin(tilt)
        statics.append({"name": "slope", "normal": normal, "offset": offset})
    bodies: list[dict] = []
    end, top = 0.0, 0.0
    for k in range(rng.randint(2, 5)):
        shape, wide, high = shape_of(dim, rng)
        body = {"name": "abcde"[k], "shape": shape}
        body["mass"] = rng.choice([1.0, 1.0, 0.5, 10 ** rng.uniform(-2, 2)])
        if k > 0 and rng.random() < 0.4:
            x = rng.choice(bodies)["pos"][0] + rng.uniform(-0.3, 0.3)
            z = top + high + rng.uniform(0, 0.4)
            speed = rng.choice([0.0, rng.uniform(-1, 1)])
        else:
            x = end + wide + rng.choice([0.01, rng.uniform(0.02, 0.4)]) if k > 0 else 0.0
            z, end = high, x + wide
            speed = rng.choice([0.0, rng.uniform(0, 3)])
        top = max(top, z + high)
        body |= {"pos": [x] + [0.0] * (dim - 2) + [z], "vel": [speed] + [0.0] * up}
        if rng.random() < 0.15:
            spin = rng.uniform(-3, 3)
            body["omega"] = spin if dim == 2 else [0.0, spin, 0.0]
        bodies.append(body)
    return {
        "id": "crowd",
        "dim": dim,
        "T": rng.choice([0.5, 1.0]),
        "hs": [rng.choice([0.005, 0.01, 0.02])],
        "gravity": [0.0] * up + [-rng.choice([9.81, 9.81, 9.81, 0.0])],
        "static": statics,
        "bodies": bodies,
        "friction": {"default": 10 ** rng.uniform(-8, -3)},
        "restitution": {"default": rng.choice([0.0, rng.uniform(0, 0.9)])},
        "observe": ["a.x", "a.vx"],
    }


def strewn_scene(rng: random.Random) -> dict:
    """One to four bodies on a floor in space, aside of each other, turned about the vertical and
    spinning, some on another off its centre and going with it, with frictions of their own."""
    statics = [{"name": "floor", "normal": [0, 0, 1], "offset": 0}]
    if rng.random() < 0.5:
        a = rng.uniform(-0.5, 0.5)
        normal = [-math.cos(a), math.sin(a), 0]
        statics.append({"name": "wall", "normal": normal, "offset": -rng.uniform(1, 2.5)})
    bodies: list[dict] = []
    end, names = 0.0, "abcd"[: rng.randint(1, 4)]
    for name in names:
        shape, wide, high = shape_of(3, rng)
        wide = math.hypot(*shape["half"][:2]) if "half" in shape else wide
        velocity = [rng.choice([0.0, rng.uniform(0, 2)]), rng.choice([0.0, rng.uniform(-1, 1)])]
        velocity.append(0.0)
        omega = [0.0, 0.0, rng.choice([0.0, rng.uniform(-1.5, 1.5)])]
        under = bodies[-1] if bodies and "half" in bodies[-1]["shape"] else None
        if under and rng.random() < 0.5:
            most = 0.8 * min(under["shape"]["half"][:2])
            aside = [rng.uniform(-most, most), rng.uniform(-most, most)]
            pos = [under["pos"][0] + aside[0], under["pos"][1] + aside[1]]
            z = under["pos"][2] + under["shape"]["half"][2] + high
            pos.append(z + rng.choice([0.0, 0.0, rng.uniform(0.01, 0.3)]))
            if rng.random() < 0.6:
                omega = list(under["omega"])
                velocity = [under["vel"][0] - omega[2] * aside[1]]
                velocity += [under["vel"][1] + omega[2] * aside[0], 0.0]
        else:
            pos = [end + wide + rng.uniform(0.02, 0.4), rng.uniform(-0.2, 0.2), high]
            end = pos[0] + wide
        yaw = rng.choice([0.0, rng.uniform(-0.7, 0.7)])
        body = {"name": name, "shape": shape, "mass": rng.choice([1.0, 10 ** rng.uniform(-1, 1)])}
        body |= {"quat": [math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)], "pos": pos}
        bodies.append(body | {"vel": velocity, "omega": omega})
    of_pairs = [
        [a, b, rng.choice([0.0, 10 ** rng.uniform(-8, -1)])]
        for a, b in zip(names, names[1:], strict=False)
        if rng.random() < 0.5
    ]
    return {
        "id": "strewn",
        "dim": 3,
        "T": rng.choice([0.5, 1.0]),
        "hs": [rng.choice([0.005, 0.01, 0.02])],
        "gravity": [0.0, 0.0, -9.81],
        "static": statics,
        "bodies": bodies,
        "friction": {"default": 10 ** rng.uniform(-8, -2), "pairs": of_pairs},
        "restitution": {"default": rng.choice([0.0, 0.0, rng.uniform(0, 0.9)])},
        "observe": ["a.x", "a.vx"],
    }


def resisting_scene(rng: random.Random) -> dict:
    """One of the others, whose contacts resist rolling or turning about their normals, and half of
    the time hold by friction."""
    scene = rng.choice([late_scene, crowd_scene, strewn_scene])(rng)
    for effect in rng.choice([("rolling",), ("torsion",), ("rolling", "torsion")]):
        scene[effect] = {"default": 10 ** rng.uniform(-5, -1)}
    if rng.random() < 0.5:
        scene["friction"] = {"default": rng.uniform(0.1, 0.8)}
    return scene


def pile(name: str, dim: int, x: float, rng: random.Random) -> list[dict]:
    """One to three bodies at rest, one on the other: boxes, and now and then a ball on top."""
    bodies: list[dict] = []
    top = 0.0
    wide = rng.uniform(0.15, 0.3)
    for k in range(rng.randint(1, 3)):
        half = [wide * 0.8**k] * (dim - 1) + [rng.uniform(0.05, 0.2)]
        shape = {"type": "box", "half": half}
        if k > 0 and rng.random() < 0.2:
            half[-1] = rng.uniform(0.05, 0.12)
            shape = {"type": "sphere" if dim == 3 else "disc", "r": half[-1]}
        off = rng.choice([0.0, rng.uniform(-0.1, 0.1) * wide])
        pos = [x + off] + [0.0] * (dim - 2) + [top + half[-1]]
        bodies.append({"name": f"{name}{k}", "shape": shape, "mass": 1.0, "pos": pos})
        top += 2 * half[-1]
        if "r" in shape:
            break
    return bodies


def settled_scene(rng: random.Random) -> dict:
    """Piles at rest, side by side or apart, on a floor or a slope that holds them, some of them
    joined; and what reaches one of them late: a ball from afar or from above, a box that slides, a
    body that is driven, a load that grows; or nothing does."""
    dim = rng.choice([2, 3])
    up, names = dim - 1, "abc"[: rng.randint(1, 3)]
    bodies: list[dict] = []
    end = 0.0
    for name in names:
        piled = pile(name, dim, end, rng)
        bodies += piled
        end += rng.choice([0.0, 0.0, rng.uniform(0.01, 0.8)]) + 2 * piled[0]["shape"]["half"][0]
    friction = rng.choice([10 ** rng.uniform(-6, -2), rng.uniform(0.1, 0.8)])
    slope = rng.choice([0.0, 0.0, rng.uniform(0, 0.9) * math.atan(friction)])
    gravity = [9.81 * math.sin(slope)] + [0.0] * (dim - 2) + [-9.81 * math.cos(slope)]
    scene = {"id": "settled", "dim": dim, "T": rng.choice([0.5, 1.0]), "gravity": gravity}
    scene["hs"] = [rng.choice([0.005, 0.01, 0.02])]
    scene["static"] = [{"name": "floor", "normal": [0] * up + [1], "offset": 0}]
    scene["friction"] = {"default": friction}
    scene["restitution"] = {"default": rng.choice([0.0, 0.0, rng.uniform(0, 0.8)])}
    kind = rng.choice(("ball", "above", "slides", "driven", "load", "nothing"))
    r = rng.uniform(0.05, 0.15)
    ball = {"name": "z", "shape": {"type": "sphere" if dim == 3 else "disc", "r": r}, "mass": 1.0}
    aside = [0.0] * (dim - 2) if rng.random() < 0.5 else [rng.uniform(-0.1, 0.1)] * (dim - 2)
    if kind == "ball":
        far, speed = rng.uniform(0.3, 1.5), rng.uniform(1, 4)
        start = [-0.4 - far, *aside, r + rng.choice([0.0, rng.uniform(0, 0.3)])]
        bodies.append(ball | {"pos": start, "vel": [speed] + [0.0] * up})
    elif kind == "above":
        high = 1.2 + rng.uniform(0, 1)
        bodies.append(ball | {"pos": [rng.uniform(-0.2, end), *aside, high]})
    elif kind == "slides":
        half = [rng.uniform(0.05, 0.2)] * dim
        start = [-0.4 - half[0] - rng.uniform(0.1, 1.0), *aside, half[-1]]
        box = ball | {"shape": {"type": "box", "half": half}, "pos": start}
        bodies.append(box | {"vel": [rng.uniform(0.5, 3)] + [0.0] * up})
    elif kind == "driven":
        start = [-0.4 - r - rng.uniform(0.05, 0.4), *aside, r + 0.01]
        pusher = {"name": "z", "shape": ball["shape"], "pos": start}
        motion = rng.choice([{"vel": [1.0] + [0.0] * up}, {"acc": [2.0] + [0.0] * up}])
        bodies.append(pusher | {"kinematic": motion})
    elif kind == "load":
        push = [1.0] + [0.0] * up
        load = {"type": "force_ramp", "body": "a0", "dir": push, "rate": rng.uniform(1, 20)}
        scene["loads"] = [load]
    if len(names) > 1 and rng.random() < 0.3:
        anchor = [0.0] * up + [0.05]
        scene["joints"] = [{"type": "ball", "body": "a0", "other": "b0", "anchor": anchor}]
    scene["bodies"] = bodies
    scene["observe"] = ["a0.x"]
    return scene


def queue_scene(rng: random.Random) -> dict:
    """Two to four boxes in a row, face to face or apart, that slide with one velocity or two, each
    with a coefficient of friction of its own with the floor: a slope, a belt, or neither, with a
    wall at its end or not. What holds a box by its face may take load off it."""
    dim = rng.choice([3, 3, 2])
    up, end, speed = dim - 1, 0.0, rng.choice([0.0, 1.0, 2.0])
    bodies: list[dict] = []
    pairs: list[list] = []
    for k in range(rng.randint(2, 4)):
        half = rng.choice([0.05, 0.1, 0.1, 0.15])
        high = half * rng.choice([1.0, 1.0, 1.5, 0.7])
        gap = rng.choice([0.0, 0.0, 0.0, 0.02, 0.1]) if k else 0.0
        sides = [half, high] if dim == 2 else [half, rng.choice([half, 0.1]), high]
        own = speed if k and gap == 0.0 else rng.choice([0.0, speed, 1.5 * speed])
        body = {"name": f"b{k}", "shape": {"type": "box", "half": sides}}
        body["pos"] = [end + gap + (half if k else 0.0)] + [0.0] * (dim - 2) + [high]
        body["mass"], body["vel"] = rng.choice([1.0, 1.0, 2.0, 0.5]), [own] + [0.0] * up
        bodies.append(body)
        end = body["pos"][0] + half
        mu = rng.choice([None, 0.0, 0.05, 0.3, 0.5, 0.8])
        pairs += [[body["name"], "floor", mu]] if mu is not None else []
    slope = rng.choice([0.0, 0.0, 0.2, 0.4])
    scene = {"id": "queue", "dim": dim, "T": rng.choice([0.3, 0.5]), "hs": [0.01]}
    scene["gravity"] = [9.81 * math.sin(slope)] + [0.0] * (dim - 2) + [-9.81 * math.cos(slope)]
    scene["static"] = [{"name": "floor", "normal": [0] * up + [1], "offset": 0}]
    if rng.random() < 0.25:
        scene["static"][0]["surface_velocity"] = [rng.choice([-1, 1])] + [0] * up
    if rng.random() < 0.4:
        stop = end + rng.choice([0.0, 0.1, 0.3])
        scene["static"].append({"name": "wall", "normal": [-1] + [0] * up, "offset": -stop})
    scene["friction"] = {"default": rng.choice([0.1, 0.3]), "pairs": pairs}
    scene["restitution"] = {"default": rng.choice([0.0, 0.0, 0.3])}
    scene["bodies"] = bodies
    scene["observe"] = ["b0.x"]
    return scene

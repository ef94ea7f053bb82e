"""What an automatic choice does not see of itself, each scene with what is known of its answer:
closed forms, and for --effects the run with everything."""

import copy
import json
import math
import pathlib
from typing import Any

Scene = dict[str, Any]
G = 9.81


def scene(name: str, dim: int, duration: float, bodies: list[Scene], **more: Any) -> Scene:
    return {"id": name, "dim": dim, "T": duration, "hs": [0.01], "bodies": bodies, **more}


def body(name: str, shape: Scene, pos: list[float], **more: Any) -> Scene:
    return {"name": name, "shape": shape, "mass": 1.0, "pos": pos, **more}


def disc(name: str, r: float, pos: list[float], **more: Any) -> Scene:
    return body(name, {"type": "disc", "r": r}, pos, **more)


def box(name: str, half: list[float], pos: list[float], **more: Any) -> Scene:
    return body(name, {"type": "box", "half": half}, pos, **more)


def plane(name: str, normal: list[float], offset: float, **more: Any) -> Scene:
    return {"name": name, "normal": normal, "offset": offset, **more}


def written(folder: pathlib.Path, s: Scene) -> pathlib.Path:
    path = folder / f"{s['id']}.json"
    path.write_text(json.dumps(s))
    return path


# ---- for --error: the scene, and the values of what it observes --------------------------------


def swinging(periods: int) -> tuple[Scene, dict[str, float]]:
    """A force that swings whole periods: halvings of the run fall on its zeros."""
    omega = 2.0 * math.pi * periods
    load = {"type": "force_sine", "body": "b", "dir": [1, 0], "amplitude": omega * omega}
    s = scene("swinging", 2, 1.0, [disc("b", 0.1, [0, 0])], observe=["b.x", "b.vx"])
    return s | {"loads": [load | {"omega": omega}]}, {"b.x": omega, "b.vx": 0.0}


def grazed(under: float) -> tuple[Scene, dict[str, float]]:
    """Thrown at a ceiling that is `under` below the top of its way."""
    v, height, duration = math.sqrt(10.0), 0.5 - under, 0.6
    left = math.sqrt(v * v - 20.0 * height)
    t = duration - (v - left) / 10.0
    s = scene("grazed", 2, duration, [body("b", {"type": "point"}, [0, 0], vel=[0, v])])
    s |= {"gravity": [0, -10.0], "restitution": {"default": 1}, "observe": ["b.y", "b.vy"]}
    s["static"] = [plane("c", [0, -1], -height)]
    return s, {"b.y": height - left * t - 5.0 * t * t, "b.vy": -left - 10.0 * t}


def crossed(speed: float) -> tuple[Scene, dict[str, float]]:
    """A disc runs through another within half of the run, if nobody looks."""
    a = disc("a", 0.05, [-0.5 * speed, 0], vel=[speed, 0])
    s = scene("crossed", 2, 1.0, [a, disc("b", 0.05, [0, 0])])
    s |= {"restitution": {"default": 1}, "observe": ["a.x", "b.x"]}
    return s, {"a.x": -0.1, "b.x": 0.5 * speed + 0.1}


def poked(over: float) -> tuple[Scene, dict[str, float]]:
    """A bar comes, pushes a disc by `over` while it slows down, and goes back."""
    duration, v = 1.2, 10.0 / 3.0 * (0.95 + over)
    a = -2.0 * v / duration
    t = (-v + math.sqrt(v * v + 2.0 * a * 0.95)) / a  # its front is at the disc
    k = box("k", [0.01, 0.2], [-1.01, 0], kinematic={"vel": [v, 0], "acc": [a, 0]})
    del k["mass"]
    s = scene("poked", 2, duration, [k, disc("b", 0.05, [0, 0])], observe=["b.x", "b.vx"])
    pushed = v + a * t
    return s, {"b.x": pushed * (duration - t), "b.vx": pushed}


def just_hit(part: float) -> tuple[Scene, dict[str, float]]:
    """The run ends a part of its time behind an impact with a wall."""
    hit = 2.97 / 2.0
    s = scene("just_hit", 2, hit * (1.0 + part), [disc("b", 0.1, [0, 0], vel=[2, 0.7])])
    s |= {"restitution": {"default": 0.8}, "observe": ["b.x", "b.vx"]}
    s["static"] = [plane("w", [-1, 0], -3.07)]
    return s, {"b.x": 2.97 - 1.6 * hit * part, "b.vx": -1.6}


def passed_by() -> tuple[Scene, dict[str, float]]:
    """The least distance from the origin on a straight way lies between all states."""
    s = scene("passed_by", 2, 1.0, [disc("b", 0.1, [-0.6, 0.05], vel=[1.3, 0])])
    check = {"type": "window_min", "var": "b.pos", "t0": 0, "t1": 1.0, "value": 0.05}
    return s | {"checks": [check | {"tol": {"abs": 1}}]}, {"window_min b.pos": 0.05}


def middle_axis(off: float) -> tuple[Scene, dict[str, float]]:
    """A free body turns about its middle axis, `off` beside it [rad/s]; the fourth-order rule of
    Runge and Kutta for Euler's equations in body axes, and for the quaternion."""
    a, b, c = 1.0, 2.0, 3.0
    n, duration = 10000, 10.0
    h = duration / n

    def rate(z: list[float]) -> list[float]:
        w, x, y, p, q, r, t = *z[3:], *z[:3]
        turn = [-x * q - y * r - p * t, w * q + y * t - p * r, w * r + p * q - x * t]
        turn.append(w * t + x * r - y * q)
        spin = [(b - c) / a * r * t, (c - a) / b * t * q, (a - b) / c * q * r]
        return spin + [0.5 * v for v in turn]

    def on(z: list[float], k: list[float], h: float) -> list[float]:
        return [u + h * v for u, v in zip(z, k, strict=True)]

    z = [off, 4.0, 0.0, 1.0, 0.0, 0.0, 0.0]
    for _ in range(n):
        k1 = rate(z)
        k2 = rate(on(z, k1, 0.5 * h))
        k3 = rate(on(z, k2, 0.5 * h))
        k4 = rate(on(z, k3, h))
        for k, part in ((k1, 1), (k2, 2), (k3, 2), (k4, 1)):
            z = on(z, k, h * part / 6.0)
    spin, w, axis = z[:3], z[3], z[4:]

    def cross(u: list[float], v: list[float]) -> list[float]:
        return [u[i - 2] * v[i - 1] - u[i - 1] * v[i - 2] for i in range(3)]

    twice = [2.0 * v for v in cross(axis, spin)]
    in_space = [s + w * t + u for s, t, u in zip(spin, twice, cross(axis, twice), strict=True)]
    body_ = box("b", [0.3, 0.2, 0.1], [0, 0, 0], inertia=[a, b, c], omega=[off, 4.0, 0.0])
    s = scene("middle_axis", 3, duration, [body_], observe=[f"b.omega.{x}" for x in "xyz"])
    return s, dict(zip((f"b.omega.{x}" for x in "xyz"), in_space, strict=True))


def stopped(dim: int, load: float) -> tuple[Scene, dict[str, float]]:
    """A load stops a slide that static friction holds then; kinetic friction would let it go."""
    side = [0.0] * (dim - 2)
    half, pos = [0.2, *side, 0.1], [0.0, *side, 0.1]
    block = box("a", [h or 0.2 for h in half], pos, vel=[1.0, *side, 0.0])
    made = scene("stopped", dim, 0.6, [block], gravity=[0.0, *side, -10.0])
    made |= {"static": [plane("floor", [0.0, *side, 1.0], 0)], "observe": ["a.x", "a.vx"]}
    made |= {"friction": {"default": 0.6}, "friction_kinetic": {"default": 0.2}}
    made["loads"] = [{"type": "constant_force", "body": "a", "force": [-load, *side, 0.0]}]
    return made, {"a.x": 0.5 / (load + 2.0), "a.vx": 0.0}


def tossed(speed: float) -> tuple[Scene, dict[str, float]]:
    """A disc falls for half a second, and slides for a tenth: the impact turns it by 2 mu v_n / r,
    its weight by 2 mu g / r a second. It is so fast that the fall is small beside its way."""
    ball = disc("a", 0.1, [0.0, 1.35], vel=[speed, 0.0])
    made = scene("tossed", 2, 0.6, [ball], gravity=[0.0, -10.0], observe=["a.angle"])
    made |= {"static": [plane("floor", [0.0, 1.0], 0)], "friction": {"default": 0.3}}
    return made, {"a.angle": -(30.0 * 0.1 + 0.5 * 60.0 * 0.1**2)}


# ---- for --effects: the scene, the formulation and the solver ----------------------------------


def cube(**more: Any) -> Scene:
    return box("a", [0.1, 0.1, 0.1], [0, 0, 0.1], **more)


def on_floor(name: str, mu: float, bodies: list[Scene], **more: Any) -> Scene:
    static = [plane("floor", [0, 0, 1], 0)]
    observe = ["a.x", "a.y", "a.z", "a.vx", "a.vy", "a.vz"]
    s = scene(name, 3, 1.0, bodies, gravity=[0, 0, -G], static=static, observe=observe)
    return s | {"friction": {"default": mu}} | more


def hopping() -> Scene:
    """Two balls that hop on a box, whose hits take friction in, once each."""
    made = on_floor("hopping", 1e-5, [box("a", [0.5, 0.5, 0.1], [0, 0, 0.1], mass=10)])
    for name, pos, speed in (("b", [0.05, 0.02, 0.8], 0.1), ("c", [-0.2, 0.1, 1.0], 0.05)):
        ball = {"type": "sphere", "r": 0.1}
        made["bodies"].append(body(name, ball, pos, mass=0.1, vel=[speed, 0, 0]))
    return made | {"T": 3.0, "hs": [0.002], "restitution": {"default": 0.8}}


def left_out_by_mistake() -> list[tuple[Scene, str, str]]:
    belt = on_floor("belt_across", 0.3, [cube()])
    belt["static"] = [plane("floor", [0, 0, 1], 0, surface_velocity=[0, 1, 0])]
    tilted = box(
        "a", [0.1, 0.2, 0.05], [0, 0, 20], quat=[0.955336489125606, 0.29552020666133955, 0, 0]
    )
    turned = {"type": "constant_force", "body": "a", "force": [0, 0, G], "torque": [0, 0.01, 0]}
    product = on_floor("product", 0.3, [tilted], loads=[turned])
    product["observe"] += ["a.omega.x", "a.omega.y", "a.omega.z"]
    wall = plane("wall", [-0.8, 0.6, 0], -0.0799)
    ball = body("a", {"type": "sphere", "r": 0.1}, [0, 0, 0.1])
    overlap = on_floor("overlap", 1e-7, [ball])
    overlap["static"].append(wall)
    column = on_floor("column", 0.0, [box("a", [0.02, 0.02, 0.1], [0, 0, 2])], gravity=[0, 0, 0])
    column["joints"] = [{"type": "ball", "body": "a", "anchor": [0, 1e-8, 1.9]}]
    column["loads"] = [{"type": "constant_force", "body": "a", "force": [0, 0, -100]}]
    slid = scene(
        "slid",
        2,
        0.6,
        [box("a", [0.5, 0.1], [0, 0.1], vel=[1, 0])],
        gravity=[0, 0],
        observe=["a.x", "a.vx"],
    )
    slid["bodies"].append(box("b", [0.1, 0.1], [0.2, 0.6], vel=[1, -1]))
    slid |= {"static": [plane("floor", [0, 1], 0)]}
    slid |= {"friction": {"default": 0.6}, "friction_kinetic": {"default": 0.3}}
    turning = copy.deepcopy(slid)
    turning |= {
        "id": "turns_round",
        "hs": [0.001],
        "gravity": [0, -G],
        "friction": {"default": 1 / 1500},
    }
    turning |= {"restitution": {"default": 0.5}, "bodies": turning["bodies"][:1]}
    turning["bodies"][0]["shape"]["half"] = [0.1, 0.1]
    del turning["friction_kinetic"]
    turning["static"] = [plane("floor", [0, 1], 0, surface_velocity=[3, 0])]
    turning["static"].append(plane("wall", [-1, 0], -0.199565727))
    turning["loads"] = [{"type": "constant_force", "body": "a", "force": [-5, 0]}]
    tall = box("a", [0.1, 0.05, 0.2], [0, 0, 0.2], vel=[1.5, 0.3, 0])
    ice = 0.0031743119266055045
    aslant = [math.sqrt(0.5), math.sqrt(0.5), 0]
    return [
        (belt, "velocity", "lemke"),
        (product, "coulomb", "cone_newton"),
        (on_floor("polygon", 0.3, [cube(vel=[1, 0, 0])]), "velocity:facets=5", "lemke"),
        (overlap, "position", "lemke"),
        (column, "velocity", "lemke"),
        (slid, "velocity", "lemke"),
        (turning, "velocity", "lemke"),
        (on_floor("bristle", 0.4, [cube(vel=[0.2, 0, 0])]), "regularized", "lemke"),
        (on_floor("tumbles", 0.4, [tall]), "regularized", "lemke"),
        (on_floor("corners", 0.1 * ice, [cube(vel=aslant)]), "boxed", "ppm"),
    ]

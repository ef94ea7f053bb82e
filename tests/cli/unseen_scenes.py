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


def bounced(r: float, e: float, part: float) -> tuple[Scene, dict[str, float]]:
    """A ball, or a point (r = 0), dropped 1 m onto a floor, at `part` of the time after which it
    bounces no more."""
    u = math.sqrt(2.0 * G)
    duration = part * (u / G + 2.0 * u * e / G / (1.0 - e))
    t, v, last = u / G, u * e, 0.0  # the next impact, the speed behind it, the one before
    while t < duration:
        last, t, v = t, t + 2.0 * v / G, v * e
    left, speed = duration - last, v / e
    shape = {"type": "disc", "r": r} if r > 0.0 else {"type": "point"}
    s = scene("bounced", 2, duration, [body("b", shape, [0, 1.0 + r])], gravity=[0, -G])
    s |= {"restitution": {"default": e}, "static": [plane("f", [0, 1], 0)]}
    known = {"b.y": r + speed * left - 0.5 * G * left * left, "b.vy": speed - G * left}
    return s | {"observe": ["b.y", "b.vy"]}, known


def passed_by() -> tuple[Scene, dict[str, float]]:
    """The least distance from the origin on a straight way lies between all states."""
    s = scene("passed_by", 2, 1.0, [disc("b", 0.1, [-0.6, 0.05], vel=[1.3, 0])])
    check = {"type": "window_min", "var": "b.pos", "t0": 0, "t1": 1.0, "value": 0.05}
    return s | {"checks": [check | {"tol": {"abs": 1}}]}, {"window_min b.pos": 0.05}


def slid_off(duration: float) -> tuple[Scene, dict[str, float]]:
    """A point slides off a shelf after a tenth of a second: nothing closes or is hit then."""
    shelf = box("shelf", [0.4, 0.05], [-0.4, -0.05], kinematic={"vel": [0, 0]})
    dot = body("b", {"type": "point"}, [-0.2, 0], vel=[2.0, 0])
    s = scene("slid_off", 2, duration, [shelf, dot], gravity=[0, -G], observe=["b.y", "b.vy"])
    left = duration - 0.1
    return s, {"b.y": -0.5 * G * left * left, "b.vy": -G * left}


def glanced(duration: float) -> tuple[Scene, dict[str, float]]:
    """A disc hits another with its side, and both go on for long: what they are apart when they
    are hit turns their ways."""
    r, side, v = 0.05, 0.08, 1.0
    along = math.sqrt(4.0 * r * r - side * side)
    n = [along / (2.0 * r), side / (2.0 * r)]  # from the one that comes to the other
    given = 0.5 * (1.0 + 0.5) * v * n[0]
    left = duration - (1.0 - along) / v
    pair = [disc("a", r, [-1.0, 0], vel=[v, 0]), disc("b", r, [0, side])]
    s = scene("glanced", 2, duration, pair, observe=["a.x", "a.y", "b.x", "b.y"])
    a = [-along + (v - given * n[0]) * left, -given * n[1] * left]
    b = [given * n[0] * left, side + given * n[1] * left]
    known = dict(zip(["a.x", "a.y", "b.x", "b.y"], a + b, strict=True))
    return s | {"restitution": {"default": 0.5}}, known


def thrown_up() -> tuple[Scene, dict[str, float]]:
    """The highest place of a ball lies between two states, its fastest fall ends at one."""
    v = 0.56
    ball = disc("b", 0.05, [0, 1.33], vel=[0, v])
    s = scene("thrown_up", 2, 1.4, [ball], gravity=[0, -G], static=[plane("f", [0, 1], 0)])
    check = {"t0": 0, "t1": 1.4, "value": 1.0, "tol": {"abs": 9}}
    kinds = (("window_max", "b.y"), ("window_min", "b.vy"))
    s["checks"] = [check | {"type": kind, "var": var} for kind, var in kinds]
    known = {"window_max b.y": 1.33 + 0.5 * v * v / G}
    known["window_min b.vy"] = -math.sqrt(v * v + 2.0 * G * (1.33 - 0.05))
    return s | {"restitution": {"default": 0.8}}, known


def much_asked() -> tuple[Scene, dict[str, float]]:
    """A hundred states of a ball on a spring, and two windows that begin together."""
    omega, duration = 5.0, 4.0
    spring = {"type": "spring_to_moving_anchor", "body": "b", "dir": [1, 0], "k": omega * omega}
    s = scene("much_asked", 2, duration, [disc("b", 0.1, [1.0, 0])])
    s["loads"] = [spring | {"c": 0, "anchor0": [0, 0], "anchor_vel": [0, 0]}]
    times = [0.01 * i for i in range(1, 100)] + [duration]
    free = {"value": 0, "tol": {"abs": 9}}
    asked = [{"type": "state", "t": t, "var": "b.x"} for t in times]
    ends = (0.05, duration)
    asked += [{"type": "window_min", "var": "b.x", "t0": 0, "t1": t} for t in ends]
    known = {f"state b.x at {t:.4g} s": math.cos(omega * t) for t in times}
    known |= {"window_min b.x from 0 to": math.cos(omega * 0.05), "window_min b.x from 0 s": -1.0}
    return s | {"checks": [a | free for a in asked]}, known


def spun_up() -> tuple[Scene, dict[str, float]]:
    """A free body at rest, and a torque about its middle axis, 2e-9 beside it."""
    return turning("spun_up", 6.0, [0.0, 0.0, 0.0], 2e-9, 4.0)


def middle_axis(off: float) -> tuple[Scene, dict[str, float]]:
    """A free body turns about its middle axis, `off` beside it [rad/s]."""
    return turning("middle_axis", 10.0, [off, 4.0, 0.0], 0.0, 0.0)


def turning(
    name: str, duration: float, omega: list[float], tilt: float, torque: float
) -> tuple[Scene, dict[str, float]]:
    """A free body of inertias 1, 2, 3 and a torque about y in space; the fourth-order rule of Runge
    and Kutta for Euler's equations in body axes, and for the quaternion."""
    a, b, c = 1.0, 2.0, 3.0
    n = 10000
    h = duration / n

    def rate(z: list[float]) -> list[float]:
        w, x, y, p, q, r, t = *z[3:], *z[:3]
        turn = [-x * q - y * r - p * t, w * q + y * t - p * r, w * r + p * q - x * t]
        turn.append(w * t + x * r - y * q)
        push = [2.0 * (x * y + w * p), 1.0 - 2.0 * (x * x + p * p), 2.0 * (y * p - w * x)]
        spin = [(b - c) / a * r * t, (c - a) / b * t * q, (a - b) / c * q * r]
        spin = [s + torque * f / i for s, f, i in zip(spin, push, (a, b, c), strict=True)]
        return spin + [0.5 * v for v in turn]

    def on(z: list[float], k: list[float], h: float) -> list[float]:
        return [u + h * v for u, v in zip(z, k, strict=True)]

    z = [*omega, 1.0, tilt, 0.0, 0.0]
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
    turned = {"inertia": [a, b, c], "omega": omega, "quat": [1.0, tilt, 0.0, 0.0]}
    one = [box("b", [0.3, 0.2, 0.1], [0, 0, 0], **turned)]
    s = scene(name, 3, duration, one, observe=[f"b.omega.{x}" for x in "xyz"])
    load = {"type": "constant_force", "body": "b", "force": [0, 0, 0], "torque": [0, torque, 0]}
    s |= {"loads": [load]} if torque != 0.0 else {}
    return s, dict(zip((f"b.omega.{x}" for x in "xyz"), in_space, strict=True))


def broke_away(
    dim: int, at: float, duration: float, kinetic: float, lifted: bool
) -> tuple[Scene, dict[str, float]]:
    """A box of 1 kg that friction holds until `at` [s], mu 0.6 and then `kinetic`: a force along
    the ground grows, or one upwards takes its weight off it under a constant force."""
    mu, half = 0.6, [0.1, 0.1, 0.05][3 - dim :]
    up, along = [0.0] * (dim - 1) + [1.0], [0.0] * (dim - 2) + [1.0, 0.0]
    push = 0.5 * mu * G if lifted else 0.0
    rate = (mu * G - push) / ((mu if lifted else 1.0) * at)
    loads = [{"type": "force_ramp", "body": "a", "dir": up if lifted else along, "rate": rate}]
    if lifted:
        force = [push * x for x in along]
        loads.append({"type": "constant_force", "body": "a", "force": force})
    on = f"a.{'yx'[3 - dim]}"
    s = scene("broke_away", dim, duration, [box("a", half, [0.05 * x for x in up])])
    s |= {"static": [plane("floor", up, 0)], "loads": loads, "observe": [on, on[:2] + "v" + on[2:]]}
    s |= {"friction": {"default": mu}, "friction_kinetic": {"default": kinetic}}
    s["gravity"] = [-G * x for x in up]
    # what stands beside it, with nearly all of the friction that it could take, hides nothing
    s["bodies"].append(box("b", half, [5.0, *[0.05 * x for x in up[1:]]]))
    force = [0.9 * mu * G * x for x in along]
    s["loads"].append({"type": "constant_force", "body": "b", "force": force})
    t, jerk = duration - at, (kinetic if lifted else 1.0) * rate
    a = (mu - kinetic) * G * (0.5 if lifted else 1.0)
    way, speed = a * t**2 / 2 + jerk * t**3 / 6, a * t + jerk * t**2 / 2
    return s, {f"{on} at the end": way, f"{on[:2]}v{on[2:]} at the end": speed}


def pushed_over(
    mu: float, at: float, duration: float, push: float
) -> tuple[Scene, dict[str, float]]:
    """A box in space that friction holds until `at` [s], under a share of what it holds, `push`,
    and a force along the ground that grows."""
    half = [0.1, 0.1, 0.03]
    s = scene("pushed_over", 3, duration, [box("a", half, [0, 0, half[2]])], gravity=[0, 0, -G])
    rate = (1.0 - push) * mu * G / at
    s |= {"static": [plane("floor", [0, 0, 1], 0)], "observe": ["a.x", "a.vx"]}
    s |= {"friction": {"default": mu}}
    s["loads"] = [{"type": "force_ramp", "body": "a", "dir": [1, 0, 0], "rate": rate}]
    s["loads"].append({"type": "constant_force", "body": "a", "force": [push * mu * G, 0, 0]})
    t = duration - at
    return s, {"a.x at the end": rate * t**3 / 6, "a.vx at the end": rate * t**2 / 2}


def lifted_off(duration: float) -> tuple[Scene, dict[str, float]]:
    """A disc without friction that a growing force takes off the floor after 1 s: no step that ends
    before that shows it."""
    s = scene("lifted_off", 2, duration, [disc("a", 0.1, [0, 0.1])], gravity=[0, -G])
    s |= {"static": [plane("floor", [0, 1], 0)], "observe": ["a.y", "a.vy"]}
    s["loads"] = [{"type": "force_ramp", "body": "a", "dir": [0, 1], "rate": G}]
    t = duration - 1.0
    return s, {"a.y at the end": 0.1 + G * t**3 / 6, "a.vy at the end": G * t**2 / 2}


def swung_off(duration: float) -> tuple[Scene, dict[str, float]]:
    """The same by a force that swings, with its first peak at 1 s: it grows ever more slowly."""
    s, _ = lifted_off(duration)
    omega, top = math.pi / 2.0, 1.5 * G
    s["loads"][0] |= {"type": "force_sine", "amplitude": top, "omega": omega, "phase": 0.0}
    del s["loads"][0]["rate"]
    at = math.asin(G / top) / omega
    t, cosine = duration - at, math.cos(omega * at)
    speed = top / omega * (cosine - math.cos(omega * duration)) - G * t
    way = top / omega * (cosine * t - (math.sin(omega * duration) - G / top) / omega)
    return s, {"a.y at the end": 0.1 + way - G * t**2 / 2, "a.vy at the end": speed}


def peaked(over: float, backwards: bool = False) -> tuple[Scene, dict[str, float]]:
    """A box under a force that swings: about each peak it is `over` times what friction at rest
    holds. The run ends half-way from the first peak to where the force turns round."""
    mu, kinetic, omega = 0.5, 0.3, 2.0 * math.pi
    top, held, duration = over * mu * G, kinetic * G, 0.375
    s = scene("peaked", 2, duration, [box("a", [0.1, 0.05], [0, 0.05])], gravity=[0, -G])
    s |= {"static": [plane("floor", [0, 1], 0)], "observe": ["a.x", "a.vx"]}
    s |= {"friction": {"default": mu}, "friction_kinetic": {"default": kinetic}}
    swings = {"type": "force_sine", "body": "a", "dir": [1, 0], "amplitude": top, "omega": omega}
    s["loads"] = [
        swings | {"omega": -omega, "phase": math.pi} if backwards else swings | {"phase": 0}
    ]
    at = math.asin(1.0 / over) / omega
    t, cosine = duration - at, math.cos(omega * at)
    speed = top / omega * (cosine - math.cos(omega * duration)) - held * t
    way = top / omega * (cosine * t - (math.sin(omega * duration) - 1.0 / over) / omega)
    return s, {"a.x at the end": way - held * t**2 / 2, "a.vx at the end": speed}


def rolled_out() -> tuple[Scene, dict[str, float]]:
    """A disc that its rolling resistance stops half-way through the run, in a short step behind
    long ones."""
    r, rolling, speed = 0.278, 0.00275, 2.3656
    ball = disc("a", r, [0, r], vel=[speed, 0], omega=-speed / r)
    s = scene("rolled_out", 2, 64.81, [ball], observe=["a.x", "a.angle"])
    s |= {"static": [plane("floor", [0, 1], 0)], "friction": {"default": 0.5}}
    s |= {"rolling": {"default": rolling}, "gravity": [0, -G]}
    slows = rolling * G / r / 1.5
    way = speed**2 / (2.0 * slows)
    return s, {"a.x at the end": way, "a.angle at the end": -way / r}


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


def hit_aslant() -> tuple[Scene, dict[str, float]]:
    """A point falls 0.2 m onto a floor as it goes on at 1 m/s, and slides: what slips in an impact
    has kinetic friction there, 0.1 for 0.2 at rest."""
    thrown = body("b", {"type": "point"}, [0, 0.2], vel=[1, 0])
    s = scene("hit_aslant", 2, 0.3, [thrown], gravity=[0, -10], observe=["b.vx"])
    s |= {"static": [plane("f", [0, 1], 0)], "friction_kinetic": {"default": 0.1}}
    return s | {"friction": {"default": 0.2}}, {"b.vx": 0.7}


def slow() -> tuple[Scene, dict[str, float]]:
    """A disc falls 0.1 m in 447 s, and comes back at 0.8 of 4.5e-4 m/s."""
    s = scene("slow", 2, 3000.0, [disc("b", 0.05, [0, 0.15])], gravity=[0, -1e-6], hs=[10])
    s |= {"static": [plane("f", [0, 1], 0)], "restitution": {"default": 0.8}}
    t, v = 3000.0 - math.sqrt(0.2 / 1e-6), math.sqrt(0.2 * 1e-6)
    while t > 2.0 * (v := 0.8 * v) / 1e-6:
        t -= 2.0 * v / 1e-6
    ends = {"b.y": 0.05 + v * t - 0.5e-6 * t * t, "b.vy": v - 1e-6 * t}
    return s | {"observe": list(ends)}, ends


def point_turns() -> tuple[Scene, dict[str, float]]:
    """A point with an inertia on a torsion spring: what turns has no radius."""
    point = body("b", {"type": "point"}, [0, 0], inertia=0.02, angle=1.0)
    s = scene("point_turns", 2, 2.0, [point], observe=["b.angle"])
    s |= {"loads": [{"type": "torsion_spring", "body": "b", "k": 2}]}
    return s, {"b.angle": math.cos(20.0)}


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
    hung = scene("hung", 3, 1.0, [body("a", {"type": "point"}, [1, 0, 0], inertia=[0.5] * 3)])
    hung |= {"gravity": [0, 0, -G], "observe": ["a.x", "a.z"]}
    hung["joints"] = [{"type": "ball", "body": "a", "anchor": [0, 0, 0]}]
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
        (hung, "velocity", "lemke"),
        (slid, "velocity", "lemke"),
        (turning, "velocity", "lemke"),
        (on_floor("bristle", 0.4, [cube(vel=[0.2, 0, 0])]), "regularized", "lemke"),
        (on_floor("tumbles", 0.4, [tall]), "regularized", "lemke"),
        (on_floor("corners", 0.1 * ice, [cube(vel=aslant)]), "boxed", "ppm"),
    ]

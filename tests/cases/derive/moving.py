"""The scenes of tests/cases/moving: 24 to 204 contacts that move, in two sizes each, for studies
that would otherwise rest on scenes of four. Those with a closed form have it as their checks,
derived here without the program; the others are judged by converged references (`accuracy`).

moving.py prints what differs between the files and what is written here, and exits with 1 where
something does; moving.py --write writes the files.
"""

import json
import math
import pathlib
import random
import sys

FOLDER = pathlib.Path(__file__).resolve().parents[1] / "moving"
G = 9.81
FLOOR = {"name": "floor", "normal": [0, 0, 1], "offset": 0}
HALF_TURN = [round(math.sqrt(0.5), 15), 0, 0, round(math.sqrt(0.5), 15)]  # about z, by 90 degrees


def scene(name: str, title: str, duration: float, bodies: list[dict], **more) -> dict:
    found = {"id": name, "title": title, "dim": 3, "T": duration, "hs": [0.005]}
    found |= {"gravity": [0, 0, -G], "bodies": bodies, "static": [FLOOR]}
    found |= {"restitution": {"default": 0}} | more
    found["checks"] = [*more.get("checks", []), {"type": "finite"}]
    return found


def box(name: str, half: list[float], pos: list[float], **more) -> dict:
    shape = {"type": "box", "half": half}
    return {"name": name, "shape": shape, "mass": 1, "pos": places(pos)} | more


def places(x: list[float]) -> list[float]:
    return [round(u, 12) for u in x]


def state(var: str, time: float, value: float, first: float, source: str) -> dict:
    """`first` bounds the error of a step of first order over the step [m/s]; friction that first
    has to be stretched lags by deflections and creeps at the regularisation speed."""
    more = {"tol": {"abs": 1e-5, "h": first}, "reg": {"h": 1, "v": 1, "d": 5}, "source": source}
    return {"type": "state", "var": var, "t": time, "value": value} | more


# ---- closed forms --------------------------------------------------------------------------------


def bowls(n: int) -> dict:
    """A ball slips until its lowest point stands, after 2 u/(7 mu g) of a slip u: friction brakes
    the middle by mu g and turns the ball by 5 mu g/(2 r). From then on it rolls evenly."""
    draw, r, mu, end = random.Random(n), 0.1, 0.2, 0.3
    wide = math.ceil(math.sqrt(n))
    bodies, checks = [], []
    for i in range(n):
        start = [1.1 * (i % wide), 1.1 * (i // wide), r]
        vel = [round(draw.uniform(-1, 1), 3), round(draw.uniform(-1, 1), 3), 0]
        omega = [round(draw.uniform(-9, 9), 3) for _ in range(3)]
        ball = {"name": f"s{i}", "shape": {"type": "sphere", "r": r}, "mass": 1}
        bodies.append(ball | {"pos": places(start), "vel": vel, "omega": omega})
        if i in (0, n // 2, n - 1):
            slip = [vel[0] - omega[1] * r, vel[1] + omega[0] * r]
            u = math.hypot(*slip)
            for time in (end / 2, end):
                slips = min(time, 2 * u / (7 * mu * G))
                lost = mu * G * slips * (time - slips / 2)
                for k, axis in enumerate("xy"):
                    value = start[k] + vel[k] * time - slip[k] / u * lost
                    source = "slips for 2 u/(7 mu g), then rolls"
                    checks.append(state(f"s{i}.{axis}", time, value, 0.3, source))
    more = {"friction": {"default": mu}, "observe": [f"s{n - 1}.x", f"s{n // 2}.y"]}
    title = f"{n} balls that slip until they roll, each thrown and spun another way"
    return scene(f"bowls{n}", title, end, bodies, checks=checks, **more)


def pushed_row(n: int) -> dict:
    """The push k t on the last of n boxes moves them once it passes mu n m g; then
    m n x'' = k t - mu n m g."""
    mu, rate, end = 0.2, 20.0 * n, 0.3
    bodies = [box(f"b{i}", [0.1, 0.1, 0.05], [0.2 * i, 0, 0.05]) for i in range(n)]
    first = mu * n * G / rate
    checks = []
    for time in (0.2, end):
        moved = rate / n * (time - first) ** 3 / 6
        for i in (0, n - 1):
            source = "rate (t - t0)^3/(6 n m) from t0 = mu n m g/rate on"
            checks.append(state(f"b{i}.x", time, bodies[i]["pos"][0] + moved, 0.05, source))
    push = {"type": "force_ramp", "body": "b0", "dir": [1, 0, 0], "rate": rate}
    more = {"friction": {"default": mu}, "loads": [push], "observe": [f"b{n - 1}.x", "b0.x"]}
    title = f"a row of {n} boxes that a growing push sets in motion"
    return scene(f"pushed_row{n}", title, end, bodies, checks=checks, **more)


def pulled_plate(n: int) -> dict:
    """The middle plate is pulled from rest at 2 m/s^2. With k plates on it, friction could give the
    next one up to (mu' k - mu (k - 1)) g > 2 m/s^2: it stays on it. Those above slide with mu g,
    those below are held by more weight than what pulls at them."""
    mu, more_mu, pull, end = 0.1, 0.15, 2.0, 0.15
    m = n // 2
    k = n - m - 1
    assert (more_mu * k - mu * (k - 1)) * G > pull > mu * G
    bodies = [box(f"b{i}", [0.3, 0.3, 0.05], [0, 0, 0.05 + 0.1 * i]) for i in range(n)]
    bodies[m]["prescribed"] = {"x": {"v0": 0, "a": pull}}
    checks = [
        state(f"b{i}.x", time, a * time**2 / 2, a * time, source)
        for time in (end / 2, end)
        for i, a, source in (
            (n - 1, mu * G, "mu g t^2/2: slides"),
            (m + 1, pull, "as the pulled plate"),
            (m - 1, 0, "held by the weight above"),
        )
    ]
    more = {"friction": {"default": mu, "pairs": [[f"b{m}", f"b{m + 1}", more_mu]]}}
    more["observe"] = [f"b{n - 1}.x", f"b{m + 1}.x", f"b{m - 1}.x"]
    title = f"a plate that is pulled out of {n}"
    return scene(f"pulled_plate{n}", title, end, bodies, checks=checks, **more)


def rollers(n: int) -> dict:
    """A plank of mass M on n rollers, capsules of mass m, pulled by F. A roller moves half as fast
    as the plank and turns with that over r: x'' = F/(M + n (m + I/r^2)/4)."""
    r, half, mass, end = 0.1, 0.3, 0.5 * n, 0.3
    tube, ends = math.pi * r**2 * 2 * half, 4 / 3 * math.pi * r**3
    turning = (tube / 2 + 0.4 * ends) / (tube + ends)  # I/(m r^2)
    pull = 2 * (mass + n * (1 + turning) / 4)
    bodies = []
    for i in range(n):
        shape = {"type": "capsule", "half_length": half, "r": r}
        roller = {"name": f"r{i}", "shape": shape, "mass": 1}
        bodies.append(roller | {"pos": places([0.25 * i, 0, r]), "quat": HALF_TURN})
    middle = 0.25 * (n - 1) / 2
    bodies.append(box("plank", [middle + 0.2, 0.3, 0.05], [middle, 0, 2 * r + 0.05], mass=mass))
    checks = []
    for time in (end / 2, end):
        source = "t^2/2 F/(M + n (m + I/r^2)/4), rollers half of it"
        checks.append(state("plank.x", time, middle + time**2, 2 * time, source))
        checks.append(state("r1.x", time, 0.25 + time**2 / 2, time, source))
    load = {"type": "constant_force", "body": "plank", "force": [pull, 0, 0]}
    more = {"friction": {"default": 0.4}, "loads": [load], "observe": ["plank.x", "r1.x"]}
    title = f"a plank that is pulled on {n} rollers"
    return scene(f"rollers{n}", title, end, bodies, checks=checks, **more)


# ---- without a closed form -----------------------------------------------------------------------


def turntable(n: int) -> dict:
    end, spin, half = 0.3, 2.0, 0.09 if n < 20 else 0.07
    disc = {"name": "disc", "kinematic": {"omega": [0, 0, spin]}, "pos": [0, 0, 0.2]}
    bodies = [disc | {"shape": {"type": "box", "half": [2, 2, 0.1]}}]
    for i in range(n):
        turn, out = 2.399963 * i, 1.6 * math.sqrt((i + 0.5) / n)
        x, y = out * math.cos(turn), out * math.sin(turn)
        more = {"vel": places([-spin * y, spin * x, 0]), "omega": [0, 0, spin]}
        bodies.append(box(f"b{i}", [half, half, 0.03], [x, y, 0.33], **more))
    more = {"friction": {"default": 0.3}, "observe": [f"b{n - 1}.x", f"b{n // 2}.x"]}
    title = f"{n} boxes on a turning table: the outer ones slide off their circles"
    return scene(f"turntable{n}", title, end, bodies, **more)


def shaken_tray(n: int) -> dict:
    tray = box("tray", [1.5, 1.5, 0.05], [0, 0, 0.05], mass=20)
    bodies = [tray]
    for i in range(n):
        at = [0.6 * (i % 5) - 1.2, 0.6 * (i // 5 % 5) - 1.2, 0.14 + 0.08 * (i // 25)]
        bodies.append(box(f"b{i}", [0.12, 0.12, 0.04], at))
    grips = [["tray", f"b{i}", round(0.1 + 0.15 * i / n, 3)] for i in range(min(n, 25))]
    force = {"type": "force_sine", "body": "tray", "dir": [1, 0, 0], "phase": 0.4}
    force |= {"amplitude": 3 * (20 + n), "omega": 12}
    more = {"friction": {"default": 0.3, "pairs": [["tray", "floor", 0], *grips]}}
    more |= {"loads": [force], "observe": [f"b{n - 1}.x", "b0.x", "tray.x"]}
    title = f"{n} boxes on a tray that is shaken, each with friction of its own"
    return scene(f"shaken_tray{n}", title, 0.25, bodies, **more)


def spinning_deck(n: int) -> dict:
    bodies = [
        box(
            f"b{i}",
            [0.3, 0.3, 0.05],
            [0, 0, 0.05 + 0.1 * i],
            vel=[round(0.02 * (i + 1), 3), 0, 0],
            omega=[0, 0, 0.3 if i % 2 else 0.6],
        )
        for i in range(n)
    ]
    more = {"friction": {"default": 0.1}, "observe": [f"b{n - 1}.x", f"b{n // 2}.x"]}
    title = f"{n} plates that slide and turn on each other"
    return scene(f"spinning_deck{n}", title, 0.1, bodies, **more)


def dragged_chain(n: int) -> dict:
    bodies, joints, length, r = [], [], 0.1, 0.03
    x = y = 0.0
    for i in range(n):
        turn = -0.5 if i % 2 == 0 else 0.5
        along = [length * math.cos(turn), length * math.sin(turn)]
        shape = {"type": "capsule", "half_length": length, "r": r}
        link = {"name": f"c{i}", "shape": shape, "mass": 0.5}
        link["pos"] = places([x + along[0], y + along[1], r])
        link["quat"] = [round(math.cos(turn / 2), 15), 0, 0, round(math.sin(turn / 2), 15)]
        bodies.append(link)
        if i:
            hinge = {"name": f"j{i}", "type": "hinge", "axis": [0, 0, 1], "body": f"c{i - 1}"}
            joints.append(hinge | {"other": f"c{i}", "anchor": places([x, y, r])})
        x, y = x + 2 * along[0], y + 2 * along[1]
    way = [round(math.cos(0.3), 15), round(math.sin(0.3), 15), 0]
    pull = {"type": "spring_to_moving_anchor", "body": f"c{n - 1}", "k": 200 * n, "dir": way}
    pull |= {"c": round(20 * math.sqrt(n), 12), "anchor0": bodies[-1]["pos"], "anchor_vel": way}
    more = {"friction": {"default": 0.3}, "joints": joints, "loads": [pull]}
    more["no_collision"] = [[f"c{i - 1}", f"c{i}"] for i in range(1, n)]
    more["observe"] = [f"c{n - 1}.x", f"c{n - 1}.y", f"c{n // 2}.x"]
    title = f"a chain of {n} links on the floor, dragged at one end"
    return scene(f"dragged_chain{n}", title, 0.2, bodies, **more)


SIZES = (
    (bowls, (24, 200)),
    (pushed_row, (6, 24)),
    (pulled_plate, (8, 40)),
    (rollers, (12, 40)),
    (turntable, (9, 49)),
    (shaken_tray, (10, 50)),
    (spinning_deck, (6,)),
    (dragged_chain, (12, 48)),
)


def main(words: list[str]) -> int:
    texts = {}
    for family, sizes in SIZES:
        for n in sizes:
            made = family(n)
            lines = ",\n".join(f" {json.dumps(k)}: {json.dumps(v)}" for k, v in made.items())
            texts[FOLDER / f"{made['id']}.json"] = "{\n" + lines + "\n}\n"
    if words == ["--write"]:
        for path, text in texts.items():
            path.write_text(text, encoding="utf-8")
        return 0
    there = {path: path.read_text(encoding="utf-8") for path in FOLDER.glob("*.json")}
    wrong = sorted(p.name for p in texts.keys() | there.keys() if texts.get(p) != there.get(p))
    print("\n".join(f"{name} DIFFERS" for name in wrong) or f"{len(there)} files are as derived")
    return 1 if wrong or words else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""The answers in tests/cases/regressions/scenes and tests/cases/disputed, from first principles and
without the program: closed forms, Runge-Kutta on the few coordinates that move, and for the ball
between floor and wall a plain time stepper of its own.

derive.py prints each answer beside the one in the scene file, and exits with 1 where they differ.
"""

import json
import math
import pathlib
import sys
from collections.abc import Callable, Iterator
from typing import NamedTuple

CASES = pathlib.Path(__file__).resolve().parents[1]
SCENES = [*(CASES / "regressions" / "scenes").glob("*.json"), *(CASES / "disputed").glob("*.json")]
G = 9.81
Vector = list[float]
Answer = tuple[str, str, float]  # scene, "type var" of its check, value


def runge_kutta(f: Callable[[Vector], Vector], y: Vector, duration: float, steps: int) -> Vector:
    """The classical method of order four."""
    h = duration / steps
    for _ in range(steps):
        a = f(y)
        b = f([u + h / 2 * v for u, v in zip(y, a, strict=True)])
        c = f([u + h / 2 * v for u, v in zip(y, b, strict=True)])
        d = f([u + h * v for u, v in zip(y, c, strict=True)])
        y = [
            u + h / 6 * (p + 2 * q + 2 * r + s) for u, p, q, r, s in zip(y, a, b, c, d, strict=True)
        ]
    return y


def cross(a: Vector, b: Vector) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a: Vector, b: Vector) -> float:
    return sum(u * v for u, v in zip(a, b, strict=True))


# ---- pendulums -----------------------------------------------------------------------------------


def pendulums() -> Iterator[Answer]:
    """theta'' = -(m g l / I) cos theta from rest at theta = 0, I about the joint, l = 0.25 to the
    centre: a rod of length 2 l, I = (4/3) m l^2; a ball of radius 0.05 that turns with its arm,
    I = m l^2 + (2/5) m r^2."""
    arm = 0.25
    for scene, up, inertia in (
        ("pend2d", "y", 4 / 3 * arm**2),
        ("pend3d", "z", arm**2 + 0.4 * 0.05**2),
    ):
        rate = G * arm / inertia
        theta, _ = runge_kutta(lambda s, k=rate: [s[1], -k * math.cos(s[0])], [0, 0], 0.5, 5000)
        yield scene, f"state b.{up}", arm * math.sin(theta)
        yield scene, "state b.x", arm * math.cos(theta)


# ---- what falls, and what rests ------------------------------------------------------------------


def falls() -> Iterator[Answer]:
    """Without restitution what has landed stays, and the floor carries the weight. The impact of
    the two rods is even: every end meets the floor at once, and impulses m v/2 at its ends stop
    each rod."""
    yield "drop_e0", "state b.y", 0.1
    yield "drop_e0", "state b.vy", 0
    yield "drop_e0", "window_max b.y", 0.1
    yield "slider_fall", "state b.y", 0.1
    yield "slider_fall", "contact_force b floor", G
    yield "lock_rest", "contact_force b floor", G
    yield "heavy_on_light_1e8", "contact_force l floor", (1e8 + 1) * G
    yield "heavy_on_light_1e8", "contact_force H l", 1e8 * G
    yield "heavy_on_light_1e8", "window_min H.y", 0.4
    for variable, value in (("b.x", 0.3 * math.cos(0.5)), ("b.y", 0.3 * math.sin(0.5))):
        yield "rail_floor", f"state {variable}", value  # the rail carries it, nothing rubs
    yield from rails_that_land()
    yield "rail_down", "state b.z", 0.1
    yield "rail_down", "contact_force b floor", G
    yield "lock_slide", "state b.x", 1 / (2 * 0.5 * G)
    yield "lock_belt", "contact_force b floor", 0.5 * G
    yield "loop_falls", "contact_force_sum a floor b floor d floor", 4 * 0.2 * G
    for scene in ("two_rods_fall", "two_rods_fall_nc"):
        for body in ("a", "c"):
            yield scene, f"state {body}.y", 0
            yield scene, f"state {body}.angle", 0
        yield scene, "contact_force_sum a floor c floor", 2 * 0.2 * G


def early_touch_light() -> Iterator[Answer]:
    """b slides all the time: x = v t - mu g t^2 / 2. c flies until its lower face has fallen 1.4 m;
    the impulse m v_n of its landing allows a friction of mu m v_n = 2.6 N s, it needs 1 N s to
    stop."""
    yield "early_touch_light", "state b.x", 2 - 1e-7 * G * 2**2 / 2
    yield "early_touch_light", "state c.x", math.sqrt(2 * 1.4 / G)


# ---- free rotation -------------------------------------------------------------------------------


def dzhanibekov() -> Iterator[Answer]:
    """Spin about the axis of middle inertia turns over. On the separatrix, where omega_2 = 0,
    energy and angular momentum give
    |omega|^2 = w^2 (I2 (I2 - I3)/(I1 (I1 - I3)) + I2 (I1 - I2)/(I3 (I1 - I3))),
    and 1e-8 of disturbance does not change nine digits of it. Until it turns, |omega| = w."""
    i1, i2, i3 = (m / 3 for m in (0.04 + 0.09, 0.01 + 0.09, 0.01 + 0.04))
    w = 8.0
    share = i2 * (i2 - i3) / (i1 * (i1 - i3)) + i2 * (i1 - i2) / (i3 * (i1 - i3))

    def euler(s: Vector) -> Vector:
        a, b, c = s
        return [(i2 - i3) / i1 * b * c, (i3 - i1) / i2 * c * a, (i1 - i2) / i3 * a * b]

    steps, s, top = 20000, [1e-8, w, 1e-8], 0.0
    for k in range(steps):  # it does turn within the ten seconds, and reaches the closed form
        s = runge_kutta(euler, s, 10 / steps, 1)
        if math.hypot(*s) > top + 1e-12:
            top, when = math.hypot(*s), 10 * (k + 1) / steps
    assert abs(top - w * math.sqrt(share)) < 1e-6 and 5 < when < 6, (top, when)
    yield "dzhanibekov", "window_max b.omega", w * math.sqrt(share)


# ---- bodies that slide and spin on feet ----------------------------------------------------------


def solved(matrix: list[Vector], right: Vector) -> Vector:
    """Gauss-Jordan with row pivots."""
    rows = [row[:] + [r] for row, r in zip(matrix, right, strict=True)]
    for i in range(len(rows)):
        best = max(range(i, len(rows)), key=lambda k: abs(rows[k][i]))
        rows[i], rows[best] = rows[best], rows[i]
        for k in range(len(rows)):
            if k != i:
                factor = rows[k][i] / rows[i][i]
                rows[k] = [u - factor * v for u, v in zip(rows[k], rows[i], strict=True)]
    return [row[-1] / row[i] for i, row in enumerate(rows)]


class Feet(NamedTuple):
    """A rigid body on points: where they are, how high its centre stands, what moves it."""

    points: list[tuple[float, float]]
    height: float
    mass: float
    inertia: float
    start: Vector  # x and y velocity, spin
    push: Vector  # x and y force, torque


SLIDERS = {
    "slide_spin": Feet(
        [(x, y) for x in (-0.3, 0.3) for y in (-0.2, 0.2)],
        0.1,
        1.0,
        (0.3**2 + 0.2**2) / 3,
        [1.5, 0.4, 5],
        [0, 0, 0],
    ),
    "feet3": Feet(
        [(0.4, 0.0), (-0.2, 0.35), (-0.2, -0.35)], 0.3, 5.0, 0.6, [1.5, 0.4, 5], [0, 0, 0]
    ),
    "feet4": Feet(
        [(x, y) for x in (-0.4, 0.4) for y in (-0.3, 0.3)], 0.3, 5.0, 0.6, [1.5, 0.4, 5], [0, 0, 0]
    ),
    "feet8": Feet(
        [(x, y) for x in (-0.45, -0.15, 0.15, 0.45) for y in (-0.3, 0.3)],
        0.3,
        5.0,
        0.6,
        [1.5, 0.4, 5],
        [0, 0, 0],
    ),
    "feet4_pushed": Feet(
        [(x, y) for x in (-0.4, 0.4) for y in (-0.3, 0.3)],
        0.3,
        5.0,
        0.6,
        [0.3, -0.2, 0.5],
        [24, 15, 1.5],
    ),
}


def sliders() -> Iterator[Answer]:
    """The limit of equal linear springs under the feet, ever stiffer: their forces are
    N = a + b x + c y, and a, b, c follow from balance of height, pitch and roll with the friction
    mu N against the slip of each foot. All N stay positive and all feet slip, which the code
    asserts. (Springs of Hertz' law, N = (a + b x + c y)^1.5, end `slide_spin` at 0.5584 rad/s.)"""
    for name, body in SLIDERS.items():
        end = runge_kutta(sliding(body), [0, 0, 0, *body.start], 0.3, 1000)
        yield name, "state b0.omega.z", end[5]
        yield name, "state b0.x", end[0]
        yield name, "state b0.y", end[1]


def sliding(body: Feet, compliance: Vector | None = None) -> Callable[[Vector], Vector]:
    """With compliances c_i instead of equal ones N_i = (a + b x_i + c y_i)/c_i."""
    mu, up = 0.4, body.height
    soft = compliance or [1.0] * len(body.points)

    def motion(s: Vector) -> Vector:
        _, _, angle, vx, vy, spin = s
        cos, sin = math.cos(angle), math.sin(angle)
        foot = [(cos * x - sin * y, sin * x + cos * y) for x, y in body.points]
        slip = [(vx - spin * y, vy + spin * x) for x, y in foot]
        unit = [(x / math.hypot(x, y), y / math.hypot(x, y)) for x, y in slip]
        assert min(math.hypot(*u) for u in slip) > 0.01
        shape = [(1.0 / c, x / c, y / c) for (x, y), c in zip(foot, soft, strict=True)]
        balance = [
            (1.0, y - up * mu * u[1], up * mu * u[0] - x)
            for (x, y), u in zip(foot, unit, strict=True)
        ]
        matrix = [
            [sum(b[row] * f[k] for b, f in zip(balance, shape, strict=True)) for k in range(3)]
            for row in range(3)
        ]
        plane = solved(matrix, [body.mass * G, 0, 0])
        normal = [dot(plane, list(f)) for f in shape]
        assert min(normal) > 0
        force = [(-mu * n * u[0], -mu * n * u[1]) for n, u in zip(normal, unit, strict=True)]
        torque = sum(x * f[1] - y * f[0] for (x, y), f in zip(foot, force, strict=True))
        total = [(body.push[k] + sum(f[k] for f in force)) / body.mass for k in (0, 1)]
        return [vx, vy, spin, *total, (body.push[2] + torque) / body.inertia]

    return motion


# ---- a ball that slides into an oblique wall -----------------------------------------------------


MU, RADIUS, SPEED = 0.05, 0.1, 2.0
INERTIA = 0.4 * RADIUS**2
PLANES = (([0.0, 0.0, 1.0], 0.0), ([-0.8, 0.6, 0.0], -1.6))


def touches_wall() -> tuple[float, Vector, Vector, Vector]:
    """Time, position, velocity and spin where -0.8 x - r = -1.6; until then the ball slides."""
    way = (1.6 - RADIUS) / 0.8
    time = (SPEED - math.sqrt(SPEED**2 - 2 * MU * G * way)) / (MU * G)
    spin = MU * G * time * RADIUS / INERTIA
    assert spin * RADIUS < SPEED - MU * G * time  # not rolling yet
    return time, [way, 0.0, RADIUS], [SPEED - MU * G * time, 0.0, 0.0], [0.0, spin, 0.0]


def ball_after_wall(steps: int, duration: float) -> Vector:
    """Semi-implicit Euler; the impulses of a step by Gauss-Seidel over the two contacts to the last
    digit, each solved exactly: at a ball's contact normal and tangential direction do not
    couple."""
    start, x, v, spin = touches_wall()
    h = (duration - start) / steps
    soft = 1 + RADIUS**2 / INERTIA  # tangential velocity that a unit impulse gives
    for _ in range(steps):
        v[2] -= h * G
        touching = [n for n, offset in PLANES if dot(n, x) - offset - RADIUS <= 1e-9]
        impulse = [(0.0, [0.0, 0.0, 0.0]) for _ in touching]
        change = 1.0
        while change > 1e-15:
            change = 0.0
            for k, n in enumerate(touching):
                old_normal, old_pull = impulse[k]
                lever = [-RADIUS * u for u in n]
                point = [u + w for u, w in zip(v, cross(spin, lever), strict=True)]
                speed = dot(n, point)
                normal = max(0.0, old_normal - speed)
                pull = [
                    t - (u - speed * m) / soft for t, u, m in zip(old_pull, point, n, strict=True)
                ]
                shrink = min(1.0, MU * normal / max(math.hypot(*pull), 1e-300))
                pull = [u * shrink for u in pull]
                more = [
                    (normal - old_normal) * m + new - old
                    for m, new, old in zip(n, pull, old_pull, strict=True)
                ]
                impulse[k] = normal, pull
                v = [u + w for u, w in zip(v, more, strict=True)]
                spin = [u + w / INERTIA for u, w in zip(spin, cross(lever, more), strict=True)]
                change = max(change, *map(abs, more))
        x = [u + h * w for u, w in zip(x, v, strict=True)]
    return x


def late_oblique() -> Iterator[Answer]:
    """In closed form to the wall, by the time stepper from there: the wall's friction makes the
    ball hop, then it slides along both. Steps of 92 and 46 microseconds, extrapolated."""
    coarse, fine = (ball_after_wall(steps, 2.0) for steps in (10000, 20000))
    for k, name in enumerate(("x", "y")):
        assert abs(fine[k] - coarse[k]) < 2e-5, (coarse, fine)
        yield "late_oblique", f"state b.{name}", 2 * fine[k] - coarse[k]


# ---- what the field argues about -----------------------------------------------------------------


def balls() -> Iterator[Answer]:
    """Solid balls, b = 2/5. Thrown with backspin: slips until (v0 + r w0) b/(mu g (1 + b)), then
    rolls at (v0 - b r w0)/(1 + b). On a turntable: rolling on a floor that moves with Omega x r
    the centre's acceleration is k Omega/|Omega| x v, k = 2 Omega/7."""
    v0, spin, r, b, mu, end = 1.0, 40.0, 0.1, 0.4, 0.3, 1.0
    slips = (v0 + r * spin) * b / (mu * G * (1 + b))
    rolls = (v0 - b * r * spin) / (1 + b)
    yield "backspin", "state ball.vx", rolls
    x = v0 * slips - mu * G * slips**2 / 2 + rolls * (end - slips)
    yield "backspin", "state ball.x", x
    k, v0, end = 2 / 7, 0.2, 6.0
    yield "turntable", "state ball.x", 1 + v0 / k * math.sin(k * end)
    yield "turntable", "state ball.y", v0 / k * (1 - math.cos(k * end))


def rails_that_land() -> Iterator[Answer]:
    """A turned box on an inclined rail falls until its lowest corner stands on the floor, where its
    rail leaves it no way: its middle is then as high as the half edges reach."""
    start, half = 0.3, (0.05, 0.06, 0.09)
    for name in ("rail_lands", "rail_lands_steep"):
        path = CASES / "regressions" / "scenes" / f"{name}.json"
        scene = json.loads(path.read_text())
        w, x, y, z = scene["bodies"][0]["quat"]
        axis = scene["joints"][0]["axis"]
        up = (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y))
        height = sum(abs(u) * h for u, h in zip(up, half, strict=True))
        yield name, "state box.z", height
        yield name, "state box.x", axis[0] * (height - start) / axis[2]


def plates() -> Iterator[Answer]:
    """mu m g brakes a plate, however 59 points share its weight; crates of 2 a on each other."""
    yield "patch59", "state plate.x", 0.5**2 / (2 * 0.3 * G)
    yield "patch59", "state plate.y", 0
    yield "crates40", "state c004.z", (2 * 4 + 1) * 0.1


def cubes() -> Iterator[Answer]:
    """A cube on its face: mu m g brakes it, at h below its middle, so the normal force stands mu h
    ahead of the middle, inside the face; on a wall it stands m g h / N above the middle."""
    h, mu, speed, push = 0.1, 0.5, 6.0, 30.0
    assert mu * h < h and G < mu * push and G * h / push < h
    yield "thrown_flat", "state cube.x", speed**2 / (2 * mu * G)
    yield "thrown_flat", "state cube.z", h
    yield "thrown_flat", "window_max cube.z", h
    yield "pressed_to_wall", "state cube.x", h
    yield "pressed_to_wall", "state cube.z", 0


def belts() -> Iterator[Answer]:
    """A mass m on a spring k is dragged to mu_s N / k and swings about mu_k N / k from there."""
    g, k, speed, static, kinetic = 9.81, 20.0, 0.1, 0.4, 0.3
    swing = math.hypot((static - kinetic) * g / k, speed / math.sqrt(k))
    for scene in ("stick_slip_twice", "stick_slip_on_four"):
        yield scene, "window_max block.x", kinetic * g / k + swing
        yield scene, "window_min block.x", kinetic * g / k - swing


def arches_are_at_their_limit(scenes: dict[str, dict]) -> bool:
    """Joint k of a semicircular arch of n equal stones is radial at phi = pi k/n and carries
    V = n/2 - k weights beside the thrust H, which is the same everywhere. Friction holds where
    the angle between (H, V) and the joint's normal is at most atan mu in every joint: the least mu
    is that of the best H (golden section would do; halving thirds is enough). The stones are thick
    enough that the thrust stays inside (0.2 of the radius, where 0.1075 are needed)."""
    n = 9

    def needed(thrust: float) -> float:
        slopes = []
        for k in range(n // 2 + 1):
            phi, v = math.pi * k / n, n / 2 - k
            along = thrust * math.cos(phi) - v * math.sin(phi)
            slopes.append(abs(along / (v * math.cos(phi) + thrust * math.sin(phi))))
        return max(slopes)

    low, high = 0.0, float(n)
    for _ in range(200):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        low, high = (low, b) if needed(a) < needed(b) else (a, high)
    least = needed(low)
    right = True
    for scene, share in (("arch_stands", 1.02), ("arch_falls", 0.98)):
        mu = scenes[scene]["friction"]["default"]
        same = abs(mu / least - share) < 1e-5
        right = right and same
        said = "" if same else "  DIFFERS"
        print(f"{scene:20} {'mu over the least, ' + str(least):36} {share:17.9g}  file {mu}{said}")
    return right


# ---- the scene files -----------------------------------------------------------------------------


def label(check: dict) -> str:
    pairs = check.get("pairs", [check["pair"]] if "pair" in check else [])
    return " ".join([check["type"], *([check["var"]] if "var" in check else []), *sum(pairs, [])])


def main() -> int:
    wrong = 0
    scenes = {path.stem: json.loads(path.read_text()) for path in SCENES}
    families = (
        pendulums,
        falls,
        early_touch_light,
        dzhanibekov,
        sliders,
        late_oblique,
        balls,
        plates,
        cubes,
        belts,
    )
    wrong += not arches_are_at_their_limit(scenes)
    for scene, name, value in (answer for family in families for answer in family()):
        checks = [c for c in scenes[scene]["checks"] if label(c) == name]
        for check in checks or [{"value": math.nan}]:
            same = abs(check["value"] - value) <= 1e-6 * max(1e-3, abs(value))
            wrong += not same
            print(
                f"{scene:20} {name:36} {value:17.9g}  file {check['value']:17.9g}"
                f"{'' if same else '  DIFFERS'}"
            )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

"""answers [--out FILE.md] - what theory says and what comes out, one line each; the last line
counts."""

import csv
import itertools
import json
import math
import pathlib
import sys
import tempfile
from collections.abc import Callable, Iterator

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from bench import binary, experiments, say  # noqa: E402

WAYS = {name: experiments.way(entry) for name, entry in experiments.of("answers.ways").items()}
VELOCITY, POSITION, REGULARIZED, CONE, ACCELERATION = WAYS.values()


Way = tuple[str, str]  # formulation, solver
Line = tuple[str, Way, float, float, float, str]  # what, way, theory, got, tolerance, why


def simulate(scene: str | pathlib.Path, way: Way, *more: object) -> dict:
    return binary.simulate(scene, *way, *more)


def scene(name: str, *values: float) -> str:
    """A scene of scripts/experiments.toml with its {} filled."""
    return experiments.filled(experiments.of("answers.scenes")[name]["scene"], *values)


def end(o: dict, name: str) -> float:
    return o["observables"][name]["value"]


# ---- three cylinders: MATHEMATICS B13 ------------------------------------------------------------


def stands(mu_cylinders: float, mu_ground: float, way: Way) -> bool:
    """Has the top cylinder not moved by more than a millionth of its radius?"""
    asked = scene("pile", mu_cylinders, mu_ground)
    o = simulate(asked, way)
    if o["status"] != "ok":
        raise SystemExit(f"{asked}, {way[0]}: {o['status']}: {o['note']}")
    return abs(end(o, "top.y") - 0.1 * (1 + math.sqrt(3))) < 1e-7


def threshold(test: Callable[[float], bool], low: float, high: float, width: float) -> float:
    """Where test turns from false to true."""
    assert not test(low) and test(high)
    while high - low > width:
        middle = (low + high) / 2
        low, high = (low, middle) if test(middle) else (middle, high)
    return (low + high) / 2


def pile() -> Iterator[Line]:
    tan15 = math.tan(math.pi / 12)
    piles = ((0.30, 0.12, 1), (0.27, 0.09, 1), (0.25, 0.12, 0), (0.30, 0.08, 0))
    for way in (VELOCITY, POSITION, CONE):
        for cylinders, ground, answer in piles:
            yield (
                f"three cylinders stand: mu = {cylinders:.2f}, {ground:.2f}",
                way,
                answer,
                int(stands(cylinders, ground, way)),
                0,
                "tan 15 and tan(15)/3",
            )
    # bristles give way a little before they hold: standing is told by the fall, not by the first
    # micrometre
    for cylinders, ground, answer in piles:
        fall = 0.1 * (1 + math.sqrt(3)) - end(
            simulate(scene("pile", cylinders, ground), REGULARIZED), "top.y"
        )
        yield (
            f"three cylinders stand: mu = {cylinders:.2f}, {ground:.2f}",
            REGULARIZED,
            answer,
            int(fall < 1e-4),
            0,
            "tan 15 and tan(15)/3",
        )
    for way in (VELOCITY, CONE):
        yield (
            "least mu between the cylinders",
            way,
            tan15,
            threshold(lambda mu, way=way: stands(mu, 0.12, way), 0.26, 0.28, 2e-6),
            1e-5,
            "tan 15",
        )
        yield (
            "least mu on the ground",
            way,
            tan15 / 3,
            threshold(lambda mu, way=way: stands(0.3, mu, way), 0.085, 0.095, 2e-6),
            1e-5,
            "tan(15)/3",
        )


# ---- rocking block: MATHEMATICS B11 --------------------------------------------------------------


def block(b: float, h: float, mu: float) -> dict:
    """Falls flat turning about its left lower corner at 1 rad/s: one step without gravity is the
    impact alone."""
    return {
        "id": "falls flat",
        "dim": 2,
        "T": 1e-4,
        "hs": [1e-4],
        "gravity": [0, 0],
        "friction": {"default": mu},
        "restitution": {"default": 0},
        "bodies": [
            {
                "name": "block",
                "shape": {"type": "box", "half": [b, h]},
                "mass": 1,
                "pos": [0, h],
                "vel": [h, -b],
                "omega": -1,
            }
        ],
        "static": [dict(name="floor", normal=[0, 1], offset=0)],
        "observe": ["block.omega"],
        "checks": [{"type": "finite"}],
    }


def rocking() -> Iterator[Line]:
    cases = (
        (0.1, 0.3, 0.5, 0.85),
        (0.2, 0.3, 0.5, 1 - 1.5 * 4 / 13),
        (0.3, 0.3, 2.0, 0.25),
        (0.1, 0.3, 0.2, 0.785714),
        (0.2, 0.3, 0.2, 0.214953),
        (0.3, 0.3, 0.5, 0.142857),
    )
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "impact.json"
        for b, h, mu, ratio in cases:
            path.write_text(json.dumps(block(b, h, mu)))
            least = 3 * b * h / (h * h + b * b) / (1 + 3 * h * h / (h * h + b * b))
            for way in (VELOCITY, CONE):
                what = f"omega after over before, b/h = {b}/{h}, mu = {mu}"
                yield (
                    what,
                    way,
                    ratio,
                    -end(simulate(path, way), "block.omega"),
                    1e-6,
                    "1 - 1.5 sin^2 (Housner)" if mu >= least else "slips at the impact",
                )


# ---- friction in time: MATHEMATICS B15, B16 ------------------------------------------------------


def spin() -> Iterator[Line]:
    event = [
        p
        for p in simulate(scene("drilling"), CONE)["predictions"]
        if p["quantity"].startswith("event_time")
    ][0]
    yield (
        "time until the spinning box stops [s]",
        CONE,
        event["predicted"],
        event["value"],
        event["tolerance"],
        "I w0/(mu m g r_c)",
    )


def belt() -> Iterator[Line]:
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "belt.csv"
        simulate(scene("stick_slip"), REGULARIZED, "--trajectory", path, "--step", 1e-4)
        with open(path, newline="", encoding="utf-8") as f:
            rows = [
                (float(r["t_s"]), float(r["vx_m_s"]))
                for r in csv.DictReader(f)
                if r["kind"] == "body"
            ]
    slips = [t for (_, before), (t, v) in itertools.pairwise(rows) if before > 0.09995 >= v]
    omega, deflection, speed = math.sqrt(20), 0.1 * 9.81 / 20, 0.1
    period = 2 / omega * (math.pi - math.atan(omega * deflection / speed)) + 2 * deflection / speed
    yield (
        "period of stick and slip on the belt [s]",
        REGULARIZED,
        period,
        slips[-1] - slips[-2],
        2e-3,
        "(2/w)(pi - atan(w D/v)) + 2D/v",
    )


# ---- where models end: MATHEMATICS B7, B8 --------------------------------------------------------


def painleve() -> Iterator[Line]:
    for tangent in (1.0, 2.0, 3.0):
        angle = math.degrees(math.atan(tangent))
        cosine = math.cos(math.atan(tangent))
        sine = tangent * cosine
        least = (1 + 3 * cosine**2) / (3 * sine * cosine)

        def refused(mu: float, angle: float = angle):
            return simulate(scene("paradox", angle, mu), ACCELERATION, "--duration", 1e-3)[
                "status"
            ] in ("infeasible", "ray")

        yield (
            f"mu from which no acceleration exists, tan = {tangent:g}",
            ACCELERATION,
            least,
            threshold(refused, 0.9 * least, 1.1 * least, 1e-6),
            1e-5,
            "(1 + 3 cos^2)/(3 sin cos)",
        )
        o = simulate(scene("paradox", angle, 1.5 * least), VELOCITY)
        yield (
            f"steps of time stepping beyond it, tan = {tangent:g}",
            VELOCITY,
            50,
            o["steps"] if o["status"] == "ok" else 0,
            0,
            "solvable for every h",
        )


def cradle() -> Iterator[Line]:
    for gap, answer, why in (
        (
            0,
            (-1 / 3, 2 / 3, 2 / 3),
            "limitation: all touch, one simultaneous impact; observed is (0, 0, 1)",
        ),
        (0.01, (0, 0, 1), "apart: impacts one after another"),
    ):
        o = simulate(scene("balls", gap), VELOCITY)
        got = {p["quantity"]: p["value"] for p in o["predictions"]}
        for i, v in enumerate(answer):
            yield (
                f"Newton's cradle, gap {gap} m: ball {i + 1} [m/s]",
                VELOCITY,
                v,
                got[f"state s{i}.vx"],
                1e-8,
                why,
            )


def number(x: float) -> str:
    return str(x) if isinstance(x, int) else f"{x:.8g}"


def main() -> int:
    parser = say.Arguments(
        prog="scripts/answers", description="Known answers and what lcpbench gets, in one table."
    )
    parser.add_argument("--out", help="also write the table to this file")
    args = parser.parse_args()
    lines = [
        "| quantity | formulation, solver | theory | got | error | allowed | | why |",
        "|---|---|---|---|---|---|---|---|",
    ]
    count = [0, 0]
    print("\n".join(lines))
    for group in (pile, rocking, spin, belt, painleve, cradle):
        for what, way, theory, got, allowed, why in group():
            error = abs(got - theory)
            good = error <= allowed
            count[not good] += 1
            lines.append(
                f"| {what} | {way[0]}, {way[1]} | {number(theory)} | {number(got)} | {error:.2g} |"
                f" {allowed:.2g} | {'ok' if good else 'MISSED'} | {why} |"
            )
            print(lines[-1], flush=True)
    if args.out:
        pathlib.Path(args.out).write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"{count[0]} passed, {count[1]} failed")
    return 0 if count[1] == 0 else 1


if __name__ == "__main__":
    sys.exit(main())

"""distribution=compliant: redundant contacts share as springs of the compliances that the scene
gives. Judged by statics in closed form, by the limit of such springs as an equation of motion
(tests/cases/derive), and that limit by springs of finite stiffness, integrated here."""

import json
import math
import pathlib
import sys

from support import SANITIZED, TESTS, Skip, fewer, one_line_error, run_json, tap

sys.path.insert(0, str(TESTS / "cases" / "derive"))
from derive import SLIDERS, G, Vector, runge_kutta, sliding, solved  # noqa: E402

SCENES = TESTS / "cases" / "regressions" / "scenes"
LEGS = [1.0, 2.0, 4.0, 8.0]
MU = 0.4

# every formulation whose cone is round, or nearly so
ROUND = (
    ("event", "lemke"),
    ("coulomb", "cone_newton"),
    ("coulomb:storage=factored", "cone_newton"),
    ("regularized", "lemke"),
    ("regularized:form=contact", "interior_point"),
    ("velocity:facets=32", "lemke"),
    ("position:facets=32", "lemke"),
    ("acceleration:facets=32", "lemke"),
)
EVERY = (
    *ROUND,
    ("boxed", "ppm"),
    ("boxed:joints=mixed", "ppm"),
    ("velocity", "lemke"),
    ("normal", "lemke"),
)


def with_(formulation, option):
    return formulation + ("," if ":" in formulation else ":") + option


def feet4(compliance=None, floor=None):
    scene = json.loads((SCENES / "feet4.json").read_text(encoding="utf-8"))
    del scene["checks"]  # of equal springs
    for k, part in enumerate(scene["bodies"][0]["shape"]["parts"]):
        if compliance:
            part["compliance"] = compliance[k]
    if floor is not None:
        scene["static"][0]["compliance"] = floor
    return scene


def simulate(d, scene, formulation, solver, *words, **kw):
    path = pathlib.Path(d) / "scene.json"
    path.write_text(json.dumps(scene), encoding="utf-8")
    return run_json(
        "simulate", path, "--formulation", formulation, "--solver", solver, *words, **kw
    )


def spin_of(d, scene, formulation, solver, *words):
    o = simulate(d, scene, formulation, solver, *words, code=None)
    assert o["status"] == "ok" and o["n_share_missed"] == 0, (formulation, o["status"], o["note"])
    return o["observables"]["b0.omega.z"]["value"]


def motions_follow_the_springs(d):
    """Four feet of compliances 1, 2, 4, 8 on a rigid floor: 6 % less spin than on equal ones."""
    body = SLIDERS["feet4"]
    wanted = runge_kutta(sliding(body, LEGS), [0, 0, 0, *body.start], 0.3, 1000)[5]
    equal = runge_kutta(sliding(body), [0, 0, 0, *body.start], 0.3, 1000)[5]
    assert abs(wanted - equal) > 0.05 * equal
    scene = feet4(LEGS, 0)
    for formulation, solver in fewer(ROUND):
        chosen = with_(formulation, "distribution=compliant")
        spin = spin_of(d, scene, chosen, solver, "--step", 1.25e-3)
        near = 1e-6 if formulation == "event" else 5e-3
        assert abs(spin - wanted) < near * wanted, (chosen, spin, wanted)
        if formulation != "event":  # which has no order but its own
            shuffled = spin_of(d, scene, chosen, solver, "--contact-order", "random:3")
            assert abs(shuffled - spin_of(d, scene, chosen, solver)) < 1e-6, chosen
        spin = spin_of(d, scene, formulation, solver, "--step", 1.25e-3)
        assert abs(spin - equal) < 5e-3 * equal, (formulation, spin, equal)


def on_springs(stiffness, steps):
    """The spin at the end of feet4 on springs of stiffness k/c_i with dampers, all six motions,
    tilts small: the two moments about horizontal axes are equal and do not follow the turn."""
    body, tilt = SLIDERS["feet4"], 0.5

    def motion(s):
        _, _, angle, z, pitch, roll, vx, vy, spin, vz, wx, wy = s
        cos, sin = math.cos(angle), math.sin(angle)
        total = [0.0] * 6
        for (px, py), c in zip(body.points, LEGS, strict=True):
            x, y = cos * px - sin * py, sin * px + cos * py
            k = stiffness / c
            damper = 0.2 * math.sqrt(stiffness * body.mass) / c
            sink = -(z + pitch * y - roll * x)
            normal = k * sink - damper * (vz + wx * y - wy * x)
            slip = (vx - spin * y - wy * body.height, vy + spin * x + wx * body.height)
            speed = math.hypot(*slip)
            fx, fy = (-MU * normal * u / speed for u in slip)
            total[0] += fx
            total[1] += fy
            total[2] += x * fy - y * fx
            total[3] += normal
            total[4] += y * normal + body.height * fy
            total[5] += -x * normal - body.height * fx
        fx, fy, turn, up, mx, my = total
        m = body.mass
        rates = [fx / m, fy / m, turn / body.inertia, up / m - G, mx / tilt, my / tilt]
        return [vx, vy, spin, vz, wx, wy, *rates]

    # in balance at the start, but for the friction's moments, which the dampers take up
    arms = [(1 / c, x / c, y / c) for (x, y), c in zip(body.points, LEGS, strict=True)]
    rows = [
        [
            sum(a * w for a, w in zip(column, weights, strict=True))
            for column in zip(*arms, strict=True)
        ]
        for weights in zip(*[(1.0, x, y) for x, y in body.points], strict=True)
    ]
    a, b, c = (u / stiffness for u in solved(rows, [body.mass * G, 0, 0]))
    state: Vector = [0, 0, 0, -a, -c, b, *body.start, 0, 0, 0]
    return runge_kutta(motion, state, 0.3, steps)[8]


def springs_tend_to_the_limit(_):
    """Ever stiffer springs, integrated with all their oscillations, end where the equation of the
    limit does: the reference above leans on nothing but them."""
    if SANITIZED:
        raise Skip("runs nothing of the program")
    body = SLIDERS["feet4"]
    wanted = runge_kutta(sliding(body, LEGS), [0, 0, 0, *body.start], 0.3, 1000)[5]
    off = [abs(on_springs(k, n) - wanted) for k, n in ((3e4, 1500), (3e5, 4000), (3e6, 12000))]
    assert off[2] < 1e-3 * wanted and off[2] < off[1] / 2 and off[1] < off[0] / 2, (off, wanted)


def legs_share_a_load_beside_the_middle(d):
    """Four legs, bodies of their own on a plate, and a floor that gives way too: at rest leg i
    carries (a + b x + c y)/c_i, c_i = its compliance and the floor's in series."""
    feet = [(-0.4, -0.3), (-0.4, 0.3), (0.4, -0.3), (0.4, 0.3)]
    floor, r, plate, weight = 0.5, 0.05, 4.0, 30.0
    at = (0.1, -0.05)
    scene = {
        "id": "table",
        "dim": 3,
        "T": 0.1,
        "gravity": [0, 0, -G],
        "friction": {"default": 0.3},
        "bodies": [
            {
                "name": "plate",
                "shape": {"type": "box", "half": [0.5, 0.4, 0.02]},
                "mass": plate,
                "pos": [0, 0, 0.3],
            }
        ],
        "static": [{"name": "floor", "normal": [0, 0, 1], "compliance": floor}],
        "joints": [],
        "loads": [
            {
                "type": "constant_force",
                "body": "plate",
                "force": [0, 0, -weight],
                "torque": [-at[1] * weight, at[0] * weight, 0],
            }
        ],
        "no_collision": [],
        "checks": [],
    }
    own = 0.5
    legs = list(zip(feet, LEGS, strict=True))
    shape = [(1 / (c + floor), x / (c + floor), y / (c + floor)) for (x, y), c in legs]
    foot = [(1, *f) for f in feet]
    rows = [
        [sum(s[k] * w[row] for s, w in zip(shape, foot, strict=True)) for k in range(3)]
        for row in range(3)
    ]
    load = (plate + 4 * own) * G + weight
    plane = solved(rows, [load, weight * at[0], weight * at[1]])
    forces = [sum(p * u for p, u in zip(plane, s, strict=True)) for s in shape]
    assert min(forces) > 1 and max(forces) > 1.5 * min(forces), forces
    for k, ((x, y), c) in enumerate(legs):
        name = f"leg{k}"
        scene["bodies"].append(
            {
                "name": name,
                "shape": {"type": "sphere", "r": r},
                "mass": own,
                "pos": [x, y, r],
                "compliance": c,
            }
        )
        scene["joints"].append(
            {"type": "fixed", "body": name, "other": "plate", "anchor": [x, y, r]}
        )
        scene["no_collision"].append([name, "plate"])
        scene["checks"].append(
            {
                "type": "contact_force",
                "pair": [name, "floor"],
                "t0": 0.05,
                "value": forces[k],
                "tol": {"abs": 1e-6 * load},
            }
        )
    for formulation, solver in EVERY:
        chosen = with_(formulation, "distribution=compliant")
        o = simulate(d, scene, chosen, solver, code=None)
        got = [(p["value"], p["predicted"]) for p in o["predictions"]]
        assert o["status"] == "ok" and len(got) == 4 and all(p["ok"] for p in o["predictions"]), (
            chosen,
            o["status"],
            got,
        )
        o = simulate(d, scene, formulation, solver, code=None)  # equal springs carry otherwise
        assert not any(p["ok"] for p in o["predictions"]), (formulation, o["predictions"])


def of_one_compliance_is_least_norm(d):
    """Bit for bit: without a compliance in the scene, and with the same everywhere; and what a
    scene gives does not matter to least_norm."""
    for formulation, solver in fewer(EVERY):
        chosen = with_(formulation, "distribution=compliant")
        hashes = {
            simulate(d, scene, f, solver)["solution_hash"]
            for scene, f in (
                (feet4(), formulation),
                (feet4(), chosen),
                (feet4([3.0] * 4, 3.0), chosen),
                (feet4(LEGS, 0), formulation),
            )
        }
        assert len(hashes) == 1, (formulation, hashes)
        other = simulate(d, feet4(LEGS, 0), chosen, solver)["solution_hash"]
        assert other not in hashes, formulation


def a_heavy_body_is_shared(d):
    """1e8 kg on 1 kg: what is left of the limit goes down by a tenth a round, and is mixed."""
    scene = json.loads((SCENES / "heavy_on_light_1e8.json").read_text(encoding="utf-8"))
    o = simulate(d, scene, "normal", "lemke", "--step", 0.01)
    assert o["status"] == "ok" and o["verified"], o["note"]
    assert (o["n_shared"], o["n_share_missed"]) == (o["n_solves"], 0), o["n_share_missed"]


def a_nearly_right_start_is_mended_in_a_few_steps(_):
    """A pyramid at rest drifts to the solver's tolerance; each time one or two Newton steps mend
    it, whatever rounding the order of the contacts gives."""
    for order in ("given",) if SANITIZED else ("given", "random:1", "random:2", "random:3"):
        run = (
            "simulate",
            f"pyramid:base={6 if SANITIZED else 12}",
            "--step",
            0.01,
            "--start",
            "previous",
        )
        run += ("--formulation", "velocity", "--solver", "cone_newton")
        run += ("--contact-order", order, "--duration")
        first, o = run_json(*run, 0.01), run_json(*run, 0.4)
        assert o["status"] == "ok" and o["verified"], o["note"]
        assert o["n_fallback"] == 0, (order, o["n_fallback"])
        assert o["n_iter"] - first["n_iter"] <= o["steps"] // 4, (order, o["n_iter"])


def bad_compliances_are_named(d):
    path = pathlib.Path(d) / "scene.json"
    words = ("simulate", path, "--formulation", "velocity", "--solver", "lemke")
    for value in (0, -1, "soft"):
        path.write_text(json.dumps(feet4([value, 1, 1, 1])), encoding="utf-8")
        one_line_error(*words, names=["part 1", "compliance"])
        scene = feet4()
        scene["bodies"][0]["compliance"] = value
        path.write_text(json.dumps(scene), encoding="utf-8")
        one_line_error(*words, names=["b0", "compliance"])
    path.write_text(json.dumps(feet4(None, -1)), encoding="utf-8")
    one_line_error(*words, names=["floor", "compliance"])


tap(
    [
        motions_follow_the_springs,
        springs_tend_to_the_limit,
        legs_share_a_load_beside_the_middle,
        of_one_compliance_is_least_norm,
        a_heavy_body_is_shared,
        a_nearly_right_start_is_mended_in_a_few_steps,
        bad_compliances_are_named,
    ]
)

"""The variants of `regularized`: presets of its options, the readings of the paper (modes=once),
and the bristles of `boxed`, against recursions of one block written down here, which share nothing
with the code."""

import itertools
import json
import math
import pathlib

from random_mechanisms import random_mechanism

from support import one_line_error, run, run_json, tap

M, G, STATIC, KINETIC, K, C, H = 2.0, 9.81, 0.5, 0.3, 4e3, 60.0, 0.01
SIDE, DOWN, OMEGA, START, T = 14.0, 6.0, 9.0, 0.8, 2.0
READINGS = {
    "bound": ("current", "previous"),
    "integration": ("implicit", "explicit"),
    "bristle": ("saturated", "reset"),
}


def block(d, kinetic=KINETIC):
    """A point on the floor, pushed to and fro, and down by a force that changes too."""
    scene = {
        "id": "rub",
        "dim": 2,
        "T": T,
        "hs": [H],
        "gravity": [0, -G],
        "friction": {"default": STATIC},
        "friction_kinetic": {"default": kinetic},
        "bodies": [
            {"name": "b", "shape": {"type": "point"}, "mass": M, "pos": [0, 0], "vel": [START, 0]}
        ],
        "static": [{"name": "floor", "normal": [0, 1]}],
        "loads": [
            {"type": "force_sine", "body": "b", "dir": [1, 0], "amplitude": SIDE, "omega": OMEGA},
            {"type": "force_sine", "body": "b", "dir": [0, -1], "amplitude": DOWN, "omega": 5.0},
        ],
        "observe": ["b.x", "b.vx"],
    }
    path = pathlib.Path(d) / "rub.json"
    path.write_text(json.dumps(scene), encoding="utf-8")
    return path


def recursion(bound, integration, bristle):
    """x, v at T and how often the block changed between holding and sliding."""
    g = H * H * K + H * C
    x, v, s, sliding, changes = 0.0, START, 0.0, False, 0
    last = H * M * G
    for n in range(round(T / H)):
        t = n * H
        normal = H * (M * G + DOWN * math.sin(5.0 * t))
        free = v + H * SIDE * math.sin(OMEGA * t) / M
        trial = H * K * s + (g if integration == "implicit" else H * C) * v
        slides = abs(trial) > (KINETIC if sliding else STATIC) * last
        if slides:
            friction = -math.copysign(KINETIC * (normal if bound == "current" else last), trial)
            v = free + friction / M
            s = 0.0 if bristle == "reset" else (-friction + C * s) / (H * K + C)
        else:
            if integration == "implicit":
                v = (M * free - H * K * s) / (M + g)
            else:
                v = free - trial / M
            s += H * v
        changes += slides != sliding
        sliding, last = slides, normal
        x += H * v
    return x, v, changes


def simulate(scene, formulation, *words):
    return run_json("simulate", scene, "--formulation", formulation, "--solver", "lemke", *words)


def readings_are_those_of_one_block(d):
    scene, ends = block(d), set()
    for words in itertools.product(*READINGS.values()):
        chosen = ",".join(f"{o}={w}" for o, w in zip(READINGS, words, strict=True))
        x, v, changes = recursion(*words)
        assert changes >= 6, (chosen, changes)  # it holds and slides by turns
        for start in ("cold", "previous"):
            o = simulate(scene, f"regularized:paper,k={K},c={C},{chosen}", "--start", start)
            got = [o["observables"][q]["value"] for q in ("b.x", "b.vx")]
            assert abs(got[0] - x) < 1e-9 and abs(got[1] - v) < 1e-9, (chosen, got, (x, v))
            assert o["n_solves"] == o["steps"], chosen
        ends.add(round(x, 6))
    assert len(ends) == 8, ends  # every reading is a motion of its own


def law_of_one_block(k, c):
    """x, v, deflection at T of the bristle's law, solved for in each step; one coefficient."""
    g = H * H * k + H * c
    x, v, s, slid = 0.0, START, 0.0, 0
    for n in range(round(T / H)):
        t = n * H
        bound = STATIC * H * (M * G + DOWN * math.sin(5.0 * t))
        free = v + H * SIDE * math.sin(OMEGA * t) / M
        v = (M * free - H * k * s) / (M + g)
        friction = -(H * k * s + g * v)
        if abs(friction) > bound:
            friction = math.copysign(bound, friction)
            v = free + friction / M
            slid += 1
        s = (c * s - friction) / (H * k + c)
        x += H * v
    assert 20 < slid < T / H - 20
    return x, v


def bristles_are_those_of_one_block(d):
    """boxed:bristle and regularized of the same stiffness, spring and damper alone too."""
    scene = block(d, STATIC)
    for k, c in ((K, C), (K, 0.0), (0.0, C), (1e6, 1e3)):
        x, v = law_of_one_block(k, c)
        box = f"boxed:bristle={k},damper={c}"
        law = f"regularized:stiffness=fixed,k={k},c={c}" + ("" if k > 0 else ",model=viscous")
        for formulation, solver in (
            (box, "ppm"),
            (box + ",storage=csc", "ppm"),
            (box + ",storage=factored", "ppm"),
            (law, "lemke"),
        ):
            o = run_json("simulate", scene, "--formulation", formulation, "--solver", solver)
            got = [o["observables"][q]["value"] for q in ("b.x", "b.vx")]
            assert abs(got[0] - x) < 1e-7 and abs(got[1] - v) < 1e-7, (formulation, got, (x, v))


def ball(d, name, speed, spin):
    """It rolls along x or spins on its place, against rolling and torsional resistance."""
    scene = {
        "id": "ball",
        "dim": 3,
        "T": 0.3,
        "gravity": [0, 0, -G],
        "friction": {"default": 0.4},
        "rolling": {"default": 0.002},
        "torsion": {"default": 0.005},
        "bodies": [
            {
                "name": "b",
                "shape": {"type": "sphere", "r": 0.1},
                "mass": 1.5,
                "pos": [0, 0, 0.1],
                "vel": [speed, 0, 0],
                "omega": [0, speed / 0.1, spin],
            }
        ],
        "static": [{"name": "floor", "normal": [0, 0, 1]}],
        "observe": ["b.x", "b.omega.y", "b.omega.z"],
    }
    path = pathlib.Path(d) / f"{name}.json"
    path.write_text(json.dumps(scene), encoding="utf-8")
    return path


def boxed_bristles_are_regularized_springs(d):
    """Scenes with many contacts, turning bodies, impacts, rolling and torsion: the same motion
    where each box has one direction, or nothing slides."""
    compared = 0
    for scene in (
        "slide",
        "incline",
        "push",
        "creep",
        "stack:n=3",
        "walking_foot",
        "impact",
        "capstan",
        "conveyor",
        "roll",
        ball(d, "rolls", 0.3, 0),
        ball(d, "spins", 0, 2),
        "wedge",
        "rocking",
    ):
        ends = []
        for formulation, solver in (
            (
                "boxed:bristle=1e5,damper=300",
                "newton" if isinstance(scene, pathlib.Path) else "ppm",
            ),
            ("regularized:stiffness=fixed,k=1e5,c=300", "lemke"),
        ):
            words = ("simulate", scene, "--duration", 0.3, "--formulation", formulation)
            o = json.loads(run(*words, "--solver", solver, code=None).stdout)
            assert o["status"] == "ok", (scene, formulation, o["status"])
            ends.append(o)
        box, law = ends
        for q, value in law["observables"].items():
            other = box["observables"][q]["value"]
            assert abs(other - value["value"]) < 1e-8 * max(1, abs(other)), (scene, q, other, value)
            compared += 1
        for key in ("stiffness_ratio_min", "deflection_max_m"):
            told = (box[key] or 0, law[key] or 0)  # null where no friction is
            assert abs(told[0] - told[1]) <= 1e-6 * told[1], (scene, key, told)
    assert compared > 20


def without_a_bristle_nothing_gives_way(_):
    rigid, zero = (
        run_json("simulate", "incline", "--formulation", f, "--solver", "ppm")
        for f in ("boxed", "boxed:bristle=0")
    )
    assert rigid["solution_hash"] == zero["solution_hash"] and rigid["deflection_max_m"] == 0
    assert rigid["stiffness_ratio_min"] is None


def a_variant_is_a_choice_of_options(_):
    for word, options in (
        ("newton", "prox=0.0001"),
        ("plain", "modes=plain,prox=0"),
        ("lugre", "model=lugre"),
        ("paper", "stiffness=fixed,modes=once,prox=0"),
    ):
        runs = [
            simulate("push", f"regularized:{text}", "--duration", 0.2)
            for text in (word, f"variant={word}", options)
        ]
        assert len({o["solution_hash"] for o in runs}) == 1, word
        for o, name in zip(runs, (word, word, "newton"), strict=True):
            assert f"variant={name}," in o["formulation_options"], (word, o["formulation_options"])
    assert (
        simulate("push", "regularized")["solution_hash"]
        == simulate("push", "regularized:newton")["solution_hash"]
    )


def what_follows_overrides_it(_):
    o = simulate("incline", "regularized:paper,k=1234,bias=position", "--duration", 0.05)
    for text in ("variant=paper", "k=1234", "bias=position", "modes=once", "stiffness=fixed"):
        assert text in o["formulation_options"].split(","), text
    again = simulate("incline", "regularized:" + o["formulation_options"], "--duration", 0.05)
    assert again["formulation_options"] == o["formulation_options"]
    assert again["solution_hash"] == o["solution_hash"]


def a_slip_that_turns_round_sticks_or_goes_in_circles(d):
    """A block that friction stops in its sixth step. Solved with the slip of the step before, it
    comes out moving back by half of the friction's impulse; slipping that way, forward again by
    three halves; for ever, because its bristles hold less only within a hundredth of rest."""
    scene = json.loads(block(d, STATIC).read_text(encoding="utf-8"))
    scene |= {"loads": [], "T": 10 * H}
    scene["bodies"][0]["vel"] = [5.5 * STATIC * G * H, 0]
    path = pathlib.Path(d) / "stops.json"
    path.write_text(json.dumps(scene), encoding="utf-8")
    words = ("--solver", "lemke", "--start", "previous")
    law = run_json("simulate", path, "--formulation", "regularized", *words)
    for text in ("regularized:plain", "regularized:plain,turned=sticks"):
        o = run_json("simulate", path, "--formulation", text, *words)
        for q, want in law["observables"].items():
            assert abs(o["observables"][q]["value"] - want["value"]) < 1e-12, (text, q)
        assert o["n_solves"] <= 14, (text, o["n_solves"])
    o = run_json(
        "simulate", path, "--formulation", "regularized:plain,turned=slips", *words, code=3
    )
    assert o["status"] == "stalled", o["status"]
    assert o["note"].startswith("step 6: the formulation's own loop goes in circles of 2 solves")
    assert o["n_solves"] < 40, o["n_solves"]


def a_loop_that_goes_in_circles_ends(d):
    """In space the direction of a slip lags behind, and may swing past where it should settle. A
    circle is a state that comes back bit for bit, which is found long before 1000 solves."""
    path = pathlib.Path(d) / "mechanism.json"
    path.write_text(json.dumps(random_mechanism(390) | {"T": 0.05, "hs": [0.005]}))
    words = ("--formulation", "regularized:plain", "--solver", "lemke")
    o = run_json("simulate", path, *words, code=3)
    assert o["status"] == "stalled" and "step 2: " in o["note"], o["note"]
    assert "goes in circles of " in o["note"] and o["n_solves"] < 1000, (o["note"], o["n_solves"])
    o = run_json("simulate", path, "--formulation", "regularized", "--solver", "lemke")
    assert o["status"] == "ok", "the step has an answer, which plain does not find"
    o = run_json("simulate", "slide", *words, "--step", 0.0025)
    assert o["status"] == "ok" and o["n_solves"] < 1.1 * o["steps"], (o["note"], o["n_solves"])


def joints_and_stacks_are_solved_once_a_step(_):
    for scene in ("stack:n=3", "plank", "ladder"):
        o = json.loads(
            run(
                *("simulate", scene, "--formulation", "regularized:paper", "--solver", "lemke"),
                code=None,
            ).stdout
        )
        assert o["status"] == "ok" and o["n_solves"] == o["steps"], (scene, o["status"])


def nonsense_is_refused(_):
    for text, names in (
        ("regularized:k=1e5,paper", ["variant=paper", "first"]),
        ("regularized:paper,plain", ["variant=plain", "first"]),
        ("regularized:papper", ["papper"]),
        ("regularized:variant=papper", ["papper", "paper"]),
        ("regularized:bound=previous", ["bound", "modes=once"]),
        ("regularized:plain,bristle=reset", ["bristle", "modes=once"]),
        ("regularized:turned=slips", ["turned", "modes=plain"]),
        ("regularized:paper,turned=slips", ["turned", "modes=plain"]),
        ("regularized:paper,model=lugre", ["modes=once"]),
        ("regularized:paper,form=mass", ["modes=once", "form=contact"]),
        ("velocity:paper", ["paper", "name=value"]),
    ):
        one_line_error(
            "simulate", "incline", "--formulation", text, "--solver", "lemke", names=names
        )


tap(
    [
        readings_are_those_of_one_block,
        bristles_are_those_of_one_block,
        boxed_bristles_are_regularized_springs,
        without_a_bristle_nothing_gives_way,
        a_variant_is_a_choice_of_options,
        what_follows_overrides_it,
        a_slip_that_turns_round_sticks_or_goes_in_circles,
        a_loop_that_goes_in_circles_ends,
        joints_and_stacks_are_solved_once_a_step,
        nonsense_is_refused,
    ]
)

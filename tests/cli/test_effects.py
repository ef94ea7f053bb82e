"""Effects that come in when the run calls for them: what stays out, and that the answer stays."""

import json
import pathlib
import random
import shlex
import sys

from support import fewer, one_line_error, run_json, tap

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from late_scenes import late_scene, strewn_scene  # noqa: E402

RUN = ("--formulation", "velocity", "--solver", "lemke")


def simulate(scene, effects, more=(), **kw):
    return run_json("simulate", scene, *RUN, "--effects", effects, *more, **kw)


def a_straight_slide_needs_neither_rotation_nor_space(_):
    whole, auto = simulate("slide", "declared"), simulate("slide", "auto:1e-6")
    assert auto["effects_auto"]["dropped"] == "rotation gyroscopic spatial", auto["effects_auto"]
    assert (whole["n_dof"], auto["n_dof"]) == (6, 2) and auto["lcp_dim_max"] < whole["lcp_dim_max"]
    assert len(auto["predictions"]) == len(whole["predictions"]) > 0 and all(
        p["ok"] for p in auto["predictions"]
    )
    error = [next(p["error"] for p in r["predictions"]) for r in (whole, auto)]
    assert abs(error[0] - error[1]) < 1e-6, error


BOUNCES_OFF = "-friction,+sleep/45:declared/49:-friction"


def landing(d):
    """A box at rest, onto which a disc falls from one metre above it, with 1 m/s along it."""
    box = {"name": "a", "shape": {"type": "box", "half": [1, 0.1]}, "mass": 1.0, "pos": [0, 0.1]}
    disc = {"name": "b", "shape": {"type": "disc", "r": 0.1}, "mass": 1.0, "pos": [0, 1.3]}
    floor = {"name": "floor", "normal": [0, 1], "offset": 0}
    scene = {"id": "landing", "dim": 2, "T": 0.8, "hs": [0.01], "gravity": [0, -9.81]}
    scene |= {"static": [floor], "bodies": [box, disc | {"vel": [1, 0]}], "observe": ["b.x"]}
    scene |= {"friction": {"default": 0.3}, "restitution": {"default": 0.5}}
    path = d / "landing.json"
    path.write_text(json.dumps(scene))
    return path


def what_matters_comes_in(d):
    """Friction at the first step, taken once where that is foreseen; and with what lands, until it
    has bounced off."""
    auto = simulate("spin", "auto:1e-6")
    assert (
        auto["effects_auto"]["dropped"] == ""
        and auto["effects_simulated"] == auto["effects_declared"]
    ), auto["effects_auto"]
    late = simulate(landing(d), "auto:1e-6")["effects_auto"]
    assert late["repeat"] == BOUNCES_OFF and late["steps_repeated"] == 1, late
    for scene in ("slide", "tip", "pit", "tablecloth"):
        foreseen = simulate(scene, "auto:1e-6")["effects_auto"]
        assert foreseen["steps_repeated"] == 0, (scene, foreseen)


def nothing_is_watched_before_contacts_touch(d):
    """What falls has no rows to save: all is in until it lies. Restitution has none at all."""
    for scene in ("bounce", "cradle", "impact"):
        auto = simulate(scene, "auto:1e-6")["effects_auto"]
        assert auto["repeat"] == "declared" and auto["steps_repeated"] == 0, (scene, auto)
    box = {"name": "a", "shape": {"type": "box", "half": [0.1] * 3}, "mass": 1, "pos": [0, 0, 0.2]}
    floor = {"name": "floor", "normal": [0, 0, 1], "offset": 0}
    scene = {"id": "falls", "dim": 3, "T": 1, "hs": [0.01], "gravity": [0, 0, -9.81]}
    scene |= {"static": [floor], "bodies": [box], "friction": {"default": 0.5}}
    (d / "falls.json").write_text(json.dumps(scene | {"observe": ["a.z"]}))
    whole, auto = (simulate(d / "falls.json", e) for e in ("declared", "auto:1e-6"))
    plan = auto["effects_auto"]["repeat"].split("/")
    assert plan[0] == "+sleep" and plan[1].endswith(":-friction,-rotation,-spatial")
    assert 10 < int(plan[1].split(":")[0]) < 25 and len(plan) == 2, plan
    a, b = (o["observables"]["a.z"]["value"] for o in (whole, auto))
    assert abs(a - b) < 1e-7 and auto["lcp_dim_max"] == whole["lcp_dim_max"], (a, b)


def a_velocity_at_the_start_keeps_its_effect(_):
    auto = simulate("top", "auto:1e-2", code=None)["effects_auto"]
    assert auto["dropped"] == "" and auto["steps_repeated"] == 0, auto


def the_run_can_be_repeated_without_auto(d):
    """Bit for bit, by what the result says under `repeat`, files included."""
    for scene in (landing(d), "bounce", "slide", "stack:n=3", "spin", "clatter", "push"):
        for form, solver in (("velocity", "lemke"), ("regularized", "lemke"), ("coulomb", "nsgs")):
            run = ("simulate", scene, "--formulation", form, "--solver", solver)
            auto = run_json(*run, "--effects", "auto:1e-4", code=None)
            again = run_json(*run, "--effects", auto["effects_auto"]["repeat"], code=None)
            assert auto["solution_hash"] == again["solution_hash"], (scene, form, auto)
            assert auto["effects_simulated"] == again["effects_simulated"], (scene, form)
    paths = [d / "auto.csv", d / "plan.csv"]
    for path, effects in zip(paths, ("auto:1e-4", BOUNCES_OFF), strict=True):
        simulate(landing(d), effects, more=("--trajectory", path))
    assert paths[0].read_bytes() == paths[1].read_bytes()


def stopping(d, push=0.0):
    """A box slides for 0.2 s and lies still until a ball lands on its edge, aslant; pushed by a
    force below friction all the time."""
    box = {"name": "a", "shape": {"type": "box", "half": [0.2, 0.2, 0.1]}, "mass": 1}
    box |= {"pos": [0, 0, 0.1], "vel": [0.981, 0, 0]}
    ball = {"name": "b", "shape": {"type": "sphere", "r": 0.05}, "mass": 0.2}
    ball |= {"pos": [0.1, 0.3, 0.25 + 0.5 * 9.81 * 0.6**2], "vel": [0, -0.2, 0]}
    floor = {"name": "floor", "normal": [0, 0, 1], "offset": 0}
    scene = {"id": "stopping", "dim": 3, "T": 0.8, "hs": [0.01], "gravity": [0, 0, -9.81]}
    scene |= {"static": [floor], "bodies": [box, ball], "friction": {"default": 0.5}}
    if push > 0:
        scene["loads"] = [{"body": "a", "type": "constant_force", "force": [push, 0, 0]}]
    path = d / f"stopping_{push}.json"
    path.write_text(json.dumps(scene | {"observe": ["a.x", "a.y", "b.x", "b.z"]}))
    return path


def what_came_in_leaves_at_rest(d):
    """Friction stops the box and goes; it comes in again with what lands, and stays while the box
    is pushed."""
    for form, solver in (("velocity", "lemke"), ("coulomb", "cone_newton")):
        for push in (0.0, 1.0):
            run = ("simulate", stopping(d, push), "--formulation", form, "--solver", solver)
            whole = run_json(*run, "--effects", "declared")
            auto = run_json(*run, "--effects", "auto:1e-6")
            told = auto["effects_auto"]
            spans = [s.split(":") for s in f"0:{told['repeat']}".split("/")]
            friction = [(int(k), "-friction" not in text) for k, text in spans]
            out = [k for k, simulated in friction if not simulated and k < 55]
            again = [k for k, simulated in friction if simulated and k > 55]
            assert friction[0][1] and (again or push > 0), told
            assert (out == []) == (push > 0) and all(20 < k < 30 for k in out), told
            assert all(k < 65 for k in again) and told["steps_repeated"] < 6, told
            assert push == 0 or all(simulated for _, simulated in friction), told
            again = run_json(*run, "--effects", told["repeat"])
            assert again["solution_hash"] == auto["solution_hash"], told
            for name, a in whole["observables"].items():
                b = auto["observables"][name]["value"]
                assert abs(a["value"] - b) <= 1e-6 * max(abs(a["value"]), 1.0), (name, a, b)


def resisting(d, name, speed=0.0, push=0.0):
    """A box with resistance to rolling and torsion: at rest, pushed, or sliding until it lies."""
    box = {"name": "a", "shape": {"type": "box", "half": [0.2, 0.15, 0.1]}, "mass": 1}
    box |= {"pos": [0, 0, 0.1], "vel": [speed, 0, 0]}
    floor = {"name": "floor", "normal": [0, 0, 1], "offset": 0}
    scene = {"id": name, "dim": 3, "T": 1, "hs": [0.01], "gravity": [0, 0, -9.81]}
    scene |= {"static": [floor], "bodies": [box], "friction": {"default": 0.4}}
    scene |= {"rolling": {"default": 0.002}, "torsion": {"default": 0.002}}
    if push > 0:
        scene["loads"] = [{"body": "a", "type": "constant_force", "force": [push, 0, 0]}]
    path = d / f"{name}.json"
    path.write_text(json.dumps(scene | {"observe": ["a.x", "a.y", "a.z"]}))
    return path


def what_does_not_turn_is_not_resisted(d):
    """What rests has no rolling and no torsion, and nothing at all where nothing pushes it. What
    slides has them until it lies, though something left out is off by rounding."""
    for form, solver in (("velocity", "lemke"), ("coulomb", "cone_newton")):
        run = ("--formulation", form, "--solver", solver, "--effects")
        for name, push in (("rests", 0.0), ("pushed", 1.5)):
            told = run_json("simulate", resisting(d, name, push=push), *run, "auto:1e-6")
            told = told["effects_auto"]
            out = "" if push > 0 else "friction "
            assert told["dropped"] == f"{out}rolling torsion rotation gyroscopic spatial", told
            assert told["steps_repeated"] == 0, told
        path = resisting(d, "slides", speed=1.0)
        whole, auto = (run_json("simulate", path, *run, e) for e in ("declared", "auto:1e-6"))
        last = auto["effects_auto"]["repeat"].split("/")[-1]
        assert all(f"-{e}" in last for e in ("rolling", "torsion", "friction")), last
        for name, a in whole["observables"].items():
            off = abs(a["value"] - auto["observables"][name]["value"])
            assert off <= 1e-6 * 0.3, (name, off)


def late(d, k, shape="sphere"):
    """The k-th of the random scenes, in which a box slides on ice and hits a ball, or another box
    lands on it."""
    rng = random.Random(7)
    scene = [late_scene(rng) for _ in range(k + 1)][-1]
    assert scene["bodies"][1]["shape"]["type"] == shape
    path = d / f"late{k}.json"
    path.write_text(json.dumps(scene))
    return path


def within(path, E):
    """What is told of a run, whose end is off by E at most, and the effects simulated in it."""
    whole, auto = (simulate(path, e) for e in ("declared", f"auto:{E:g}"))
    told = auto["effects_auto"]
    again = simulate(path, told["repeat"])
    assert again["solution_hash"] == auto["solution_hash"], told
    for name, scale in (("a.x", told["size_m"]), ("a.vx", told["speed_m_s"])):
        a, b = (o["observables"][name]["value"] for o in (whole, auto))
        assert abs(a - b) <= E * scale, (name, told)
    return told, told["repeat"].split("/")


def what_an_impact_called_in_leaves_behind_it(d):
    """Friction is in up to where the box, hit low, rocks on feet that open by less than what it may
    be off by, and goes when both slide on."""
    told, spans = within(late(d, 46), 1e-2)
    assert ["-friction" in s for s in spans] == [False] * (len(spans) - 1) + [True], told
    assert 5 < int(spans[-1].split(":")[0]) < 30, told


def what_an_impact_takes_alone_leaves_while_bodies_tip(d):
    """A box lands on the edge of another and tips over: friction in the impact would use up E, and
    what it does from there on, with all that grows of it, is foreseen to be a third of E."""
    told, spans = within(late(d, 11, "box"), 1e-2)
    assert ["-friction" in s for s in spans] == [True, False, True], told
    assert int(spans[2].split(":")[0]) - int(spans[1].split(":")[0]) < 5, told
    assert told["steps_repeated"] == 1 and 1e-3 < told["bound"] < 1e-2, told


def what_spins_on_its_floor_needs_friction(d):
    """The feet of a box hold no moment about the normal of its floor. By the same friction one that
    slides is off by less than E, and one that spins by more."""
    floor = {"name": "floor", "normal": [0, 0, 1], "offset": 0}
    scene = {"id": "spins", "dim": 3, "T": 1.0, "hs": [0.01], "gravity": [0, 0, -9.81]}
    scene |= {"static": [floor], "friction": {"default": 6.7e-4}, "observe": ["a.omega.z"]}
    dropped, turned = [], []
    for spin in (0.0, 1.5):
        box = {"name": "a", "shape": {"type": "box", "half": [0.35, 0.3, 0.1]}, "mass": 1}
        box |= {"pos": [0, 0, 0.1], "vel": [1.0 - 0.6 * spin, 0, 0], "omega": [0, 0, spin]}
        path = d / f"spins_{spin}.json"
        path.write_text(json.dumps(scene | {"bodies": [box]}))
        ends = [simulate(path, e)["observables"] for e in ("declared", "-friction")]
        turned.append(0.5 * abs(ends[0]["a.omega.z"]["value"] - ends[1]["a.omega.z"]["value"]))
        dropped.append("friction" in simulate(path, "auto:1e-2")["effects_auto"]["dropped"])
    assert turned[0] < 1e-6 and turned[1] > 1e-2, turned
    assert dropped == [True, False], dropped


def load_may_be_taken_off_a_face(d):
    """Two boxes slide face to face, the one in front on the rougher floor: how much of its load the
    other takes by its face is not told without what turns them, or holds them in the plane."""
    cube = {"shape": {"type": "box", "half": [0.1] * 3}, "mass": 1, "vel": [2, 0, 0]}
    scene = {"id": "pair", "dim": 3, "T": 0.3, "hs": [0.01], "gravity": [0, 0, -9.81]}
    scene["static"] = [{"name": "floor", "normal": [0, 0, 1], "offset": 0}]
    scene["bodies"] = [cube | {"name": n, "pos": [x, 0, 0.1]} for n, x in (("a", 0), ("b", 0.2))]
    scene["observe"] = ["a.vx"]
    path = d / "pair.json"
    for rough, kept in ((0.5, True), (0.1, False)):
        scene["friction"] = {"default": 0.1, "pairs": [["b", "floor", rough]]}
        path.write_text(json.dumps(scene))
        whole, auto = simulate(path, "declared"), simulate(path, "auto:1e-4")
        assert (auto["effects_auto"]["dropped"] == "") == kept, (rough, auto["effects_auto"])
        ends = [r["observables"]["a.vx"]["value"] for r in (whole, auto)]
        assert abs(ends[0] - ends[1]) < 1e-4, (rough, ends)


def a_deviation_passes_over_an_impact(d):
    """Every contact is hit, stays or opens by more than what friction can have done before: only
    rotation comes in, in the step of the impact, and nothing before it is done again."""
    told, spans = within(late(d, 26), 1e-4)
    assert all("-friction" in s for s in spans) and len(spans) == 2, told
    assert "-rotation" in spans[0] and "-rotation" not in spans[1], told
    assert told["steps_repeated"] == 1 and 1e-6 < told["bound"] <= 1e-4, told
    told, spans = within(late(d, 26), 1e-6)  # the bound of what goes on is above that
    assert any("-friction" not in s for s in spans), told


def nothing_given_is_lost_on_the_way(_):
    """Where the program chooses everything, `repeat` is a whole command."""
    words = ("--error", "2%", "--effects", "auto:1e-4", "--duration", "0.4", "--start", "previous")
    auto = run_json("simulate", "slide", *words)
    command = shlex.split(auto["choice"]["repeat"])
    assert command[:2] == ["lcpbench", "simulate"] and not any("auto" in c for c in command)
    assert run_json(*command[1:])["solution_hash"] == auto["solution_hash"], command


def effects_change_in_the_run(d):
    """Bodies go on from where they are: what slid freely for ten steps rubs for forty."""
    h, v, mu, g = 0.01, 2.0, 0.3, 9.81
    box = {"type": "box", "half": [0.1, 0.1]}
    body = {"name": "a", "shape": box, "mass": 1.0, "pos": [0.0, 0.1], "vel": [v, 0.0]}
    floor = {"name": "floor", "normal": [0, 1], "offset": 0}
    scene = {"id": "block", "dim": 2, "T": 50 * h, "hs": [h], "gravity": [0, -g]}
    scene |= {"static": [floor], "bodies": [body], "friction": {"default": mu}, "observe": ["a.vx"]}
    (d / "block.json").write_text(json.dumps(scene))
    for effects, steps in (("declared", 50), ("-friction/10:declared", 40), ("-friction", 0)):
        speed = simulate(d / "block.json", effects)["observables"]["a.vx"]["value"]
        assert abs(speed - (v - mu * g * h * steps)) < 1e-9, (effects, speed)


def the_budget_is_kept_where_things_happen_late(d):
    """The change against the full run stays within E, in every scene, whatever comes."""
    rng, path, dropped = random.Random(7), d / "late.json", 0
    makers = [late_scene, late_scene, strewn_scene] * 30
    for case, made in enumerate(fewer(makers)):
        path.write_text(json.dumps(made(rng)))
        E = rng.choice([1e-2, 1e-4, 1e-6])
        full, auto = (simulate(path, e, code=None) for e in ("declared", f"auto:{E:g}"))
        for name, a in full["observables"].items():
            b = auto["observables"][name]["value"]
            assert abs(a["value"] - b) <= E * max(abs(a["value"]), 1.0), (case, name, a, b)
        dropped += auto["effects_auto"]["dropped"] != ""
    assert 4 * dropped > len(fewer(makers)), (
        dropped
    )  # and something is left out where nothing happens


def what_is_small_in_a_step_adds_up(d):
    """mu g h is 1e-10 m/s a step, and 12 micrometres in the 50 s of the run: more than E."""
    box = {"type": "box", "half": [0.1, 0.1]}
    body = {"name": "a", "shape": box, "mass": 1.0, "pos": [0, 0.1], "vel": [2, 0]}
    floor = {"name": "floor", "normal": [0, 1], "offset": 0}
    scene = {"id": "ice", "dim": 2, "T": 50, "hs": [0.01], "gravity": [0, -9.81]}
    scene |= {"static": [floor], "bodies": [body], "friction": {"default": 1e-9}}
    (d / "ice.json").write_text(json.dumps(scene | {"observe": ["a.x"]}))
    full, auto = (
        simulate(d / "ice.json", e)["observables"]["a.x"]["value"]
        for e in ("declared", "auto:1e-6")
    )
    assert abs(full - (100 - 0.5 * 1e-9 * 9.81 * 2500)) < 1e-7, full
    assert abs(full - auto) <= 1e-6 * 0.14, (full, auto)


def a_wrong_plan_is_named(_):
    for text, culprit in (
        ("-friction/5", "'5'"),
        ("-friction/0:declared", "above 0"),
        ("declared/7:-friction/7:declared", "above 7"),
        ("-friction/9:-frictoin", "frictoin"),
    ):
        one_line_error("simulate", "slide", *RUN, "--effects", text, names=[culprit])
    words = ("--effects", "-friction/9:declared", "--error", "1%")
    one_line_error("simulate", "slide", *RUN, *words, names=["--error"])


def loads_that_grow_are_not_judged_by_their_beginning(_):
    auto = simulate("push", "auto:1e-3")
    assert "loads" in auto["effects_simulated"] and all(p["ok"] for p in auto["predictions"]), auto[
        "effects_auto"
    ]


def the_level_decides(_):
    strict, loose = (
        simulate("roll:speed=2", "auto:1e-9"),
        simulate("roll:speed=2", "auto:1e9", code=None),
    )
    assert (
        "friction" not in strict["effects_auto"]["dropped"]
        and "friction" in loose["effects_auto"]["dropped"]
    )


def everything_on_is_judged_and_less_is_not(_):
    declared, everything, without = (
        simulate("slide", e, code=None) for e in ("declared", "all", "-friction")
    )
    assert [p["ok"] for p in everything["predictions"]] == [
        p["ok"] for p in declared["predictions"]
    ]
    assert without["predictions"] == []


def bad_levels_are_named(_):
    for text in ("auto", "auto:", "auto:0", "auto:-1", "auto:x"):
        one_line_error("simulate", "slide", *RUN, "--effects", text, names=["auto"])


def stiffness_stands_beside_the_result(d):
    """G/m_t of the run, where friction is regularised; nothing where it is not."""
    o = run_json(
        "simulate", "stack:n=2", "--formulation", "regularized:ratio=50", "--solver", "lemke"
    )
    assert abs(o["stiffness_ratio_min"] - 50) < 1e-6 and o["deflection_max_m"] > 0, o[
        "stiffness_ratio_min"
    ]
    o = run_json("simulate", "stack:n=2", "--formulation", "velocity", "--solver", "lemke")
    assert o["stiffness_ratio_min"] is None and o["deflection_max_m"] == 0


tap(
    [
        a_straight_slide_needs_neither_rotation_nor_space,
        what_matters_comes_in,
        nothing_is_watched_before_contacts_touch,
        a_velocity_at_the_start_keeps_its_effect,
        the_run_can_be_repeated_without_auto,
        what_came_in_leaves_at_rest,
        what_does_not_turn_is_not_resisted,
        what_an_impact_called_in_leaves_behind_it,
        what_an_impact_takes_alone_leaves_while_bodies_tip,
        what_spins_on_its_floor_needs_friction,
        load_may_be_taken_off_a_face,
        a_deviation_passes_over_an_impact,
        nothing_given_is_lost_on_the_way,
        effects_change_in_the_run,
        what_is_small_in_a_step_adds_up,
        a_wrong_plan_is_named,
        the_budget_is_kept_where_things_happen_late,
        loads_that_grow_are_not_judged_by_their_beginning,
        the_level_decides,
        everything_on_is_judged_and_less_is_not,
        bad_levels_are_named,
        stiffness_stands_beside_the_result,
    ]
)

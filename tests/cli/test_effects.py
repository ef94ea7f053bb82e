"""Effects chosen by a pilot: what it drops, what it keeps, and that the answer stays."""

from support import one_line_error, run_json, tap

RUN = ("--formulation", "velocity", "--solver", "lemke")


def simulate(scene, effects, **kw):
    return run_json("simulate", scene, *RUN, "--effects", effects, **kw)


def a_straight_slide_needs_neither_rotation_nor_space(_):
    whole, auto = simulate("slide", "declared"), simulate("slide", "auto:1e-6")
    assert auto["effects_auto"]["dropped"] == "rotation spatial", auto["effects_auto"]
    assert (whole["n_dof"], auto["n_dof"]) == (6, 2) and auto["lcp_dim_max"] < whole["lcp_dim_max"]
    assert len(auto["predictions"]) == len(whole["predictions"]) > 0 and all(
        p["ok"] for p in auto["predictions"]
    )
    error = [next(p["error"] for p in r["predictions"]) for r in (whole, auto)]
    assert abs(error[0] - error[1]) < 1e-6, error


def what_matters_stays(_):
    auto = simulate("spin", "auto:1e-6")
    assert (
        auto["effects_auto"]["dropped"] == ""
        and auto["effects_simulated"] == auto["effects_declared"]
    ), auto["effects_auto"]


def what_the_pilot_did_not_show_stays(_):
    auto = simulate("bounce", "auto:1e-6")["effects_auto"]
    assert (
        "contact" not in auto["why"]
        and "kept restitution (unseen)" in auto["why"]
        and auto["dropped"] == ""
    ), auto


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
        what_matters_stays,
        what_the_pilot_did_not_show_stays,
        loads_that_grow_are_not_judged_by_their_beginning,
        the_level_decides,
        everything_on_is_judged_and_less_is_not,
        bad_levels_are_named,
        stiffness_stands_beside_the_result,
    ]
)

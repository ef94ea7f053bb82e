"""What an automatic choice does not see of itself (unseen_scenes): it is kept, or is said."""

from unseen_scenes import (
    bounced,
    broke_away,
    crossed,
    glanced,
    grazed,
    hit_aslant,
    hopping,
    just_hit,
    left_out_by_mistake,
    lifted_off,
    middle_axis,
    much_asked,
    passed_by,
    peaked,
    point_turns,
    poked,
    pushed_over,
    rolled_out,
    slid_off,
    slow,
    spun_up,
    stopped,
    swinging,
    swung_off,
    thrown_up,
    tossed,
    written,
)

from support import fewer, run_json, tap


def keeps(d, made, errors=("1e-1", "1e-2", "1e-3"), way=()):
    """Promised, and within E of what is known in all that is asked for."""
    scene, known = made
    path = written(d, scene)
    for E in fewer(errors):
        e = run_json("simulate", path, *way, "--error", E)["error"]
        assert e["promised"], (scene["id"], E, e["reason"])
        asked = {q["quantity"]: q for q in e["quantities"]}
        for name, value in known.items():
            q = next(q for key, q in asked.items() if key.startswith(name))
            assert abs(q["value"] - value) <= float(E) * q["scale"], (
                scene["id"],
                E,
                name,
                value,
                q,
            )


def loads_that_swing_are_seen(d):
    """Six steps over whole periods of a force: nothing moves in them."""
    for periods in (4, 16):
        keeps(d, swinging(periods))


def a_contact_that_closes_and_opens_in_a_step_is_seen(d):
    for under in (1e-2, 1e-4):
        keeps(d, grazed(under), ("1e-1", "1e-2"))


def bodies_do_not_pass_through_each_other(d):
    for speed in (5.0, 1000.0):
        keeps(d, crossed(speed))


def what_a_driven_body_pushes_is_pushed(d):
    for over in (0.1, 0.001):
        keeps(d, poked(over))


def a_speed_next_to_an_impact_is_of_the_right_side(d):
    for part in (1e-3, 1e-5):
        keeps(d, just_hit(part))


def a_speed_behind_many_bounces_is_of_the_right_one(d):
    """Two runs that are at different bounces are near each other by chance; and how far gravity
    takes a point in free fall is no scale of one that bounces."""
    for r, e in ((0.05, 0.95), (0.0, 0.95), (0.05, 0.9)):
        for part in (0.6, 0.7, 0.8, 0.85, 0.9, 0.95):
            keeps(d, bounced(r, e, part), ("1e-1", "1e-2"))


def a_length_between_two_states_is_no_chords(d):
    keeps(d, passed_by())


def the_highest_place_is_between_two_states(d):
    keeps(d, thrown_up(), ("1e-2", "1e-3", "1e-4"))


def a_side_that_ends_is_met(d):
    for duration in (0.13, 0.15, 0.17, 0.2):
        keeps(d, slid_off(duration), ("1e-2", "1e-3", "1e-4"))


def where_friction_gives_way_is_foreseen(d):
    """Loads that grow while friction falls: nothing moves in steps that end before it does."""
    for way in (("coulomb", "nsgs"), ("coulomb", "cone_newton"), ("velocity", "lemke")):
        for dim, at, duration, kinetic, lifted in (
            (2, 0.22, 0.237, 0.6, False),
            (2, 1.6, 1.668, 0.55, False),
            (2, 4.3, 4.95, 0.33, True),
            (3, 2.36, 3.47, 0.4, True),
        ):
            if dim == 3 and way[1] == "nsgs":
                continue  # its sweeps end before two boxes in space are solved, and say so
            words = ("--formulation", way[0], "--solver", way[1])
            made = broke_away(dim, at, duration, kinetic, lifted)
            keeps(d, made, ("1e-1", "1e-2", "1e-3"), words)


def bristles_do_not_hold_beyond_their_friction(d):
    """They give way one after the other: what stretches them is no way back. Where the program may
    choose it takes none, which know no rest under a load that grows."""
    bristles = ("--formulation", "regularized", "--solver", "lemke")
    for mu, at, duration, push in ((0.46, 0.86, 1.03, 0.33), (0.88, 4.4, 4.56, 0.0)):
        made = pushed_over(mu, at, duration, push)
        few = ("--work", "50000")
        keeps(d, made, ("1e-2", "3e-3", "1e-3", "1e-4"), (*bristles, *few))
        keeps(d, made, ("1e-2", "1e-4"), ("--work", "1000"))


def a_contact_that_nothing_pulls_at_yet_is_seen_to_open(d):
    for way in (("coulomb", "cone_newton"), ("velocity", "lemke"), ("regularized", "lemke")):
        words = ("--formulation", way[0], "--solver", way[1], "--work", "5000")
        for duration in (1.05, 1.3, 1.45):
            keeps(d, lifted_off(duration), ("1e-1", "1e-2", "1e-3"), words)
        for duration in (0.52, 0.6, 0.8):
            keeps(d, swung_off(duration), ("1e-1", "1e-2", "1e-3"), words)


def a_narrow_peak_of_a_load_is_seen(d):
    """Friction holds on both sides of it, and kinetic friction does not."""
    for over in (1.0009, 1.01):
        for way in (("coulomb", "cone_newton"), ("velocity", "lemke")):
            words = ("--formulation", way[0], "--solver", way[1])
            for backwards in (False, True):
                keeps(d, peaked(over, backwards), ("1e-1", "1e-2", "1e-3"), words)


def what_rolls_out_in_a_short_step_is_measured(d):
    keeps(
        d,
        rolled_out(),
        ("1e-2", "1e-3", "1e-4"),
        ("--formulation", "velocity", "--solver", "lemke"),
    )


def where_round_sides_are_hit_turns_their_ways(d):
    for duration in (3.0, 30.0):
        keeps(d, glanced(duration))


def all_that_is_asked_for_is_watched(d):
    keeps(d, much_asked(), ("1e-2", "1e-3"))


def what_grows_off_a_steady_turning_is_seen(d):
    for off in (1e-6, 1e-10):
        keeps(d, middle_axis(off), ("1e-2", "1e-3"))
    keeps(d, spun_up(), ("1e-1", "1e-2", "1e-3"))


def an_answer_that_is_not_verified_is_not_promised(_):
    few = ("--work", "20000", "--formulation", "coulomb", "--solver", "nsgs")
    o = run_json("simulate", "impact", "--error", "1e-3", "--tol", "1", *few, code=3)
    assert not o["error"]["promised"] and "tolerance" in o["error"]["reason"], o["error"]


def steps_of_the_scene_are_not_asked_for(d):
    """The scene's own step is longer than the run, and than its spring bears."""
    short = run_json("simulate", "bounce", "--error", "1%", "--duration", "0.001")
    assert short["error"]["promised"], short["error"]
    scene, _ = swinging(4)
    spring = {"type": "spring_to_moving_anchor", "body": "b", "dir": [1, 0], "anchor0": [0, 0]}
    scene |= {"loads": [spring | {"k": 1e6, "c": 2e3, "anchor_vel": [0.1, 0]}]}
    stiff = run_json("simulate", written(d, scene), "--error", "10%", "--duration", "0.02")
    assert stiff["error"]["promised"], stiff["error"]


def a_load_does_not_turn_a_slide_round_that_friction_holds(d):
    """Wherever in a step it stops: kinetic friction held on, and let it go (62 E)."""
    for dim, load in ((2, 4), (2, 5.5), (3, 4), (3, 5.5)):
        made, known = stopped(dim, load)
        keeps(d, (made, known), ("2e-2", "1e-2", "1e-3"))
    # one that static friction cannot hold breaks away
    for dim in (2, 3):
        made, _ = stopped(dim, 6.6)
        made["bodies"][0]["vel"] = [0.0] * dim
        way = ("--formulation", "regularized", "--solver", "lemke", "--error", "1e-2")
        o = run_json("simulate", written(d, made), *way)
        assert abs(o["observables"]["a.x"]["value"] + 0.5 * 4.6 * 0.36) < 8e-3, o["observables"]
    # of four corners the two with less weight give way to equal bristles, and then the others
    made, _ = stopped(3, 5.5)
    way = ("--formulation", "regularized", "--solver", "lemke", "--error")
    for E in ("2e-2", "1e-3"):
        e = run_json("simulate", written(d, made), *way, E, code=3)["error"]
        assert not e["promised"] and "not Coulomb's" in e["reason"], e


def a_turn_is_not_measured_by_the_way(d):
    """An impact is small beside 360 m, and all of the turning (330 E)."""
    for speed in (600.0, 20.0):
        keeps(d, tossed(speed), ("1e-1", "1e-2"))
    keeps(d, point_turns())


def friction_that_is_too_small_is_said(d):
    """Of a law without friction, and of one without a static coefficient."""
    made, _ = stopped(2, 4)
    for way, why in (("normal", "not Coulomb's"), ("penalty", "static")):
        words = ("--formulation", way, "--solver", "lemke", "--error", "1%")
        e = run_json("simulate", written(d, made), *words, code=3)["error"]
        assert not e["promised"] and why in e["reason"], (way, e)


def bristles_too_soft_for_an_impact_are_said(d):
    """Hardly any friction comes of it, and the slide that goes on is 0.4 m/s too fast."""
    made, _ = hit_aslant()
    del made["friction_kinetic"]
    for form in ("regularized:stiffness=fixed", "regularized:model=lugre"):
        words = ("--formulation", form, "--solver", "lemke", "--error", "0.1%")
        e = run_json("simulate", written(d, made), *words, code=3)["error"]
        assert not e["promised"] and "not Coulomb's" in e["reason"], (form, e)
    keeps(
        d,
        (made, {"b.vx": 0.4}),
        ("1e-2", "1e-3"),
        ("--formulation", "regularized", "--solver", "lemke"),
    )


def no_speed_in_metres_a_second_is_slow(d):
    """`event` let nothing bounce below 1e-3 m/s, and promised that. What bounces on springs of its
    own is not promised at all."""
    for way in ("event", "velocity"):
        words = ("--formulation", way, "--solver", "lemke")
        keeps(d, slow(), ("1e-2", "1e-3"), words)
    words = ("--formulation", "penalty", "--solver", "lemke", "--error", "1%")
    e = run_json("simulate", written(d, slow()[0]), *words, code=3)["error"]
    assert not e["promised"] and "stiffness" in e["reason"], e


def an_impact_that_slips_has_kinetic_friction(d):
    """By every formulation: some took the static coefficient, and two of them promised it."""
    for way in (
        ("velocity", "lemke"),
        ("boxed", "newton"),
        ("coulomb", "nsgs"),
        ("position", "lemke"),
        ("acceleration", "lemke"),
        ("event", "lemke"),
        ("regularized", "lemke"),
    ):
        words = ("--formulation", way[0], "--solver", way[1])
        keeps(d, hit_aslant(), ("1e-2", "1e-3"), words)


def effects_that_no_bound_tells_of_stay_in(d):
    for scene, formulation, solver in left_out_by_mistake():
        path = written(d, scene)
        way = ("--formulation", formulation, "--solver", solver, "--effects")
        whole = run_json("simulate", path, *way, "declared")["observables"]
        for level in ("1e-2", "1e-4"):
            auto = run_json("simulate", path, *way, f"auto:{level}")
            told = auto["effects_auto"]
            for name, q in whole.items():
                scale = told["size_m"] if q["unit"] == "m" else told["speed_m_s"]
                scale /= told["size_m"] if q["unit"] == "rad/s" else 1.0
                off = abs(auto["observables"][name]["value"] - q["value"]) / scale
                assert off <= float(level), (scene["id"], level, name, off, told)


def what_comes_in_again_and_again_stays_in(d):
    """Steps that are taken again: no more than one return beyond half of the run."""
    way = ("--formulation", "velocity", "--solver", "lemke", "--effects", "auto:1e-2")
    r = run_json("simulate", written(d, hopping()), *way)
    again = r["effects_auto"]["steps_repeated"]
    assert 0 < again <= 1.5 * r["steps"], (again, r["steps"], r["effects_auto"])


tap(
    [
        loads_that_swing_are_seen,
        a_contact_that_closes_and_opens_in_a_step_is_seen,
        bodies_do_not_pass_through_each_other,
        what_a_driven_body_pushes_is_pushed,
        a_speed_next_to_an_impact_is_of_the_right_side,
        a_speed_behind_many_bounces_is_of_the_right_one,
        a_length_between_two_states_is_no_chords,
        the_highest_place_is_between_two_states,
        a_side_that_ends_is_met,
        where_friction_gives_way_is_foreseen,
        bristles_do_not_hold_beyond_their_friction,
        a_contact_that_nothing_pulls_at_yet_is_seen_to_open,
        a_narrow_peak_of_a_load_is_seen,
        what_rolls_out_in_a_short_step_is_measured,
        where_round_sides_are_hit_turns_their_ways,
        all_that_is_asked_for_is_watched,
        what_grows_off_a_steady_turning_is_seen,
        an_answer_that_is_not_verified_is_not_promised,
        steps_of_the_scene_are_not_asked_for,
        a_load_does_not_turn_a_slide_round_that_friction_holds,
        a_turn_is_not_measured_by_the_way,
        friction_that_is_too_small_is_said,
        bristles_too_soft_for_an_impact_are_said,
        no_speed_in_metres_a_second_is_slow,
        an_impact_that_slips_has_kinetic_friction,
        effects_that_no_bound_tells_of_stay_in,
        what_comes_in_again_and_again_stays_in,
    ]
)

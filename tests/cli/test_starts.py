"""Steps from the last one: a method that pivots begins from a basis of its own, not from the answer
chosen among redundant ones, whose active rows are none; and nothing that is solved from zero is
left unsolved from there."""

from support import SANITIZED, TESTS, run_json, tap


def of(scene, formulation, *words, duration, solver="lemke", code=0):
    way = ("--formulation", formulation, "--solver", solver, "--duration", duration)
    return run_json("simulate", scene, *way, *words, code=code)


def redundant_contacts_need_no_cold_start(_):
    """Of ten steps six to nine began from nothing. The choice is the same."""
    scenes = ("wall",) if SANITIZED else ("wall", "pyramid:base=6")
    for scene in scenes:
        for formulation in ("velocity:facets=8", "position", "regularized"):
            cold = of(scene, formulation, "--start", "cold", duration=0.1)
            for order in ("given", "random:3"):
                words = ("--start", "previous", "--contact-order", order)
                warm = of(scene, formulation, *words, duration=0.1)
                assert warm["status"] == "ok" and warm["n_share_missed"] == 0, warm["note"]
                assert warm["n_shared"] == warm["n_solves"] == 10, (scene, formulation)
                assert warm["n_fallback"] == 0, (scene, formulation, order, warm["n_fallback"])
                assert warm["n_pivot"] < 0.2 * cold["n_pivot"], (warm["n_pivot"], cold["n_pivot"])
                for name, value in cold["observables"].items():
                    assert abs(warm["observables"][name]["value"] - value["value"]) < 1e-9, name


def a_slide_keeps_its_basis(_):
    """Twenty steps of a box on four corners took 62 pivots by `regularized`; 5 are left."""
    warm = of("slide", "regularized", "--start", "previous", duration=0.2)
    assert warm["status"] == "ok" and warm["n_pivot"] <= 12, warm["n_pivot"]


def sweeps_that_give_their_start_back_are_no_end(_):
    """A solver stops at its tolerance, looser than that of the loop over the bounds of `boxed`: it
    gave its own start back up to a hundred times a step, and the step was `stalled`."""
    for scene in ("capstan", "card_house", "conveyor", "tablecloth"):
        warm = of(scene, "boxed", "--start", "previous", duration=0.2, solver="pgs")
        assert warm["status"] == "ok" and warm["n_solves"] < 10 * warm["steps"], (scene, warm)


def pivots_on_boxes_keep_what_is_redundant(_):
    """Rows that depend on others went to a bound of their box, which made another answer of the
    same motion: 270 solves a step, and `stalled`."""
    for scene in ("wall", "hopper"):
        warm = of(scene, "boxed", "--start", "previous", duration=0.05, solver="ppm")
        assert warm["status"] == "ok" and warm["n_solves"] == warm["steps"], (scene, warm)


def a_choice_without_noise_ends_a_loop(_):
    """The bounds of `boxed` follow the choice among redundant impulses, which was right to 1e-9."""
    scene = TESTS / "cases" / "moving" / "dragged_chain12.json"
    for start in ("cold", "previous"):
        run = of(scene, "boxed", "--start", start, duration=0.1, solver="ppm")
        assert run["status"] == "ok" and run["n_share_missed"] == 0, (start, run["note"])
        assert run["n_solves"] < 12 * run["steps"], (start, run["n_solves"])


def what_shrinks_without_end_is_zero(_):
    """Friction of the last step where nothing is to be held: q is 0 there, and the impulse was
    halved and halved (4.9e-324 was still no answer)."""
    for solver in ("newton", "pgs", "apgd", "ppm"):
        warm = of("billiard", "boxed", "--start", "previous", duration=1.7, solver=solver)
        assert warm["status"] == "ok" and warm["n_iter"] < 10000, (solver, warm)


tap(
    [
        redundant_contacts_need_no_cold_start,
        a_slide_keeps_its_basis,
        sweeps_that_give_their_start_back_are_no_end,
        pivots_on_boxes_keep_what_is_redundant,
        a_choice_without_noise_ends_a_loop,
        what_shrinks_without_end_is_zero,
    ]
)

"""Steps from the last one: a method that pivots begins from a basis of its own, not from the answer
chosen among redundant ones, whose active rows are none."""

from support import SANITIZED, run_json, tap


def of(scene, formulation, *words, duration):
    solver = ("--formulation", formulation, "--solver", "lemke", "--duration", duration)
    return run_json("simulate", scene, *solver, *words)


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


tap([redundant_contacts_need_no_cold_start, a_slide_keeps_its_basis])

"""`regularized` posed twice: normal impulses alone with a loop of modes, and all impulses at once
over cones with a compliance. One law, so one motion; an option that one pose lacks, it refuses."""

from support import SANITIZED, one_line_error, run_json, tap

SCENES = (
    "incline",
    "slide",
    "stack:n=3",
    "wall:duration=0.2",
    "walking_foot",
    "billiard",
    "gripper",
    "slider_crank:duration=0.1",
)
LAWS = ("", "model=viscous,", "stiffness=fixed,k=1e5,c=300,")


def observables(scene, formulation, solver, start):
    o = run_json(
        *("simulate", scene, "--formulation", formulation, "--solver", solver, "--start", start)
    )
    assert o["status"] == "ok", f"{scene} {formulation}: {o['note']}"
    assert o["verified"], f"{scene} {formulation}"
    return {k: v["value"] for k, v in o["observables"].items()}, o


def one_motion_of_both(_):
    for scene in SCENES:
        for law in LAWS[: 1 if SANITIZED else 3]:
            by_normals = f"regularized:{law}distribution=least_norm"
            reduced, _ = observables(scene, by_normals, "lemke", "cold")
            for storage in ("dense", "csc", "factored"):
                cone = f"regularized:{law}pose=cone,storage={storage}"
                start = "previous" if storage == "csc" else "cold"
                other, _ = observables(scene, cone, "cone_newton", start)
                # the slider turns in its guide by what gaps may be: a few 1e-7 rad
                close = 1e-6 if scene.startswith("slider_crank") else 1e-7
                for name, value in reduced.items():
                    assert abs(other[name] - value) <= close * max(1, abs(value)), (
                        f"{scene} {cone} {start}: {name} {other[name]}, by normal impulses {value}"
                    )


def other_solvers_of_cones(_):
    want, _ = observables("slide", "regularized", "lemke", "cold")
    for solver in ("nsgs", "prox"):
        got, _ = observables("slide", "regularized:pose=cone", solver, "cold")
        for name, value in want.items():
            assert abs(got[name] - value) <= 1e-6 * max(1, abs(value)), (solver, name, got[name])


def unknowns_are_told(_):
    for scene, p, n in (("stack:n=3", 12, 36), ("billiard", 1, None)):
        _, reduced = observables(scene, "regularized", "lemke", "cold")
        _, cone = observables(scene, "regularized:pose=cone", "cone_newton", "cold")
        assert reduced["lcp_dim_max"] == p, reduced["lcp_dim_max"]
        assert cone["lcp_dim_max"] > p and n in (None, cone["lcp_dim_max"]), cone["lcp_dim_max"]
        assert cone["n_solves"] == cone["steps"], "one solve a step"


def what_it_has_not_is_refused(_):
    for option, name in (
        ("model=lugre", "lugre"),
        ("ellipse=0.5", "ellipse"),
        ("modes=secant", "modes"),
        ("form=mass", "form"),
        ("factor=cholmod", "factor"),
        ("prox=0", "prox"),
        ("newton_iter=3", "newton_iter"),
    ):
        one_line_error(
            *("simulate", "slide", "--formulation", f"regularized:pose=cone,{option}"),
            *("--solver", "cone_newton"),
            names=[name, "pose=cone"],
        )
    one_line_error(
        *("simulate", "slide", "--formulation", "regularized:storage=factored"),
        *("--solver", "lemke"),
        names=["storage", "pose=cone"],
    )


tap([one_motion_of_both, other_solvers_of_cones, unknowns_are_told, what_it_has_not_is_refused])

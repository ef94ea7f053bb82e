"""`regularized` posed twice: normal impulses alone with a loop of modes, and all impulses at once
over cones with a compliance. One law, so one motion; an option that one pose lacks, it refuses.
By default many contacts are posed as cones to Newton's methods that read them."""

import json
import pathlib
import tempfile

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
    """scene: its name, or that and further options"""
    scene = (scene,) if isinstance(scene, (str, pathlib.Path)) else scene
    o = run_json(
        *("simulate", *scene, "--formulation", formulation, "--solver", solver, "--start", start)
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


def bouncing(folder):
    """144 balls that land one after the other and rebound: the contacts pass 128 up and down."""
    scene = pathlib.Path(folder) / "bouncing.json"
    bodies = [
        {
            "name": f"b{k}",
            "shape": {"type": "sphere", "r": 0.1},
            "mass": 1,
            "pos": [0.25 * (k % 12), 0.25 * (k // 12), 0.1 + 0.002 * (7 * k % 23)],
            "vel": [0.5, 0.1, 0],
        }
        for k in range(144)
    ]
    spec = {
        "id": "bouncing",
        "dim": 3,
        "T": 0.25,
        "gravity": [0, 0, -9.81],
        "bodies": bodies,
        "static": [{"name": "floor", "normal": [0, 0, 1], "offset": 0}],
        "friction": {"default": 0.3},
        "restitution": {"default": 0.4},
        "observe": ["b0.x", "b77.x", "b77.z", "b143.z"],
    }
    scene.write_text(json.dumps(spec))
    return scene


def many_contacts_are_posed_as_cones(_):
    def posed(scene, pose, solver):
        formulation = f"regularized{pose}"
        return observables(scene, formulation, solver, "previous")[1]

    still = ("silo:side=4,layers=4", "--step", "0.01", "--duration", "0.02")
    for scene, solver, as_cones in (
        ("stack:n=3", "cone_newton", False),
        (still, "cone_newton", True),
        (still, "cone_ipm", True),
        (still, "nsgs", False),  # of first order
        (still, "lemke", False),
    ):
        chosen = posed(scene, "", solver)
        given = posed(scene, f":pose={'cone' if as_cones else 'reduced'}", solver)
        assert chosen["solution_hash"] == given["solution_hash"], (scene, solver)
        times = 3 if as_cones else 1
        assert chosen["lcp_dim_max"] == times * chosen["n_contact_max"], (scene, solver)


def options_of_one_pose_choose_it(_):
    still = ("silo:side=4,layers=4", "--step", "0.01", "--duration", "0.01")
    for option in ("model=lugre", "ellipse=0.5", "modes=secant", "form=mass", "storage=dense"):
        _, o = observables(still, f"regularized:{option}", "cone_newton", "cold")
        assert o["lcp_dim_max"] == o["n_contact_max"], option


def a_run_goes_from_pose_to_pose(_):
    with tempfile.TemporaryDirectory() as folder:
        scene = bouncing(folder)
        of = {
            pose: observables(scene, f"regularized{pose}", "cone_newton", "previous")
            for pose in ("", ":pose=reduced", ":pose=cone")
        }
        hashes = {o["solution_hash"] for _, o in of.values()}
        assert len(hashes) == 3, "steps of both poses"
        for pose in (":pose=reduced", ":pose=cone"):
            for name, value in of[""][0].items():
                assert abs(of[pose][0][name] - value) <= 1e-7 * max(1, abs(value)), (pose, name)


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


tap(
    [
        one_motion_of_both,
        other_solvers_of_cones,
        unknowns_are_told,
        many_contacts_are_posed_as_cones,
        options_of_one_pose_choose_it,
        a_run_goes_from_pose_to_pose,
        what_it_has_not_is_refused,
    ]
)

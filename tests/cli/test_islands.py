"""--islands, --threads: columns that stand apart are solved one by one, by any number of threads,
with the answers of the whole and the same bits; what is one part is shared out inside."""

import json
import pathlib
import shlex

from support import SANITIZED, campaign, fewer, one_line_error, rows, run, run_json, tap

COLUMNS, HEIGHT = 7, 3
THREADS = [1, 3] if SANITIZED else [1, 2, 3, 4]
# of each storage one: dense, sparse, factors, and the reduced problem of one normal a contact
PAIRS = (
    ("velocity:storage=dense", "lemke"),
    ("velocity:storage=csc", "lemke"),
    ("velocity", "cone_newton"),
    ("coulomb:storage=csc", "cone_newton"),
    ("coulomb:storage=factored", "nsgs"),
    ("normal:storage=csc", "pgs"),
    ("regularized", "newton"),
    ("normal", "ppm"),
)


def columns(d: pathlib.Path, joined: bool = False, lift: float = 0.0) -> pathlib.Path:
    """Stacks of boxes, no two alike, side by side on one floor; joined: a plank on all of them;
    lift: the last lands first, so that the islands are numbered anew."""
    bodies, loads = [], []
    for c in range(COLUMNS):
        for k in range(HEIGHT):
            name = f"b{c}_{k}"
            shape = {"type": "box", "half": [0.5, 0.5, 0.5]}
            up = lift * (COLUMNS - c)
            place = {"pos": [3.0 * c, 0, 0.5 + k + up], "quat": [1, 0, 0, 0]}
            bodies.append({"name": name, "shape": shape, "mass": 1 + 0.1 * c} | place)
        push = {"type": "force_ramp", "body": f"b{c}_{HEIGHT - 1}", "dir": [0.8, 0.6, 0]}
        loads.append(push | {"rate": 20.0 + 10 * c})
    if joined:
        middle = {"pos": [1.5 * (COLUMNS - 1), 0, HEIGHT + 0.1], "quat": [1, 0, 0, 0]}
        plank = {"type": "box", "half": [1.5 * COLUMNS, 0.5, 0.1]}
        bodies.append({"name": "plank", "shape": plank, "mass": 2} | middle)
    checks = [{"type": "finite"}]
    scene = {"id": "columns", "dim": 3, "T": 0.1, "hs": [0.01], "gravity": [0, 0, -9.81]}
    scene |= {"friction": {"default": 0.5}, "restitution": {"default": 0.0}, "bodies": bodies}
    scene |= {"loads": loads, "static": [{"name": "floor", "normal": [0, 0, 1], "offset": 0}]}
    scene |= {"observe": [f"b{c}_{HEIGHT - 1}.pos" for c in range(COLUMNS)], "checks": checks}
    path = d / f"columns_{joined}_{lift}.json"
    path.write_text(json.dumps(scene), encoding="utf-8")
    return path


def words(scene: pathlib.Path, formulation: str, solver: str, *more: str) -> tuple:
    pair = ("--formulation", formulation, "--solver", solver, "--start", "previous")
    return ("simulate", scene, *pair, *more)


def seen(o: dict) -> list[float]:
    return [o["observables"]["energy"]["value"], *(v["value"] for v in o["observables"].values())]


def answers_are_those_of_the_whole(d: pathlib.Path) -> None:
    scene = columns(d)
    for pair in fewer(PAIRS):
        whole, parts = (run_json(*words(scene, *pair, "--islands", i)) for i in ("off", "on"))
        assert "n_island" not in whole and whole["verified"] and parts["verified"], pair
        assert parts["n_island"] == COLUMNS, (pair, parts["n_island"])
        assert parts["largest_island"] * COLUMNS == whole["lcp_dim_max"] == parts["lcp_dim_max"]
        for a, b in zip(seen(whole), seen(parts), strict=True):
            assert abs(a - b) <= 1e-8 * (1 + abs(a)), (pair, a, b)


def bits_do_not_depend_on_threads(d: pathlib.Path) -> None:
    scene = columns(d)
    for pair in fewer(PAIRS):
        on = words(scene, *pair, "--islands", "on", "--threads")
        made = [run_json(*on, str(n)) for n in THREADS]
        assert [o["threads"] for o in made] == THREADS
        assert len({(o["solution_hash"], o["n_iter"], o["n_pivot"]) for o in made}) == 1, pair


# One island each: sweeps one behind the other, and factors by fronts and by blocks.
ONE_PART = (
    ("sphere_pile:n=400", "coulomb", "nsgs:budget=60"),
    ("sphere_pile:n=400", "boxed", "pgs:budget=60"),
    ("sphere_pile:n=400", "coulomb:distribution=extreme", "cone_newton:max_iter=8"),
    ("sphere_pile:n=400", "normal", "newton"),
    ("silo:side=8,layers=4", "velocity", "cone_newton"),
    ("silo:side=8,layers=4", "regularized:pose=cone", "cone_newton"),
    ("pyramid:base=8", "boxed", "pgs"),
)


def what_is_one_part_is_shared_too(_: pathlib.Path) -> None:
    for scene, formulation, solver in fewer(ONE_PART):
        asked = words(scene, formulation, solver, "--step", "0.01", "--duration", "0.05")
        made = [run_json(*asked, "--threads", str(n), code=None) for n in THREADS]
        assert [o.get("threads", 1) for o in made] == THREADS
        assert all("n_island" not in o for o in made)
        told = {(o["solution_hash"], o["n_iter"], o["status"], o["rho_max"]) for o in made}
        assert len(told) == 1, (scene, formulation, solver, told)
        assert made[0]["n_contact_max"] > 60, scene


def impulses_are_chosen_in_each(d: pathlib.Path) -> None:
    """Boxes on four feet each have many impulses: the islands' choices are those of the whole, by
    any number of threads, also where contacts begin and end."""
    for scene in (columns(d), columns(d, lift=0.001)):
        for pair in (("velocity", "cone_newton"), ("coulomb", "cone_newton"), ("boxed", "newton")):
            asked = (*words(scene, *pair), "--islands")
            whole = run_json(*asked, "off")
            made = [run_json(*asked, "on", "--threads", str(n)) for n in (1, 2, 4)]
            assert made[0]["n_island"] > 1 and made[0]["verified"], (scene, pair)
            assert len({o["solution_hash"] for o in made}) == 1, (scene, pair)
            counts = [(o["n_shared"], o["n_share_missed"]) for o in (whole, *made)]
            assert counts[0][0] > 0 and len(set(counts)) == 1, (scene, pair, counts)
            for a, b in zip(seen(whole), seen(made[0]), strict=True):
                assert abs(a - b) <= 1e-8 * (1 + abs(a)), (scene, pair, a, b)


def order_of_contacts_moves_no_island(d: pathlib.Path) -> None:
    scene = columns(d)
    on = words(scene, "regularized", "newton", "--islands", "on", "--contact-order")
    given = run_json(*on, "given")
    for seed in fewer(range(1, 11)):
        other = run_json(*on, f"random:{seed}")
        assert other["n_island"] == COLUMNS and other["verified"]
        for a, b in zip(seen(given), seen(other), strict=True):
            assert abs(a - b) <= 1e-8 * (1 + abs(a)), seed


def what_is_joined_is_one_island(d: pathlib.Path) -> None:
    scene = columns(d, joined=True)
    for pair in fewer(PAIRS):
        asked = (words(scene, *pair, "--islands", i) for i in ("off", "on"))
        whole, parts = (run_json(*w, code=None) for w in asked)
        assert parts["n_island"] == 1 and parts["largest_island"] == whole["lcp_dim_max"]
        assert parts["solution_hash"] == whole["solution_hash"], pair


CAMPAIGN = """
name: parts
limits: {time: 20s, grace: 1s}
sampling: {processes: 1, samples: 1, max_samples: 1}
parts:
  - name: a
    problems: ["%s"]
    formulations: [normal, regularized]
    solvers: [newton]
    starts: [previous]
    islands: [off, on]
"""


def islands_are_an_axis(d: pathlib.Path) -> None:
    """Each a cell of its own, with its columns and a command that gives it back; a key without
    islands is that of before there were any."""
    text = CAMPAIGN % columns(d)
    run("run", campaign(d, text), "--out", d / "o", "--quiet")
    got = rows(d / "o")
    assert len({r["cell_id"] for r in got}) == 4 and all(r["status"] == "ok" for r in got)
    for r in got:
        parts = (r["n_island"], r["largest_island"])
        on = r["islands"] == "on"
        assert parts == ((str(COLUMNS), str(int(r["lcp_dim"]) // COLUMNS)) if on else ("", "")), r
        assert ("--islands" in r["command"]) == on
        o = json.loads(run(*shlex.split(r["command"])[1:]).stdout)
        assert o["solution_hash"] == r["solution_hash"]
    plain = campaign(d, text.replace("    islands: [off, on]\n", ""), "plain.yaml")
    run("run", plain, "--out", d / "p", "--quiet")
    off = {r["cell_id"] for r in got if r["islands"] == "off"}
    assert {r["cell_id"] for r in rows(d / "p")} == off
    run("run", campaign(d, text), "--out", d / "f", "--quiet", "--filter", "islands=on")
    assert {r["islands"] for r in rows(d / "f")} == {"on"}
    wrong = campaign(d, text.replace("[off, on]", "[some]"), "wrong.yaml")
    one_line_error("run", wrong, "--dry-run", names=["islands", "some", "on or off"])


def what_cannot_be_is_said(d: pathlib.Path) -> None:
    on = words(columns(d), "regularized", "newton", "--islands", "on")
    one_line_error(*on[:-1], "yes", names=["--islands yes", "on or off"])
    one_line_error(*on, "--threads", "0", names=["--threads"])
    one_line_error(*on, "--threads", "two", names=["--threads", "two"])
    one_line_error(*on, "--trace", d / "t.csv", names=["--trace", "--islands off"])
    assert run(*on, "--threads", "1").returncode == 0


tap(
    [
        answers_are_those_of_the_whole,
        bits_do_not_depend_on_threads,
        what_is_one_part_is_shared_too,
        impulses_are_chosen_in_each,
        order_of_contacts_moves_no_island,
        what_is_joined_is_one_island,
        islands_are_an_axis,
        what_cannot_be_is_said,
    ]
)

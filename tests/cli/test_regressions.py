"""Problems on which the program once failed (tests/cases/regressions): each comes out right, or is
listed in known.txt with a reason. A listed one that comes out right fails too, so that the list
only shrinks."""

import json

from support import SANITIZED, TESTS, Skip, run, tap

FOLDER = TESTS / "cases" / "regressions"
# what a model leaves out is no failure
LIMITS = ("models no ", "models compliant ", "not applicable")
LIMIT = ("--time-limit", "120")
# 1600 contacts: one combination, where every other scene goes through all formulations
COMBINATIONS = {"pyramid_ramp": ("--formulation", "regularized", "--solver", "interior_point")}
INFEASIBLE = ("infeasible_ray_1195",)


def listed():
    """{"NAME WHO": reason}, WHO a solver or a formulation."""
    known = {}
    for line in (FOLDER / "known.txt").read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            key, _, reason = line.partition(": ")
            assert len(key.split()) == 2 and reason and key not in known, f"known.txt: {line}"
            known[key] = reason
    return known


def compare(found, names):
    """found: {"NAME WHO": "" or why it did not come out right}, of the problems called `names`."""
    known = {key: why for key, why in listed().items() if key.split()[0] in names}
    lines = [f"{key} is listed, but no such run was made" for key in known if key not in found]
    for key, why in found.items():
        if why and key not in known:
            lines.append(f"{key}: {why}")
        if not why and key in known and not known[key].startswith("by rounding: "):
            lines.append(f"{key} comes out right: take it out of known.txt ({known[key]})")
    assert not lines, "\n".join(lines)


def lcps_are_solved(d):
    problems = sorted((FOLDER / "lcp").glob("*.M.mtx"))
    assert len(problems) == 22
    found = {}
    for path in problems:
        name = path.name.removesuffix(".M.mtx")
        o = json.loads(run("solve", path, "--solver", "lemke", code=None).stdout)
        right = o["status"] == "infeasible" if name in INFEASIBLE else o["verified"]
        found[f"{name} lemke"] = "" if right else f"{o['status']}, rho {o['rho']}"
    compare(found, {path.name.removesuffix(".M.mtx") for path in problems})


def judged(path):
    """{"SCENE FORMULATION": ""} or the first thing that was not as the scene says."""
    words = COMBINATIONS.get(path.stem, ())
    found = {}
    said = run("check", path, *words, *LIMIT, "--json", code=None, timeout=600).stdout
    for c in json.loads(said)["checks"]:
        key = f"{path.stem} {c['formulation']}"
        limit = c["result"] == "skipped" and c["reason"].startswith(LIMITS)
        right = c["result"] == "passed" or limit
        why = "" if right else f"{c['check']} {c['result']}: {c['reason']}"
        if c["result"] == "failed" and c["got"] is not None:
            why += f" got {c['got']}, expected {c['expected']} within {c['tolerance']}"
        found[key] = found.get(key) or why
    assert found, path
    return found


def scenes_come_out_right(d):
    if SANITIZED:
        raise Skip("a thousand steps of many formulations: too slow with sanitizers")
    scenes = sorted((FOLDER / "scenes").glob("*.json"))
    assert len(scenes) == 24
    found = {}
    for path in scenes:
        checks = json.loads(path.read_text())["checks"]
        assert any("value" in c or c["type"] == "max_drift" for c in checks), path
        found |= judged(path)
    compare(found, {path.stem for path in scenes})


def the_list_names_what_exists(d):
    names = {p.name.removesuffix(".M.mtx") for p in (FOLDER / "lcp").glob("*.M.mtx")}
    names |= {p.stem for p in (FOLDER / "scenes").glob("*.json")}
    assert {key.split()[0] for key in listed()} <= names


tap([lcps_are_solved, scenes_come_out_right, the_list_names_what_exists])

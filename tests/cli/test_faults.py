"""Solvers that lie, crash, hang, hog, quit and flood: one typed row each, and the campaign completes."""
import json

from support import FAULTY, SANITIZED, campaign, one_line_error, rows, run, tap

TEXT = """
name: faults
limits: {time: 2s, memory: 2G, grace: 0.5s}
sampling: {processes: 2, samples: 2, max_samples: 2, inner: 0.0001s}
parts:
  - name: a
    problems: ["stack:n=1,duration=0.02"]
    formulations: ["velocity:facets=4"]
    solvers: [lemke, faulty_liar, faulty_nan, faulty_crash, faulty_hang, faulty_hog, faulty_quit, faulty_flood]
"""
WANT = {"lemke": "ok", "faulty_liar": "unverified", "faulty_nan": "numerical", "faulty_crash": "crash", "faulty_hang": "timeout",
        "faulty_hog": "oom", "faulty_quit": "no_output", "faulty_flood": "flood"}

if SANITIZED:  # no memory limit there, and the sanitizer turns SIGSEGV into its own abort
    TEXT = TEXT.replace("faulty_hog, ", "")
    del WANT["faulty_hog"]


def each_death_has_its_word(d):
    run("run", campaign(d, TEXT), "--out", d / "out", "--quiet", exe=FAULTY)
    got = rows(d / "out")
    for solver, word in WANT.items():
        mine = [r for r in got if r["solver"] == solver]
        assert {r["status"] for r in mine} == {word}, (solver, [r["status"] for r in mine])
        assert len(mine) == (4 if word == "ok" else 1), (solver, len(mine))
        if word != "ok":
            assert mine[0]["t_total_s"] == "" and mine[0]["verified"] != "true", solver
    liar = next(r for r in got if r["solver"] == "faulty_liar")
    assert liar["status_claimed"] == "ok" and float(liar["rho"]) > 1e-3 and liar["note"]
    assert next(r for r in got if r["solver"] == "faulty_crash")["exit_signal"] == ("6" if SANITIZED else "11")


def strict_says_so(d):
    c = campaign(d, TEXT.replace("faulty_hang, ", "").replace("faulty_hog, ", ""))
    run("run", c, "--out", d / "out", "--quiet", "--strict", exe=FAULTY, code=3)


def liar_in_json(d):
    o = json.loads(run("solve", "random_spd:n=5", "--solver", "faulty_liar", exe=FAULTY, code=3).stdout)
    assert (o["status"], o["claimed"], o["verified"]) == ("unverified", "ok", False), o
    o = json.loads(run("simulate", "stack:n=1", "--formulation", "normal", "--solver", "faulty_liar", exe=FAULTY, code=3).stdout)
    assert (o["status"], o["claimed"], o["verified"]) == ("unverified", "ok", False), o


def faults_are_not_in_the_release(d):
    one_line_error("solve", "random_spd:n=5", "--solver", "faulty_liar", names=["faulty_liar"])


tap([each_death_has_its_word, strict_says_so, liar_in_json, faults_are_not_in_the_release])

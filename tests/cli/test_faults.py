"""Solvers that lie, crash, hang, hog, quit and flood: one typed row each, and the campaign
completes."""

import json

from support import FAULTY, SANITIZED, campaign, diagonal, one_line_error, rows, run, tap

TEXT = """
name: faults
limits: {time: 5s, memory: 2G, grace: 0.5s}
sampling: {processes: 2, samples: 2, max_samples: 2, inner: 0.0001s}
parts:
  - name: a
    problems: ["stack:n=1,duration=0.02"]
    formulations: ["velocity:facets=4"]
    solvers: [lemke, faulty_liar, faulty_nan, faulty_crash, faulty_hang, faulty_hog, faulty_quit,
              faulty_flood]
"""
WANT = {
    "lemke": "ok",
    "faulty_liar": "unverified",
    "faulty_nan": "numerical",
    "faulty_crash": "crash",
    "faulty_hang": "timeout",
    "faulty_hog": "oom",
    "faulty_quit": "no_output",
    "faulty_flood": "flood",
}

if SANITIZED:  # no memory limit there, and the sanitizer turns SIGSEGV into its own abort
    TEXT = TEXT.replace("faulty_hog, ", "")
    del WANT["faulty_hog"]


def g3_each_death_has_its_word(d):
    run("run", campaign(d, TEXT), "--out", d / "out", "--quiet", exe=FAULTY)
    got = rows(d / "out")
    for solver, word in WANT.items():
        mine = [r for r in got if r["solver"] == solver]
        assert {r["status"] for r in mine} == {word}, (solver, [r["status"] for r in mine])
        assert len(mine) == (4 if word == "ok" else 1), (solver, len(mine))
        if word != "ok":
            assert mine[0]["t_total_s"] == "" and mine[0]["verified"] != "true", solver
    assert {(r["t_limit_s"], r["mem_limit_B"]) for r in got} == {("5", str(2 << 30))}
    liar = next(r for r in got if r["solver"] == "faulty_liar")
    assert liar["status_claimed"] == "ok" and float(liar["rho"]) > 1e-3 and liar["note"]
    assert next(r for r in got if r["solver"] == "faulty_crash")["exit_signal"] == (
        "6" if SANITIZED else "11"
    )


def g3_strict_says_so(d):
    c = campaign(d, TEXT.replace("faulty_hang, ", "").replace("faulty_hog, ", ""))
    run("run", c, "--out", d / "out", "--quiet", "--strict", exe=FAULTY, code=3)


def g2_liar_in_json(d):
    o = json.loads(
        run("solve", "random_spd:n=5", "--solver", "faulty_liar", exe=FAULTY, code=3).stdout
    )
    assert (o["status"], o["claimed"], o["verified"]) == ("unverified", "ok", False), o
    o = json.loads(
        run(
            "simulate",
            "stack:n=1",
            "--formulation",
            "normal",
            "--solver",
            "faulty_liar",
            exe=FAULTY,
            code=3,
        ).stdout
    )
    assert (o["status"], o["claimed"], o["verified"]) == ("unverified", "ok", False), o


def rerun_measures_what_is_asked_for(d):
    """timeouts: what timed out; failed: every cell that is not ok; a solver: its cells; all: all.
    Nothing asked: nothing."""
    text = FLAGS % (
        1,
        1,
        diagonal(d, 6),
        "[lemke, pgs, faulty_liar, faulty_crash, faulty_hang, faulty_patient]",
    )
    c = campaign(d, text)
    run("run", c, "--out", d / "o", "--quiet", exe=FAULTY)
    first = {r["solver"]: r["status"] for r in rows(d / "o")}
    assert (
        first["faulty_hang"] == "timeout"
        and first["faulty_patient"] == "time_limit"
        and first["faulty_crash"] == "crash"
    ), first
    for what, count in ((None, 0), ("timeouts", 2), ("failed", 4), ("pgs", 1), ("all", 6)):
        done = run(
            "run", c, "--out", d / "o", "--quiet", *(("--rerun", what) if what else ()), exe=FAULTY
        )
        assert f" {count} measured now" in done.stdout, (what, done.stdout)
        assert {r["solver"]: r["status"] for r in rows(d / "o")} == first and len(
            rows(d / "o")
        ) == 6


FLAGS = """
name: flags
limits: {time: 5s, grace: 1s}
sampling: {processes: 1, samples: %d, max_samples: %d, half_width: 0, inner: 0.0001s, budget: 10s}
parts:
  - name: a
    problems: ["%s"]
    solvers: %s
"""


def flagged(d, solvers):
    out = d / f"o{len(list(d.iterdir()))}"
    c = campaign(d, FLAGS % (2, 2, diagonal(d, 6), solvers))
    run("run", c, "--out", out, "--quiet", exe=FAULTY)
    return [(r["solver"], set(r["flags"].split()), r) for r in rows(out)]


def suspicious_rows_are_flagged(d):
    """Twins in disguise, answers without work, a method that asked another, answers that change:
    none passes in silence."""
    got = flagged(
        d, "[lemke, faulty_damped, faulty_copy, faulty_idle, faulty_fallback, faulty_fickle]"
    )
    word = {
        "faulty_damped": "same_bits",
        "faulty_copy": "same_bits",
        "faulty_idle": "zero_iterations",
        "faulty_fallback": "fallback",
        "faulty_fickle": "not_repeatable",
    }
    for solver, flags, r in got:
        assert r["status"] == "ok", r
        assert (word[solver] in flags) if solver in word else not flags & set(word.values()), (
            solver,
            flags,
        )
    assert {s for s, _, _ in got} == set(word) | {"lemke"}
    # one of the two alone is nothing special
    assert all("same_bits" not in flags for _, flags, _ in flagged(d, "[lemke, faulty_damped]"))


def limits_do_not_part_pairs(d):
    """The same cells under another limit are compared with each other."""
    c = campaign(d, FLAGS % (2, 2, diagonal(d, 6), "[lemke, 'pgs:omega=0.9']"))
    run("run", c, "--out", d / "a", "--quiet")
    run("run", c, "--out", d / "b", "--quiet", "--time-limit", "3")
    assert "over 2 pairs" in run("compare", d / "a", d / "b").stdout


def faults_are_not_in_the_release(d):
    one_line_error("solve", "random_spd:n=5", "--solver", "faulty_liar", names=["faulty_liar"])


tap(
    [
        g3_each_death_has_its_word,
        g3_strict_says_so,
        g2_liar_in_json,
        rerun_measures_what_is_asked_for,
        suspicious_rows_are_flagged,
        limits_do_not_part_pairs,
        faults_are_not_in_the_release,
    ]
)

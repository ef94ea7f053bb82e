"""--memory: what the parts of a step work in goes back in between, with the same bits; a run tells
the most that it had."""

from support import SANITIZED, Skip, one_line_error, run_json, tap

FEW = ("stack:n=3", "--step", 0.01, "--duration", 0.05)
MANY = ("silo:side=8,layers=7", "--step", 0.01, "--duration", 0.03)


def told(scene, formulation, solver, *more):
    words = ("--formulation", formulation, "--solver", solver, "--start", "previous", *more)
    return run_json("simulate", *scene, *words)


def the_bits_are_the_same(_):
    for scene in (FEW, MANY):
        for formulation in ("velocity", "regularized", "boxed"):
            usual = told(scene, formulation, "cone_newton")
            least = told(scene, formulation, "cone_newton", "--memory", "least")
            assert usual["verified"] and usual["solution_hash"] == least["solution_hash"], scene
            assert least["memory"] == "least" and "memory" not in usual
    usual, least = (told(FEW, "velocity", "lemke", "--memory", m) for m in ("usual", "least"))
    assert usual["solution_hash"] == least["solution_hash"]


def less_is_taken(_):
    if SANITIZED:
        raise Skip("freed memory is kept by the sanitizer")
    one = told(FEW, "coulomb", "cone_newton")["rss_peak_B"]
    for formulation in ("velocity", "coulomb"):
        usual, least = (
            told(MANY, formulation, "cone_newton", "--memory", m)["rss_peak_B"] - one
            for m in ("usual", "least")
        )
        assert 0 < least < 0.85 * usual, (formulation, usual, least)


def another_word_is_refused(_):
    words = ("--formulation", "coulomb", "--solver", "cone_newton", "--memory", "most")
    one_line_error("simulate", *FEW, *words, names=["--memory most", "usual or least"])


tap([the_bits_are_the_same, less_is_taken, another_word_is_refused])

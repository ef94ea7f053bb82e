"""The table of scenes where many contacts carry, on planted rows: who reaches the error first, what
stands where nobody does, and that a reference is no rival."""

import pathlib
import sys
import unittest

import pandas as pd

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from bench import crowded  # noqa: E402

BASE = {
    "campaign": "crowded",
    "part": "polyhedral",
    "problem": "tests/cases/moving/bowls24.json",
    "command": "lcpbench simulate",
    "combination": "velocity + lemke",
    "formulation": "velocity",
    "formulation_options": "facets=8",
    "solver": "lemke",
    "start": "cold",
    "status": "ok",
    "noise": 1.05,
    "tol": 1e-10,
    "effects": "",
    "n_active": 24.0,
    "n_contacts": 30.0,
    "step_s": 0.01,
    "duration_s": 0.2,
    "err_ref": 1e-3,
    "err_floor": 1e-12,
    "t_total_s": 1e-2,
    "t_total_s_low": 0.99e-2,
    "t_total_s_high": 1.01e-2,
}


def took(seconds):
    return {"t_total_s": seconds, "t_total_s_low": 0.99 * seconds, "t_total_s_high": 1.01 * seconds}


def ours(seconds=2e-2, **other):
    return {
        "formulation": "regularized",
        "formulation_options": "",
        "combination": "regularized + lemke",
        **took(seconds),
        **other,
    }


LATE = {"status": "timeout", "err_ref": float("nan")}


def cells(*rows):
    return pd.DataFrame([{**BASE, **row} for row in rows]).assign(
        good=[{**BASE, **row}["status"] == "ok" for row in rows]
    )


def text(table, row=0):
    words = [c if isinstance(c, str) else c.text for c in table.rows[row]]
    return dict(zip(table.header, words, strict=True))


def row_of(some, error="0.01", start="cold"):
    made = crowded.counts(some)
    (line,) = (r for r in made.rows if r[:2] == [error, start])
    return dict(zip(made.header, line, strict=True))


class Crowded(unittest.TestCase):
    def test_the_cheapest_cell_within_the_error_stands_for_its_formulation(self):
        fine = {"step_s": 0.0025, "err_ref": 2e-3, **took(4e-2)}
        some = cells({"err_ref": 0.05}, fine, ours(), ours(1e-3, solver="newton", err_ref=0.1))
        found = text(crowded.table(some))
        self.assertEqual(found["velocity:facets=8"], "40 ms by lemke, 2.5 ms")
        self.assertEqual(found["regularized"], "20 ms by lemke")
        self.assertEqual((found["scene"], found["contacts"]), ("bowls24", "24"))
        told = row_of(some)
        self.assertEqual((told["velocity:facets=8"], told["regularized"]), ("0", "1"))

    def test_who_does_not_reach_the_error_is_told_by_how_much(self):
        some = cells({"err_ref": 0.05}, ours())
        self.assertEqual(text(crowded.table(some))["velocity:facets=8"], "off by 5.0e-02")
        self.assertEqual(row_of(some)["velocity:facets=8"], "0 of 0")

    def test_finer_errors_are_told_beside_it(self):
        some = cells({"err_ref": 5e-4}, ours(1e-3, err_ref=5e-3))
        self.assertEqual(row_of(some)["regularized"], "1")
        told = row_of(some, "0.001")
        self.assertEqual((told["velocity:facets=8"], told["regularized"]), ("1", "0 of 0"))
        self.assertEqual(row_of(some, "0.0001")["velocity:facets=8"], "0 of 0")

    def test_an_error_that_a_finer_step_does_not_keep_is_luck(self):
        some = cells({}, {"step_s": 0.0025, "err_ref": 0.05}, ours())
        self.assertEqual(text(crowded.table(some))["velocity:facets=8"], "off by 5.0e-02")

    def test_who_is_not_solved_is_told_with_how_it_ended(self):
        some = cells({}, ours(**LATE), ours(**{**LATE, "solver": "newton", "status": "stalled"}))
        found = text(crowded.table(some))
        self.assertEqual(found["regularized"], "not solved: lemke timeout, newton stalled")

    def test_times_within_the_noise_or_the_spread_are_tied(self):
        for other in (ours(1.04e-2), ours(2e-2, t_total_s_low=1e-2)):
            told = row_of(cells({}, other))
            self.assertEqual({told["velocity:facets=8"], told["regularized"]}, {"0 + 1 tied"})
        self.assertEqual(row_of(cells({}, ours()))["velocity:facets=8"], "1")

    def test_who_was_not_asked_is_no_loser(self):
        other = {"problem": "tests/cases/moving/rollers12.json"}
        self.assertIn("every formulation ran on every scene.", crowded.words(cells({}, ours())))
        some = cells({}, ours(), other)
        self.assertIn("ran on 1 of 2 scenes and starts", crowded.words(some))
        self.assertEqual((row_of(some)["scenes"], row_of(some)["velocity:facets=8"]), ("1", "1"))

    def test_who_has_no_known_error_is_no_loser(self):
        blind = {"err_ref": float("nan")}
        some = cells({}, ours(**blind), {"problem": "b.json"}, ours(problem="b.json"))
        self.assertEqual(text(crowded.table(some), 1)["regularized"], "no error known")
        self.assertIn("ran on 1 of 2 scenes and starts", crowded.words(some))

    def test_starts_are_told_apart(self):
        some = cells({}, ours(), {"start": "previous"}, ours(1e-3, start="previous"))
        made = crowded.table(some)
        self.assertEqual([r[2] for r in made.rows], ["cold", "previous step"])
        self.assertIn("(1 scene)", crowded.words(some))
        self.assertEqual(row_of(some)["velocity:facets=8"], "1")
        self.assertEqual(row_of(some, start="previous step")["regularized"], "1")

    def test_what_gives_the_reference_is_no_rival(self):
        event = {"part": "references", "formulation": "event", "formulation_options": ""}
        self.assertNotIn("event", text(crowded.table(cells({}, event, ours()))))
        self.assertIsNone(crowded.section(cells({"campaign": "accuracy"})))


if __name__ == "__main__":
    unittest.main()

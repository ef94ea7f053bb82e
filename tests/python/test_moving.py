"""The table of larger scenes that move, on planted rows: who is fastest, who is not solved, and
that a solver which ends early does not stand for its formulation."""

import pathlib
import sys
import unittest

import pandas as pd

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from bench import moving  # noqa: E402

BASE = {
    "campaign": "moving",
    "problem": "granular_column:columns=4",
    "formulation": "velocity",
    "formulation_options": "facets=4",
    "solver": "lemke",
    "status": "ok",
    "good": True,
    "noise": 1.05,
    "n_active": 49.0,
    "n_contacts": 60.0,
    "step_s": 0.005,
    "duration_s": 0.2,
    "t_total_step_s": 1e-3,
    "res_ncp_rel": 1e-3,
}


def cells(*rows):
    some = pd.DataFrame([{**BASE, **row} for row in rows])
    for end, factor in (("low", 0.99), ("high", 1.01)):
        if f"t_total_step_s_{end}" not in some:
            some[f"t_total_step_s_{end}"] = factor * some["t_total_step_s"]
    return some


def text(table, row=0):
    words = [c if isinstance(c, str) else c.text for c in table.rows[row]]
    return dict(zip(table.header, words, strict=True))


OURS = {"formulation": "regularized", "formulation_options": "", "t_total_step_s": 2e-3}
LATE = {"good": False, "status": "timeout"}


class Moving(unittest.TestCase):
    def test_the_fastest_that_is_solved_stands_for_its_formulation(self):
        some = cells(
            {}, {"solver": "pgs", "t_total_step_s": 5e-4, "good": False, "status": "max_iter"}, OURS
        )
        found = text(moving.table(some))
        self.assertEqual(found["velocity:facets=4"], "1 ms by lemke")
        self.assertEqual(found["regularized"], "2 ms by lemke")
        self.assertIn("The fastest: velocity:facets=4 on 1.", moving.words(some))
        self.assertIn("The fastest: `velocity:facets=4` on 1.", moving.words(some, "`"))

    def test_who_is_not_solved_is_told_with_how_it_ended(self):
        some = cells(
            {}, {**OURS, **LATE}, {**OURS, **LATE, "solver": "newton", "status": "stalled"}
        )
        found = text(moving.table(some))
        self.assertEqual(found["regularized"], "not solved: lemke timeout, newton stalled")
        self.assertIn("velocity:facets=4 1, regularized 0", moving.words(some))

    def test_times_within_the_noise_or_the_spread_are_tied(self):
        both = "velocity:facets=4 on 0 and 1 tied, regularized on 0 and 1 tied"
        self.assertIn(both, moving.words(cells({}, {**OURS, "t_total_step_s": 1.04e-3})))
        spread = {"t_total_step_s_low": 0.9e-3, "t_total_step_s_high": 2.1e-3}
        self.assertIn(both, moving.words(cells(spread, {**OURS, **spread})))

    def test_what_is_left_of_coulombs_law_is_told_and_counted(self):
        some = cells({"res_ncp_rel": 0.2}, OURS)
        found = text(moving.table(some))
        self.assertEqual(found["velocity:facets=4"], "1 ms by lemke, 2.0e-01")
        self.assertEqual(found["regularized"], "2 ms by lemke")
        said = moving.words(some)
        self.assertIn("The fastest: velocity:facets=4 on 1.", said)
        self.assertIn(
            "(velocity:facets=4 0, regularized 1) the fastest are regularized on 1.", said
        )

    def test_scenes_stand_by_their_contacts(self):
        some = cells({"problem": "folder/ramp.json", "n_active": 1600.0}, {}, OURS)
        made = moving.table(some)
        self.assertEqual([r[0] for r in made.rows], ["granular_column:columns=4", "ramp"])
        self.assertEqual(text(made, 1)["regularized"], "not asked")
        self.assertIn("Where 49 to 1600 contacts move (2 scenes)", moving.words(some))

    def test_one_scene_by_other_settings_is_another_row(self):
        longer = {"campaign": "moving_settled", "duration_s": 0.5, "n_active": 70.0}
        some = cells({}, OURS, {**longer, **LATE}, {**OURS, **longer})
        made = moving.table(some)
        self.assertEqual([r[1:4] for r in made.rows], [["49", "5", "0.2"], ["70", "5", "0.5"]])
        self.assertEqual(text(made, 1)["velocity:facets=4"], "not solved: lemke timeout")
        said = moving.words(some)
        self.assertIn("(1 scene, 2 settings)", said)
        self.assertIn("velocity:facets=4 1, regularized 2", said)

    def test_other_campaigns_and_undefined_cells_are_left_out(self):
        self.assertIsNone(moving.table(cells({"campaign": "accuracy"}, {"status": "unsupported"})))
        self.assertIsNone(moving.section(cells({"campaign": "accuracy"})))


if __name__ == "__main__":
    unittest.main()

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
}


def cells(*rows):
    return pd.DataFrame([{**BASE, **row} for row in rows])


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

    def test_times_within_the_noise_are_tied(self):
        some = cells({}, {**OURS, "t_total_step_s": 1.04e-3})
        said = moving.words(some)
        self.assertIn("velocity:facets=4 on 0 and 1 tied, regularized on 0 and 1 tied", said)

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

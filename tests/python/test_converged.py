"""References from converged runs: what they are worth, whom they judge, and that neither luck nor
an unresolved error reaches a level."""

import math
import pathlib
import sys
import unittest

import numpy as np
import pandas as pd

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from bench import accuracy, converged, recommend  # noqa: E402

STEPS = (4e-3, 2e-3, 1e-3)


def cell(part, formulation, step, end, seconds=1e-3, **more):
    return {
        "campaign": "accuracy",
        "part": part,
        "problem": "pile",
        "problem_family": "pile",
        "duration_s": 0.1,
        "effects": "contact",
        "formulation": formulation,
        "combination": f"{formulation} + lemke",
        "label": formulation,
        "formulation_options": "",
        "tol": 1e-9,
        "start": "cold",
        "step_s": step,
        "end_value": end,
        "end_quantity": "top.y",
        "err_ref": math.nan,
        "err_quantity": "",
        "err_source": "",
        "status": "ok",
        "good": True,
        "t_total_s": seconds,
        "t_total_s_low": seconds,
        "t_total_s_high": seconds,
        "noise": 1.05,
        "disturbed": "",
        "command": "lcpbench simulate pile",
    } | more


def judged(*cells):
    return accuracy.confirmed(converged.judge(pd.DataFrame(cells)))


def ladder(limit=1.0, slope=2.0, formulation="event"):
    return [cell("references", formulation, h, limit + slope * h) for h in STEPS]


class Limits(unittest.TestCase):
    def test_first_order_is_extrapolated_with_the_small_factor(self):
        value, uncertainty, order = converged.limit(STEPS, [1 + 2 * h for h in STEPS])
        self.assertEqual(value, 1.002)
        self.assertAlmostEqual(order, 1)
        self.assertAlmostEqual(uncertainty, 1.25 * 2e-3)
        self.assertGreater(uncertainty, abs(value - 1))

    def test_an_order_that_theory_does_not_give_is_not_trusted(self):
        _, uncertainty, order = converged.limit(STEPS, [1 + h**3 for h in STEPS])
        self.assertAlmostEqual(order, 3)
        self.assertAlmostEqual(uncertainty, 3 * 7e-9)
        _, slow, order = converged.limit(STEPS, [1 + h**0.25 for h in STEPS])
        self.assertAlmostEqual(slow, 3 / (math.sqrt(2) - 1) * abs(2e-3**0.25 - 1e-3**0.25))

    def test_a_ladder_to_and_fro_counts_its_largest_difference(self):
        _, uncertainty, order = converged.limit(STEPS, [1.03, 1.0, 1.01])
        self.assertTrue(math.isnan(order))
        self.assertAlmostEqual(uncertainty, 3 / (math.sqrt(2) - 1) * 0.03)

    def test_another_setting_that_ends_elsewhere_widens_it(self):
        other = [
            dict(c, combination="event:rtol=1e-3 + lemke", end_value=c["end_value"] + 0.5)
            for c in ladder()
        ]
        (found,) = converged.references(pd.DataFrame(ladder() + other)).values()
        self.assertEqual(found.runs, 6)
        self.assertAlmostEqual(found.uncertainty, 0.5)

    def test_runs_that_failed_or_are_too_few_give_none(self):
        self.assertEqual(converged.references(pd.DataFrame(ladder()[1:])), {})
        self.assertEqual(
            converged.references(
                pd.DataFrame([dict(c, good=c["step_s"] != 1e-3) for c in ladder()])
            ),
            {},
        )


class Judged(unittest.TestCase):
    def test_two_campaigns_with_one_ladder_give_what_one_gives(self):
        again = [{**one, "campaign": "crowded"} for one in ladder()]
        (one,) = converged.references(pd.DataFrame(ladder())).values()
        (two,) = converged.references(pd.DataFrame([*ladder(), *again])).values()
        self.assertEqual((one.value, one.uncertainty, one.runs), (two.value, two.uncertainty, 3))

    def test_others_are_measured_by_it_and_the_method_itself_is_not(self):
        cells = judged(
            *ladder(),
            cell("open", "velocity", 0.01, 1.1),
            cell("open", "event", 0.01, 1.1),
            cell("open", "velocity", 0.01, 1.1, duration_s=0.2),
        )
        error = cells["err_ref"].tolist()
        self.assertAlmostEqual(error[3], 1.1 - 1.002)
        self.assertTrue(np.isnan(error[:3] + error[4:]).all())
        self.assertEqual(cells["err_quantity"][3], "end top.y")
        self.assertIn("converged run: event + lemke", cells["err_source"][3])

    def test_a_ladder_that_gives_no_reference_is_told(self):
        short = judged(*ladder()[1:], cell("open", "velocity", 0.01, 1.1))
        (row,) = accuracy.references_table(short).rows
        self.assertEqual((row[0], row[2].text), ("pile", "no reference"))
        self.assertIn("2 of 2 runs verified: event + lemke", row[4])
        (row,) = accuracy.references_table(
            judged(*ladder(), cell("open", "velocity", 0.01, 1.1))
        ).rows
        self.assertEqual(row[2], "1.002")

    def test_a_closed_form_stays(self):
        cells = judged(*ladder(), cell("open", "velocity", 0.01, 1.1, err_ref=1e-5))
        self.assertEqual(cells["err_ref"][3], 1e-5)
        self.assertEqual(cells["err_floor"][3], converged.ROUNDING)

    def test_below_the_uncertainty_no_level_is_reached(self):
        cells = judged(
            *ladder(), cell("open", "velocity", 0.01, 1.002)
        )  # uncertainty 2.5e-3, error 0
        self.assertIsNone(accuracy.cheapest(cells, 2e-3))
        self.assertIsNotNone(accuracy.cheapest(cells, 3e-3))
        self.assertEqual(accuracy.level_cell(cells, 2e-3).text, "not resolved")
        self.assertIn("uncertain by 2.5e-03", recommend.why_not(cells, "err_ref", 2e-3))
        self.assertIn("not resolved", recommend.said(cells.iloc[3], "err_ref"))
        self.assertIn("not resolved", accuracy.spot(cells.iloc[3]))
        self.assertAlmostEqual(accuracy.drawn(cells.iloc[3:])[0], 1.25e-3)

    def test_unresolved_errors_are_equal_on_the_front(self):
        cells = judged(
            *ladder(),
            cell("open", "velocity", 0.01, 1.002, seconds=2.0),
            cell("open", "regularized", 0.01, 1.003, seconds=1.0),
        )
        self.assertEqual(accuracy.front(cells.iloc[3:]), [1])

    def test_times_whose_samples_overlap_are_ties(self):
        cells = judged(
            cell("open", "velocity", 0.01, 1.0, 1.0, err_ref=0.0),
            cell("open", "boxed", 0.01, 1.0, 1.2, err_ref=0.0),
            cell("open", "normal", 0.01, 1.0, 1.3, err_ref=0.0),
        )
        best = accuracy.cheapest(cells, 1e-3)
        self.assertEqual(accuracy.ties(cells, best, 1e-3), [])
        cells.loc[1, "t_total_s_low"] = 0.99
        self.assertEqual(accuracy.ties(cells, best, 1e-3), ["boxed + lemke"])

    def test_a_lucky_step_reaches_nothing_that_finer_ones_do_not_keep(self):
        cells = judged(
            *ladder(slope=1e-9),
            cell("open", "velocity", 0.04, 1.0, 1e-4),
            cell("open", "velocity", 0.02, 1.5, 2e-4),
            cell("open", "velocity", 0.01, 1.01, 4e-4),
        )
        self.assertEqual(accuracy.cheapest(cells, 0.1)["step_s"], 0.01)
        self.assertIsNone(accuracy.cheapest(cells, 1e-3))

    def test_the_uncertainty_is_drawn_where_it_matters(self):
        near = judged(
            *ladder(),
            cell("open", "velocity", 0.01, 1.004),
            cell("open", "velocity", 0.02, 1.1, 1e-4),
        )
        far = judged(
            *ladder(slope=1e-9),
            cell("open", "velocity", 0.01, 1.004),
            cell("open", "velocity", 0.02, 1.1, 1e-4),
        )
        bands = [
            [line.kind for line in accuracy.panel("pile", c.iloc[3:], {}).lines].count("band")
            for c in (near, far)
        ]
        self.assertEqual(bands, [1, 0])
        self.assertIn("± ", accuracy.panel("pile", far.iloc[3:], {}).xlabel)


if __name__ == "__main__":
    unittest.main()

"""The four readings of the headline on planted rows: a tie is a tie, a start and a tuned setting
can turn the order round, and nothing is left out."""

import pathlib
import sys
import unittest
from unittest import mock

import pandas as pd

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from bench import headline  # noqa: E402
from bench import rows as rows_  # noqa: E402

DEFAULTS = {("velocity", "facets=8"), ("coulomb", "")}


def row(form, options, cost, **more):
    return {
        "campaign": "accuracy",
        "part": "x",
        "problem": "slide",
        "problem_family": "slide",
        "formulation": form,
        "formulation_options": options,
        "solver": "lemke",
        "solver_options": "",
        "combination": rows_.combination(form, options, "lemke", ""),
        "tol": 1e-9,
        "step_s": 0.01,
        "start": "cold",
        "duration_s": 1.0,
        "effects": "",
        "command": "lcpbench simulate",
        "status": "ok",
        "t_total_s": cost,
        "t_total_s_low": cost,
        "t_total_s_high": cost,
        "noise": 1.05,
        "err_ref": 1e-3,
        "n_contacts": 4,
        "err_floor": 1e-12,
        **more,
    }


def cells(*rows):
    return pd.DataFrame(rows)


class Readings(unittest.TestCase):
    def setUp(self):
        patched = mock.patch.object(headline.settings, "declared", lambda: DEFAULTS)
        patched.start()
        self.addCleanup(patched.stop)
        self.rows = [
            row("velocity", "facets=8", 1.0),
            row("coulomb", "", 2.0),
            row("coulomb", "outer=9", 0.5),
            row("velocity", "facets=8", 0.9, start="previous"),
            row("coulomb", "", 0.1, start="previous"),
        ]

    def read(self, rows, start, setting):
        some = headline.accuracy.confirmed(cells(*rows))
        found = headline.read(headline.scenes_of(some, start, setting), 1e-2)
        return dict(found.alone), dict(found.tied)

    def test_each_reading_has_its_winner(self):
        self.assertEqual(self.read(self.rows, "cold", "default"), ({"velocity": 1}, {}))
        self.assertEqual(self.read(self.rows, "cold", "tuned"), ({"coulomb": 1}, {}))
        self.assertEqual(self.read(self.rows, "previous", "default"), ({"coulomb": 1}, {}))

    def test_a_tie_is_nobodys_win(self):
        close = [row("velocity", "facets=8", 1.0), row("coulomb", "", 1.04)]
        both = {"velocity": 1, "coulomb": 1}
        self.assertEqual(self.read(close, "cold", "default"), ({}, both))
        noisy = [{**r, "noise": 1.4} for r in self.rows]
        noisy[1].update(t_total_s=1.3, t_total_s_low=1.3, t_total_s_high=1.3)
        self.assertEqual(self.read(noisy, "cold", "default"), ({}, both))

    def test_a_loose_tolerance_is_no_default(self):
        loose = [
            row("velocity", "facets=8", 1.0),
            row("coulomb", "", 0.1, command="x --tol '1e-2'"),
        ]
        more = [row("coulomb", "", 2.0)]
        self.assertEqual(self.read(loose + more, "cold", "default")[0], {"velocity": 1})

    def test_every_reading_stands_in_the_table(self):
        """A start that was not measured says so; it is not left out."""
        made = headline.table(cells(*self.rows[:3]))
        self.assertEqual(len(made.rows), len(headline.LEVELS) * 4)
        unmeasured = [r for r in made.rows if r[1] == "previous step"]
        self.assertEqual({r[3].text for r in unmeasured}, {"not measured"})
        self.assertEqual({r[4] for r in unmeasured}, {""})

    def test_the_words_do_not_crown_who_leads_in_one_reading(self):
        said = headline.words(cells(*self.rows))
        self.assertIn("Nobody leads beyond the ties in all of the 4 measured", said)
        once = [r for r in self.rows if r["formulation_options"] == "facets=8"]
        slow = {"formulation": "coulomb", "formulation_options": "", "t_total_s": 9.0}
        other = [{**r, **slow, "t_total_s_low": 9.0} for r in once]
        said = headline.words(cells(*once, *other))
        self.assertIn("`velocity` leads in every reading", said)
        self.assertNotIn("lack its rival", said)  # both ran on the one scene

    def test_the_tries_of_the_tuned_readings_are_counted_on_a_scene(self):
        some = [row("coulomb", f"outer={k}", 0.5) for k in (1, 2)]
        some += [row("coulomb", f"outer={k}", 0.5, problem="roll") for k in (3, 4, 5)]
        some += [row("velocity", "facets=8", 1.0), row("velocity", "x", 1.0, status="unsupported")]
        said = headline.tries_words(cells(*some), "coulomb")
        self.assertIn("the best of up to 3 of its settings on a scene (`velocity` 1)", said)

    def test_a_win_without_its_rival_is_told(self):
        """Velocity alone ran on two of three scenes, and is slower on the third: it leads in what
        was run, and nowhere where both were asked."""
        some = [row("velocity", "facets=8", 3.0), row("coulomb", "", 2.0)]
        for scene in ("spin", "tip"):
            some += [row("velocity", "facets=8", c, problem=scene) for c in (1.0, 1.5)]
        said = headline.words(cells(*some))
        self.assertIn("`velocity` leads in the 2 of 4 measured readings at 0.01, of what", said)
        self.assertIn("all ran on 1 of 3, where the cheapest are `coulomb` 1", said)
        self.assertIn("there `coulomb` leads", said)
        self.assertNotIn("or more contacts", said)
        for r in some:
            r["n_contacts"] = 24 if r["problem"] == "tip" else 4
        said = headline.words(cells(*some))
        self.assertIn("all ran on 1 of 3 (0 of the 1 with 20 or more contacts)", said)

    def test_ties_could_turn_a_lead_round(self):
        def leader(alone, tied):
            Counter = headline.collections.Counter
            return headline.Reading(20, Counter(alone), Counter(tied)).leader()

        self.assertEqual(leader({"a": 10, "b": 4}, {"b": 5}), "a")
        self.assertIsNone(leader({"a": 10, "b": 4}, {"b": 6}))
        self.assertIsNone(leader({"a": 3}, {"a": 9, "c": 3}))
        self.assertIsNone(leader({}, {"a": 1, "b": 1}))

    def test_readings_that_were_not_measured_are_counted(self):
        said = headline.words(cells(row("velocity", "facets=8", 1.0), row("coulomb", "", 9.0)))
        self.assertIn("`velocity` leads in the 2 of 4 measured readings", said)

    def test_the_price_of_tuning_is_told(self):
        spent, gained = headline.price_of_tuning(
            headline.accuracy.confirmed(cells(*self.rows)), "cold", 1e-2
        )
        self.assertEqual((spent, gained), (5.0, 4.0))


if __name__ == "__main__":
    unittest.main()

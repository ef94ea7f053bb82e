"""The section of warm starts on planted rows: what is paired, what its judge must refuse."""

import math
import pathlib
import sys
import unittest

import pandas as pd

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from bench import warm  # noqa: E402
from bench.judges import EXCEPT, FAILS, HOLDS, UNMEASURED  # noqa: E402

BASE = {
    "campaign": "warmstart",
    "part": "few",
    "problem": "drop@f@s@0.01@100",
    "formulation": "",
    "solver": "lemke",
    "solver_options": "",
    "tol": math.nan,
    "start": "cold",
    "status": "ok",
    "good": True,
    "disturbed": "",
    "noise": 1.05,
    "n_iter": 100,
    "n_pivot": 100,
    "n_solves": 100,
    "t_total_s": 1.0,
    "active_change": 0.0,
    "regressions": math.nan,
    "regressions_time": math.nan,
    "p": 4,
}


def two(work, time, **more):
    """A cold cell, and the same from the last answer with its work and time."""
    last = {"start": "previous", "n_iter": work, "n_pivot": 0, "t_total_s": time}
    counts = {"regressions": 3, "regressions_time": 7}
    return [{**BASE, "n_pivot": 0, **more}, {**BASE, **last, **counts, **more}]


class Warm(unittest.TestCase):
    def word(self, cost, word, *rows, says=""):
        found = warm.saves(warm.pairs(pd.DataFrame([r for pair in rows for r in pair])), cost)
        self.assertIsNotNone(found)
        self.assertEqual(found.word, word, found.evidence)
        self.assertIn(says, found.evidence)

    def test_work_is_exact(self):
        self.word("work", HOLDS, two(99, 1), says="won 1")
        self.word("work", FAILS, two(100, 1), says="tied 1")
        self.word("work", FAILS, two(101, 1), says="lost 1")
        self.word("work", HOLDS, two(0, 1))

    def test_time_counts_beyond_the_noise(self):
        self.word("time", HOLDS, two(1, 0.9))
        self.word("time", FAILS, two(1, 0.97), says="tied 1")
        self.word("time", FAILS, two(1, 0.9, noise=1.2), says="tied 1")
        self.word("time", FAILS, two(1, 1.2), says="lost 1")

    def test_solvers_are_judged_one_by_one(self):
        """A hundred times faster with one, slower with the other: a mean would hold."""
        rows = (two(1, 0.01), two(1, 1.2, solver="pgs"))
        self.word("time", EXCEPT, *rows, says="pgs: 1.2 (1 pair), won 0, tied 0, lost 1")
        rows = (two(1, 0.5), two(1, 0.5, problem="b"), two(1, 1.2, problem="c"))
        self.word("time", EXCEPT, *rows, says="won 2, tied 0, lost 1")

    def test_a_start_that_fails_is_lost(self):
        cold, last = two(1, 0.1)
        self.word("time", FAILS, [cold, {**last, "good": False, "status": "max_iter"}])

    def test_nothing_is_compared_with_a_cold_failure(self):
        cold, last = two(1, 0.1)
        p = warm.pairs(pd.DataFrame([{**cold, "good": False, "status": "max_iter"}, last]))
        self.assertTrue(p.empty)
        self.assertEqual([v.word for _, v in warm.verdicts(p)], [UNMEASURED] * 2)

    def test_what_is_not_defined_is_no_pair(self):
        cold, last = two(1, 0.1)
        rows = [cold, {**last, "good": False, "status": "unsupported"}]
        self.assertTrue(warm.pairs(pd.DataFrame(rows)).empty)

    def test_other_rows_are_no_sequences(self):
        rows = [
            {**BASE, "start": "", "active_change": math.nan},
            {**BASE, "formulation": "f", "start": "previous", "active_change": math.nan},
            {**BASE, "active_change": math.nan},  # its process died: nothing was counted
        ]
        self.assertEqual(warm.of(pd.DataFrame(rows)).tolist(), [False, False, True])

    def test_the_table_tells_classes_and_shares(self):
        rows = two(10, 0.5) + two(20, 2.0, problem="b", active_change=0.2)
        (line,) = warm.table(warm.pairs(pd.DataFrame(rows))).rows
        told = [getattr(c, "text", c) for c in line]
        self.assertEqual(
            told, ["lemke", "previous", "2 of 2", "0.1", "", "0.2", "0.5", "", "2", "3.0%", "7.0%"]
        )
        self.assertIn("2 sequences with 200 problems", warm.section(pd.DataFrame(rows)).lead)


if __name__ == "__main__":
    unittest.main()

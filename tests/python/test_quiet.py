"""A test of the clock that fails is red on a quiet machine, and on a busy one inconclusive, with
the reason."""

import contextlib
import io
import itertools
import pathlib
import sys
import unittest
from unittest import mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
import quiet  # noqa: E402
from quiet import Canary  # noqa: E402

QUIET = Canary(0.99, 0.0100)


class Quiet(unittest.TestCase):
    def test_each_sign_of_a_busy_machine(self):
        for before, after, others, late, why in (
            (QUIET, QUIET, 0.0, 0.0, ""),
            (QUIET, Canary(0.95, 0.0105), 0.1, 0.05, ""),
            (Canary(0.4, 0.0100), QUIET, 0.0, 0.0, "40 % of a core"),
            (QUIET, Canary(0.4, 0.0100), 0.0, 0.0, "40 % of a core"),
            (QUIET, Canary(0.99, 0.0125), 0.0, 0.0, "1.25 times as fast"),
            (QUIET, QUIET, 0.5, 0.0, "others took 50 %"),
            (QUIET, QUIET, 0.0, 2.0, "stood still for 2.00 s"),
        ):
            found = quiet.why_busy(before, after, others, late)
            self.assertIn(why, found)
            self.assertEqual(found == "", why == "")

    def ends(self, after: Canary, code: int) -> tuple[int, str]:
        said = io.StringIO()
        with (
            mock.patch.object(quiet, "canary", side_effect=[QUIET, after]),
            mock.patch.object(quiet, "busy_s", return_value=1.0),
            contextlib.redirect_stdout(said),
        ):
            return quiet.main([sys.executable, "-c", f"raise SystemExit({code})"]), said.getvalue()

    def test_a_failure_is_red_where_it_was_quiet(self):
        self.assertEqual(self.ends(QUIET, 1)[0], 1)
        self.assertEqual(self.ends(QUIET, 0)[0], 0)

    def test_a_failure_is_inconclusive_where_it_was_busy(self):
        busy = Canary(0.5, 0.0100)
        code, said = self.ends(busy, 1)
        self.assertEqual(code, 77)
        self.assertRegex(said, r"(?m)^inconclusive: .*50 % of a core$")
        self.assertEqual(self.ends(busy, 0)[0], 0)

    def test_the_machine_is_measured(self):
        canary = quiet.canary()
        self.assertTrue(0 < canary.share <= 1 and canary.cpu_s > 0, canary)
        before = quiet.busy_s()
        quiet.canary()
        self.assertGreater(quiet.busy_s() + 1, before)

    def test_a_machine_that_stands_still_is_seen(self):
        """The clock as after a pause of the machine: it goes on by two seconds at once."""
        clock = itertools.chain([0.0], itertools.repeat(2.0 + quiet.NAP_S))
        with mock.patch.object(quiet.time, "monotonic", side_effect=clock):
            sleeper = quiet.Sleeper()
            sleeper.start()
            self.assertAlmostEqual(sleeper.end(), 2.0)


if __name__ == "__main__":
    unittest.main()

"""What limits the error, on planted surfaces: the knob that raises it most, and none where nothing
does."""

import itertools
import pathlib
import sys
import unittest

import pandas as pd

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from bench import surface  # noqa: E402


def rows(error, **more):
    """A grid of two steps, two tolerances, and two values of an option."""
    return pd.DataFrame(
        [
            {
                "part": surface.PART,
                "problem": "slide",
                "formulation": "velocity",
                "formulation_options": f"facets={facets}",
                "step_s": h,
                "tol": tol,
                "good": True,
                "err_ref": error(h, tol, facets),
                "err_floor": 1e-12,
                "err_quantity": "x",
                "t_total_s": 1e-3 / h,
                "disturbed": "",
                **more,
            }
            for h, tol, facets in itertools.product((0.01, 0.001), (1e-2, 1e-6), (4, 16))
        ]
    )


class Surfaces(unittest.TestCase):
    def limit(self, error):
        (found,) = surface.surfaces(rows(error))
        return found.limit().name if found.limit() else ""

    def test_the_knob_that_raises_the_error_most_limits_it(self):
        self.assertEqual(self.limit(lambda h, tol, facets: h + 1e-4 * tol + 1e-5 / facets), "step")
        self.assertEqual(self.limit(lambda h, tol, facets: 1e-5 * h + tol), "tolerance")
        self.assertEqual(self.limit(lambda h, tol, facets: 1e-5 * h + 1 / facets), "facets")

    def test_nothing_limits_what_is_right_already(self):
        self.assertEqual(self.limit(lambda h, tol, facets: 1e-9 * h), "")
        self.assertEqual(self.limit(lambda h, tol, facets: 0.1), "")
        self.assertIn(
            "by none of these in 1", surface.message(surface.surfaces(rows(lambda *_: 0.1)))
        )

    def test_time_is_told_beside_the_error(self):
        (found,) = surface.surfaces(rows(lambda h, tol, facets: h))
        step = next(k for k in found.knobs if k.name == "step")
        self.assertAlmostEqual(step.error, 10)
        self.assertAlmostEqual(step.time, 10)

    def test_without_its_finest_corner_a_surface_says_nothing(self):
        some = rows(lambda h, tol, facets: h)
        fine = (some["step_s"] == 0.001) & (some["tol"] == 1e-6)
        self.assertEqual(surface.surfaces(some.assign(good=~fine)), [])
        self.assertEqual(surface.surfaces(some.assign(part="steps")), [])


if __name__ == "__main__":
    unittest.main()

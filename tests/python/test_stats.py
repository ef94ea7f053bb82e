"""Statistics helpers against examples that can be checked by hand."""

import math
import pathlib
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from bench import stats  # noqa: E402

INF = math.inf


class Median(unittest.TestCase):
    def test_interval_of_few_samples_is_the_range(self):
        self.assertEqual(stats.median_interval([3, 1, 2]), (2, 1, 3))

    def test_interval_of_ten_samples_leaves_out_one_on_each_side(self):
        # P(Binomial(10, 1/2) <= 1) = 11/1024 = 1.1 % <= 2.5 %, <= 2: 5.5 %: the 2nd and the 9th
        # value
        self.assertEqual(stats.median_interval(range(1, 11)), (5.5, 2, 9))

    def test_nothing_measured_is_nan_not_zero(self):
        self.assertTrue(all(math.isnan(v) for v in stats.median_interval([])))


class Profiles(unittest.TestCase):
    cost = np.array([[1.0, 2.0], [4.0, 1.0], [INF, 3.0], [INF, INF]])

    def test_failures_stay_in_the_denominator(self):
        p = stats.relative_profile(self.cost, [1, 2, 4, 1e9])
        self.assertEqual(p[:, 0].tolist(), [0.25, 0.25, 0.5, 0.5])
        self.assertEqual(p[:, 1].tolist(), [0.5, 0.75, 0.75, 0.75])

    def test_ties_within_the_noise_floor_are_wins_for_both(self):
        p = stats.relative_profile([[1.0, 1.03]], [1.0], noise=1.05)
        self.assertEqual(p.tolist(), [[1.0, 1.0]])
        p = stats.relative_profile([[1.0, 1.03]], [1.0], noise=1.0)
        self.assertEqual(p.tolist(), [[1.0, 0.0]])

    def test_zero_times_tie(self):
        self.assertEqual(stats.ratios([[0.0, 0.0, 1.0]]).tolist(), [[1.0, 1.0, INF]])

    def test_all_fail(self):
        self.assertEqual(stats.relative_profile([[INF, INF]], [1, 1e9]).tolist(), [[0, 0], [0, 0]])

    def test_a_single_solver_reaches_its_solve_rate_at_one(self):
        self.assertEqual(stats.relative_profile([[1.0], [INF]], [1.0]).tolist(), [[0.5]])

    def test_absolute_profile_ignores_the_others(self):
        both = stats.absolute_profile(self.cost, [1, 3])[:, 0]
        alone = stats.absolute_profile(self.cost[:, :1], [1, 3])[:, 0]
        self.assertEqual(both.tolist(), alone.tolist())

    def test_band_contains_the_profile_and_repeats(self):
        rng = np.random.default_rng(1)
        cost = rng.lognormal(size=(40, 2))
        families = np.repeat(np.arange(10), 4)
        profile = lambda c: stats.relative_profile(c, [1, 2, 4])  # noqa: E731
        low, high = stats.profile_band(profile, cost, families)
        mid = profile(cost)
        self.assertTrue(np.all(low <= mid) and np.all(mid <= high))
        self.assertTrue(np.array_equal(low, stats.profile_band(profile, cost, families)[0]))

    def test_band_of_one_family_has_no_width(self):
        low, high = stats.profile_band(lambda c: stats.relative_profile(c, [1]), self.cost, [0] * 4)
        self.assertTrue(np.array_equal(low, high))


class Front(unittest.TestCase):
    def test_keeps_what_nothing_beats(self):
        error, time = [1e-1, 1e-2, 1e-2, 1e-3, INF], [1, 2, 3, 5, 0.1]
        self.assertEqual(stats.pareto_front(error, time), [0, 1, 3])

    def test_equal_time_keeps_the_smaller_error(self):
        self.assertEqual(stats.pareto_front([2, 1], [1, 1]), [1])


class Fits(unittest.TestCase):
    def test_exact_power_law(self):
        n = np.array([10, 20, 40, 80])
        b, low, high, a = stats.fit_exponent(n, 3.0 * n**1.5)
        self.assertAlmostEqual(b, 1.5)
        self.assertAlmostEqual(a, 3.0)
        self.assertAlmostEqual(low, 1.5)
        self.assertAlmostEqual(high, 1.5)

    def test_two_sizes_fit_nothing(self):
        self.assertTrue(math.isnan(stats.fit_exponent([1, 2], [1, 2])[0]))

    def test_order_of_a_ladder(self):
        self.assertAlmostEqual(
            stats.observed_order([0.1, 0.05, 0.025], [1e-2, 2.5e-3, 6.25e-4]), 2.0
        )

    def test_paired_ratio_leaves_failures_out_and_counts_pairs(self):
        ratio, low, high, pairs = stats.paired_ratio([2, 4, INF], [1, 2, 1])
        self.assertAlmostEqual(ratio, 2.0)
        self.assertAlmostEqual(low, 2.0)
        self.assertAlmostEqual(high, 2.0)
        self.assertEqual(pairs, 2)


class Means(unittest.TestCase):
    def test_shifted_geometric_mean(self):
        self.assertAlmostEqual(stats.geometric_mean_shifted([1, 4], 0), 2.0)
        self.assertAlmostEqual(stats.geometric_mean_shifted([0, 3], 1), 1.0)

    def test_failure_is_infinite_or_the_stated_penalty(self):
        self.assertEqual(stats.geometric_mean_shifted([1, INF], 0), INF)
        self.assertAlmostEqual(
            stats.geometric_mean_shifted([1, INF], 0, limit=10, penalty=10), 10.0
        )


if __name__ == "__main__":
    unittest.main()

"""Statistics of benchmark rows: medians with intervals, profiles, Pareto fronts, fitted exponents.

A failure is an infinite cost: it stays in every denominator and never gets a time (PAR-k penalties
are applied only where a function says so). Random draws come from a fixed seed, so that every
number repeats.
"""

import itertools
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

SEED = 20240229
LEVEL = 0.95


def median_interval(x: ArrayLike, level: float = LEVEL) -> tuple[float, float, float]:
    """Median with its order-statistic interval (binomial, distribution-free): (median, low, high).

    With fewer than 6 samples no interval of 95 % exists; the range is given instead.
    """
    x = np.sort(np.asarray(x, float))
    x = x[np.isfinite(x)]
    n = len(x)
    if n == 0:
        return math.nan, math.nan, math.nan
    k = -1  # largest k with P(Binomial(n, 1/2) <= k) <= (1 - level) / 2
    total = 0.0
    for i in range(n // 2):
        total += math.comb(n, i) / 2.0**n
        if total > (1 - level) / 2:
            break
        k = i
    low, high = (x[k], x[n - 1 - k]) if k >= 0 else (x[0], x[-1])
    return float(np.median(x)), float(low), float(high)


def geometric_mean_shifted(
    cost: ArrayLike, shift: float, limit: float | None = None, penalty: float = 10.0
) -> float:
    """exp(mean(log(cost + shift))) - shift; a failure (inf) costs penalty * limit (PAR-k), inf
    without a limit."""
    cost = np.asarray(cost, float)
    if limit is not None:
        cost = np.where(np.isfinite(cost), cost, penalty * limit)
    if len(cost) == 0:
        return math.nan
    if not np.all(np.isfinite(cost)):
        return math.inf
    return float(np.exp(np.mean(np.log(cost + shift))) - shift)


def ratios(cost: ArrayLike) -> np.ndarray:
    """cost[problem, solver] -> ratio to the best solver of each problem; inf where a solver
    failed."""
    cost = np.asarray(cost, float)
    best = np.min(cost, axis=1, keepdims=True)
    out = np.full(cost.shape, math.inf)
    good = np.isfinite(cost)
    zero = (best == 0) & good  # a cost below the clock's resolution
    np.divide(cost, best, out=out, where=good & ~zero)
    out[zero & (cost == 0)] = 1.0
    return out


def relative_profile(cost: ArrayLike, tau: ArrayLike, noise: float = 1.0) -> np.ndarray:
    """Dolan & More (2002): share of all problems that solver s solves within tau times the best.

    cost[problem, solver], inf = failure; tau >= 1. Ratios up to `noise` count as ties, so the value
    at tau = 1 is the share of wins with ties. Problems nobody solved stay in the denominator.
    Returns [len(tau), solver].
    """
    r = ratios(cost)
    r = np.where(r <= noise, 1.0, r)
    return np.mean(r[None, :, :] <= np.asarray(tau, float)[:, None, None], axis=1)


def absolute_profile(cost: ArrayLike, t: ArrayLike) -> np.ndarray:
    """Share of all problems solved within t: does not change when a solver joins. Returns [len(t),
    solver]."""
    cost = np.asarray(cost, float)
    return np.mean(cost[None, :, :] <= np.asarray(t, float)[:, None, None], axis=1)


def profile_band(
    profile: Callable[[np.ndarray], np.ndarray],
    cost: ArrayLike,
    families: ArrayLike,
    draws: int = 400,
    level: float = LEVEL,
) -> tuple[np.ndarray, np.ndarray]:
    """Bootstrap band of profile(cost) by resampling whole families (rows of one family are not
    independent)."""
    rng = np.random.default_rng(SEED)
    families = np.asarray(families)
    names = sorted(set(families.tolist()))
    members = [np.flatnonzero(families == f) for f in names]
    samples = []
    for _ in range(draws):
        picked = np.concatenate([members[i] for i in rng.integers(len(names), size=len(names))])
        samples.append(profile(np.asarray(cost)[picked]))
    tail = (1 - level) / 2
    return np.quantile(samples, tail, axis=0), np.quantile(samples, 1 - tail, axis=0)


def pareto_front(error: ArrayLike, time: ArrayLike) -> list[int]:
    """Indices of the points that no other point beats in both error and time, by falling error."""
    error, time = np.asarray(error, float), np.asarray(time, float)
    front, best = [], math.inf
    for i in sorted(range(len(error)), key=lambda i: (time[i], error[i])):
        if math.isfinite(time[i]) and math.isfinite(error[i]) and error[i] < best:
            front.append(i)
            best = error[i]
    return front


def fit_exponent(
    n: ArrayLike, cost: ArrayLike, level: float = LEVEL, draws: int = 2000
) -> tuple[float, float, float, float]:
    """cost ~ a n^b by least squares in logarithms: (b, low, high, a). Interval: pairs bootstrap.

    Needs three distinct sizes; otherwise all NaN.
    """
    n, cost = np.asarray(n, float), np.asarray(cost, float)
    keep = np.isfinite(n) & np.isfinite(cost) & (n > 0) & (cost > 0)
    x, y = np.log(n[keep]), np.log(cost[keep])
    if len(set(x.tolist())) < 3:
        return (math.nan,) * 4

    def slope(x: np.ndarray, y: np.ndarray):
        dx = x - np.mean(x)
        return np.sum(dx * (y - np.mean(y))) / np.sum(dx * dx)

    b = slope(x, y)
    a = math.exp(np.mean(y) - b * np.mean(x))
    rng = np.random.default_rng(SEED)
    found = []
    for _ in range(draws):
        i = rng.integers(len(x), size=len(x))
        if len(set(x[i].tolist())) > 1:
            found.append(slope(x[i], y[i]))
    tail = (1 - level) / 2
    return float(b), float(np.quantile(found, tail)), float(np.quantile(found, 1 - tail)), a


def observed_order(h: ArrayLike, error: ArrayLike) -> float:
    """Order p of error ~ h^p from a ladder of steps (median of the successive slopes); NaN with
    fewer than two."""
    pairs = sorted(
        (float(a), float(b))
        for a, b in zip(h, error, strict=True)
        if a > 0 and b > 0 and math.isfinite(b)
    )
    slopes = [
        math.log(e1 / e0) / math.log(h1 / h0)
        for (h0, e0), (h1, e1) in itertools.pairwise(pairs)
        if h1 > h0
    ]
    return float(np.median(slopes)) if slopes else math.nan


LEAST_ORDER = 0.5  # half of the formal order of time stepping


def tail_order(h: ArrayLike, error: ArrayLike, floor: float = 1e-12) -> tuple[str, float]:
    """What the finest three steps of a ladder say: ("converges", the lower of their two slopes),
    ("exact", inf) where all three are below `floor`, ("plateau", slope) where the error no longer
    falls, ("grows", slope) where it rises; ("short", nan) with fewer than three steps.

    Coarser steps do not count: an error that fell at first and stands now does not converge.
    """
    ladder = sorted(zip(map(float, h), map(float, error), strict=True))[:3]
    if len(ladder) < 3 or len({step for step, _ in ladder}) < 3:
        return "short", math.nan
    if all(e <= floor for _, e in ladder):
        return "exact", math.inf
    slopes = [
        math.log(max(e1, floor) / max(e0, floor)) / math.log(h1 / h0)
        for (h0, e0), (h1, e1) in itertools.pairwise(ladder)
    ]
    least = min(slopes)
    if least >= LEAST_ORDER:
        return "converges", least
    return ("grows" if slopes[0] < -LEAST_ORDER else "plateau"), least


def paired_ratio(
    a: ArrayLike, b: ArrayLike, draws: int = 2000, level: float = LEVEL
) -> tuple[float, float, float, int]:
    """Geometric mean of a/b over pairs solved by both, with its bootstrap interval: (ratio, low,
    high, pairs)."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    keep = np.isfinite(a) & np.isfinite(b) & (a > 0) & (b > 0)
    r = np.log(a[keep] / b[keep])
    if len(r) == 0:
        return math.nan, math.nan, math.nan, 0
    rng = np.random.default_rng(SEED)
    means = np.mean(r[rng.integers(len(r), size=(draws, len(r)))], axis=1)
    tail = (1 - level) / 2
    low, high = np.quantile(means, [tail, 1 - tail])
    return float(np.exp(np.mean(r))), float(np.exp(low)), float(np.exp(high)), int(len(r))

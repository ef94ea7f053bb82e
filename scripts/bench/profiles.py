"""Performance profiles of cells as tables; knows nothing of figures, so that who imports it keeps
his own."""

import numpy as np
import pandas as pd

from bench import stats

NOISE = 1.05  # ratio of times that counts as a tie when the machine's own noise floor is not known
FACTORS = (1.0, 2.0, 5.0, 10.0)  # of the best time, that a table has


def matrix(
    cells: pd.DataFrame, column: str = "cost"
) -> tuple[np.ndarray, list[str], list[str], list[str]]:
    """Problems x solvers: median time of a verified answer, inf otherwise, also where a combination
    is not defined. Returns cost, problems, families, solvers."""
    solvers = sorted(cells["combination"].unique())
    key = [
        f"{problem}|{step:.17g}"
        for problem, step in zip(cells["problem"], cells["step_s"].astype(float), strict=True)
    ]  # no step: nan, like any other
    problems = sorted(set(key))
    at = {p: i for i, p in enumerate(problems)}
    cost = np.full((len(problems), len(solvers)), np.inf)
    families = [""] * len(problems)
    for k, family, combo, value, good in zip(
        key,
        cells["problem_family"],
        cells["combination"],
        cells[column],
        cells["good"],
        strict=True,
    ):
        families[at[k]] = family
        if good and np.isfinite(value):
            cost[at[k], solvers.index(combo)] = value
    return cost, problems, families, solvers


def shares(cells: pd.DataFrame, noise: float, factors: tuple[float, ...] = FACTORS) -> pd.DataFrame:
    """One line a solver: problems, those that it was asked (that have a row of it), solved, share
    of all problems within each factor of the best time (within_2). A failure, and a combination
    that is not defined or was not asked, counts as not solved."""
    cost, problems, _, solvers = matrix(cells)
    within = stats.relative_profile(cost, np.array(factors, dtype=float), noise)
    table = pd.DataFrame({"solver": solvers, "problems": len(problems)})
    asked = cells.drop_duplicates(["problem", "step_s", "combination"])["combination"]
    table["asked"] = table["solver"].map(asked.value_counts())
    table["solved"] = np.isfinite(cost).sum(axis=0)
    for k, factor in enumerate(factors):
        table[f"within_{factor:g}"] = within[k]
    first = f"within_{factors[0]:g}"
    return table.sort_values(
        ["solved", first, "solver"], ascending=[False, False, True], ignore_index=True
    )

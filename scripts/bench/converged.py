"""References where theory has no closed form: a run of another method, refined until it agrees with
itself, and how far it does not.

Rows of a part whose name begins with `references` give the value of the scene's first observed
quantity at the end of the run (column end_value). The finest of a ladder of steps is the reference;
its uncertainty is the grid convergence index as Oberkampf & Roy (2010, Verification and Validation
in Scientific Computing, ch. 8) use it: Fs/(r^p - 1) times the last difference, with Fs = 1.25 where
the observed order p is the formal one (1, of time stepping) to a tenth, and Fs = 3 with p held
between 1/2 and 1 elsewhere; where the ladder does not even go one way, the difference is the
largest along it. Where the part has several settings, the least uncertain gives the value, and its
uncertainty covers the others.
"""

import dataclasses
import math
from collections.abc import Iterable

import numpy as np
import pandas as pd

PART = "references"
# closed forms and integrations are right to about this; also what is left of a run of exact answers
ROUNDING = 1e-12
FORMAL = 1.0
SAFE, SAFER = 1.25, 3.0
LEAST = 3  # steps of a ladder


@dataclasses.dataclass
class Reference:
    problem: str
    quantity: str
    value: float
    uncertainty: float
    formulation: str
    combination: str
    step: float  # the finest
    order: float  # observed; nan: the ladder does not go one way
    runs: int

    def source(self) -> str:
        return f"converged run: {self.combination}, h = {self.step:g} s"


Key = tuple[str, float, str]  # problem, duration [s], effects


def key(cells: pd.DataFrame) -> list[Key]:
    """What must be the same for two runs to end with the same value: everything but the method."""
    return list(
        zip(
            cells["problem"],
            cells["duration_s"].astype(float).round(12),
            cells["effects"],
            strict=True,
        )
    )


def limit(steps: Iterable[float], values: Iterable[float]) -> tuple[float, float, float]:
    """(value, uncertainty, observed order) of a ladder of at least three steps; the finest three
    count."""
    (h1, f1), (h2, f2), (h3, f3) = sorted(zip(steps, values, strict=True))[:LEAST]
    near, far = f2 - f1, f3 - f2
    order = math.nan
    if near * far > 0 and math.isclose(h3 / h2, h2 / h1, rel_tol=1e-6):
        order = math.log(far / near) / math.log(h2 / h1)
    asymptotic = abs(order - FORMAL) <= 0.1 * FORMAL
    held = FORMAL if asymptotic else min(max(order, 0.5), FORMAL) if math.isfinite(order) else 0.5
    difference = abs(near) if math.isfinite(order) else max(abs(near), abs(far), abs(f3 - f1))
    uncertainty = (SAFE if asymptotic else SAFER) / ((h2 / h1) ** held - 1) * difference
    return f1, max(uncertainty, ROUNDING * max(1.0, abs(f1))), order


def references(cells: pd.DataFrame) -> dict[Key, Reference]:
    """key -> Reference, from the verified rows of the parts of references."""
    some = cells[cells["part"].str.startswith(PART) & cells["good"] & cells["end_value"].notna()]
    out = {}
    for at, group in some.assign(key=key(some)).groupby("key"):
        found = []
        for combination, runs in group.groupby("combination"):
            ladder = runs.drop_duplicates("step_s")  # of two campaigns the same
            if ladder["step_s"].nunique() >= LEAST:
                value, uncertainty, order = limit(ladder["step_s"], ladder["end_value"])
                first = ladder.iloc[0]
                found.append(
                    Reference(
                        at[0],
                        first["end_quantity"],
                        value,
                        uncertainty,
                        first["formulation"],
                        combination,
                        ladder["step_s"].min(),
                        order,
                        len(ladder),
                    )
                )
        if found:
            best = min(found, key=lambda r: (r.uncertainty, r.combination))
            best.uncertainty = max([best.uncertainty] + [abs(r.value - best.value) for r in found])
            best.runs = sum(r.runs for r in found)
            out[at] = best
    return out


def judge(cells: pd.DataFrame) -> pd.DataFrame:
    """Every cell with the uncertainty of what it is measured by (`err_floor`); cells of scenes
    without a closed form with the error against their reference. The formulation that gives the
    reference is not judged by it."""
    cells = cells.assign(
        err_floor=np.where(cells["err_ref"].notna(), ROUNDING, np.nan), converged=False
    )
    known = references(cells)
    for i, at, formulation in zip(cells.index, key(cells), cells["formulation"], strict=True):
        found = known.get(at)
        ended = np.isfinite(cells.at[i, "end_value"]) and not cells.at[i, "part"].startswith(PART)
        if (
            found
            and ended
            and formulation != found.formulation
            and not np.isfinite(cells.at[i, "err_ref"])
        ):
            cells.loc[i, ["err_ref", "err_floor", "converged"]] = (
                abs(cells.at[i, "end_value"] - found.value),
                found.uncertainty,
                True,
            )
            cells.loc[i, ["err_quantity", "err_source"]] = f"end {found.quantity}", found.source()
    return cells

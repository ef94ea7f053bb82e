"""One setting for each formulation, and one start: what a comparison of formulations needs, since
the best of six settings against the one of another compares how much was tried."""

import pandas as pd

from bench import experiments, registry

STARTS = {"cold": "cold", "previous": "previous step"}


def declared() -> set[tuple[str, str]]:
    """(formulation, options): the one default setting of each."""
    return {
        tuple((entry["formulation"] + ":").split(":")[:2])
        for entry in experiments.of("headline.defaults")
    }


def among(cells: pd.DataFrame, known: set[tuple[str, str]]) -> pd.DataFrame:
    keys = zip(cells["formulation"], cells["formulation_options"], strict=True)
    return cells[pd.Series([key in known for key in keys], index=cells.index, dtype=bool)]


def plain(cells: pd.DataFrame) -> pd.DataFrame:
    """Any solver without options of its own, at its own tolerance."""
    loose = cells["command"].str.contains("--tol ", regex=False)
    return cells[(cells["solver_options"] == "") & ~loose]


def started(cells: pd.DataFrame, start: str) -> pd.DataFrame:
    """Cells of a start; what poses no problems to a solver has none, and counts in both."""
    alone = ~cells["formulation"].map(registry.uses_solver)
    return cells[alone | (cells["start"] == start)]


def measured(cells: pd.DataFrame) -> list[str]:
    return [start for start in STARTS if (cells["start"] == start).any()]


def one_each(cells: pd.DataFrame) -> pd.DataFrame:
    """The declared setting of each formulation; of one that these rows do not have in it, the
    setting that was run on most problems."""
    some = plain(cells)
    found = among(some, declared())
    other = some[~some["formulation"].isin(set(found["formulation"]))]
    if other.empty:
        return found
    ran = other.groupby(["formulation", "formulation_options"])["problem"].nunique()
    most = {key for _, g in ran.groupby(level=0) for key in [g.idxmax()]}
    return pd.concat([found, among(other, most)]).sort_index()

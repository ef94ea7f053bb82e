"""Scenes of many contacts that move, every step from the last one: which formulation solves each of
them with any of its solvers, and what a step takes. The answers of the accuracy campaign come from
small scenes; this is the table that could turn them round."""

import collections
import dataclasses

import pandas as pd

from bench import registry, rows
from bench.section import Cell, Section, Table, error, si

OWN = "moving"
SETTING = ["problem", "step_s", "duration_s"]


def named(some: pd.DataFrame) -> pd.DataFrame:
    """Column `asked`: the formulation with its options, as it was asked for."""
    options = some["formulation_options"].map(lambda text: f":{text}" if text else "")
    return some.assign(asked=some["formulation"] + options)


def own(cells: pd.DataFrame) -> pd.DataFrame:
    """The cells of the campaign that were defined, each with its formulation as it was asked for (a
    process that was killed tells no more of it)."""
    some = cells[
        cells["campaign"].str.startswith(OWN) & ~cells["status"].isin(["unsupported", "skipped"])
    ]
    return named(some)


def scene(problem: str) -> str:
    """A scene of a file is named by the file."""
    return problem.rsplit("/", 1)[-1].removesuffix(".json")


def names_of(some: pd.DataFrame) -> list[str]:
    """The formulations that were asked, in the order of the registry."""
    first = dict(zip(some["asked"], some["formulation"], strict=True))
    order = registry.by_formulation(set(first.values()))
    return sorted(first, key=lambda name: (order.index(first[name]), name))


def fastest(g: pd.DataFrame) -> pd.Series | None:
    """The solved cell that takes least time; None where no solver solved every step."""
    good = g[g["good"]]
    return None if good.empty else good.loc[good["t_total_step_s"].idxmin()]


def told(g: pd.DataFrame, leads: bool) -> Cell:
    """What a step takes, by whom, and what is left of the exact Coulomb problem; where nobody
    solves every step, how each ended."""
    if g.empty:
        return Cell("not asked", "none")
    first = fastest(g)
    if first is None:
        ends = [f"{s} {w}" for s, w in zip(g["solver"], g["status"], strict=True)]
        return Cell("not solved: " + ", ".join(ends), "bad")
    took = first["t_total_step_s"]
    left = first["res_ncp_rel"]
    off = f", {error(left)}" if left > EXACT else ""
    return Cell(f"{si(took, 's')} by {first['solver']}{off}", "good" if leads else "", sort=took)


@dataclasses.dataclass
class Case:
    """A scene, for how long and by which steps, and who was asked."""

    scene: str
    contacts: float
    step: float  # s
    end: float  # s
    by: dict[str, pd.DataFrame]  # formulation: its cells


def grid(cells: pd.DataFrame) -> list[Case]:
    """By their contacts."""
    some = own(cells)
    names = names_of(some)
    some = some.assign(contacts=rows.sizes(some, SETTING))
    found = [
        Case(
            scene(problem),
            float(g["contacts"].max()),
            step,
            end,
            {name: g[g["asked"] == name] for name in names},
        )
        for (problem, step, end), g in some.groupby(SETTING)
    ]
    return sorted(found, key=lambda c: (c.contacts, c.scene, c.end, -c.step))


def best_of(by: dict[str, pd.DataFrame]) -> dict[str, pd.Series]:
    """{formulation: its fastest cell} of those that solve every step."""
    first = {name: fastest(g) for name, g in by.items()}
    return {name: cell for name, cell in first.items() if cell is not None}


def ties(by: dict[str, pd.DataFrame]) -> list[str]:
    """Formulations that nobody can tell from the fastest (rows.tied), the fastest first."""
    found = best_of(by)
    order = sorted(found, key=lambda name: found[name]["t_total_step_s"])
    return [n for n in order if rows.tied(found[n], found[order[0]], "t_total_step_s")]


EXACT = 1e-2  # residual of the exact Coulomb problem, relative, that a good answer stays below


def exact(by: dict[str, pd.DataFrame]) -> dict[str, pd.DataFrame]:
    """The cells of which each step keeps Coulomb's law as well as that."""
    return {name: g[~(g["res_ncp_rel"] > EXACT)] for name, g in by.items()}


def table(cells: pd.DataFrame) -> Table | None:
    found = grid(cells)
    if not found:
        return None
    names = list(found[0].by)
    body = []
    for c in found:
        first = ties(c.by)
        setting = [f"{1e3 * c.step:g}", f"{c.end:g}"]
        body.append(
            [c.scene, f"{c.contacts:.0f}", *setting, *(told(c.by[n], n in first) for n in names)]
        )
    return Table(
        "moving",
        "Time of a step by the fastest solver of each formulation that solves and verifies every"
        " step; the step is the same for all of a row, and each begins from the last one. A scene"
        " that stands twice has another duration or step, and other limits of time: see their"
        " campaigns. Behind the solver stands what its answers leave of the exact Coulomb problem,"
        f" where that is more than {EXACT:g} (relative).",
        ["scene", "contacts", "step [ms]", "to [s]", *names],
        body,
    )


def won_words(firsts: list[list[str]], names: list[str], mark: str) -> str:
    """On how many settings each is fastest, alone or tied."""
    alone, tied = collections.Counter(), collections.Counter()
    for first in firsts:
        (alone if len(first) == 1 else tied).update(first)
    said = ", ".join(
        f"{mark}{n}{mark} on {alone[n]}" + (f" and {tied[n]} tied" if tied[n] else "")
        for n in names
        if alone[n] or tied[n]
    )
    return said or "none"


def words(cells: pd.DataFrame, mark: str = "") -> str:
    """Who solves every scene, and who is fastest on how many; mark: what names stand in."""
    found = grid(cells)
    names = list(found[0].by)
    solved = {n: sum(fastest(c.by[n]) is not None for c in found) for n in names}
    won = won_words([ties(c.by) for c in found], names, mark)
    kept = [exact(c.by) for c in found]
    good = won_words([ties(by) for by in kept], names, mark)
    keep = ", ".join(
        f"{mark}{n}{mark} {sum(fastest(by[n]) is not None for by in kept)}" for n in names
    )
    low, high = found[0].contacts, found[-1].contacts
    n = len({c.scene for c in found})
    scenes = f"{n} scene{'s' * (n > 1)}"
    settings = f", {len(found)} settings" if len(found) > n else ""
    counts = ", ".join(f"{mark}{n}{mark} {solved[n]}" for n in names)
    return (
        f"Where {low:.0f} to {high:.0f} contacts move ({scenes}{settings}), every step from the"
        f" last one: {'settings' if settings else 'scenes'} of which each step is solved and"
        f" verified: {counts}."
        f" The fastest: {won}. These are equal steps and no equal errors: of what leaves at most"
        f" {EXACT:g} of the exact Coulomb problem ({keep}) the fastest are {good}."
    )


def section(cells: pd.DataFrame) -> Section | None:
    made = table(cells)
    if made is None:
        return None
    return Section("moving", "Where many contacts move", words(cells), [], [made])

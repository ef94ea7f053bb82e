"""Error against time where many contacts carry, every formulation on every scene: what the headline
of the small scenes leaves open, for there not each formulation was run on the larger ones."""

import collections
import dataclasses

import pandas as pd

from bench import accuracy, converged, moving, settings
from bench import rows as rows_
from bench.section import Cell, Section, Table, error, si

OWN = "crowded"
GIVEN = 0.01  # s; the step that is not told


def own(cells: pd.DataFrame) -> pd.DataFrame:
    """The cells that were defined, but those of what gives the references, each with its
    formulation as it was asked for."""
    some = accuracy.confirmed(cells[cells["campaign"].str.startswith(OWN)])
    some = some[
        ~some["status"].isin(["unsupported", "skipped"])
        & ~some["part"].str.startswith(converged.PART)
    ]
    asked = some["formulation_options"].map(lambda text: f":{text}" if text else "")
    return some.assign(asked=some["formulation"] + asked)


@dataclasses.dataclass
class Case:
    """A scene and a start, and who was asked."""

    scene: str
    start: str
    contacts: float
    by: dict[str, pd.DataFrame]  # formulation: its cells


def grid(cells: pd.DataFrame) -> list[Case]:
    """Scenes of which any cell has an error, by their contacts, each from all of its starts."""
    some = own(cells)
    if some.empty:
        return []
    some = some.assign(contacts=rows_.sizes(some, ["problem"]))
    names = moving.names_of(some)
    found = [
        Case(
            moving.scene(problem),
            start,
            float(g["contacts"].max()),
            {name: g[g["asked"] == name] for name in names},
        )
        for (problem, start), g in some.groupby(["problem", "start"])
        if g["err_ref"].notna().any()
    ]
    return sorted(found, key=lambda c: (c.contacts, c.scene, c.start))


def best_of(case: Case, level: float = accuracy.LEVEL) -> dict[str, pd.Series]:
    """{formulation: its cheapest cell} of those that reach the error."""
    first = {name: accuracy.cheapest(g, level) for name, g in case.by.items()}
    return {name: cell for name, cell in first.items() if cell is not None}


def leaders(case: Case, level: float = accuracy.LEVEL) -> list[str]:
    """The cheapest formulation, and those that the noise of the campaign or the spread of the
    samples does not tell from it."""
    found = best_of(case, level)
    order = sorted(found, key=lambda name: found[name]["cost"])
    if not order:
        return []
    least = found[order[0]]
    return [name for name in order if rows_.tied(found[name], least)]


def asked(g: pd.DataFrame) -> bool:
    """Was it run, and is its error known where it is solved?"""
    return len(g) > 0 and not (g["good"].any() and accuracy.usable(g).empty)


def told(g: pd.DataFrame, first: bool, level: float = accuracy.LEVEL) -> Cell:
    """What the run takes, by whom; where nobody reaches the error, why not."""
    if g.empty:
        return Cell("not asked", "none")
    best = accuracy.cheapest(g, level)
    if best is not None:
        step = "" if best["step_s"] == GIVEN else f", {1e3 * best['step_s']:g} ms"
        mark = "good" if first else ""
        return Cell(f"{si(best['cost'], 's')} by {best['solver']}{step}", mark, sort=best["cost"])
    fit = accuracy.usable(g)
    if len(fit):
        return Cell(f"off by {error(fit['err_sure'].min())}", "bad")
    if g["good"].any():
        return Cell("no error known", "none")
    ends = sorted({f"{s} {w}" for s, w in zip(g["solver"], g["status"], strict=True)})
    return Cell("not solved: " + ", ".join(ends), "bad")


def table(cells: pd.DataFrame, level: float = accuracy.LEVEL) -> Table | None:
    found = grid(cells)
    if not found:
        return None
    names = list(found[0].by)
    body = []
    for c in found:
        first = leaders(c, level)
        start = settings.STARTS.get(c.start, c.start)
        each = (told(c.by[n], n in first, level) for n in names)
        body.append([c.scene, f"{c.contacts:.0f}", start, *each])
    return Table(
        "crowded",
        f"Time of the run by which a formulation first reaches an error of {level:g} (m, m/s or"
        " rad), by its cheapest solver and step: 10 ms where no other is told, and at rest the only"
        " one.",
        ["scene", "contacts", "start", *names],
        body,
    )


def start_words(cases: list[Case], level: float, mark: str) -> str:
    """Of one start: who reaches the error on how many scenes, and who is cheapest."""
    names = list(cases[0].by)
    reached = {n: sum(n in best_of(c, level) for c in cases) for n in names}
    alone, tied = collections.Counter(), collections.Counter()
    for c in cases:
        first = leaders(c, level)
        (alone if len(first) == 1 else tied).update(first)
    won = ", ".join(
        f"{mark}{n}{mark} {alone[n]}" + (f" + {tied[n]} tied" if tied[n] else "")
        for n in sorted(names, key=lambda n: -alone[n] - tied[n])
        if alone[n] or tied[n]
    )
    few = ", ".join(f"{mark}{n}{mark} {reached[n]}" for n in names if reached[n] < len(cases))
    on = f"on {len(cases)} scene{'s' * (len(cases) > 1)}"
    counts = f"each reaches it {on}" + (f" but {few}" if few else "")
    start = settings.STARTS.get(cases[0].start, cases[0].start)
    return f"{start}: the cheapest {won or 'is none'} ({counts})"


FINER = (1e-3, 1e-4)  # errors that could turn the order at the first one round


def each_start(found: list[Case], level: float, mark: str) -> str:
    """Of all starts that were measured, in their order."""
    starts = [[c for c in found if c.start == s] for s in settings.STARTS]
    return "; ".join(start_words(cases, level, mark) for cases in starts if cases) or "none"


def words(cells: pd.DataFrame, mark: str = "", level: float = accuracy.LEVEL) -> str:
    """Who is cheapest on how many scenes from each start, at this error and at finer ones; mark:
    what names stand in."""
    every = grid(cells)
    found = [c for c in every if all(asked(g) for g in c.by.values())]
    if not found:
        return "No formulation ran on every scene where many contacts carry."
    ran = (
        "every scene"
        if len(found) == len(every)
        else f"{len(found)} of {len(every)} scenes and starts, which count here"
    )
    low, high = found[0].contacts, found[-1].contacts
    each = each_start(found, level, mark)
    finer = " ".join(f"To {v:g}, {each_start(found, v, mark)}." for v in FINER if v < level)
    n = len({c.scene for c in found})
    return (
        f"Where {low:.0f} to {high:.0f} contacts carry ({n} scene{'s' * (n > 1)}), every"
        f" formulation ran on {ran}, to an error of {level:g}. {each[0].upper()}{each[1:]}. {finer}"
    ).rstrip()


def section(cells: pd.DataFrame) -> Section | None:
    made = table(cells)
    if made is None:
        return None
    return Section("crowded", "Where many contacts carry", words(cells), [], [made])

"""Error against time where many contacts carry, every formulation on every scene: what the headline
of the small scenes leaves open, for there not each formulation was run on the larger ones."""

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
    return moving.named(some)


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


LEVELS = (1e-2, 1e-3, 1e-4)  # finer errors could turn the order at the first one round


def everywhere(cells: pd.DataFrame) -> tuple[list[Case], int]:
    """Scenes and starts on which every formulation ran and has a known error, and of how many."""
    every = grid(cells)
    return [c for c in every if all(asked(g) for g in c.by.values())], len(every)


def counts(cells: pd.DataFrame) -> Table | None:
    """For each error and start: on how many scenes a formulation is first, and reaches it."""
    found, _ = everywhere(cells)
    if not found:
        return None
    names = list(found[0].by)
    body = []
    for level in LEVELS:
        for start in settings.STARTS:
            cases = [c for c in found if c.start == start]
            first = [leaders(c, level) for c in cases]
            best = [best_of(c, level) for c in cases]
            each = []
            for n in names:
                alone = sum(f == [n] for f in first)
                tied = sum(n in f for f in first) - alone
                won = f"{alone}" + (f" + {tied} tied" if tied else "")
                reached = sum(n in b for b in best)
                each.append(f"{won} of {reached}" if reached < len(cases) else won)
            if cases:
                body.append([f"{level:g}", settings.STARTS[start], str(len(cases)), *each])
    return Table(
        "crowded_counts",
        "On how many scenes a formulation reaches an error (m, m/s or rad) in the least time, alone"
        " or tied with others; behind it on how many it reaches the error, where that is not on"
        " all.",
        ["error", "start", "scenes", *names],
        body,
    )


def words(cells: pd.DataFrame) -> str:
    """What was run where."""
    found, every = everywhere(cells)
    if not found:
        return "No formulation ran on every scene where many contacts carry."
    n = len({c.scene for c in found})
    ran = "every scene" if len(found) == every else f"{len(found)} of {every} scenes and starts"
    only = "" if len(found) == every else " The counts are of these."
    return (
        f"Where {found[0].contacts:.0f} to {found[-1].contacts:.0f} contacts carry"
        f" ({n} scene{'s' * (n > 1)}), every formulation ran on {ran}.{only}"
    )


def section(cells: pd.DataFrame) -> Section | None:
    made = table(cells)
    if made is None:
        return None
    tables = [t for t in (counts(cells), made) if t]
    return Section("crowded", "Where many contacts carry", words(cells), [], tables)

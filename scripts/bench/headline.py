"""The headline with its four readings: which formulation is cheapest at an error, when steps start
cold or from the last one, and when each formulation has one declared default setting or the best of
its settings on each scene. A reading that is left out could turn the others round, so none is."""

import collections
import dataclasses
import itertools
import math

import numpy as np
import pandas as pd

from bench import accuracy, registry, settings
from bench.section import Cell, Table

LEVELS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
STARTS = settings.STARTS
SETTINGS = {"default": "default", "tuned": "tuned per scene"}


READINGS = len(STARTS) * len(SETTINGS)


@dataclasses.dataclass
class Reading:
    """Of the scenes that somebody reaches a level on: who is cheapest alone, who is within the
    noise of the cheapest."""

    reached: int
    alone: collections.Counter
    tied: collections.Counter

    def leader(self) -> str | None:
        """Who is cheapest alone on more scenes than any other would be that won all its ties."""
        best = max(self.alone, key=lambda f: self.alone[f], default=None)
        others = {*self.alone, *self.tied} - {best}
        clear = all(self.alone[best] > self.alone[f] + self.tied[f] for f in others)
        return best if clear else None


def setting(cells: pd.DataFrame, name: str) -> pd.DataFrame:
    """Default: the declared options of the formulation, any solver without options of its own, its
    own tolerance; the step is what reaches the error. Tuned: everything that was run."""
    if name == "tuned":
        return cells
    return settings.among(settings.plain(cells), settings.declared())


def scenes_of(cells: pd.DataFrame, start: str, name: str) -> accuracy.Scenes:
    return accuracy.scenes(setting(settings.started(cells, start), name))


def best_of(cells: pd.DataFrame, level: float) -> list[str]:
    """Formulations within the noise of the cheapest at a level, the cheapest first; [] where nobody
    gets there."""
    best = accuracy.cheapest(cells, level)
    if best is None:
        return []
    same = accuracy.ties(cells, best, level)
    others = {c.split(" + ")[0].split(":")[0] for c in same} - {best["formulation"]}
    return [best["formulation"], *sorted(others)]


def read(found: accuracy.Scenes, level: float) -> Reading:
    """From the scenes of one start and setting."""
    out = Reading(0, collections.Counter(), collections.Counter())
    for _, group in found:
        first = best_of(group, level)
        out.reached += bool(first)
        if len(first) == 1:
            out.alone[first[0]] += 1
        else:
            out.tied.update(first)
    return out


def price_of_tuning(cells: pd.DataFrame, start: str, level: float) -> tuple[float, float]:
    """(how many times the time of one run all settings of the winner took, how much faster its best
    setting is than its default), medians over the scenes where both get there."""
    spent, gained = [], []
    some = settings.started(cells, start)
    for _, group in accuracy.scenes(some):
        best = accuracy.cheapest(group, level)
        if best is None:
            continue
        own = group[group["formulation"] == best["formulation"]]
        plain = accuracy.cheapest(setting(own, "default"), level)
        if plain is not None:
            spent.append(own["t_total_s"].sum() / best["cost"])
            gained.append(plain["cost"] / best["cost"])
    return tuple(float(np.median(x)) if x else math.nan for x in (spent, gained))


def ran(cells: pd.DataFrame, problem: str) -> set[str]:
    """The formulations that were measured on a scene, whatever became of it."""
    tried = ~cells["status"].isin(["unsupported", "skipped"])
    return set(cells[tried & (cells["problem"] == problem)]["formulation"])


SOME = 20  # contacts from which on a scene is none of the small ones


def sized(found: accuracy.Scenes) -> accuracy.Scenes:
    return [(p, g) for p, g in found if g["n_contacts"].max() >= SOME]


def fair_words(own: pd.DataFrame, forms: list[str]) -> list[str]:
    """Who is first where all of them ran, by their defaults, and of all settings where that is
    another: elsewhere a win may lack its rival. Nothing where all of them ran everywhere."""
    out, lacks = [], False

    def wins(reading: Reading, form: str) -> tuple[int, int]:
        return reading.alone[form], reading.tied[form]

    for start, name in itertools.product(STARTS, SETTINGS):
        asked = setting(settings.started(own, start), name)
        found = accuracy.scenes(asked)
        all_ran = [(p, g) for p, g in found if set(forms) <= ran(asked, p)]
        if not found or not (own["start"] == start).any():
            continue
        fair = read(all_ran, accuracy.LEVEL)
        order = sorted(forms, key=lambda f: wins(fair, f), reverse=True)
        first = ", ".join(f"`{f}` {told(fair, f)}" for f in order if told(fair, f))
        said = f"{STARTS[start]}, {SETTINGS[name]}: all ran on {len(all_ran)} of {len(found)}"
        if large := sized(found):
            said += f" ({len(sized(all_ran))} of the {len(large)} with {SOME} or more contacts)"
        said += f", where the cheapest are {first}" if first else ""
        leader, fairly = read(found, accuracy.LEVEL).leader(), fair.leader()
        if first and leader not in (None, fairly):
            said += f": there {f'`{fairly}` leads' if fairly else 'nobody leads'}"
        elif name != "default":
            continue  # tells nothing else than the defaults do
        lacks = lacks or len(all_ran) < len(found)
        out.append(said)
    return out if lacks else []


def told(reading: Reading, formulation: str) -> str:
    """'10', '10 + 3 tied', or nothing."""
    alone, tied = reading.alone[formulation], reading.tied[formulation]
    if not alone and not tied:
        return ""
    return f"{alone}" + (f" + {tied} tied" if tied else "")


def table(cells: pd.DataFrame) -> Table | None:
    """One line for each error and reading; no reading is left out, one without rows says so."""
    own = accuracy.own(cells)
    asked = {key: scenes_of(own, *key) for key in itertools.product(STARTS, SETTINGS)}
    readings = {(level, *key): read(g, level) for level in LEVELS for key, g in asked.items()}
    seen = {f for r in readings.values() for f in (*r.alone, *r.tied)}
    forms = registry.by_formulation(seen)
    if not forms:
        return None
    rows = []
    for (level, start, name), reading in readings.items():
        measured = (own["start"] == start).any()
        rows.append(
            [
                f"{level:g}",
                STARTS[start],
                SETTINGS[name],
                str(reading.reached) if measured else Cell("not measured", "none"),
                *[told(reading, f) if measured else "" for f in forms],
            ]
        )
    return Table(
        "headline",
        "On how many scenes is a formulation the cheapest way to an error (m, m/s or rad)? Tied:"
        " the next one is as fast, to the noise of the campaign or the spread of the samples. Steps"
        " start from nothing (cold) or from the last step. A formulation has one declared setting"
        " (default), or the best of all that were run on the scene (tuned per scene).",
        ["error", "start", "setting", "scenes reached", *forms],
        rows,
    )


def tries_words(own: pd.DataFrame, leader: str) -> str:
    """Of how many settings of each formulation the best is taken in the tuned readings: the most on
    a scene from one start."""
    tried = own[~own["status"].isin(["unsupported", "skipped"])]
    each = tried.groupby(["formulation", "problem", "start"])["formulation_options"].nunique()
    sets = each.groupby("formulation").max()
    order = [f for f in registry.by_formulation(set(sets.index)) if f != leader]
    others = ", ".join(f"`{f}` {sets[f]}" for f in order if registry.uses_solver(f))
    return (
        f" The tuned ones take the best of up to {sets[leader]} of its settings on a scene"
        f" ({others}), and of solvers, tolerances and steps."
    )


def words(cells: pd.DataFrame) -> str:
    """Who is first in every reading, or that nobody is; and what tuning costs."""
    own = accuracy.own(cells)
    leaders, won, out, n = set(), set(), [], 0
    for start in STARTS:
        for name in SETTINGS:
            reading = read(scenes_of(own, start, name), accuracy.LEVEL)
            if reading.reached and (own["start"] == start).any():
                n += 1
                leaders.add(reading.leader())
                won |= {f for f in (*reading.alone, *reading.tied) if registry.uses_solver(f)}
    if len(leaders) == 1 and None not in leaders:
        which = "every reading" if n == READINGS else f"the {n} of {READINGS} measured readings"
        leader = next(iter(leaders))
        out.append(
            f"`{leader}` leads in {which} at {accuracy.LEVEL:g}, of what was run."
            + tries_words(own, leader)
        )
    elif leaders:
        out.append(
            f"Nobody leads beyond the ties in all of the {n} measured readings at"
            f" {accuracy.LEVEL:g}."
        )
    forms = registry.by_formulation(won)
    if fair := fair_words(own, forms):
        names = ", ".join(f"`{f}`" for f in forms)
        out.append(
            f"Not each of {names} was run on every scene, so a win may lack its rival"
            f" ({'; '.join(fair)})."
        )
    for start in STARTS:
        spent, gained = price_of_tuning(own, start, accuracy.LEVEL)
        if math.isfinite(spent):
            gain = f"{gained:.2g}"
            faster = "as fast" if gain == "1" else f"{gain} times as fast"
            out.append(
                f"Tuning ({STARTS[start]}): the winner's best setting is {faster} as its default,"
                f" and finding it took {spent:.2g} times one run (medians)."
            )
    return " ".join(out)

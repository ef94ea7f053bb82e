"""What limits the error: work-precision surfaces over the step, the tolerance of the solver, and
the facets or the stiffness of the formulation. From the finest corner of a surface one knob at a
time is made coarse; the knob that raises the error most is the one that the accuracy was bought
with, and one that leaves it as it was costs time for nothing."""

import collections
import dataclasses
import math

import numpy as np
import pandas as pd

from bench import accuracy
from bench import rows as rows_
from bench.chart import Chart, Line, Panel
from bench.section import Cell, Table, error

PART = "surfaces"
LEAST = 1e-6  # an error below is right for every question of this page, and compared as this
APART = 0.24  # of two formulations on one line of the figure
MATTERS = 1.5  # times the error from which a knob limits it


@dataclasses.dataclass
class Knob:
    name: str  # what is turned
    coarse: str
    fine: str
    error: float  # with this one coarse and all others fine, over all fine
    time: float


@dataclasses.dataclass
class Surface:
    problem: str
    formulation: str
    finest: pd.Series  # its finest corner
    knobs: list[Knob]

    def limit(self) -> Knob | None:
        """The knob that raises the error most; None where none matters."""
        most = max(self.knobs, key=lambda k: k.error)
        return most if most.error >= MATTERS else None


def turned(cells: pd.DataFrame) -> tuple[str, pd.Series]:
    """The option of the formulation that these rows turn up: (its name, its values)."""
    given = cells["formulation_options"].map(rows_.options)
    for name in sorted({k for o in given for k in o}):
        values = given.map(lambda o, name=name: float(o.get(name, "nan")))
        if values.nunique() > 1:
            return name, values
    return "", pd.Series(math.nan, index=cells.index)


def judged(cells: pd.DataFrame) -> pd.Series:
    """Errors as they are compared: not below what is resolved."""
    return cells["err_ref"].clip(lower=np.maximum(cells["err_floor"], LEAST))


def surface(problem: str, formulation: str, cells: pd.DataFrame) -> Surface | None:
    """From the verified rows of one scene and formulation; None without a finest corner that a
    coarse knob can be held against."""
    option, values = turned(cells)
    # largest is finest: of steps and tolerances the smallest are
    grid = pd.DataFrame({"step": -cells["step_s"], "tolerance": -cells["tol"], option: values})
    good = cells["good"] & cells["err_ref"].notna() & (cells["t_total_s"] > 0)
    top, low = grid.max(), grid.min()
    corner = cells[good & (grid == top).all(axis=1)]
    if not option or corner.empty:
        return None
    finest = corner.iloc[0]
    knobs = []
    for name in grid.columns[low < top]:
        others = grid.columns[grid.columns != name]
        at = cells[good & (grid[name] == low[name]) & (grid[others] == top[others]).all(axis=1)]
        if len(at):
            knobs.append(
                Knob(
                    name,
                    f"{abs(low[name]):g}",
                    f"{abs(top[name]):g}",
                    float(judged(at).iloc[0] / judged(corner).iloc[0]),
                    float(finest["t_total_s"] / at.iloc[0]["t_total_s"]),
                )
            )
    return Surface(problem, formulation, finest, knobs) if knobs else None


def surfaces(cells: pd.DataFrame) -> list[Surface]:
    some = cells[cells["part"] == PART]
    found = [
        surface(*key, group) for key, group in some.groupby(["problem", "formulation"], sort=True)
    ]
    return [s for s in found if s]


def message(found: list[Surface]) -> str:
    """Which knob limits how many of the surfaces, and which is turned for nothing."""
    limits = collections.Counter(s.limit().name if s.limit() else "" for s in found)
    told = [f"the {name} in {n}" for name, n in limits.most_common() if name]
    free = limits[""]
    out = f"Of {len(found)} surfaces the error is limited by {', by '.join(told) or 'nothing'}"
    out += f"; by none of these in {free}." if free else "."
    idle = [k for s in found for k in s.knobs if k.error < MATTERS]
    if idle:
        out += (
            " To turn up another one takes"
            f" {np.median([k.time for k in idle]):.2g} times the time and buys nothing (median of"
            f" {len(idle)})."
        )
    return out


def chart(found: list[Surface]) -> Chart:
    """One panel a knob: how much the error grows where this one alone is coarse."""
    scenes, forms = (sorted({getattr(s, k) for s in found}) for k in ("problem", "formulation"))
    kinds: dict[str, list[str]] = {}  # options of formulations share a panel: nobody has two
    for s in found:
        for k in s.knobs:
            title = k.name if k.name in ("step", "tolerance") else "facets or stiffness"
            kinds.setdefault(title, [])
            if k.name not in kinds[title]:
                kinds[title].append(k.name)
    names = [accuracy.short(p) for p in scenes]
    panels = []
    for title, knobs in kinds.items():
        lines = []
        for form in forms:
            marks = [
                (k, s) for s in found if s.formulation == form for k in s.knobs if k.name in knobs
            ]
            lines.append(
                Line(
                    form,
                    [k.error for k, _ in marks],
                    [scenes.index(s.problem) + APART * forms.index(form) for _, s in marks],
                    kind="points",
                    hollow=[bool(s.finest["disturbed"]) for _, s in marks],
                    hover=[
                        f"{s.problem}, {form}: {k.name} {k.coarse} in place of {k.fine}:"
                        f" {k.error:.2g} times the error, 1/{k.time:.2g} of the time"
                        for k, s in marks
                    ],
                )
            )
        panels.append(
            Panel(
                [line for line in lines if line.x],
                title=title,
                xlabel="times the error",
                ylog=0,
                yticks=names,
            )
        )
    return Chart(
        "surfaces",
        "What limits the error. Each panel makes one knob coarse (hover, or the table, tells from"
        " what to what) where all others are fine: far to the right it limits the error, at 1 it"
        f" buys nothing. {message(found)}",
        panels,
        columns=3,
        share_y=True,
        height=1.9,
    )


def table(found: list[Surface]) -> Table:
    rows = []
    for s in found:
        limit = s.limit()
        rows.append(
            [
                s.problem,
                Cell(s.formulation, look=s.formulation),
                f"{error(s.finest['err_ref'])} ({s.finest['err_quantity']})",
                "; ".join(
                    f"{k.name} {k.coarse} for {k.fine}: {k.error:.2g} × the error,"
                    f" 1/{k.time:.2g} of the time"
                    for k in s.knobs
                ),
                Cell(limit.name, "fair") if limit else Cell("nothing", "good"),
            ]
        )
    return Table(
        "surfaces",
        "Work-precision surfaces: from the finest corner (smallest step, smallest tolerance, most"
        " facets or highest stiffness of these rows) one knob at a time is made coarse. Errors"
        f" below {LEAST:g} or the uncertainty of the reference count as that; a knob limits the"
        f" error where it raises it {MATTERS:g} times or more.",
        ["scene", "formulation", "error, all fine", "one knob coarse", "limited by"],
        rows,
    )

"""What breaks first: every stressor against every formulation and every solver, with the reason."""

import collections
import math
import re

import numpy as np
import pandas as pd

from bench import registry
from bench import rows as rows_
from bench.chart import Heat, HeatPanel
from bench.section import Cell, Section, Table

# Words of a run, the worst first; one letter each for the maps
LETTERS = {
    "false claim": "x",
    "dies": "d",
    "time-out": "t",
    "fails honestly": "f",
    "gains energy": "e",
    "penetrates": "p",
    "a step deep": "h",
    "creeps": "c",
    "misses": "m",
    "not defined": "–",
}
MARK = {
    "stands": "good",
    "not defined": "none",
    "gains energy": "bad",
    "false claim": "bad",
    "dies": "bad",
    "time-out": "bad",
    "fails honestly": "bad",
}
DEATHS = {"crash", "oom", "no_output", "flood"}  # ends of a process that are nobody's word
DEEP = 1e-2  # penetration [m] that counts where the scene begins without any
# What is turned up along a ladder whose problems differ in more than one number, and where it is
# mild: part -> (name, key)
MILD = {
    "near-parallel normals": ("beta_deg", lambda v: abs(math.log(math.tan(math.radians(v))))),
    "vanishing inertia": ("inertia", lambda v: -v),
    "short step": ("h", lambda v: -v),
    "long step": ("h", lambda v: v),
    "gyroscopic": ("", None),
}  # no key: problems of different kinds


# The ends of a run for a reader who meets the words for the first time
ENDS = {
    "false claim": "claims a wrong answer",
    "dies": "crashes",
    "time-out": "runs out of time",
    "fails honestly": "gives up and says so",
    "gains energy": "energy grows",
    "penetrates": "bodies sink into each other",
    "a step deep": "bodies overlap by what they approach in one step",
    "creeps": "bodies at rest creep",
    "misses": "the known answer is missed",
}


def said(part: str) -> str:
    """What a stressor is, in the words of the campaign's file."""
    return registry.part_words("stability", part)


Fall = tuple[int, int, dict[str, list[str]]]  # stands, is defined, {word: [stressors]}


def asked_words(share: tuple[int, int]) -> str:
    """' (asked 256 of the 299 predictions)'; nothing where it was asked all of them."""
    return "" if share[0] >= share[1] else f" (asked {share[0]} of the {share[1]} predictions)"


def fall_words(found: Fall | None, share: tuple[int, int] = (0, 0)) -> str:
    """'Passes 14 of 17 stress tests. Bodies at rest creep: tall stacks.', from one entry of
    falls() and of asked()."""
    if not found:
        return ""
    stands, of, fell = found
    ends = [
        f"{ENDS[w][0].upper()}{ENDS[w][1:]}: {', '.join(said(p) or p for p in parts)}."
        for w, parts in sorted(fell.items())
    ]
    return " ".join([f"Passes {stands} of {of} stress tests{asked_words(share)}."] + ends)


def missed_word(missed: str) -> str:
    """The worst kind among the missed predictions, from their names (column `missed`)."""
    kinds = [m.strip() for m in str(missed).split(",")]
    if any(m.startswith(("energy", "angular_momentum", "max_speed")) for m in kinds):
        return "gains energy"
    if any(m.startswith("max_penetration") for m in kinds):
        return "penetrates"
    if any(m.startswith("max_drift") or " = 0 " in m for m in kinds):
        return "creeps"
    return "misses"


def unsolvable(cell: pd.Series | dict) -> bool:
    """No motion of rigid bodies exists, and the contact is not compliant: only a refusal is
    right."""
    scene = cell["problem"].partition(":")[0]
    return not registry.solvable(scene) and not registry.trait(cell["formulation"], "compliant")


def refusals(cells: pd.DataFrame) -> pd.Series:
    """Which cells did what is right where no solution exists: they said so."""
    return pd.Series(
        [
            c["campaign"].startswith("stability")
            and unsolvable(c)
            and c["status"] not in ("unsupported", "skipped")
            and word(c)[0] == "stands"
            for c in cells.to_dict("records")
        ],
        dtype=bool,
    )


def word(cell: pd.Series | dict) -> tuple[str, str]:
    """One word for how a run ended, and the longer reason."""
    status = cell["status"]
    if status in ("unsupported", "skipped"):
        return "not defined", cell.get("note", "")
    if status == "unverified":
        return "false claim", "claimed solved, the judge disagrees"
    if status in DEATHS:
        return "dies", f"{status}: {cell.get('note', '')}"
    if status in ("timeout", "time_limit"):
        return "time-out", f"not finished within {cell.get('t_limit_s', math.nan):g} s"
    if status != "ok" or not cell["verified"]:
        if unsolvable(cell):
            return "stands", f"refuses, as it must: {status}"
        return "fails honestly", f"{status}: {cell.get('note', '')}"
    if unsolvable(cell):
        return "misses", "gives an answer where none exists"
    if cell.get("n_predictions_missed", 0) > 0:
        return (
            depth_word(missed_word(cell.get("missed", "")), cell),
            f"misses {cell.get('missed', '') or cell.get('err_quantity', '')}",
        )
    if cell["part"] not in ("initial overlap",) and cell.get("penetration_m", 0) > DEEP:
        return depth_word("penetrates", cell), f"{cell['penetration_m']:.2g} m"
    return "stands", ""


def depth_word(found: str, cell: pd.Series | dict) -> str:
    """Penetration up to what bodies approach in a step is a fact of the discretisation, h v: a gap
    that closes inside a step is seen at its end. Deeper, it is the method's failure."""
    within = cell.get("penetration_m", 0) <= cell.get("approach_m", math.nan)
    return "a step deep" if found == "penetrates" and within else found


def severity(part: str, cells: pd.DataFrame) -> tuple[str, list[float], list[str]]:
    """What is turned up along a ladder, and how far each of its cells is: (name, values,
    printed)."""
    options = [
        {**rows_.options(str(p).partition(":")[2]), **rows_.options(f)}
        for p, f in zip(cells["problem"], cells["formulation_options"], strict=True)
    ]
    if part in MILD and MILD[part][0] == "h":
        return (
            "h",
            [MILD[part][1](h) for h in cells["step_s"]],
            [f"{h:g} s" for h in cells["step_s"]],
        )
    if part in MILD and MILD[part][1]:
        values = [float(o[MILD[part][0]]) for o in options]
        return MILD[part][0], [MILD[part][1](v) for v in values], [f"{v:g}" for v in values]
    for name in dict.fromkeys(k for o in options for k in o if part not in MILD):
        values = [o.get(name, "") for o in options]
        if len(set(values)) > 1 and all(re.fullmatch(r"[-+0-9.eE]+", v) for v in values):
            return name, [float(v) for v in values], [f"{float(v):g}" for v in values]
    return "problem", list(range(len(cells))), list(cells["problem"])


class Ladder:
    """All rungs of one stressor for one formulation and one solver."""

    def __init__(self, part: str, cells: pd.DataFrame) -> None:
        name, values, printed = severity(part, cells)
        order = np.argsort(values, kind="stable")
        self.rungs = [
            (
                *word(cells.iloc[i]),
                name,
                printed[i] + rows_.from_last(cells.iloc[i]["start"]),
                cells.iloc[i].get("command", ""),
            )
            for i in order
        ]
        self.defined = [r for r in self.rungs if r[0] != "not defined"]
        self.stands = sum(r[0] == "stands" for r in self.defined)
        solved = cells[cells["good"]]
        self.asked, self.most = (int(solved[c].fillna(0).sum()) for c in ("n_predictions", "most"))
        self.first = next((r for r in self.defined if r[0] != "stands"), None)

    def cell(self) -> Cell:
        if not self.defined:
            return Cell("not defined: " + (self.rungs[0][1] or "for this combination"), "none")
        n = len(self.defined)
        if self.first is None:
            return Cell(f"stands {n}/{n}", "good", "on every rung", sort=1.0)
        what, why, name, at, command = self.first
        return Cell(
            f"{what} {self.stands}/{n}",
            MARK.get(what, "fair"),
            f"first at {name} = {at}: {why}\n{command}",
            sort=self.stands / n,
        )


Ladders = dict[tuple[str, str], dict[str, Ladder]]  # (formulation, solver) -> part -> Ladder


RUNG = ["part", "problem", "step_s", "start"]
COMMON = 0.5  # of the combinations of a part; a rung that fewer were asked for compares nobody


def asked_alike(cells: pd.DataFrame) -> pd.DataFrame:
    """The rungs on which at least half of a part's combinations were measured, of the combinations
    that were measured on all of them: who was asked less, as in a form that was cut, does not stand
    longer for it."""
    if cells.empty:
        return cells
    cells = cells.assign(who=cells["formulation"] + " + " + cells["solver"])
    of_part = cells.groupby("part")["who"].transform("nunique")
    cells = cells[cells.groupby(RUNG)["who"].transform("nunique") >= COMMON * of_part]
    rungs = cells.assign(rung=cells[RUNG[1:]].astype(str).agg(" ".join, axis=1))
    whole = rungs.groupby("part")["rung"].transform("nunique")
    mine = rungs.groupby(["part", "who"])["rung"].transform("nunique")
    return cells[(mine == whole).to_numpy()]


def ladders(cells: pd.DataFrame) -> Ladders:
    """(formulation, solver) -> part -> Ladder, of the campaign `stability`; formulations without
    solver have the solver ''."""
    out = {}
    some = cells[
        cells["campaign"].str.startswith("stability") & ~cells["command"].str.contains("--effects")
    ]
    some = asked_alike(some)
    rung = some.groupby(["part", "problem", "step_s"], dropna=False)
    some = some.assign(most=rung["n_predictions"].transform("max").fillna(0))
    for (form, solver, part), g in some.groupby(["formulation", "solver", "part"]):
        out.setdefault((form, solver if registry.uses_solver(form) else ""), {})[part] = Ladder(
            part, g
        )
    return out


def summed(found: list[Ladder], part: str) -> tuple[str, float | None]:
    """A field of the overview: how many of the combinations that are defined stand on every rung;
    what brings most others down."""
    found = [ladder[part] for ladder in found if part in ladder and ladder[part].defined]
    if not found:
        return "–", None
    whole = sum(ladder.first is None for ladder in found)
    fell = collections.Counter(ladder.first[0] for ladder in found if ladder.first is not None)
    letter = LETTERS[min(fell, key=lambda w: (-fell[w], list(LETTERS).index(w)))] if fell else ""
    return f"{whole}/{len(found)} {letter}".strip(), whole / len(found)


LEGEND = ", ".join(f"{letter} {name}" for name, letter in LETTERS.items())


def overview(by: Ladders, parts: list[str]) -> Heat:
    forms, solvers = (
        registry.by_formulation({f for f, _ in by}),
        registry.by_solver({s for _, s in by if s}),
    )
    panels = [
        HeatPanel(
            "formulations",
            [f if registry.uses_solver(f) else f"{f} (no solver)" for f in forms],
            [
                [
                    summed([parts_of for (f, _), parts_of in by.items() if f == form], p)
                    for p in parts
                ]
                for form in forms
            ],
        ),
        HeatPanel(
            "solvers",
            solvers,
            [
                [
                    summed([parts_of for (_, s), parts_of in by.items() if s == solver], p)
                    for p in parts
                ]
                for solver in solvers
            ],
        ),
    ]
    return Heat(
        "stability",
        "What breaks first: combinations that stand on every rung of a stressor's ladder, of those"
        " that are defined, by formulation (top) and by solver (bottom); the letter is what brings"
        f" most of the others down ({LEGEND}). Dark: all stand. Stressors from the mildest to the"
        " hardest.",
        parts,
        panels,
    )


def map_of_all(by: Ladders, parts: list[str]) -> Heat:
    panels = []
    for form in sorted(
        registry.by_formulation({f for f, _ in by}), key=lambda f: not registry.uses_solver(f)
    ):
        solvers = registry.by_solver({s for f, s in by if f == form})
        words = []
        for solver in solvers:
            line = []
            for part in parts:
                ladder = by[form, solver].get(part)
                if ladder is None or not ladder.defined:
                    line.append((LETTERS["not defined"], None))
                else:
                    line.append(
                        (
                            "" if ladder.first is None else LETTERS[ladder.first[0]],
                            ladder.stands / len(ladder.defined),
                        )
                    )
            words.append(line)
        alone = solvers == [""]  # one row: its name stands on it, a title beside it would not fit
        panels.append(
            HeatPanel("" if alone else form, [f"{form} (no solver)"] if alone else solvers, words)
        )
    return Heat(
        "stability_all",
        "The whole map: every formulation with every solver. Dark: stands on every rung; otherwise"
        f" what the first failing rung does: {LEGEND}.",
        parts,
        panels,
        across=3,
        size=5.5,
    )


def asked(by: Ladders) -> dict[tuple[str, str], tuple[int, int]]:
    """(formulation, solver) -> (predictions that its solved rungs were asked, the most that anybody
    was asked on them): who is asked less stands more easily."""
    return {
        key: (sum(x.asked for x in found.values()), sum(x.most for x in found.values()))
        for key, found in by.items()
    }


def falls(by: Ladders) -> dict[tuple[str, str], Fall]:
    """(formulation, solver) -> (stressors it stands, stressors that are defined, {word:
    [stressors]}), from ladders()."""
    out = {}
    for key, by_part in by.items():
        defined = {p: ladder for p, ladder in by_part.items() if ladder.defined}
        fell = {}
        for part, ladder in sorted(defined.items()):
            if ladder.first is not None:
                fell.setdefault(ladder.first[0], []).append(part)
        out[key] = (sum(ladder.first is None for ladder in defined.values()), len(defined), fell)
    return out


UNITS = {
    "depth": "m",
    "speed": "m/s",
    "duration": "s",
    "press": "N",
    "beta_deg": "deg",
    "height": "m",
    "inertia": "kg m^2",
    "k": "N/m",
    "stiffness": "N/m",
}


def turned_up(ladder: Ladder) -> str:
    """'mass_ratio: 1 to 1e+06', or the problems themselves where they are of different kinds."""
    name, first, last = ladder.rungs[0][2], ladder.rungs[0][3], ladder.rungs[-1][3]
    if name == "problem":
        return "; ".join(dict.fromkeys(rung[3] for rung in ladder.rungs))
    return f"{name}: {first} to {last} {UNITS.get(name, '')}".strip()


def stressors_table(by: Ladders, parts: list[str]) -> Table:
    """What each stressor turns up, and how far it went in these rows."""
    rows = []
    for part in parts:
        found = [ladders_[part] for ladders_ in by.values() if part in ladders_]
        rows.append(
            [
                part,
                said(part),
                "; ".join(dict.fromkeys(turned_up(ladder) for ladder in found)),
                str(max(len(ladder.rungs) for ladder in found)),
            ]
        )
    return Table(
        "stressors",
        "The stressors: what is made harder, from the mildest to the hardest rung of these rows.",
        ["stressor", "in words", "turned up", "rungs"],
        rows,
    )


def why_missing(form: str, solver: str, part: str) -> str:
    """The reason of a field that no cell was planned for."""
    if part == "stiffness":
        return f"not defined: {form} has no stiffness to turn up"
    return f"not run: {form} with {solver or 'no solver'} is not in this campaign's part"


def section(by: Ladders) -> Section:
    """The map, from ladders()."""
    if not by:
        return None
    parts = sorted(
        {p for found in by.values() for p in found},
        key=lambda p: (
            -np.mean(
                [
                    parts_of[p].first is None
                    for parts_of in by.values()
                    if p in parts_of and parts_of[p].defined
                ]
                or [0]
            ),
            p,
        ),
    )
    table, reasons = [], collections.Counter()
    forms, solvers = (
        registry.by_formulation({f for f, _ in by}),
        registry.by_solver({s for _, s in by}),
    )
    for form, solver in sorted(by, key=lambda k: (forms.index(k[0]), solvers.index(k[1]))):
        line = [Cell(form, look=form), Cell(solver, look=solver) if solver else "none (integrator)"]
        for part in parts:
            ladder = by[form, solver].get(part)
            cell = ladder.cell() if ladder else Cell(why_missing(form, solver, part), "none")
            reasons[cell.text.partition(":")[0].rstrip("0123456789/ ")] += 1
            line.append(cell)
        table.append(line)
    fields = sum(reasons.values())
    refusing = [name for name in registry.scenes() if not registry.solvable(name)]
    counts = ", ".join(f"{name} {n}" for name, n in sorted(reasons.items(), key=lambda kv: -kv[1]))
    return Section(
        "stability",
        "What breaks first",
        "Each stressor is a ladder of ever harder rungs. A field says how many rungs stand and"
        f" what the first failing one does: {', '.join(LETTERS)}. To die is to crash, to run out of"
        " memory or to end without a result; to fail honestly is to say that it was not solved. Of"
        f" {fields} fields: {counts}. A tooltip names the rung, the reason and the command."
        f" Penetration counts above {DEEP:g} m; up to what bodies approach in one step (h v) it is"
        " the step's doing and called so, deeper it is the method's; where no solution exists"
        f" ({', '.join(refusing)}), only a refusal stands.",
        [overview(by, parts), map_of_all(by, parts)],
        [
            stressors_table(by, parts),
            Table(
                "stability",
                f"Stability map: {len(by)} combinations, {len(parts)} stressors, no field without a"
                " word.",
                ["formulation", "solver"] + parts,
                table,
                paper=False,
            ),
        ],
        {"StabilityFields": str(fields), "StabilityStands": str(reasons["stands"])},
    )

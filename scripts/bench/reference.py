"""reference [DIR] - the committed reference run and the README's words about it, from the rows
under DIR."""

import lzma
import math
import pathlib
import re
import shutil
import sys

import numpy as np
import pandas as pd

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from bench import (
    accuracy,
    chart,
    crowded,
    cut,
    effects,
    headline,
    moving,
    paper,
    registry,
    rows,
    say,
    section,
    stability,
    style,
    surface,
)  # noqa: E402
from bench.section import Cell, Table, si  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
BEGIN, END = "<!-- begin: scripts/reference -->\n", "<!-- end: scripts/reference -->\n"
EXTRA = ("limits.csv", "calibration.jsonl", "doctor.json")


def pack(source: pathlib.Path, target: pathlib.Path) -> None:
    """Rows and manifests of every campaign, and of the full forms that are begun (cut/); packed
    rows have the same bytes for the same rows. What other scripts measured beside them stays."""
    for old in [*target.glob("*/results.csv.xz"), *target.glob("cut/*/results.csv.xz")]:
        shutil.rmtree(old.parent)
    found = [*source.glob("*/results.csv*"), *source.glob("cut/*/results.csv*")]
    for folder in sorted({one.parent for one in found}):
        kept = rows.file_of(folder)
        whole = kept.read_bytes()
        out = target / folder.relative_to(source)
        out.mkdir(parents=True, exist_ok=True)
        packed = whole if kept.suffix == ".xz" else lzma.compress(whole, preset=9)
        (out / "results.csv.xz").write_bytes(packed)
        for name in ("manifest.json", *EXTRA):
            if (folder / name).exists():
                shutil.copyfile(folder / name, out / name)


def figures(cells: pd.DataFrame, ladders: stability.Ladders, target: pathlib.Path) -> set[str]:
    """The pictures of the README."""
    own = paper.own(cells)
    stable = stability.section(ladders)
    effect = effects.section(cells)
    made = [
        paper.dimension(own),
        paper.time_and_error(own),
        accuracy.chart(accuracy.own(cells)),
        (found := surface.surfaces(accuracy.own(cells))) and surface.chart(found),
        stable and stable.charts[0],
        effect and effect.charts and effect.charts[0],
    ]
    shutil.rmtree(target, ignore_errors=True)
    for one in filter(None, made):
        style.save(chart.draw(one), target, one.name)
        (target / f"{one.name}.pdf").unlink()
    return {one.name for one in filter(None, made)}


def picture(
    name: str, title: str, have: set[str], words: str, at: str = "reference/figures"
) -> str:
    return f"![{title}]({at}/{name}.png)\n\n{words}\n\n" if name in have else ""


def largest_words(advised: list[dict]) -> str:
    large = [". ".join(accuracy.largest_words(a["large"])) for a in advised if a["large"]]
    return f"\nThe largest: {' '.join(large)}\n" if large else ""


def step_words(a: dict) -> str:
    return (
        f"{si(a['per_step'], 's')} ({a['problem']}, {a['contacts']:g} contacts, step"
        f" {a['step'] * 1e3:g} ms)"
    )


def advice_words(cells: pd.DataFrame) -> str:
    """The answer as a table: what the first screen of the page says."""
    advised = accuracy.advise(cells)
    body = [
        [
            accuracy.kind(a),
            Cell(f"`{a['use']}`"),
            step_words(a),
            f"{a['reached']} of {a['scenes']}; {accuracy.all_ran_words(a)}",
            *[accuracy.rivals_words(a["others"], k, "`") for k in accuracy.OTHERS],
        ]
        for a in advised
        if a["use"]
    ]
    header = ["scene, start", "use", "a step takes", f"scenes within {accuracy.LEVEL:g}"]
    header += accuracy.OTHERS.values()
    lines = ""
    if body:
        lines = f"{accuracy.READ}\n\n" + section.table_md(Table("", "", header, body))
    return lines + largest_words(advised)


def factor_words(r: dict) -> str:
    """A rival's time over that of the one to use, as a field of the table below."""
    if not r["both"]:
        return "-"
    ratio, low, high = (accuracy.times(r[k]) for k in ("ratio", "low", "high"))
    told = ratio + (f" [{low}, {high}]" if r["both"] > 1 else "")
    told += f", {r['reached']} of {r['run']}" if r["reached"] < r["run"] else ""
    kind = accuracy.kind_of_rival(r)
    return {"few": f"({told})", "open": f"\u2248 {told}"}.get(kind, told)


def advice_in_short(cells: pd.DataFrame) -> str:
    """The same with a column for each formulation, and without the solvers of the others."""
    advised = accuracy.advise(cells)
    large = largest_words(advised)
    advised = [a for a in advised if a["use"]]
    if not advised:
        return large
    of = [
        {a["formulation"]: "**1**"}
        | {r["name"].split(" + ")[0]: factor_words(r) for r in a["others"]}
        for a in advised
    ]
    names = registry.by_formulation({f for fields in of for f in fields})
    body = [
        [accuracy.kind(a), Cell(f"`{a['use']}`"), step_words(a), *[d.get(f, "") for f in names]]
        for a, d in zip(advised, of, strict=True)
    ]
    header = ["scene, start", "use", "a step takes", *[f"`{f}`" for f in names]]
    return (
        "How many times the time of the one to use each formulation takes to an error of"
        f" {accuracy.LEVEL:g}, the mean over the scenes that both reach, with its 95 % interval."
        " \u2248: the rows do not tell who is faster; in round brackets: run on too few scenes to"
        " tell; 9 of 11: it reaches the error on 9 of 11 scenes; -: on none of the same; an"
        " interval over three scenes is a rough one. One declared setting each"
        f" ({accuracy.declared_words()}; of the others the program's own), with the solver that"
        " ranks first and the cheapest step. Solvers and numbers of scenes:"
        " [results/README.md](results/README.md).\n\n"
        + section.table_md(Table("", "", header, body))
        + large
    )


def converged_words(own: pd.DataFrame) -> str:
    """How many scenes have no closed form, and what their references are worth."""
    found = accuracy.converged.references(own).values()
    if not found:
        return ""
    worst = max(found, key=lambda r: r.uncertainty)
    return (
        f"{len(found)} scenes have no closed form: they are measured by a converged run of another"
        f" method, uncertain by {min(r.uncertainty for r in found):.0e} to {worst.uncertainty:.0e}"
        f" (`{worst.problem}`)."
    )


def accuracy_words(cells: pd.DataFrame) -> str:
    own = accuracy.own(cells)
    tenth = [f for f, _, _ in accuracy.tenths(own)]
    price = (
        f"a tenth of the error takes {np.median(tenth):.2g} times the time (median of {len(tenth)}"
        " scenes whose front spans a decade)"
        if tenth
        else "no front spans a decade"
    )
    return (
        "What accuracy costs: left and low is better, grey is the front that nothing beats, in the"
        " hatched band the reference itself is uncertain."
        f" {price[0].upper()}{price[1:]}. " + converged_words(own)
    )


def headline_words(cells: pd.DataFrame) -> str:
    """The four readings in one table, with what they say together."""
    made = headline.table(cells)
    if made is None:
        return ""
    return f"{made.caption} {headline.words(cells)}\n\n{section.table_md(made)}\n"


def moving_words(cells: pd.DataFrame) -> str:
    """Larger scenes that move, beside the headline of the small ones."""
    made = moving.table(cells)
    return f"{moving.words(cells, '`')}\n\n{section.table_md(made)}\n" if made else ""


def crowded_words(cells: pd.DataFrame, *, counts_alone: bool = False) -> str:
    """The same at an error, every formulation on every scene."""
    tables = [crowded.counts(cells), None if counts_alone else crowded.table(cells)]
    told = [f"{t.caption}\n\n{section.table_md(t)}\n\n" for t in tables if t]
    return f"{crowded.words(cells)} {''.join(told)}".rstrip() + "\n\n" if told else ""


def disturbed_words(cells: pd.DataFrame) -> str:
    """How many of the cells were measured while something disturbed the machine."""
    n = int((cells["disturbed"] != "").sum())
    if not n:
        return "No cell was disturbed."
    why = ", ".join(sorted({w for d in cells["disturbed"] if d for w in d.split(", ")}))
    return (
        f"**{n} of {len(cells)} cells were measured on a disturbed machine ({why}):**"
        " their ties are wider by the drift of the canaries, their markers hollow, and their times"
        " worth a factor at best."
    )


def rungs_words(ladders: stability.Ladders) -> str:
    """How many rungs half of the ladders have at most, and the longest."""
    all_of = [one for found in ladders.values() for one in found.values() if one.defined]
    lengths = [len(one.rungs) for one in all_of] or [0]
    return f"{np.median(lengths):.0f} in the median and {max(lengths)} at most"


def stability_words(ladders: stability.Ladders) -> str:
    falls = stability.falls(ladders)
    stressors = {part for found in ladders.values() for part in found}
    fields = sum(of for _, of, _ in falls.values())
    stands = sum(n for n, _, _ in falls.values())
    shares = stability.asked(ladders)
    full = [(n / of, f, s) for (f, s), (n, of, _) in falls.items() if of >= 15]
    best = sorted(full, reverse=True)[:3]
    causes = {}
    for _, _, fell in falls.values():
        for word, parts in fell.items():
            causes[word] = causes.get(word, 0) + len(parts)
    worst = sorted(causes.items(), key=lambda kv: -kv[1])[:3]
    names = ", ".join(
        (f"`{f}` with `{s}`" if s else f"`{f}`") + stability.asked_words(shares[f, s])
        for _, f, s in best
    )
    return (
        f"What breaks first: {len(stressors)} stressors as ladders, every formulation with every"
        " solver; a field counts the combinations that stand on every rung, its letter is what"
        f" brings most others down ({stability.LEGEND}). A ladder has the rungs that at least half"
        f" of the combinations were asked, {rungs_words(ladders)}. Of {fields} ladders that are"
        f" defined {stands} stand on all of theirs, most often {names}; most of the others end"
        " with " + ", ".join(f"{word} ({n})" for word, n in worst) + "."
    )


def effects_words(cells: pd.DataFrame) -> str:
    found = list(effects.groups(cells[cells["campaign"].str.startswith("effects")]))
    ratios = {}
    for _, _, by in found:
        declared = by.get("as declared")
        for name, c in by.items():
            if declared is not None and declared["good"] and c["good"]:
                ratios.setdefault(name, []).append(effects.shortest(c) / effects.shortest(declared))
    dropped = [r for r in ratios.get("auto", []) if r < 0.9]
    compared = effects.compare(found)
    noise = effects.noise_of(compared)
    other = [r for _, _, r, same, _ in compared if not same]
    dearer = sum(r > 1 + noise for r in other)
    return (
        "What an effect is worth: time with everything on, with the effects that the"
        " run called for (`--effects auto:1e-6`), and with one declared effect dropped, over the"
        f" time as declared. {len(compared) - len(other)} of {len(compared)} scenes declare all"
        f" that costs: their work is the same with everything on, and tells the noise"
        f" ({noise:.0%}). As declared is dearer beyond it in {dearer} of the other {len(other)}."
        f" Without friction a run takes {np.median(ratios.get('-friction', [math.nan])):.2f} times"
        " the time (median),"
        f" and watching saves something in {len(dropped)} scenes, at most a factor"
        f" {1 / min(dropped, default=1):.2g}."
    )


def dimension_words(cells: pd.DataFrame) -> str:
    """Whose unknowns are the normal impulses, of the formulations in these rows with friction."""
    few = [
        f"`{f}`"
        for f in registry.with_trait("normal_only")
        if not registry.trait(f, "frictionless") and (cells["formulation"] == f).any()
    ]
    if not few:
        return ""
    one = len(few) == 1
    return (
        f"{' and '.join(few)} {'keeps' if one else 'keep'} the normal impulses only, so"
        f" {'its' if one else 'their'} problem has as many unknowns as there are active contacts,"
        " where a polyhedral cone with *nd* facets has *nd* + 2 times as many."
    )


def machines_words(cells: pd.DataFrame) -> str:
    """Which campaigns are of which machine, where there are several."""
    classes = cells["host_class"].map(lambda c: ", ".join(str(c).split("; ")[:3]))
    by = {c: sorted(set(cells[classes == c]["campaign"])) for c in sorted(set(classes))}
    if len(by) < 2:
        return ""
    told = "; ".join(f"{c}: {', '.join(names)}" for c, names in by.items())
    return f" ({told}; times of two machines are not compared)"


def spread_words(cells: pd.DataFrame) -> str:
    """How far processes of one undisturbed cell are apart: one ratio below that tells little."""
    some = cells[cells["good"] & (cells["disturbed"] == "") & cells["between"].notna()]
    told = [
        f"{name} {100 * (g['between'] > 1.2).mean():.0f} %"
        for name, g in some.groupby("campaign")
        if len(g) >= 20
    ]
    if not told:
        return ""
    return (
        "Of the undisturbed solved cells so many have two processes that differ by more than a"
        f" factor of 1.2: {', '.join(told)}."
    )


def yardsticks_words(cells: pd.DataFrame) -> str:
    """On how many solved cells each of the three errors is known."""
    some = cells[cells["good"]]
    if not len(some):
        return ""
    known = [some[k].notna() for k in ("rho", "res_ncp_rel", "err_ref")]
    told = [f"{k.mean():.0%}" for k in [*known, known[0] & known[1] & known[2]]]
    return (
        f"Of the {len(some):,} solved cells {told[0]} have `rho`, {told[1]} the residual of the"
        f" exact Coulomb problem, {told[2]} an error of the motion (against a closed form, or a"
        f" converged run of another method) and {told[3]} all three. "
    )


def measured_words(cells: pd.DataFrame, manifests: dict[str, dict]) -> str:
    """Where the rows come from."""
    commit = sorted({str(c)[:12] for c in cells["suite_commit"] if c})
    load = cells["load1"].astype(float).median() if "load1" in cells else math.nan
    form = cut.forms(manifests) or "unknown form"
    one = cells["host_class"].nunique() < 2
    known = (
        zip(cells["campaign"], cells["suite_dirty"], strict=True) if "suite_dirty" in cells else ()
    )
    dirty = sorted({name for name, changed in known if str(changed).lower() == "true"})
    changed = f" ({', '.join(dirty)} from a tree with changes)" if dirty else ""
    return (
        f"Measured by `scripts/reproduce`, {len(cells)} cells of {len(manifests)} campaigns"
        f" ({form}), commit {', '.join(commit) or 'unknown'}{changed}, at a load of {load:.1g}"
        f" on the machine{'' if one else 's'} named in the manifests{machines_words(cells)}."
        f" {yardsticks_words(cells)}{disturbed_words(cells)} {spread_words(cells)}"
    )


def short_words(cells: pd.DataFrame, have: set[str], manifests: dict[str, dict]) -> str:
    """The README: which to take, and what accuracy costs."""
    return "".join(
        [
            advice_in_short(cells),
            "\n",
            headline_words(cells),
            crowded_words(cells, counts_alone=True),
            picture(
                "accuracy_against_time",
                "Error against time",
                have,
                accuracy_words(cells),
                at="results/reference/figures",
            ),
            measured_words(cells, manifests),
            "\n",
        ]
    )


def surface_words(cells: pd.DataFrame) -> str:
    return (
        "What limits the error: one of step, tolerance, and facets or stiffness made coarse, all"
        f" others fine. {surface.message(surface.surfaces(accuracy.own(cells)))}"
    )


def long_words(
    cells: pd.DataFrame, ladders: stability.Ladders, have: set[str], manifests: dict[str, dict]
) -> str:
    """results/README.md: all figures, each with what it says."""
    table = paper.summary(paper.own(cells))
    left = cut.table(manifests)
    out = [
        advice_words(cells),
        "\n",
        headline_words(cells),
        moving_words(cells),
        crowded_words(cells),
        picture("accuracy_against_time", "Error against time", have, accuracy_words(cells)),
        picture("surfaces", "What limits the error", have, surface_words(cells)),
        picture("stability", "Stability map", have, stability_words(ladders)),
        picture("effects", "Effects", have, effects_words(cells)),
        picture("dimension", "Unknowns of the LCP against contacts", have, dimension_words(cells)),
        f"{table.caption}\n\n{section.table_md(table)}\n" if table is not None else "",
        measured_words(cells, manifests),
        "\n",
        f"\n{left.caption}\n\n{section.table_md(left)}\n" if left else "",
    ]
    return "".join(out)


def write_between(page: pathlib.Path, text: str) -> None:
    """Replaces what stands between the markers of a page."""
    old = page.read_text(encoding="utf-8")
    page.write_text(
        re.sub(
            re.escape(BEGIN) + ".*?" + re.escape(END), lambda _: BEGIN + text + END, old, flags=re.S
        ),
        encoding="utf-8",
    )


def main() -> int:
    parser = say.Arguments(prog="scripts/reference", description=__doc__)
    parser.add_argument(
        "folder",
        nargs="?",
        default=str(ROOT / "results" / "runs"),
        help="folder of campaigns (default: results/runs)",
    )
    parser.add_argument(
        "--out",
        default=str(ROOT),
        help="where results/reference, results/README.md and README.md are (default: this project)",
    )
    args = parser.parse_args()
    source, root = pathlib.Path(args.folder), pathlib.Path(args.out)
    try:
        all_rows, manifests = rows.load_all(source)
    except rows.BadRows as error:
        say.complain(error)
        return 2
    pages = (root / "README.md", root / "results" / "README.md")
    for page in pages:
        readme = page.read_text(encoding="utf-8")
        if BEGIN not in readme or END not in readme:
            say.complain(f"{page}: the markers '{BEGIN.strip()}' and '{END.strip()}' are missing")
            return 2
    cells = rows.cells(all_rows)
    target = root / "results" / "reference"
    target.mkdir(parents=True, exist_ok=True)
    if source.resolve() != target.resolve():
        pack(source, target)
    ladders = stability.ladders(cells)
    have = figures(cells, ladders, target / "figures")
    write_between(pages[0], short_words(cells, have, manifests))
    write_between(pages[1], long_words(cells, ladders, have, manifests))
    print(target)
    return 0


if __name__ == "__main__":
    sys.exit(main())

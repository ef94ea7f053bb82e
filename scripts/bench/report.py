"""report DIR [--out FOLDER] [--pdf] - the page and the LaTeX document of one or several
campaigns."""

import pathlib
import shutil
import subprocess
import sys

import pandas as pd

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from bench import (  # noqa: E402
    accuracy,
    asked,
    calibration,
    claims,
    crowded,
    effects,
    engine_rows,
    engines,
    headline,
    latex,
    library,
    limits,
    moving,
    page,
    paper,
    rows,
    say,
    scaling,
    stability,
    surface,
    warm,
)
from bench.section import Section  # noqa: E402

LIMIT = 5_000_000  # bytes of the page


def paper_section(cells: pd.DataFrame) -> Section:
    own = paper.own(cells)
    charts = [c for c in (make(own) for make in paper.CHARTS) if c] if len(own) else []
    if not charts:
        return None
    return Section(
        "paper",
        "How large, how long, how wrong",
        f"The {claims.SUBJECT} formulation against the polyhedral ones: unknowns, time and error.",
        charts,
        [t for t in (paper.summary(own),) if t],
    )


def accuracy_section(cells: pd.DataFrame, calibrated: list[dict]) -> Section:
    made = accuracy.section(cells)
    readings = headline.table(cells) if made else None
    if readings:
        made.tables.insert(0, readings)
    found = surface.surfaces(accuracy.own(cells)) if made else []
    if found:
        made.charts.append(surface.chart(found))
        made.tables.append(surface.table(found))
    if made and calibrated:
        made.tables.append(calibration.table(calibrated))
    return made


def stability_section(ladders: stability.Ladders, bounds: list[dict]) -> Section:
    made = stability.section(ladders)
    if made and bounds:
        made.tables.insert(1, limits.table(bounds))
    return made


def gather(
    cells: pd.DataFrame,
    manifests: dict[str, dict],
    ladders: stability.Ladders,
    bounds: list[dict],
    calibrated: list[dict],
    noise: float,
    measured: list[engine_rows.Row],
    wanted: list[asked.Row],
) -> list[Section]:
    """Sections in the order of the questions; what this campaign cannot answer is named, not left
    out in silence."""
    makers = [
        ("claims", claims.section),
        ("paper", paper_section),
        ("accuracy", lambda c: accuracy_section(c, calibrated)),
        ("stability", lambda _: stability_section(ladders, bounds)),
        ("effects", effects.section),
        ("scaling", scaling.section),
        ("library", lambda c: library.section(c, noise)),
        ("warmstart", warm.section),
        ("moving", moving.section),
        ("crowded", crowded.section),
    ]
    sections, absent = [], []
    sequences = warm.of(cells)
    own = cells[
        ~cells["command"].str.contains("--effects|--contact-order") & ~sequences
    ]  # an experiment with effects, orders or sequences answers its own section only
    given = {"effects": cells[~sequences], "warmstart": cells}
    for name, make in makers:
        made = make(given.get(name, own))
        if made:
            sections.append(made)
        else:
            absent.append(name)
    beside = (asked.section(wanted), engines.section(measured))
    sections += [made for made in beside if made]
    bad = page.failures_table(cells)
    refused = int(stability.refusals(cells).sum())
    undefined = page.undefined_table(cells)
    sections.append(
        Section(
            "failures",
            "Failures",
            f"{sum(int(r[2]) for r in bad.rows)} cells failed or were not verified, {refused} of"
            " them refusals where no solution exists, which is the right answer there;"
            f" {sum(int(r[2]) for r in undefined.rows)} were not defined or left out.",
            [],
            [t for t in (bad, undefined) if t.rows],
        )
    )
    sections.append(
        Section(
            "cells",
            "All cells",
            "Filter, sort, and rerun any of them.",
            [],
            [page.cells_table(cells)],
        )
    )
    lead = (
        "Every figure, table and verdict of this page is computed from the rows; results/FORMAT.md"
        " explains the columns." + (f" No rows for: {', '.join(absent)}." if absent else "")
    )
    sections.append(Section("method", "Method", lead, [], page.method_tables(manifests)))
    return sections


def facts(
    all_rows: pd.DataFrame,
    cells: pd.DataFrame,
    sections: list[Section],
    manifests: dict[str, dict],
    cards: list[dict],
) -> dict[str, str]:
    found = surface.surfaces(accuracy.own(cells))
    out = {
        "Masthead": page.masthead(cells, manifests),
        "Campaigns": ", ".join(sorted(set(cells["campaign"]))),
        "AnswerLevel": f"{accuracy.LEVEL:g}",
        "Answers": "; ".join(f"{accuracy.kind(c)}: {c['use']}" for c in cards if c["use"]),
        "Limits": surface.message(found) if found else "",
        "NumRows": str(len(all_rows)),
        "NumCells": str(len(cells)),
        "NumVerified": str(int(cells["good"].sum())),
        "NumFalseClaims": str(int((cells["status"] == "unverified").sum())),
    }
    for s in sections:
        out.update(s.facts)
    return out


def main() -> int:
    parser = say.Arguments(
        prog="scripts/report",
        description="One HTML page and a LaTeX document from the rows under DIR.",
    )
    parser.add_argument("folder", metavar="DIR", help="campaign, or folder of campaigns")
    parser.add_argument("--out", help="where the report goes (default: DIR/report)")
    parser.add_argument(
        "--pgf", action="store_true", help="also the figures as PGF (slow; needs pdflatex)"
    )
    parser.add_argument("--pdf", action="store_true", help="build the LaTeX document")
    args = parser.parse_args()
    out = pathlib.Path(args.out or pathlib.Path(args.folder) / "report")
    try:
        all_rows, manifests = rows.load_all(args.folder)
    except rows.BadRows as problem:
        say.complain(problem)
        return 2
    cells = rows.cells(all_rows)
    measured = rows.noise(args.folder)
    noise = measured or rows.TIE
    names = sorted(set(cells["campaign"]))
    title = "lcpbench: " + ", ".join(names)
    bounds = [
        r
        for path in sorted(pathlib.Path(args.folder).glob("**/limits.csv"))
        for r in limits.load(path)
    ]
    calibrated = [
        f
        for path in sorted(pathlib.Path(args.folder).glob("**/calibration.jsonl"))
        for f in calibration.load(path)
    ]
    try:
        of_engines = [
            r
            for path in sorted(pathlib.Path(args.folder).glob(f"**/{engine_rows.FILE}"))
            for r in engine_rows.read(path)
        ]
        wanted = [
            r
            for path in sorted(pathlib.Path(args.folder).glob(f"**/{asked.FILE}"))
            for r in asked.read(path)
        ]
    except ValueError as problem:
        say.complain(problem)
        return 2
    ladders = stability.ladders(cells)
    sections = gather(cells, manifests, ladders, bounds, calibrated, noise, of_engines, wanted)
    defined = cells[~cells["status"].isin(["unsupported", "skipped"])]
    floor = ", measured as the same work under two names" if measured else " not measured"
    commits = sorted({str(c)[:12] for c in cells.get("suite_commit", []) if c})
    counts = (
        f"{len(all_rows)} rows are repetitions of {len(cells)} cells, each one problem with one"
        f" formulation, solver and setting: {int(cells['good'].sum())} verified,"
        f" {int((~defined['good']).sum())} failed or not verified "
        f"(of these {int((cells['status'] == 'unverified').sum())} false claims),"
        f" {len(cells) - len(defined)} not defined. "
        f"Times closer than {noise - 1:.0%} are ties"
        f" (noise floor{floor}). Commit {', '.join(commits) or 'unknown'}."
    )
    advised = accuracy.scenes(accuracy.own(cells))
    cards = accuracy.advise(cells) if advised else []
    falls = stability.falls(ladders)
    shares = stability.asked(ladders)
    for card in [*cards, *(c["large"] for c in cards if c.get("large"))]:
        key = (card.get("formulation"), card.get("solver"))
        card["breaks"] = stability.fall_words(falls.get(key), shares.get(key, (0, 0)))
    advice = accuracy.advice(cards) if cards else None
    names = page.names_table(cells)
    out.mkdir(parents=True, exist_ok=True)
    text = page.render(
        title,
        counts,
        "Made by scripts/report from results.csv and manifest.json.",
        cells,
        manifests,
        cards,
        advice,
        names,
        sections,
    )
    (out / "index.html").write_text(text)
    latex.write(
        out / "latex",
        facts(all_rows, cells, sections, manifests, cards),
        [Section("how", "Method", latex.METHOD, [], [latex.units()])]
        + ([Section("advice", "Which one to use", "", [], [advice])] if advice else [])
        + sections
        + [Section("names", "What the names mean", "", [], [names])],
        args.pgf,
    )
    print(out / "index.html")
    if len(text.encode()) > LIMIT:
        say.complain(f"report: the page has {len(text.encode())} bytes, more than {LIMIT}")
        return 1
    return build(out / "latex") if args.pdf else 0


def build(folder: pathlib.Path, document: str = "main.tex") -> int:
    """Compiles a document of a folder; 0 when it came out."""
    if not shutil.which("latexmk"):
        say.complain("report: no latexmk; run scripts/setup latex")
        return 1
    done = subprocess.run(
        ["latexmk", "-pdf", "-halt-on-error", "-interaction=nonstopmode", "-quiet", document],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    if done.returncode:
        print(done.stdout[-3000:], file=sys.stderr)
        return 1
    print((folder / document).with_suffix(".pdf"))
    return 0


if __name__ == "__main__":
    sys.exit(main())

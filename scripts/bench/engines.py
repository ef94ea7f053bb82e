"""engines DIR [--out FOLDER] [--scenes LIST] - the figure of the rows that scripts/engines wrote:
error against time a step, one panel a scene, for every engine at every setting and for our own
formulations; or those rows as a table. And the section of the page."""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from bench import chart, engine_rows, experiments, say, style  # noqa: E402
from bench.chart import Chart, Line, Panel
from bench.engine_rows import Row, value
from bench.section import Cell, Section, Table, error, si

FLOOR = 1e-12  # drawn, not computed: an exact answer has no place on a logarithmic axis
OWN = "lcpbench"  # the engine's name of our own rows


def name(row: Row) -> str:
    """What a line of the figure is called."""
    return row.setting if row.engine == OWN else f"{row.engine} {row.setting}"


def variants(rows: list[Row]) -> dict[str, int]:
    """name -> its number among the settings of its engine, or the solvers of its formulation."""
    seen: dict[str, list[str]] = {}
    for r in rows:
        same = seen.setdefault(name(r).split(" ")[0], [])
        if name(r) not in same:
            same.append(name(r))
    return {n: same.index(n) for same in seen.values() for n in same}


def scenes(rows: list[Row]) -> list[str]:
    """Scenes with a reference that something was measured against, in the order of the rows."""
    return list(dict.fromkeys(r.scene for r in rows if r.error and r.t_step_s))


def line(rows: list[Row], variant: int) -> Line:
    """One engine at one setting over the steps, the longest first; what did not end well is a
    cross."""
    some = sorted((r for r in rows if r.error and r.t_step_s), key=lambda r: -value(r.step_s))
    points = [(value(r.t_step_s) * 1e3, max(value(r.error), FLOOR), r) for r in some]
    good = [p for p in points if p[2].status == "ok"]
    return Line(
        name(rows[0]),
        [x for x, _, _ in good],
        [y for _, y, _ in good],
        bad=[(x, y) for x, y, r in points if r.status != "ok"],
        hover=[
            f"{name(r)} {r.version}, {r.options or 'defaults'}, step {r.step_s} s"
            for _, _, r in good
        ],
        variant=variant,
    )


def figure(rows: list[Row]) -> Chart | None:
    shown = scenes(rows)
    if not shown:
        return None
    index, panels = variants(rows), []
    for scene in shown:
        here = [r for r in rows if r.scene == scene]
        names = list(dict.fromkeys(name(r) for r in here if r.error and r.t_step_s))
        panels.append(
            Panel(
                [line([r for r in here if name(r) == n], index[n]) for n in names],
                title=scene.replace("_", " "),
                xlabel="time a step [ms]",
                ylabel=f"error [{unit(here)}]",
            )
        )
    steps = ", ".join(sorted({r.step_s for r in rows if r.step_s}, key=float))
    return Chart(
        "engines",
        "Error of the scene's first kinematic check against time a step, for every engine and"
        f" setting at steps of {steps} s (a line joins the steps) and for our own formulations, by"
        f" the same judge, on one thread of one processor. Errors below {FLOOR:g} are drawn there."
        " A cross is a run that did not end well. Planar scenes are slabs in engines of space.",
        panels,
        columns=4,
        height=1.55,
    )


def unit(rows: list[Row]) -> str:
    told = next((r.quantity for r in rows if r.quantity), "")
    what = told.rpartition(" ")[2].partition(".")[2]
    if what.startswith("omega"):
        return "rad/s"
    return "rad" if what.startswith("angle") else "m/s" if what.startswith("v") else "m"


def number(text: str) -> Cell | str:
    v = value(text)
    return Cell(error(v), sort=v) if math.isfinite(v) else ""


def table(rows: list[Row]) -> Table:
    """Every row, with its setting and its version."""
    body = []
    for r in rows:
        t = value(r.t_step_s)
        body.append(
            [
                r.scene,
                Cell(f"{r.engine} {r.version}", look=name(r).split(" ")[0]),
                Cell(r.setting, title=r.options or "defaults"),
                r.step_s,
                r.status if not r.note else Cell(r.status, title=r.note),
                number(r.error),
                number(r.penetration_m),
                number(r.creep_m_s),
                number(r.energy_gain_J),
                number(r.coulomb),
                Cell(si(t, "s"), sort=t) if math.isfinite(t) else "",
            ]
        )
    return Table(
        "engines",
        "Engines on the suite's scenes.",
        [
            "scene",
            "engine",
            "setting",
            "step [s]",
            "status",
            "error",
            "penetration [m]",
            "creep [m/s]",
            "energy gain [J]",
            "Coulomb residual",
            "time a step",
        ],
        body,
        paper=False,
    )


def settings_table(rows: list[Row]) -> Table:
    """What each setting is, and who recommends it."""
    known = {(s["engine"], s["name"]): s["source"] for s in experiments.of("engines.settings")}
    used = dict.fromkeys(
        (r.engine, r.version, r.setting, r.options) for r in rows if r.engine != OWN and r.setting
    )
    return Table(
        "engine_settings",
        "Settings of the engines.",
        ["engine", "setting", "options", "what it is, or who recommends it"],
        [
            [f"{engine} {version}", setting, options or "none", known.get((engine, setting), "")]
            for engine, version, setting, options in used
        ],
    )


def section(rows: list[Row]) -> Section | None:
    """The section of the page; None without rows."""
    if not rows:
        return None
    absent = [f"{r.engine} ({r.note})" for r in rows if r.status == "absent"]
    here = [r for r in rows if r.scene]
    drawn = figure(here)
    machine = f" Processor: {rows[0].cpu}." if rows[0].cpu else ""
    return Section(
        "engines",
        "Other engines on the same scenes",
        "The same judge reads the states of all; no engine is asked what it thinks of itself. Each"
        " is run as it comes and at settings that its documentation recommends. An engine solves"
        " the problem that it has chosen, mostly a softened one: its error is not a solver's."
        + machine
        + (f" Absent: {', '.join(absent)}." if absent else ""),
        [drawn] if drawn else [],
        [settings_table(here), table(here)],
    )


SHOWN = ("scene", "engine", "setting", "step_s", "status")
FIRST, LAST = map(engine_rows.NAMES.index, ("error", "n_contact"))
MEASURED = [n for n in engine_rows.NAMES[FIRST:LAST] if n != "quantity"]


def printed(rows: list[Row]) -> str:
    """Rows for a terminal, two digits a number, without times."""
    lines = [(*SHOWN, *MEASURED)]
    for r in rows:
        numbers = [error(value(getattr(r, c))) or "-" for c in MEASURED]
        lines.append((*(getattr(r, c) for c in SHOWN), *numbers))
    wide = [max(len(line[k]) for line in lines) for k in range(len(lines[0]))]
    return "\n".join(
        "  ".join(text.ljust(w) for text, w in zip(line, wide, strict=True)).rstrip()
        for line in lines
    )


def main() -> int:
    parser = say.Arguments(prog="scripts/bench/engines.py", description=__doc__)
    parser.add_argument("folder", metavar="DIR", help="folder with engines.csv")
    parser.add_argument("--out", help="where the figure goes (default: DIR/figures)")
    parser.add_argument("--scenes", metavar="LIST", help="print the rows of these, and no figure")
    args = parser.parse_args()
    try:
        rows = engine_rows.read(pathlib.Path(args.folder) / engine_rows.FILE)
    except (OSError, ValueError) as problem:
        say.complain(problem)
        return 2
    if args.scenes:
        print(printed([r for r in rows if r.scene in args.scenes.split(",")]))
        return 0
    drawn = figure([r for r in rows if r.scene])
    if drawn is None:
        say.complain("engines: no row has an error and a time")
        return 3
    out = pathlib.Path(args.out or pathlib.Path(args.folder) / "figures")
    style.save(chart.draw(drawn), out, drawn.name)
    (out / f"{drawn.name}.dat").write_text(chart.table(drawn))
    print(out / f"{drawn.name}.pdf")
    return 0


if __name__ == "__main__":
    sys.exit(main())

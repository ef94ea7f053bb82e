"""The report as one self-contained HTML page: no network, readable without JavaScript, the same
bytes each time."""

import base64
import gzip
import html
import io
import pathlib
from collections.abc import Iterator

import jinja2
import numpy as np
import pandas as pd
import plotly
from markupsafe import Markup
from matplotlib.figure import Figure
from PIL import Image

from bench import accuracy, registry, style
from bench import chart as chart_
from bench.chart import Chart, Heat
from bench.cut import forms
from bench.cut import table as left_out
from bench.section import Cell, Section, Table, error, si, table_html

HERE = pathlib.Path(__file__).resolve().parent
SCOPE = (
    "Times hold for the machine and build they name; errors and counters hold everywhere, to"
    " rounding. A row counts only when the judge, which never trusts the solver, confirmed every"
    " solve of it: to 1e-9 (exact methods) or 1e-6, and where accuracy is the question to the"
    " tolerance that was asked for. Differences inside the noise of the clock are ties. Nothing"
    " here says anything about scenes that are not in the tables."
)


def png(figure: Figure) -> str:
    out, small = io.BytesIO(), io.BytesIO()
    figure.savefig(out, format="png", dpi=160, metadata={"Software": "lcpbench"})
    style.plt.close(figure)
    Image.open(out).convert("RGB").quantize(128).save(small, format="png", optimize=True)
    return base64.b64encode(small.getvalue()).decode()


def picture(chart: Chart | Heat) -> dict:
    """A chart for the page: a drawing, and what makes it interactive."""
    made = chart_.plotly_heat if isinstance(chart, chart_.Heat) else chart_.plotly
    spec = Markup(made(chart).replace("</", "<\\/"))
    return {
        "name": chart.name,
        "caption": chart.caption,
        "data": png(chart_.draw(chart)),
        "json": spec,
    }


def library() -> str:
    """Plotly's own bundle, packed."""
    path = pathlib.Path(plotly.__file__).parent / "package_data" / "plotly.min.js"
    return base64.b64encode(gzip.compress(path.read_bytes(), 9, mtime=0)).decode()


FILTERS = [("problem family", 1), ("formulation", 3), ("solver", 4), ("status", 6), ("campaign", 0)]


# cells of a table that a browser sorts and filters at once, and that keep the page below its limit
MOST = 4000


def fewer(cells: pd.DataFrame) -> tuple[pd.DataFrame, str]:
    """Where there are too many: all that failed, and of the others the smallest step of each
    ladder. (cells, what was left out)."""
    if len(cells) <= MOST:
        return cells, ""
    ladder = cells.groupby(
        ["campaign", "part", "problem", "combination", "effects", "tol", "start"], dropna=False
    )["step_s"]
    kept = cells[
        ~cells["good"] | cells["step_s"].isna() | (cells["step_s"] == ladder.transform("min"))
    ]
    return (
        kept,
        (
            f", and {len(cells) - len(kept)} verified ones at larger steps than their ladder's"
            " smallest, which are in results.csv"
        ),
    )


def cells_table(cells: pd.DataFrame) -> Table:
    """Every cell, but of the stability campaign only as ladders (its own table): a page of all of
    its rungs would not load."""
    ladders = cells["campaign"].str.startswith("stability")
    left = int(ladders.sum())
    cells, coarser = fewer(cells[~ladders])
    rows = []
    for c in cells.to_dict("records"):
        mark = "" if c["good"] else "none" if c["status"] in ("unsupported", "skipped") else "bad"
        rows.append(
            [
                c["campaign"],
                c["problem_family"],
                c["problem"],
                join(c["formulation"], c["formulation_options"]),
                join(c["solver"], c["solver_options"]),
                f"{c['step_s']:g}" if c["step_s"] == c["step_s"] else "",
                Cell(c["status"], mark, c.get("note", "")),
                f"{c['n_contacts']:g}" if c["n_contacts"] == c["n_contacts"] else "",
                f"{c['lcp_dim']:g}" if c["lcp_dim"] == c["lcp_dim"] else "",
                Cell(si(c.get("t_total_s"), "s"), sort=num(c.get("t_total_s"))),
                Cell(error(c["err_ref"]), sort=num(c["err_ref"])),
                Cell(error(c.get("res_ncp_rel")), sort=num(c.get("res_ncp_rel"))),
                Cell(error(c["rho"]), sort=num(c["rho"])),
                c.get("command", ""),
            ]
        )
    return Table(
        "cells",
        f"All {len(rows)} cells"
        + (
            f" but the {left} rungs of the stability ladders, which are summed up in their own"
            " table"
            if left
            else ""
        )
        + coarser
        + "; the last column is the command that reruns the cell.",
        [
            "campaign",
            "family",
            "problem",
            "formulation",
            "solver",
            "step [s]",
            "status",
            "contacts",
            "LCP",
            "time",
            "error",
            "Coulomb residual",
            "rho",
            "command",
        ],
        rows,
        code=13,
        paper=False,
    )


def num(v: float) -> float | None:
    return float(v) if v is not None and v == v else None


def join(name: str, opts: str) -> str:
    return f"{name}:{opts}" if opts else name


def failures_table(cells: pd.DataFrame) -> Table:
    bad = cells[~cells["good"] & ~cells["status"].isin(["unsupported", "skipped"])]
    rows = []
    for (status, combo), g in bad.groupby(["status", "combination"]):
        first = g.iloc[0]
        signals = sorted({s for s in g.get("exit_signal", []) if s and s != "0"})
        rows.append(
            [
                Cell(status, "bad"),
                combo,
                str(len(g)),
                ", ".join(sorted(set(g["problem"]))[:6])
                + (" …" if g["problem"].nunique() > 6 else ""),
                (first.get("note", "") or "claimed " + str(first["status_claimed"]))
                + (f"; signal {', '.join(signals)}" if signals else ""),
                str(first.get("command", "")),
            ]
        )
    return Table(
        "failures",
        "Failures, grouped by cause and combination; none is left out of a denominator.",
        ["status", "combination", "cells", "problems", "first note", "rerun the first"],
        rows,
        code=5,
    )


def undefined_table(cells: pd.DataFrame) -> Table:
    some = cells[cells["status"].isin(["unsupported", "skipped"])]
    rows = [
        [status, combo, str(len(g)), g.iloc[0].get("note", "")]
        for (status, combo), g in some.groupby(["status", "combination"])
    ]
    return Table(
        "undefined",
        "Combinations that are not defined or were left out by policy, with the reason.",
        ["status", "combination", "cells", "reason"],
        rows,
        paper=False,
    )


def flatten(data: dict, prefix: str = "") -> Iterator[tuple[str, str]]:
    for key in sorted(data):
        value = data[key]
        if isinstance(value, dict):
            yield from flatten(value, f"{prefix}{key}.")
        elif isinstance(value, list):
            yield prefix + key, ", ".join(map(str, value))[:400]
        else:
            yield prefix + key, str(value)[:600]


def method_tables(manifests: dict[str, dict]) -> list[Table]:
    left = left_out(manifests)
    return ([left] if left else []) + [
        Table(
            f"manifest_{name}",
            f"Manifest of {name}: what was run, on what, with what.",
            ["key", "value"],
            [[k, v] for k, v in flatten(m)],
            paper=False,
        )
        for name, m in manifests.items()
        if m
    ]


def names_table(cells: pd.DataFrame) -> Table:
    """Formulations and solvers of these rows, for a reader who meets the names for the first
    time."""
    rows = []
    for kind, column, order in (
        ("formulation", "formulation", registry.by_formulation),
        ("solver", "solver", registry.by_solver),
    ):
        known = registry.listed(f"{kind}s")
        for name in order({n for n in cells[column] if n}):
            what = known.get(name)
            rows.append(
                [
                    Cell(name, look=name),
                    kind,
                    *(
                        [what["words"], what["when"], what["cite"]]
                        if what
                        else [Cell("unknown to this build", "none"), "", ""]
                    ),
                ]
            )
    return Table(
        "names",
        "The names on this page. Each has its colour and marker in every figure.",
        ["name", "is a", "what it is", "when to take it", "source"],
        rows,
    )


def masthead(cells: pd.DataFrame, manifests: dict[str, dict]) -> str:
    """Product, version, date, processor, form: what a reader must know before a number."""
    machines = [m.get("machine", {}) for m in manifests.values()]
    classes = sorted({c for c in cells["host_class"] if c})
    cpus = classes or sorted({m["cpu"] for m in machines if m.get("cpu")})
    days = sorted({str(d)[:10] for d in cells["started_utc"] if d})
    commits = sorted({str(c)[:12] for c in cells["suite_commit"] if c})
    form = forms(manifests)
    parts = [
        f"lcpbench {', '.join(commits)}".strip(),
        f"measured {days[0]}" + (f" to {days[-1]}" if len(days) > 1 else "") if days else "",
        f"on {' and '.join(cpus)}" if cpus else "",
        f"{form}: a smoke test, not a reference" if form == "quick form" else form,
    ]
    return " · ".join(p for p in parts if p)


def band(cells: pd.DataFrame) -> str:
    """What stands above everything where rows were disturbed; nothing where none was."""
    n = int((cells["disturbed"] != "").sum())
    if not n:
        return ""
    why = ", ".join(sorted({w for d in cells["disturbed"] if d for w in d.split(", ")}))
    where = ", ".join(sorted(set(cells["campaign"][cells["disturbed"] != ""])))
    return (
        f"{n} of {len(cells)} cells were measured on a disturbed machine ({why}; in {where}). Their"
        " markers are hollow, their ties wider by the drift of the canaries, and their times worth"
        " a factor at best."
    )


SPARK = (150, 44)  # of the small picture [px]


def spark(cells: pd.DataFrame) -> str:
    """What a tenth of the error costs: the median over the scenes, and the front of the scene
    next to it as a small picture. Empty where no front spans a decade."""
    found = accuracy.tenths(accuracy.own(cells))
    if not found:
        return ""
    factor = float(np.median([f for f, _, _ in found]))
    _, problem, front = min(found, key=lambda e: (abs(e[0] - factor), e[1]))
    x, y = (np.log(front[c].to_numpy(float)) for c in ("err_ref", "cost"))
    w, h = SPARK
    name = html.escape(accuracy.short(problem))
    points = " ".join(
        f"{4 + (w - 8) * (a - x.min()) / (np.ptp(x) or 1):.1f},"
        f"{h - 4 - (h - 8) * (b - y.min()) / (np.ptp(y) or 1):.1f}"
        for a, b in sorted(zip(x, y, strict=True))
    )
    return (
        f'<p class="price"><b>{factor:.2g} ×</b> the time for a tenth of the error'
        f" <small>(median of {len(found)} scenes; the picture: {name},"
        " time up, error to the right)</small>"
        f'<svg width="{w}" height="{h}" role="img" aria-label="time against error">'
        f'<polyline points="{points}" fill="none" stroke="currentColor" stroke-width="2"/>'
        "</svg></p>"
    )


def plain(*names: str) -> str:
    """'regularized: solves for ...' for each of the names that this build knows."""
    return " ".join(
        f"{name}: {registry.words(name)[0].lower()}{registry.words(name)[1:]}"
        for name in names
        if registry.words(name)
    )


def card(a: dict) -> dict:
    """One situation of the first screen, in words."""
    stands_for = registry.listed("situations")[a["situation"]]["words"]
    if not a["use"]:
        return {
            "situation": accuracy.kind(a),
            "stands_for": stands_for,
            "use": "",
            "why": (
                "Nothing in these rows reaches it."
                if a["scenes"]
                else "No scene of this kind in these rows."
            ),
        }
    large, behind = accuracy.largest_words(a["large"])
    told = {w: accuracy.rivals_in_short(a["others"], k) for k, w in accuracy.OTHERS.items()}
    other = " ".join(f"{w[0].upper()}{w[1:]}: {names}." for w, names in told.items() if names)
    return {
        "situation": accuracy.kind(a),
        "stands_for": stands_for,
        "use": Markup(
            " + ".join(
                f"{style.swatch(n)}{html.escape(n)}" for n in (a["formulation"], a["solver"])
            )
        ),
        "plain": plain(a["formulation"], a["solver"]),
        "cost": f"{si(a['per_step'], 's', 2)} a step",
        "what": (
            f"{a['problem'].split(':')[0].replace('_', ' ')}, {a['contacts']:g} contacts, step"
            f" {a['step'] * 1e3:g} ms"
        ),
        "why": (
            f"Gets there on {a['reached']} of the {a['scenes']} scenes it was run on;"
            f" {accuracy.all_ran_words(a)}."
        ),
        "other": other,
        "breaks": a["breaks"],
        "large": large,
        "behind": f"{behind} {a['large']['breaks']}" if large else "",
        "command": a["command"],
    }


def render(
    title: str,
    counts: str,
    footer: str,
    cells: pd.DataFrame,
    manifests: dict[str, dict],
    cards: list[dict],
    advice: Table,
    names: Table,
    sections: list[Section],
) -> str:
    env = jinja2.Environment(
        loader=jinja2.FileSystemLoader(HERE),
        autoescape=True,
        trim_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    body = []
    for s in sections:
        tables = [
            Markup(filters() if t.name == "cells" else "") + Markup(table_html(t)) for t in s.tables
        ]
        body.append(
            {
                "id": s.id,
                "title": s.title,
                "lead": s.lead,
                "first": tables[:1] if s.id == "claims" else [],
                "tables": tables[1:] if s.id == "claims" else tables,
                "charts": [picture(c) for c in s.charts],
            }
        )
    links = [{"id": "advice", "short": "Which one to use"}] + [
        {"id": s.id, "short": SHORT.get(s.id, s.title)} for s in sections
    ]
    return env.get_template("page.html.j2").render(
        title=title,
        level=f"{accuracy.LEVEL:g}",
        counts=counts,
        masthead=masthead(cells, manifests),
        band=band(cells),
        price=Markup(spark(cells)),
        footer=footer,
        scope=SCOPE,
        cards=[card(a) for a in cards],
        read=accuracy.READ,
        advice=Markup(table_html(advice)) if advice else "",
        names=Markup(table_html(names)),
        sections=links,
        body=body,
        css=Markup((HERE / "page.css").read_text()),
        js=Markup((HERE / "page.js").read_text()),
        plotly=library() if any(s.charts for s in sections) else "",
    )


SHORT = {
    "claims": "Claims",
    "paper": "Size and time",
    "accuracy": "Accuracy",
    "stability": "Stability",
    "effects": "Effects",
    "scaling": "Scaling",
    "library": "Solvers",
    "moving": "Many contacts",
    "crowded": "Many, by error",
    "asked": "Error asked",
    "engines": "Other engines",
    "warm": "Warm starts",
    "cells": "All cells",
    "failures": "Failures",
    "method": "Method",
}


def filters() -> str:
    menus = "".join(
        f'<select data-column="{column}" aria-label="{name}"><option>{name}: all</option></select>'
        for name, column in FILTERS
    )
    return (
        f'<div class="filters">{menus}<input id="find" placeholder="words" aria-label="words"><span'
        ' id="shown"></span></div>'
    )

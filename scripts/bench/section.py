"""What a report is made of: sections of text, charts and tables; each is written as HTML and as
LaTeX."""

import dataclasses
import html
import math

from bench import style


@dataclasses.dataclass
class Cell:
    text: str
    mark: str = ""  # good, fair, bad, none: shading; the text always says it too
    title: str = ""  # longer text on the screen
    sort: float = None  # value to sort by
    look: str = ""  # the component whose colour and marker stand before the text, on the page


@dataclasses.dataclass
class Table:
    name: str
    caption: str
    header: list
    rows: list  # lists of str or Cell
    code: int = None  # column of commands
    note: str = ""
    paper: bool = True  # goes into the LaTeX document


@dataclasses.dataclass
class Section:
    id: str
    title: str
    lead: str
    charts: list = dataclasses.field(default_factory=list)
    tables: list = dataclasses.field(default_factory=list)
    facts: dict = dataclasses.field(default_factory=dict)  # LaTeX macro -> text


def as_cell(value: Cell | str) -> Cell:
    return value if isinstance(value, Cell) else Cell(str(value))


PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))


def si(value: float, unit: str = "", digits: int = 3) -> str:
    """0.00123, 's' -> '1.23 ms'; empty for what was not measured."""
    if value is None or not math.isfinite(value):
        return ""
    if value == 0:
        return f"0 {unit}".strip()
    factor, prefix = next((p for p in PREFIXES if abs(value) >= p[0] * 0.9995), PREFIXES[-1])
    return f"{float(f'{value / factor:.{digits}g}'):g} {prefix}{unit}".strip()


def error(value: float) -> str:
    """An error for a table: 2 digits, a power of ten."""
    if value is None or not math.isfinite(value):
        return ""
    return "0" if value == 0 else f"{value:.1e}"


def interval(mid: float, low: float, high: float, digits: int = 3) -> str:
    if not math.isfinite(mid):
        return ""
    return f"{mid:.{digits}g} [{low:.{digits}g}, {high:.{digits}g}]"


def table_html(table: Table) -> str:
    out = [
        # a caption inside would be as wide as the table, and cut
        f'<p class="caption" id="caption-{table.name}">{html.escape(table.caption)}</p>'
        f'<div class="scroll"><table id="table-{table.name}" class="sortable"'
        f' aria-describedby="caption-{table.name}"><thead><tr>'
    ]
    out += [f"<th>{html.escape(h)}</th>" for h in table.header]
    out.append("</tr></thead><tbody>")
    for row in table.rows:
        out.append("<tr>")
        for i, value in enumerate(row):
            cell = as_cell(value)
            text = html.escape(cell.text, quote=False).replace("\n", "<br>")
            if table.code == i and text:
                text = f"<code>{text}</code>"
            attributes = f' class="{cell.mark}"' if cell.mark else ""
            if cell.title:
                attributes += f' title="{html.escape(cell.title)}"'
            if cell.sort is not None:
                attributes += f' data-sort="{cell.sort:.9g}"'
            mark = style.swatch(cell.look) if cell.look else ""
            out.append(
                f"<td{attributes}>{mark}{text}"
            )  # HTML needs no end tags of cells and rows; a tenth of the page
    out.append("</tbody></table></div>")
    if table.note:
        out.append(f'<p class="note">{html.escape(table.note)}</p>')
    return "".join(out)


TEX = {
    "\\": r"\textbackslash{}",
    "_": r"\_",
    "%": r"\%",
    "&": r"\&",
    "#": r"\#",
    "$": r"\$",
    "{": r"\{",
    "}": r"\}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "µ": r"\ensuremath{\mu}",
    "≤": r"\ensuremath{\le}",
    "≥": r"\ensuremath{\ge}",
    "×": r"\ensuremath{\times}",
    "→": r"\ensuremath{\to}",
    "<": r"\ensuremath{<}",
    ">": r"\ensuremath{>}",
    "–": "--",
    "—": "---",
    "∞": r"\ensuremath{\infty}",
    ",": r",\allowbreak{}",
    ":": r":\allowbreak{}",
}


def tex(text: str) -> str:
    return "".join(TEX.get(c, c) for c in str(text)).replace("\n", " ")


SHORT, MANY = 20, 8  # characters of a column that need no wrapping; columns that fit on a page


LINES, ACROSS = 62, 118  # lines of a page, characters of a line


def fitting(rows: list[list[Cell]], wraps: list[bool]) -> int:
    """How many of the rows fit on a page when the long texts wrap in what the short columns
    leave."""
    narrow = sum(
        max([len(as_cell(row[k]).text) for row in rows] + [0]) + 2
        for k, w in enumerate(wraps)
        if not w
    )
    width = max(8, (ACROSS - narrow) // max(1, sum(wraps)))
    left = LINES
    for n, row in enumerate(rows):
        left -= max(
            -(-max(len(as_cell(c).text), 1) // width) if w else 1
            for c, w in zip(row, wraps, strict=True)
        )
        if left < 0:
            return n
    return len(rows)


def table_tex(table: Table) -> str:
    """A booktabs table; columns of long text wrap, a wide table is scaled, one longer than a page
    is cut and says so."""
    keep = [i for i in range(len(table.header)) if i != table.code]
    rows = [[as_cell(row[i]) for i in keep] for row in table.rows]
    wraps = [max([len(row[k].text) for row in rows] + [0]) > SHORT for k in range(len(keep))]
    wide = len(keep) > MANY or not any(wraps)
    most = 40 if wide else fitting(rows, wraps)
    body = rows[:most]
    columns = "l" * len(keep) if wide else "".join("Y" if w else "l" for w in wraps)
    start = (
        [
            "\\resizebox{\\ifdim\\width>\\textwidth\\textwidth\\else\\width\\fi}{!}{%",
            f"\\begin{{tabular}}{{{columns}}}",
        ]
        if wide
        else [f"\\begin{{tabularx}}{{\\textwidth}}{{{columns}}}"]
    )
    out = [
        "\\begin{table}[htbp]",
        "\\centering\\footnotesize",
        f"\\caption{{{tex(table.caption)}}}\\label{{tab:{table.name}}}",
        *start,
        "\\toprule",
        " & ".join(tex(table.header[i]) for i in keep) + r" \\",
        "\\midrule",
    ]
    for row in body:
        out.append(
            " & ".join(
                f"\\textbf{{{tex(c.text)}}}" if c.mark == "good" and c.text else tex(c.text)
                for c in row
            )
            + r" \\"
        )
    out += ["\\bottomrule", "\\end{tabular}}" if wide else "\\end{tabularx}"]
    if len(table.rows) > most:
        out.append(f"\\par {most} of {len(table.rows)} rows; all of them in the page.")
    out.append("\\end{table}")
    return "\n".join(out) + "\n"


def table_md(table: Table) -> str:
    """A Markdown table, for the README."""
    lines = ["| " + " | ".join(table.header) + " |", "|" + "---|" * len(table.header)]
    lines += [
        "| " + " | ".join(as_cell(v).text.replace("\n", " ").replace("|", "/") for v in row) + " |"
        for row in table.rows
    ]
    return "\n".join(lines) + "\n"

"""What a report is made of: sections of text, charts and tables; each is written as HTML and as
LaTeX."""

import base64
import dataclasses
import gzip
import html
import json
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
    """Of a number that was not measured (NaN) there is no place to sort to, and JSON has none."""
    cell = value if isinstance(value, Cell) else Cell(str(value))
    lost = cell.sort is not None and not math.isfinite(cell.sort)
    return dataclasses.replace(cell, sort=None) if lost else cell


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


ROWS = 80  # of a table in the page at load; a browser draws the others when they are asked for


def packed(table: Table) -> str:
    """All rows of a long table as [text, mark, title, sort] of each cell, for the page's script;
    the same bytes each time."""
    rows = []
    for row in table.rows:
        cells = map(as_cell, row)
        rows.append(
            [
                c.text
                if not (c.mark or c.title or c.sort is not None)
                else [c.text, c.mark, c.title, c.sort]
                for c in cells
            ]
        )
    text = json.dumps(rows, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()


def table_html(table: Table) -> str:
    long = len(table.rows) > ROWS
    out = [
        # a caption inside would be as wide as the table, and cut
        f'<p class="caption" id="caption-{table.name}">{html.escape(table.caption)}</p>'
        f'<div class="scroll"><table id="table-{table.name}" class="sortable"'
        + (f' data-code="{table.code}"' if table.code is not None else "")
        + f' aria-describedby="caption-{table.name}"><thead><tr>'
    ]
    out += [f"<th>{html.escape(h)}</th>" for h in table.header]
    out.append("</tr></thead><tbody>")
    for row in table.rows[:ROWS]:
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
    if long:
        out.append(
            f'<noscript><p class="note">{ROWS} of {len(table.rows)} rows; the others need a script,'
            " or results.csv.</p></noscript>"
            f'<script type="text/plain" id="rows-{table.name}">{packed(table)}</script>'
        )
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


LONGEST = 60  # rows of a table that runs over pages; the page has them all


def widths(rows: list[list[Cell]], wraps: list[bool]) -> list[float]:
    """Shares of the line for the columns that wrap, by how much text they hold; 0 for the others,
    which take what they need."""
    need = [max([len(row[k].text) for row in rows] + [1]) for k in range(len(wraps))]
    left = ACROSS - sum(n + 2 for n, w in zip(need, wraps, strict=True) if not w)
    weight = [math.sqrt(n) if w else 0.0 for n, w in zip(need, wraps, strict=True)]
    return [0.94 * left / ACROSS * w / sum(weight) for w in weight]


def line_tex(row: list[Cell]) -> str:
    cells = (
        f"\\textbf{{{tex(c.text)}}}" if c.mark == "good" and c.text else tex(c.text) for c in row
    )
    return " & ".join(cells) + r" \\"


def long_tex(table: Table, keep: list[int], rows: list[list[Cell]], wraps: list[bool]) -> str:
    """A table that runs over pages, its header on each; past LONGEST rows it is cut and says so."""
    columns = "".join(
        f">{{\\raggedright\\arraybackslash}}p{{{w:.3f}\\linewidth}}" if w else "l"
        for w in widths(rows, wraps)
    )
    head = " & ".join(tex(table.header[i]) for i in keep) + r" \\"
    cut = len(rows) > LONGEST
    note = f"{LONGEST} of {len(rows)} rows; all of them in the page."
    out = [
        "{\\footnotesize\\setlength{\\tabcolsep}{3pt}",
        f"\\begin{{longtable}}{{{columns}}}",
        f"\\caption{{{tex(table.caption)}}}\\label{{tab:{table.name}}}\\\\",
        f"\\toprule\n{head}\n\\midrule\n\\endfirsthead",
        f"\\toprule\n{head}\n\\midrule\n\\endhead",
        "\\bottomrule\n\\endfoot",
        *map(line_tex, rows[:LONGEST]),
        *([f"\\midrule\n\\multicolumn{{{len(keep)}}}{{l}}{{{note}}} \\\\"] if cut else []),
        "\\end{longtable}}",
    ]
    return "\n".join(out) + "\n"


def table_tex(table: Table) -> str:
    """A booktabs table; columns of long text wrap, a wide table is scaled, one longer than a page
    runs over pages."""
    keep = [i for i in range(len(table.header)) if i != table.code]
    rows = [[as_cell(row[i]) for i in keep] for row in table.rows]
    wraps = [max([len(row[k].text) for row in rows] + [0]) > SHORT for k in range(len(keep))]
    wide = len(keep) > MANY or not any(wraps)
    most = 40 if wide else fitting(rows, wraps)
    if not wide and len(rows) > most:
        return long_tex(table, keep, rows, wraps)
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
    out += map(line_tex, body)
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

"""The report for a paper: figures, booktabs tables, macros and a document that inputs them all."""

import pathlib

from bench import chart as chart_
from bench import style
from bench.section import Section, table_tex, tex

# What a figure as PGF needs: scripts/report --pgf writes figures/NAME.pgf, and
# \input{figures/NAME.pgf} stands in for figures/NAME.pdf.
FIGURES = r"""\usepackage[T1]{fontenc}
\usepackage[utf8]{inputenc}
\usepackage{lmodern}
\usepackage{amsmath,pgf}
\newcommand{\mathdefault}[1]{#1}
\DeclareUnicodeCharacter{03C4}{\ensuremath{\tau}}
"""
HEAD = (
    r"""\documentclass[10pt]{article}
"""
    + FIGURES
    + r"""\usepackage[a4paper,left=15mm,right=15mm,top=18mm,bottom=18mm]{geometry}
\usepackage{graphicx,booktabs,tabularx}
\newcolumntype{Y}{>{\raggedright\arraybackslash}X}
\renewcommand{\topfraction}{0.95}
\renewcommand{\floatpagefraction}{0.8}
\setcounter{topnumber}{4}
\input{macros}
\title{\CampaignTitle}
\author{made from \NumRows\ rows, \NumCells\ cells, by scripts/report}
\date{}
\begin{document}
\maketitle
"""
)


def macros(facts: dict[str, str]) -> str:
    return "".join(
        f"\\newcommand{{\\{name}}}{{{tex(value)}}}\n" for name, value in sorted(facts.items())
    )


def write(
    folder: pathlib.Path, facts: dict[str, str], sections: list[Section], pgf: bool = False
) -> None:
    """folder/{main.tex,macros.tex,tables/NAME.tex,figures/NAME.{pdf,png,dat}}, with pgf also
    NAME.pgf for \\input."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "tables").mkdir(exist_ok=True)
    (folder / "figures").mkdir(exist_ok=True)
    body = [HEAD]
    for s in sections:
        charts, tables = s.charts, [t for t in s.tables if t.paper and t.rows]
        if not charts and not tables:
            continue
        body.append(f"\\section{{{tex(s.title)}}}\n{tex(s.lead)}\n")
        for c in charts:
            style.save(chart_.draw(c), folder / "figures", c.name, pgf)
            (folder / "figures" / f"{c.name}.dat").write_text(chart_.table(c))
            width = c.width if c.width < style.PAGE else 7.08
            body.append(
                "\\begin{figure}[htbp]\\centering"
                f"\\includegraphics[width={width}in]{{figures/{c.name}.pdf}}\n"
                f"\\caption{{{tex(c.caption)}}}\\label{{fig:{c.name}}}\\end{{figure}}\n"
            )
        for t in tables:
            (folder / "tables" / f"{t.name}.tex").write_text(table_tex(t))
            body.append(f"\\input{{tables/{t.name}}}\n")
        body.append("\\clearpage\n")
    body.append("\\end{document}\n")
    (folder / "macros.tex").write_text(macros(facts))
    (folder / "main.tex").write_text("".join(body))

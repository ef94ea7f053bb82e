"""The report for a paper: figures, booktabs tables, macros and a document that inputs them all."""

import pathlib

from bench import chart as chart_
from bench import style
from bench.section import Section, Table, table_tex, tex

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
\usepackage{graphicx,booktabs,tabularx,longtable}
\newcolumntype{Y}{>{\raggedright\arraybackslash}X}
\renewcommand{\topfraction}{0.95}
\renewcommand{\floatpagefraction}{0.8}
\setcounter{topnumber}{4}
\input{macros}
\setlength{\LTcapwidth}{\linewidth}
\makeatletter
\renewcommand*{\l@section}{\@dottedtocline{1}{0em}{2.6em}}
\makeatother
\renewcommand{\thesection}{S\arabic{section}}
\renewcommand{\thetable}{S\arabic{table}}
\renewcommand{\thefigure}{S\arabic{figure}}
\title{Supplement: contact formulations and their solvers, measured}
\author{\parbox{0.9\textwidth}{\centering\normalsize\Masthead}}
\date{}
\begin{document}
\maketitle
"""
)


def macros(facts: dict[str, str]) -> str:
    return "".join(
        f"\\newcommand{{\\{name}}}{{{tex(value)}}}\n" for name, value in sorted(facts.items())
    )


METHOD = (
    "Every row is one process of one cell, pinned to one processor, after an untimed warm-up. The"
    " time of a run is the sum of its phases: contacts, assembly, set-up, factorisation, solves,"
    " choice among redundant answers, and state update. Medians and 95 % intervals are resampled"
    " over processes, then samples; two times are a tie within the noise floor of their campaign"
    " and size, the same work measured under two names. A row counts as verified when the residual"
    " of every problem posed, recomputed in extended precision from the data and the answer, stays"
    " below the tolerance; the error of the motion is against a closed form, an invariant, or a"
    " converged run of another method, whose uncertainty is told. Where rows were disturbed by"
    " other work their ties are wider by the drift of a fixed kernel, and their markers hollow."
)


def units() -> Table:
    """What the columns of the tables are measured in."""
    return Table(
        "units",
        "Quantities and their units.",
        ["quantity", "unit", "what it is"],
        [
            ["time of a run, of a step", "s", "sum of the clocked phases; over the steps"],
            ["error", "m, m/s, rad, J or N", "of the quantity named beside it, at most over time"],
            ["rho", "1", "scale-invariant residual of the problem that was posed"],
            ["Coulomb residual", "1", "De Saxce's natural map of exact Coulomb contact, relative"],
            ["contacts, unknowns", "1", "most in a step of the run"],
            ["step h, duration", "s", "of the simulation"],
            ["stiffness k, damping c", "N/m, N s/m", "of regularised friction, compliant contact"],
            ["memory", "B", "peak of the process"],
        ],
    )


ABSTRACT = {  # a sentence for each fact that these rows have, in this order
    "NumCells": (
        "For a given scene and a given accuracy, which contact formulation and which solver get"
        " there in the least time, and what breaks first? \\NumRows\\ rows are repetitions of"
        " \\NumCells\\ cells, each one problem with one formulation, solver and setting, of the"
        " campaigns \\Campaigns: \\NumVerified\\ were verified from the data and the answer alone,"
        " \\NumFalseClaims\\ solvers claimed what the judge did not confirm."
    ),
    "Answers": "Within \\AnswerLevel\\ (m, m/s or rad): \\Answers.",
    "Limits": "\\Limits",
    "ClaimsHolding": (
        "Of \\ClaimsJudged\\ verdicts on the statements of a paper \\ClaimsHolding\\ hold without"
        " exception (Table~\\ref{tab:claims})."
    ),
}


def abstract(facts: dict[str, str]) -> str:
    told = [sentence for fact, sentence in ABSTRACT.items() if facts.get(fact)]
    return "\\begin{abstract}\n" + "\n".join(told) + "\n\\end{abstract}\n"


def write(
    folder: pathlib.Path, facts: dict[str, str], sections: list[Section], pgf: bool = False
) -> None:
    """folder/{main.tex,macros.tex,tables/NAME.tex,figures/NAME.{pdf,png,dat}}, with pgf also
    NAME.pgf for \\input."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "tables").mkdir(exist_ok=True)
    (folder / "figures").mkdir(exist_ok=True)
    body = [HEAD, abstract(facts), "\\tableofcontents\n\\clearpage\n"]
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

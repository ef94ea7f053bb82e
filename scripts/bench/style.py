"""One look for every figure: column widths, colours that colour-blind readers and grey printers can tell apart, and
bytes that repeat. A name has the same colour, marker and line style in every figure of a campaign."""

import os
import pathlib
import re

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

COLUMN, PAGE = 3.49, 7.16  # widths of one and two columns [in]

# Okabe & Ito (2008), ordered so that neighbours differ in lightness too
COLOURS = [
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#CC79A7",
    "#E69F00",
    "#56B4E9",
    "#000000",
    "#8C6D1F",
    "#7A7A7A",
]
MARKERS = ["o", "s", "^", "D", "v", "P", "X", "<", ">", "h"]
DASHES = [
    "-",
    (0, (5, 1.5)),
    (0, (1, 1)),
    (0, (6, 1.5, 1, 1.5)),
    (0, (3, 1)),
    (0, (6, 1, 1, 1, 1, 1)),
]

FORMULATIONS = [
    "regularized",
    "velocity",
    "position",
    "normal",
    "coulomb",
    "boxed",
    "acceleration",
    "penalty",
    "event",
]
SOLVERS = [
    "lemke",
    "pgs",
    "projected_gradient",
    "ppm",
    "block_pivoting",
    "newton",
    "interior_point",
    "nncg",
    "apgd",
    "murty",
    "jacobi",
    "pgs_sm",
    "sqp",
    "nsgs",
    "prox",
    "enumerate",
    "cone_newton",
]

matplotlib.rcParams.update(
    {
        "font.family": "DejaVu Sans",
        "font.size": 7.5,
        "axes.titlesize": 8,
        "axes.titleweight": "bold",
        "axes.titlelocation": "left",
        "axes.labelsize": 7.5,
        "legend.fontsize": 7,
        "xtick.labelsize": 7,
        "ytick.labelsize": 7,
        "axes.linewidth": 0.6,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "axes.grid.which": "major",
        "grid.color": "#e4e4e4",
        "grid.linewidth": 0.5,
        "axes.axisbelow": True,
        "lines.linewidth": 1.3,
        "lines.markersize": 4.2,
        "legend.frameon": False,
        "legend.handlelength": 2.8,
        "legend.borderaxespad": 0.2,
        "figure.constrained_layout.use": True,
        "figure.dpi": 110,
        "savefig.dpi": 200,
        "pdf.fonttype": 42,
        "ps.fonttype": 42,
        "svg.hashsalt": "lcpbench",
        "xtick.major.width": 0.6,
        "ytick.major.width": 0.6,
        "xtick.minor.width": 0.4,
        "ytick.minor.width": 0.4,
    }
)


def _place(name, known):
    base = name.split(":")[0].split()[0]
    if base in known:
        return known.index(base)
    return len(known) + sum(map(ord, base)) % 7


def colour(name, known=None):
    known = known or (FORMULATIONS if name.split(":")[0] in FORMULATIONS else SOLVERS)
    return COLOURS[_place(name, known) % len(COLOURS)]


def look(name, variant=0):
    """Keyword arguments of plot() for a formulation or a solver; variants of one name differ in dashes."""
    known = FORMULATIONS if name.split(":")[0] in FORMULATIONS else SOLVERS
    i = _place(name, known)
    marker = MARKERS[(i + 3 * variant) % len(MARKERS)]
    out = {
        "color": COLOURS[i % len(COLOURS)],
        "marker": marker,
        "linestyle": DASHES[(i + variant) % len(DASHES)],
    }
    if (
        i % 2 == 0 and i > 0
    ):  # large and open below, small and filled above: two lines on top of each other both show
        out.update(markerfacecolor="white", markersize=6.5, markeredgewidth=1.1, zorder=1.9)
    return out


UNVERIFIED = {
    "marker": "x",
    "linestyle": "none",
    "markersize": 6.5,
    "markeredgewidth": 1.4,
    "zorder": 5,
}


def mark_unverified(ax, x, y, color):
    """Rows whose claim the judge did not confirm: a large cross in the colour of their maker, never a filled point."""
    ax.plot(x, y, color=color, **UNVERIFIED)


def label_ends(ax, ends, gap=8.0):
    """Names at the right ends of lines instead of a legend. ends: [(x, y, text, colour)]; moved apart to `gap` points."""
    ax.figure.canvas.draw()
    todo = sorted(ends, key=lambda e: ax.transData.transform((e[0], e[1]))[1])
    last = -1e9
    scale = 72.0 / ax.figure.dpi
    for x, y, text, color in todo:
        at = ax.transData.transform((x, y))[1] * scale
        moved = max(at, last + gap)
        last = moved
        ax.annotate(
            text,
            (x, y),
            xytext=(6, moved - at),
            textcoords="offset points",
            va="center",
            color=color,
            fontsize=7,
            annotation_clip=False,
            arrowprops=None
            if moved - at < 2
            else {"arrowstyle": "-", "lw": 0.4, "color": color, "shrinkA": 0, "shrinkB": 1},
        )


def _escaped(text):
    """What TeX would take for its own; formulas of the ticks stay. Twice is as good as once."""
    return text if "$" in text else re.sub(r"(?<!\\)([_&#])", r"\\\1", text)


def save(figure, folder, name, pgf=False):
    """NAME.pdf and NAME.png (and NAME.pgf), the same bytes each time."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    os.environ.setdefault("SOURCE_DATE_EPOCH", "0")
    figure.savefig(
        folder / f"{name}.pdf",
        metadata={"CreationDate": None, "Creator": "lcpbench", "Producer": "matplotlib"},
    )
    figure.savefig(folder / f"{name}.png", metadata={"Software": "lcpbench"})
    if pgf:
        with matplotlib.rc_context(
            {
                "pgf.texsystem": "pdflatex",
                "pgf.rcfonts": False,
                "font.family": "sans-serif",
                "axes.unicode_minus": False,
                "pgf.preamble": r"\usepackage[T1]{fontenc}\usepackage[utf8]{inputenc}\usepackage{lmodern}\DeclareUnicodeCharacter{03C4}{\ensuremath{\tau}}",
            }
        ):
            for text in figure.findobj(
                matplotlib.text.Text
            ):  # the backend leaves names as they are
                text.set_text(_escaped(text.get_text()))
            for axis in [a for ax in figure.axes for a in (ax.xaxis, ax.yaxis)]:
                names = [label.get_text() for label in axis.get_ticklabels()]
                if any(name != _escaped(name) for name in names):
                    axis.set_ticks(axis.get_ticklocs(), [_escaped(name) for name in names])
            figure.savefig(folder / f"{name}.pgf", backend="pgf")
    plt.close(figure)

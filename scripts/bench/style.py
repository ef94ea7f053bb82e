"""One look for every figure: column widths, colours that colour-blind readers and grey printers can
tell apart, and bytes that repeat. A component has the same colour and marker wherever it is drawn;
both follow from its place in the registry, so that a new one has its own without a word here."""

import os
import pathlib
import re
from collections.abc import Sequence

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bench import experiments, registry

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

COLUMN, PAGE = 3.49, 7.16  # widths of one and two columns [in]

# Okabe & Ito (2008), black and yellow replaced by grey and wine, which have darker and lighter
# shades: three rounds of eight
HUES = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#6E6E6E", "#882255"]
SHADES = [(0, 0.0), (0, 0.45), (255, 0.5)]  # towards black or white, and how far
MARKERS = ["o", "s", "^", "D", "v", "P", "X", "<", ">", "h"]
GLYPHS = dict(zip(MARKERS, "●■▲◆▼✚✖◀▶⬢", strict=True))  # the markers where text is all there is
DASHES = [
    "-",
    (0, (5, 1.5)),
    (0, (1, 1)),
    (0, (6, 1.5, 1, 1.5)),
    (0, (3, 1)),
    (0, (6, 1, 1, 1, 1, 1)),
]
KINDS = {
    "formulations": 0,
    "solvers": 5,
    "effects": 2,
}  # what has a look, and with which marker it begins
NEUTRAL = "#444444"  # of names that this build does not know

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


def colour_at(i: int) -> str:
    """The colour of the i-th of a registry."""
    hue, (target, share) = HUES[i % len(HUES)], SHADES[i // len(HUES) % len(SHADES)]
    parts = [int(hue[k : k + 2], 16) for k in (1, 3, 5)]
    return "#" + "".join(f"{round(v + (target - v) * share):02X}" for v in parts)


def code(name: str) -> tuple[int, str, str]:
    """(place in its registry, colour, marker) of a component; options and a sign before the name do
    not matter."""
    base = name.split(":")[0].lstrip("+-")
    for kind, first in KINDS.items():
        names = list(registry.listed(kind))
        if base in names:
            i = names.index(base)
            return i, colour_at(i), MARKERS[(i + first) % len(MARKERS)]
    engines = list(dict.fromkeys(s["engine"] for s in experiments.of("engines.settings")))
    if base in engines:  # paler than any component, which stand out beside them
        i = engines.index(base)
        return i, colour_at(i + 2 * len(HUES)), MARKERS[(i + 4) % len(MARKERS)]
    return 0, NEUTRAL, MARKERS[sum(map(ord, base)) % len(MARKERS)]


def look(name: str, variant: int = 0) -> dict:
    """Keyword arguments of plot() for a component; variants of one name differ in dashes and in the
    filling of the marker."""
    i, colour, marker = code(name)
    out = {"color": colour, "marker": marker, "linestyle": DASHES[(i + variant) % len(DASHES)]}
    if variant % 2:
        out.update(markerfacecolor="white", markeredgewidth=1.1)
    if i % 2:  # large below, small above: two lines on top of each other both show
        out.update(markersize=5.6, zorder=1.9)
    return out


def glyph(name: str) -> str:
    """The marker of a component as a character."""
    return GLYPHS[code(name)[2]]


def swatch(name: str) -> str:
    """The marker of a component in its colour, for the page."""
    return (  # the character, not a picture of it
        f'<i class="look" style="color:{code(name)[1]}">{glyph(name)}\ufe0e</i>'
    )


def marked(combination: str) -> str:
    """A combination with the marker of each part before it, in its colour, for a terminal."""
    parts = []
    for part in combination.split(" + "):
        rgb = ";".join(str(int(code(part)[1][k : k + 2], 16)) for k in (1, 3, 5))
        parts.append(f"\x1b[38;2;{rgb}m{glyph(part)}\x1b[0m {part}")
    return " + ".join(parts)


UNVERIFIED = {
    "marker": "x",
    "linestyle": "none",
    "markersize": 6.5,
    "markeredgewidth": 1.4,
    "zorder": 5,
}


def mark_unverified(ax: Axes, x: Sequence[float], y: Sequence[float], color: str) -> None:
    """Rows whose claim the judge did not confirm: a large cross in the colour of their maker, never
    a filled point."""
    ax.plot(x, y, color=color, **UNVERIFIED)


def label_ends(ax: Axes, ends: list[tuple[float, float, str, str]], gap: int = 8.0) -> None:
    """Names at the right ends of lines instead of a legend. ends: [(x, y, text, colour)]; moved
    apart to `gap` points."""
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
            arrowprops=(
                None
                if moved - at < 2
                else {"arrowstyle": "-", "lw": 0.4, "color": color, "shrinkA": 0, "shrinkB": 1}
            ),
        )


def _escaped(text: str):
    """What TeX would take for its own; formulas of the ticks stay. Twice is as good as once."""
    return text if "$" in text else re.sub(r"(?<!\\)([_&#])", r"\\\1", text)


def save(figure: Figure, folder: pathlib.Path, name: str, pgf: bool = False) -> None:
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
                "pgf.preamble": (
                    r"\usepackage[T1]{fontenc}\usepackage[utf8]{inputenc}\usepackage{lmodern}\DeclareUnicodeCharacter{03C4}{\ensuremath{\tau}}"
                ),
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

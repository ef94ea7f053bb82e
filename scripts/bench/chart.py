"""A chart is data: panels of lines. It is drawn for paper (matplotlib), for the screen (Plotly) and
as a plain table (.dat), so the three never disagree."""

import dataclasses
import json
import math

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter
from matplotlib.transforms import ScaledTranslation

from bench import style
from bench.style import plt


@dataclasses.dataclass
class Line:
    name: str
    x: list
    y: list
    low: list = None  # interval of y
    high: list = None
    bad: list = dataclasses.field(
        default_factory=list
    )  # [(x, y)]: rows whose claim was not verified
    hover: list = None
    variant: int = 0
    kind: str = "line"  # line, steps, points, front, band
    look_as: str = ""  # the name whose colour and marker it takes
    end_label: str = ""
    hollow: list = None  # which points were measured on a disturbed machine

    def look(self) -> dict:
        """Of the component that it is called after, unless it says which."""
        return style.look((self.look_as or self.name).split(",")[0].split(" ")[0], self.variant)


@dataclasses.dataclass
class Panel:
    lines: list
    title: str = ""
    xlabel: str = ""
    ylabel: str = ""
    xlog: int = 10  # base, 0: linear
    ylog: int = 10
    xticks: list = None
    ylim: tuple = None
    yticks: list = None  # names of 0, 1, 2, ...


@dataclasses.dataclass
class HeatPanel:
    title: str
    rows: list
    words: list  # rows of (text, share or None)


@dataclasses.dataclass
class Heat:
    """Maps of words with the same columns. On the screen they are tables; on paper they are
    this."""

    name: str
    caption: str
    columns: list
    panels: list
    across: int = 1  # panels side by side
    size: float = 6  # of the words [pt]
    width: float = style.PAGE


@dataclasses.dataclass
class Chart:
    name: str
    caption: str
    panels: list
    columns: int = 1
    share_x: bool = False
    share_y: bool = False
    width: float = style.PAGE
    height: float = 2.0  # of one panel [in]
    end_labels: bool = False


def _axis(ax: Axes, panel: Panel):
    for base, scale, axis in (
        (panel.xlog, ax.set_xscale, ax.xaxis),
        (panel.ylog, ax.set_yscale, ax.yaxis),
    ):
        if base:
            scale("log", base=base)
            axis.set_minor_formatter(NullFormatter())
            if base == 2:
                axis.set_major_formatter(lambda v, _: f"{v:g}" if v >= 1 else f"1/{1 / v:g}")
            else:
                axis.set_major_locator(LogLocator(numticks=6))
    if panel.xticks:
        few = panel.xticks[:: max(1, -(-len(panel.xticks) // 5))]
        ax.set_xticks(few, [f"{v:g}" for v in few])
        ax.xaxis.set_minor_formatter(NullFormatter())
        ax.minorticks_off()
    if panel.ylim:
        ax.set_ylim(*panel.ylim)
    if panel.yticks:
        ax.set_yticks(range(len(panel.yticks)), panel.yticks)
        ax.set_ylim(len(panel.yticks) - 0.5, -0.5)
    ax.set_title(panel.title)
    ax.set_xlabel(panel.xlabel)


def _narrow(ax: Axes, panel: Panel):
    """Less than two decades: ticks at 1, 2, 5 with plain numbers, or the axis would carry hardly
    any."""
    for (low, high), scale, axis in (
        (ax.get_ylim(), ax.get_yscale(), ax.yaxis),
        (ax.get_xlim(), ax.get_xscale(), ax.xaxis),
    ):
        named = panel.yticks if axis is ax.yaxis else panel.xticks
        if (
            scale == "log"
            and not named
            and 0 < low
            and high / low < (100 if axis is ax.yaxis else 8)
        ):
            close = (
                high / low < 3
            )  # no two of 1, 2, 5 in view: evenly spaced ticks, few enough not to touch
            axis.set_major_locator(
                MaxNLocator(3) if close else LogLocator(subs=(1.0, 2.0, 5.0), numticks=9)
            )
            axis.set_major_formatter(lambda v, _: f"{v:.3g}")
            axis.set_minor_formatter(NullFormatter())


HOLLOW = {"linestyle": "none", "markerfacecolor": "white", "markeredgewidth": 1.1, "zorder": 3}


def _line(ax: Axes, line: Line):
    look = line.look()
    if line.kind == "front":
        ax.plot(
            line.x,
            line.y,
            color="#bbbbbb",
            linewidth=3.0,
            zorder=1,
            label=line.name,
            solid_capstyle="round",
        )
        return
    if line.kind == "band":
        ax.fill_between(
            line.x,
            line.low,
            line.high,
            facecolor="none",
            edgecolor="#d0d0d0",
            hatch="////",
            linewidth=0,
            zorder=0,
            label=line.name,
        )
        return
    if line.kind == "points":
        look["linestyle"] = "none"
    if line.kind == "steps":
        look.update(
            drawstyle="steps-post", markevery=0.2, markersize=3.6
        )  # a mark here and there tells dashes apart in grey
    if len(line.x):
        ax.plot(line.x, line.y, label=line.name, **look)
        some = [(x, y) for x, y, h in zip(line.x, line.y, line.hollow or [], strict=False) if h]
        if some:
            ax.plot(*zip(*some, strict=True), **look | HOLLOW)
    if line.low is not None and len(line.x):
        step = {"step": "post"} if line.kind == "steps" else {}
        ax.fill_between(
            line.x, line.low, line.high, color=look["color"], alpha=0.16, linewidth=0, **step
        )
    if line.bad:
        style.mark_unverified(ax, *zip(*line.bad, strict=True), look["color"])


LOW, HIGH, ALL = (
    np.array([0.98, 0.74, 0.55, 1]),
    np.array([0.80, 0.90, 0.97, 1]),
    np.array([0.45, 0.70, 0.89, 1]),
)  # lightness falls and rises: legible in grey


def _heat_panel(ax: Axes, heat: Heat, panel: HeatPanel, top: bool, tall: int):
    shades = np.full((len(panel.rows), len(heat.columns), 4), 1.0)
    for i, row in enumerate(panel.words):
        for j, (text, share) in enumerate(row):
            if share is not None:
                shades[i, j] = ALL if share >= 1 else LOW + (HIGH - LOW) * share
            ax.text(
                j,
                i,
                text,
                ha="center",
                va="center",
                fontsize=heat.size,
                color="#1c2330" if share is not None else "#9a9a9a",
                fontweight=700 if share is not None and share < 0.5 else 400,
            )
    ax.pcolormesh(
        np.arange(len(heat.columns) + 1) - 0.5,
        np.arange(len(panel.rows) + 1) - 0.5,
        shades,
        edgecolors="white",
        linewidth=0.9,
    )
    ax.set_xticks(
        range(len(heat.columns)),
        heat.columns if top else [""] * len(heat.columns),
        fontsize=6.5 if heat.across == 1 else 5.5,
        rotation=90,
    )
    ax.set_yticks(range(len(panel.rows)), panel.rows, fontsize=6.5)
    ax.set_ylim(tall - 0.5, -0.5)
    ax.xaxis.tick_top()
    ax.tick_params(length=0, pad=1.5)
    ax.tick_params(axis="y", pad=9)  # room for the marker of the row
    beside = ax.get_yaxis_transform() + ScaledTranslation(-5 / 72, 0, ax.figure.dpi_scale_trans)
    for i, row in enumerate(panel.rows):
        _, colour, marker = style.code(row.split(" ")[0])
        ax.plot(
            [0],
            [i],
            transform=beside,
            color=colour,
            marker=marker,
            markersize=3.6,
            linestyle="none",
            clip_on=False,
        )
    ax.grid(False)
    ax.set_xticks(np.arange(len(heat.columns) + 1) - 0.5, minor=True)
    ax.set_yticks(np.arange(len(panel.rows) + 1) - 0.5, minor=True)
    ax.grid(True, which="minor", color="white", linewidth=1.0)
    ax.tick_params(which="minor", length=0)
    if panel.title:
        ax.set_ylabel(
            panel.title, fontsize=7.5, fontweight="bold", y=1 - len(panel.rows) / tall / 2
        )
    for spine in ax.spines.values():
        spine.set_visible(False)


def draw_heat(heat: Heat) -> Figure:
    """Colour and word say the same thing: dark stands, light blue to orange falls earlier and
    earlier, white is not defined."""
    down = -(-len(heat.panels) // heat.across)
    tall = [
        max(len(p.rows) for p in heat.panels[r * heat.across : (r + 1) * heat.across])
        for r in range(down)
    ]
    size = (heat.width, 0.078 * max(map(len, heat.columns)) + sum(0.135 * n + 0.08 for n in tall))
    figure, axes = plt.subplots(
        down, heat.across, figsize=size, squeeze=False, height_ratios=tall, layout="constrained"
    )
    for i, ax in enumerate(axes.flat):
        if i < len(heat.panels):
            _heat_panel(ax, heat, heat.panels[i], i < heat.across, tall[i // heat.across])
        else:
            ax.axis("off")
    return figure


def draw(chart: Chart | Heat) -> Figure:
    """The chart as a matplotlib figure."""
    if isinstance(chart, Heat):
        return draw_heat(chart)
    columns = min(chart.columns, len(chart.panels))
    rows = -(-len(chart.panels) // columns)
    size = (chart.width, chart.height * rows + (0 if chart.end_labels else 0.42))
    figure, axes = plt.subplots(
        rows,
        columns,
        figsize=size,
        squeeze=False,
        sharex=chart.share_x,
        sharey=chart.share_y,
        layout="none" if chart.end_labels else "constrained",
    )
    if chart.end_labels:
        figure.subplots_adjust(left=0.15, right=0.62, bottom=0.4 / size[1], top=0.93)
    for ax, panel in zip(axes.flat, chart.panels, strict=False):
        _axis(ax, panel)
        for line in panel.lines:
            _line(ax, line)
        _narrow(ax, panel)
    for i, ax in enumerate(axes.flat):
        if i >= len(chart.panels):
            ax.axis("off")
            continue
        if i % columns == 0 or not chart.share_y:
            ax.set_ylabel(chart.panels[i].ylabel)
        if chart.share_x and i < len(chart.panels) - columns:
            ax.set_xlabel("")
        elif chart.share_x:
            ax.tick_params(labelbottom=True)
    if chart.end_labels:
        for ax, panel in zip(axes.flat, chart.panels, strict=False):
            style.label_ends(
                ax,
                [
                    (line.x[-1], line.y[-1], line.end_label or line.name, line.look()["color"])
                    for line in panel.lines
                    if len(line.x)
                ],
                gap=16 if any("\n" in line.end_label for line in panel.lines) else 9,
            )
    else:
        _legend(figure, axes, chart)
    return figure


def _legend(figure: Figure, axes: np.ndarray, chart: Chart):
    found = {}
    for ax in axes.flat:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    if any(line.bad for panel in chart.panels for line in panel.lines):
        found["not solved or not verified"] = plt.Line2D(
            [], [], color="#444444", **style.UNVERIFIED
        )
    if any(any(line.hollow or []) for panel in chart.panels for line in panel.lines):
        found["hollow: on a disturbed machine"] = plt.Line2D(
            [], [], color="#444444", marker="o", **HOLLOW
        )
    if found:
        longest = max(len(name) for name in found)
        per_row = max(1, int(chart.width / (0.62 + 0.062 * longest)))
        per_row = -(-len(found) // -(-len(found) // per_row))
        figure.legend(found.values(), found.keys(), loc="outside lower center", ncols=per_row)


def _number(v: float):
    return None if v is None or not math.isfinite(v) else float(f"{float(v):.6g}")


PLOTLY_MARKER = {
    "o": "circle",
    "s": "square",
    "^": "triangle-up",
    "D": "diamond",
    "v": "triangle-down",
    "P": "cross",
    "X": "x",
    "<": "triangle-left",
    ">": "triangle-right",
    "h": "hexagon",
}
PLOTLY_DASH = ["solid", "dash", "dot", "dashdot", "4px,2px", "longdashdot"]


def _at(panel: Panel) -> str:
    """What a point of the panel says of itself: the axes' own words, with their units."""
    named = ((panel.xlabel, "%{x:.4g}"), (panel.ylabel, "%{y:.4g}"))
    return "<br>".join(f"{name}: {at}" if name else at for name, at in named) + "<extra></extra>"


def _plotly_line(line: Line, panel: Panel, axis: str, shown: set[str]):
    look = line.look()
    first = line.name not in shown
    shown.add(line.name)
    common = {"xaxis": f"x{axis}", "yaxis": f"y{axis}", "legendgroup": line.name, "name": line.name}
    out = []
    x, y = [_number(v) for v in line.x], [_number(v) for v in line.y]
    if line.kind == "band":
        return [
            {
                **common,
                "type": "scatter",
                "mode": "lines",
                "x": x + x[::-1],
                "y": [_number(v) for v in line.high] + [_number(v) for v in line.low][::-1],
                "fill": "toself",
                "fillcolor": "#ffffff",
                "fillpattern": {"shape": "/", "fgcolor": "#b8b8b8", "size": 7, "solidity": 0.25},
                "line": {"width": 0},
                "hoverinfo": "skip",
                "showlegend": first,
            }
        ]
    if line.low is not None and len(x) > 1 and line.kind != "points":
        out.append(
            {
                **common,
                "type": "scatter",
                "mode": "lines",
                "x": x + x[::-1],
                "y": [_number(v) for v in line.high] + [_number(v) for v in line.low][::-1],
                "fill": "toself",
                "fillcolor": look["color"] + "26",
                "line": {"width": 0},
                "hoverinfo": "skip",
                "showlegend": False,
            }
        )
    trace = {
        **common,
        "type": "scatter",
        "mode": {"points": "markers", "front": "lines"}.get(line.kind, "lines+markers"),
        "x": x,
        "y": y,
        "showlegend": first,
        "line": {
            "color": "#bbbbbb" if line.kind == "front" else look["color"],
            "width": 5 if line.kind == "front" else 2,
            "dash": (
                "solid"
                if line.kind == "front"
                else PLOTLY_DASH[style.DASHES.index(look["linestyle"])]
            ),
            "shape": "hv" if line.kind == "steps" else "linear",
        },
        "marker": {
            "symbol": (
                PLOTLY_MARKER[look["marker"]] + ("-open" if "markerfacecolor" in look else "")
            ),
            "size": 10 if "markersize" in look else 7,
            "color": look["color"],
        },
    }
    if any(line.hollow or []):
        base = trace["marker"]["symbol"].removesuffix("-open")
        trace["marker"]["symbol"] = [base + ("-open" if h else "") for h in line.hollow]
    if line.kind == "steps":
        trace["marker"] |= {"size": 6, "maxdisplayed": 6}
    if line.hover:
        trace.update(text=line.hover, hovertemplate="%{text}<br>" + _at(panel))
    out.append(trace)
    if line.bad:
        bx, by = zip(*line.bad, strict=True)
        out.append(
            {
                **common,
                "type": "scatter",
                "mode": "markers",
                "x": [_number(v) for v in bx],
                "y": [_number(v) for v in by],
                "showlegend": False,
                "marker": {
                    "symbol": "x-thin",
                    "size": 11,
                    "line": {"width": 2.5, "color": look["color"]},
                },
                "hovertemplate": line.name + ": not solved or not verified<br>" + _at(panel),
            }
        )
    return out


def plotly(chart: Chart) -> str:
    """The chart as the JSON text of a Plotly figure."""
    columns = min(chart.columns, len(chart.panels))
    rows = -(-len(chart.panels) // columns)
    shown, data, notes = set(), [], []
    tall = max(
        [300] + [19 * len(p.yticks) + 60 for p in chart.panels if p.yticks]
    )  # a line of text for each name [px]
    height = tall * rows + 70
    pixel = 1 / (height - 100)  # of the plotting area, without its margins
    gap_y = 84 * pixel if rows > 1 else 0.0
    gap_x = 0.16 if any(p.yticks for p in chart.panels) else 0.075
    layout = {
        "height": height,
        "margin": {"l": 62, "r": 12, "t": 50, "b": 50},
        "hovermode": "closest",
        "legend": {"orientation": "h", "y": -56 * pixel},
        "font": {"size": 12},
        "plot_bgcolor": "#fff",
        "paper_bgcolor": "#fff",
    }
    for i, panel in enumerate(chart.panels):
        axis = "" if i == 0 else str(i + 1)
        row, column = divmod(i, columns)
        w, h = (1 - gap_x * (columns - 1)) / columns, (1 - gap_y * (rows - 1)) / rows
        x0, y0 = column * (w + gap_x), 1 - row * (h + gap_y) - h
        grid = {
            "gridcolor": "#e8e8e8",
            "zeroline": False,
            "linecolor": "#444",
            "ticks": "outside",
            "exponentformat": "power",
        }
        layout[f"xaxis{axis}"] = {
            **grid,
            "domain": [round(x0, 4), round(x0 + w, 4)],
            "anchor": f"y{axis}",
            "type": "log" if panel.xlog else "linear",
            "title": {"text": panel.xlabel, "standoff": 4},
        }
        if panel.xticks:
            layout[f"xaxis{axis}"].update(
                tickvals=[_number(v) for v in panel.xticks],
                ticktext=[f"{v:g}" for v in panel.xticks],
            )
        layout[f"yaxis{axis}"] = {
            **grid,
            "domain": [round(y0, 4), round(y0 + h, 4)],
            "anchor": f"x{axis}",
            "type": "log" if panel.ylog else "linear",
            "title": {
                "text": panel.ylabel if column == 0 or not chart.share_y else "",
                "standoff": 4,
            },
        }
        if panel.yticks:
            layout[f"yaxis{axis}"].update(
                tickvals=list(range(len(panel.yticks))),
                ticktext=panel.yticks,
                autorange="reversed",
                automargin=True,
            )
        if chart.share_y and i:
            layout[f"yaxis{axis}"]["matches"] = "y"
        if panel.title:
            notes.append(
                {
                    "text": f"<b>{panel.title}</b>",
                    "xref": "paper",
                    "yref": "paper",
                    "x": round(x0, 4),
                    "y": round(y0 + h, 4),
                    "xanchor": "left",
                    "yanchor": "bottom",
                    "showarrow": False,
                }
            )
        for which, base, values in (
            ("x", panel.xlog, [v for line in panel.lines for v in line.x]),
            ("y", panel.ylog, [v for line in panel.lines for v in line.y]),
        ):
            values = [v for v in values if v > 0 and math.isfinite(v)]
            if base and values and not (which == "x" and panel.xticks):
                layout[f"{which}axis{axis}"]["dtick"] = (
                    max(1, round(math.log10(max(values) / min(values)) / 5))
                    if max(values) / min(values) > 30
                    else "D2"
                )
                if (
                    layout[f"{which}axis{axis}"]["dtick"] == "D2"
                ):  # 0.02, not a 2 without its decade
                    layout[f"{which}axis{axis}"]["tickformat"] = "~g"
        for line in panel.lines:
            data += _plotly_line(line, panel, axis, shown)
    layout["annotations"] = notes
    if chart.width <= style.COLUMN:
        layout["width"] = 620
    return json.dumps({"data": data, "layout": layout}, separators=(",", ":"), sort_keys=True)


def plotly_heat(heat: Heat) -> str:
    """A map as the JSON text of a Plotly figure: a field tells its row, its column and its word."""
    down = -(-len(heat.panels) // heat.across)
    tall = [
        max(len(p.rows) for p in heat.panels[r * heat.across : (r + 1) * heat.across])
        for r in range(down)
    ]
    head, line, gap = 120, 20, 26  # names of the columns, a row, between panels [px]
    height = head + sum(line * n + gap for n in tall)
    data, layout = [], {"height": height, "margin": {"l": 10, "r": 10, "t": 10, "b": head}}
    inside, top = height - head - 10, 1.0
    scale = [[0, "#fabd8c"], [0.999, "#cce6f7"], [1, "#73b3e3"]]
    for i, panel in enumerate(heat.panels):
        axis, (row, column) = "" if i == 0 else str(i + 1), divmod(i, heat.across)
        if column == 0 and row:
            top -= (line * tall[row - 1] + gap) / inside
        bottom = top - line * len(panel.rows) / inside
        width = 1 / heat.across
        data.append(
            {
                "type": "heatmap",
                "xaxis": f"x{axis}",
                "yaxis": f"y{axis}",
                "x": heat.columns,
                "y": panel.rows,
                "z": [[_number(share) for _, share in words] for words in panel.words],
                "text": [[word for word, _ in words] for words in panel.words],
                "texttemplate": "%{text}",
                "hovertemplate": "%{y}<br>%{x}<br>%{text}<extra></extra>",
                "hoverongaps": False,
                "zmin": 0,
                "zmax": 1,
                "showscale": False,
                "colorscale": scale,
                "xgap": 1,
                "ygap": 1,
                "textfont": {"size": 10, "color": "#1c2330"},
            }
        )
        layout[f"xaxis{axis}"] = {
            "domain": [round(column * width + 0.14 * width, 4), round((column + 1) * width, 4)],
            "anchor": f"y{axis}",
            "tickangle": 60,
            "showticklabels": row == down - 1,
            "tickfont": {"size": 10},
        }
        layout[f"yaxis{axis}"] = {
            "domain": [round(max(bottom, 0), 4), round(top, 4)],
            "anchor": f"x{axis}",
            "autorange": "reversed",
            "tickfont": {"size": 10},
        }
    layout |= {"paper_bgcolor": "#fff", "plot_bgcolor": "#fff"}
    return json.dumps({"data": data, "layout": layout}, separators=(",", ":"), sort_keys=True)


def table(chart: Chart | Heat) -> str:
    """The numbers of the chart as a whitespace-separated table for pgfplots or gnuplot."""
    if isinstance(chart, Heat):
        lines = ["\t".join(["panel", "of", *chart.columns])]
        lines += [
            "\t".join([p.title, row] + [w for w, _ in words])
            for p in chart.panels
            for row, words in zip(p.rows, p.words, strict=True)
        ]
        return "\n".join(lines) + "\n"
    lines = ["panel line x y low high verified"]
    for p, panel in enumerate(chart.panels):
        for line in panel.lines:
            name = line.name.replace(" ", "_")
            low = line.low if line.low is not None else [math.nan] * len(line.x)
            high = line.high if line.high is not None else [math.nan] * len(line.x)
            for row in zip(line.x, line.y, low, high, strict=True):
                lines.append(f"{p} {name} " + " ".join(f"{float(v):.9g}" for v in row) + " 1")
            lines += [f"{p} {name} {float(x):.9g} {float(y):.9g} nan nan 0" for x, y in line.bad]
    return "\n".join(lines) + "\n"


def from_cells(
    good: pd.DataFrame, bad: pd.DataFrame, x: str, y: str, name: str, **more: object
) -> Line:
    """A line with one point per x: the median over cells, their median interval; crosses for the
    cells in `bad`."""
    take = [c for c in (y, y + "_low", y + "_high") if c in good]
    some = good.dropna(subset=[y])
    points = some.groupby(x, as_index=False)[take].median()
    hollow = (
        (some["disturbed"] != "").groupby(some[x]).any().tolist() if "disturbed" in some else []
    )
    low = points[y + "_low"].tolist() if y + "_low" in points else None
    high = points[y + "_high"].tolist() if y + "_high" in points else None
    crosses = [
        (float(a), float(b))
        for a, b in zip(bad[x], bad[y], strict=True)
        if np.isfinite(a) and np.isfinite(b)
    ]
    more.setdefault("hollow", hollow)
    return Line(name, points[x].tolist(), points[y].tolist(), low, high, crosses, **more)

"""Figures of the `paper` campaign: how large, how long, how wrong, formulation against formulation."""
import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter

from bench import style
from bench.style import plt

LADDER_MIN = 3  # sizes that make a ladder of contacts


def variants(cells):
    """label -> index among the variants of one formulation (different dashes)."""
    seen = {}
    for label, form in sorted(set(zip(cells["label"], cells["formulation"]))):
        seen[label] = sum(1 for k, f in seen.items() if f[1] == form), form
    return {label: i for label, (i, form) in seen.items()}


def by_size(cells, column):
    """The cells of one line, one point per size (median over cells of that size)."""
    return cells.groupby("n_contacts", as_index=False)[[column, column + "_low", column + "_high"]
                                                       if column + "_low" in cells else [column]].median()


def ladders(cells):
    """Families with at least LADDER_MIN sizes, the longest ladder first."""
    sizes = cells[cells["n_contacts"] > 0].groupby("problem_family")["n_contacts"].nunique().sort_values(ascending=False, kind="stable")
    return [f for f in sizes.index if sizes[f] >= LADDER_MIN]


def log_axes(ax, x=True, y=True):
    if x:
        ax.set_xscale("log", base=2)
        ax.xaxis.set_major_formatter(lambda v, _: f"{v:g}")
    if y:
        ax.set_yscale("log")
        ax.yaxis.set_major_locator(LogLocator(numticks=7))
        ax.yaxis.set_minor_formatter(NullFormatter())


def ticks(ax, values):
    """The steps themselves as ticks (at most five)."""
    values = values[::max(1, -(-len(values) // 5))]
    ax.set_xticks(values, [f"{v:g}" for v in values])
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.minorticks_off()


def draw_line(ax, cells, column, label, variant=0, band=True):
    """One line of medians with its interval; cells that the judge did not confirm are crosses, off the line."""
    good, bad = cells[cells["good"]], cells[~cells["good"]]
    look = style.look(label.split(",")[0].split(" ")[0], variant)
    end = None
    if len(good):
        line = by_size(good, column).dropna(subset=[column])
        ax.plot(line["n_contacts"], line[column], label=label, **look)
        if band and column + "_low" in line:
            ax.fill_between(line["n_contacts"], line[column + "_low"], line[column + "_high"], color=look["color"],
                            alpha=0.18, linewidth=0)
        if len(line):
            end = (line["n_contacts"].iloc[-1], line[column].iloc[-1], label, look["color"])
    bad = bad.dropna(subset=[column])
    if len(bad):
        style.mark_unverified(ax, bad["n_contacts"], bad[column], look["color"])
    return end


def dimension(cells, form_dimension=None):
    """Unknowns of the complementarity problem against contacts."""
    cells = cells[(cells["lcp_dim"] > 0) & (cells["n_contacts"] > 0)]
    families = ladders(cells)
    if not families:
        return None
    cells = cells[cells["problem_family"] == families[0]]
    figure, ax = plt.subplots(figsize=(style.COLUMN, 2.3), layout="none")
    figure.subplots_adjust(left=0.15, right=0.62, bottom=0.17, top=0.88)
    log_axes(ax)
    lines = {}  # formulations that pose the same size share a line
    for label, group in cells.groupby("label"):
        points = group.groupby("n_contacts")["lcp_dim"].max()
        lines.setdefault(tuple(points.items()), []).append(label)
    ends = []
    for points, labels in sorted(lines.items(), key=lambda kv: kv[0][-1]):
        x, y = zip(*points)
        look = style.look(labels[0].split(",")[0])
        ax.plot(x, y, **look)
        per = sorted({round(b / a, 2) for a, b in points})
        factor = f"{per[0]:g} p" if len(per) == 1 else f"{per[0]:g} to {per[-1]:g} p"
        factor = "p" if factor == "1 p" else factor
        ends.append((x[-1], y[-1], f"{merge(labels)}: {factor}", look["color"]))
    ax.set_xlabel("contacts p")
    ax.set_ylabel("unknowns of the LCP")
    style.label_ends(ax, ends, gap=16)
    return figure


def merge(labels):
    """['position, 4 facets', 'velocity, 4 facets'] -> 'position, velocity\n4 facets'"""
    tails = sorted({label.partition(", ")[2] for label in labels})
    if len(tails) == 1:
        return "\n".join(filter(None, [", ".join(label.partition(", ")[0] for label in labels), tails[0]]))
    return "\n".join(labels)


def time_and_error(cells):
    """Solve time per step beside the error of the trajectory, against contacts, one row of panels a solver."""
    families = ladders(cells)
    if not families:
        return None
    cells = cells[cells["problem_family"] == families[0]]
    solvers = [s for s in style.SOLVERS if s in set(cells["solver"])] + sorted(set(cells["solver"]) - set(style.SOLVERS))
    index = variants(cells)
    wide = len(solvers) + 1
    figure, axes = plt.subplots(1, wide, figsize=(style.PAGE, 2.4), width_ratios=[1] * len(solvers) + [1.15])
    low = cells[cells["t_solve_step_s"] > 0]["t_solve_step_s"].min()
    high = cells["t_solve_step_s"].max()
    for ax, solver in zip(axes, solvers):
        log_axes(ax)
        for label, group in cells[cells["solver"] == solver].groupby("label"):
            draw_line(ax, group.assign(**scaled(group, "t_solve_step_s", 1e3)), "t_solve_step_s", label, index[label])
        ax.set_title(solver)
        ax.set_ylim(low * 1e3 / 2, high * 1e3 * 2)
        ax.set_xlabel("contacts")
        if ax is not axes[0]:
            ax.tick_params(labelleft=False)
    axes[0].set_ylabel("solve time per step [ms]")
    ax = axes[-1]
    log_axes(ax)
    for label, group in cells[cells["solver"] == solvers[0]].groupby("label"):
        draw_line(ax, group, "err_ref", label, index[label])
    ax.set_title(f"error ({solvers[0]})")
    ax.set_xlabel("contacts")
    ax.set_ylabel("error of the trajectory")
    handles, labels = [], []
    for a in axes:
        for h, l in zip(*a.get_legend_handles_labels()):
            if l not in labels:
                handles.append(h)
                labels.append(l)
    if not cells["good"].all():
        handles.append(plt.Line2D([], [], color="#444444", **style.UNVERIFIED))
        labels.append("claim not verified")
    figure.legend(handles, labels, loc="outside lower center", ncols=-(-len(labels) // (1 + (len(labels) > 5))))
    return figure


def scaled(group, column, factor):
    return {c: group[c] * factor for c in (column, column + "_low", column + "_high") if c in group}


def error_against_step(cells, most=6):
    """Error of the trajectory against the step, one panel a scene, one line a formulation (first solver)."""
    cells = cells[(cells["err_ref"] > 0) & (cells["step_s"] > 0)]
    counts = cells.groupby("problem_family")["step_s"].nunique()
    scenes = sorted(f for f in counts.index if counts[f] >= 2)[:most]
    if not scenes:
        return None
    index = variants(cells)
    columns = min(3, len(scenes))
    lines = -(-len(scenes) // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(style.PAGE, 1.95 * lines + 0.35), squeeze=False, sharex=True, sharey=True)
    for ax, scene in zip(axes.flat, scenes):
        ax.set_xscale("log")
        ax.set_yscale("log")
        here = cells[cells["problem_family"] == scene]
        for label, group in here.groupby("label"):
            look = style.look(label.split(",")[0], index[label])
            good = group[group["good"]].groupby("step_s")["err_ref"].median()
            ax.plot(good.index * 1e3, good.values, label=label, **look)
            bad = group[~group["good"]]
            if len(bad):
                style.mark_unverified(ax, bad["step_s"] * 1e3, bad["err_ref"], look["color"])
        ax.set_title(scene.replace("_", " "))
        ticks(ax, sorted(here["step_s"].unique() * 1e3))
    for ax in axes.flat[len(scenes):]:
        ax.axis("off")
    for ax in axes.flat[max(0, len(scenes) - columns):len(scenes)]:
        ax.set_xlabel("step [ms]")
        ax.tick_params(labelbottom=True)
    for row in axes:
        row[0].set_ylabel("error of the trajectory")
    handles, labels = axes.flat[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 5))
    return figure

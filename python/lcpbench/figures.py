"""Figures: each takes a table of load(), profile() or study() and draws on matplotlib axes."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from lcpbench.rows import stats as _stats


def _axes(ax: Axes | None) -> Axes:
    return plt.subplots(layout="constrained")[1] if ax is None else ax


def profile(table: pd.DataFrame, ax: Axes | None = None) -> Axes:
    """The curves of profile(): share of problems solved within a factor tau of the best time."""
    ax = _axes(ax)
    cost = table.attrs["cost"]
    ratios = _stats.ratios(cost.to_numpy())
    finite = ratios[np.isfinite(ratios)]
    tau = np.geomspace(1, max(4.0, float(finite.max()) * 1.1) if finite.size else 4.0, 200)
    share = _stats.relative_profile(cost.to_numpy(), tau, table.attrs["noise"])
    for name in table["solver"]:
        ax.step(tau, share[:, list(cost.columns).index(name)], where="post", label=name)
    ax.set(xscale="log", ylim=(0, 1.02), xlabel="time / best time", ylabel="share of problems")
    ax.legend(fontsize="small")
    return ax


def work_precision(
    rows: pd.DataFrame,
    ax: Axes | None = None,
    *,
    by: str = "formulation",
    error: str = "err_ref",
    cost: str = "t_total_s",
) -> Axes:
    """Error against time: of rows that are ok and verified, a line for each value of `by`, a point
    for each cell at its median time. rows: of load(), or of any table with these columns."""
    ax = _axes(ax)
    good = rows[rows["verified"] & (rows["status"] == "ok") & (rows[error] > 0)]
    key = [c for c in (by, "campaign", "cell_id") if c in good.columns]
    points = good.groupby(key).agg(error=(error, "median"), cost=(cost, "median")).reset_index()
    for name, line in points.groupby(by):
        line = line.sort_values("cost")
        ax.plot(line["cost"], line["error"], marker="o", label=name)
    unit = rows.attrs.get("units", {}).get(cost, "")
    ax.set(xscale="log", yscale="log", xlabel=f"{cost} [{unit}]" if unit else cost, ylabel=error)
    ax.legend(fontsize="small")
    return ax

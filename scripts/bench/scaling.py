"""Cost against contacts, with fitted exponents."""
import math

from bench import stats
from bench.chart import Chart, Panel, from_cells
from bench.paper import variants
from bench.section import Cell, Section, Table, interval, si

SIZES_MIN = 4


def ladders(cells):
    some = cells[(cells["p"] > 0) & (cells["formulation"] != "")]
    for (family, combo, step), g in some.groupby(["problem_family", "combination", "step_s"]):
        if g[g["good"]]["p"].nunique() >= SIZES_MIN:
            yield family, combo, g


def section(cells):
    own = cells[cells["campaign"].str.startswith("scaling")]
    cells = own if len(own) else cells
    table, lines = [], {}
    index = variants(cells)
    for family, combo, g in ladders(cells):
        good = g[g["good"]]
        half = good[good["p"] >= good["p"].median()]
        fit = stats.fit_exponent(half["p"], half["t_total_step_s"])
        if math.isnan(fit[0]):
            fit = stats.fit_exponent(good["p"], good["t_total_step_s"])
        memory = stats.fit_exponent(good["p"], good["workspace_B"]) if "workspace_B" in good else (math.nan,) * 4
        top = good.loc[good["p"].idxmax()]
        table.append([family, combo, f"{g['n_contacts'].min():g} to {top['n_contacts']:g}", Cell(interval(*fit[:3]), sort=fit[0]),
                      Cell(si(top["t_total_step_s"], "s"), sort=top["t_total_step_s"]), interval(*memory[:3]) if memory[0] == memory[0] else ""])
        lines.setdefault((family, g["solver"].iloc[0]), []).append(
            from_cells(good.assign(ms=good["t_total_step_s"] * 1e3), g[~g["good"]].assign(ms=g["t_total_step_s"] * 1e3), "p", "ms",
                       g["label"].iloc[0], variant=index[g["label"].iloc[0]]))
    if not table:
        return None
    panels = [Panel(l, title=f"{f.replace('_', ' ')}, {s}", xlabel="contacts", ylabel="time per step [ms]", xlog=10) for (f, s), l in sorted(lines.items())][:6]
    return Section("scaling", "Cost against contacts",
                   "Exponents b of time per step = a p^b over the larger half of the sizes, with 95 % bootstrap intervals.",
                   [Chart("scaling", "Time per step against contacts.", panels, columns=3, height=1.95)],
                   [Table("scaling", "Fitted exponents of time and of solver memory.", ["scene", "combination", "contacts", "exponent of time", "at the largest", "exponent of memory"], table)])

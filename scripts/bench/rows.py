"""Rows of a campaign: reads results.csv and manifest.json, and sums the repetitions of each cell
up."""

import json
import pathlib
from collections.abc import Sequence

import numpy as np
import pandas as pd

from bench import converged, stats

TIMES = [
    "t_contacts_s",
    "t_assemble_s",
    "t_setup_s",
    "t_factor_s",
    "t_solve_s",
    "t_share_s",
    "t_watch_s",
    "t_advance_s",
    "t_total_s",
    "t_step_max_s",
]
TEXT = [
    "campaign",
    "cell_id",
    "problem_family",
    "problem",
    "problem_sha256",
    "formulation",
    "formulation_options",
    "solver",
    "solver_options",
    "solver_variant",
    "start",
    "effects",
    "storage",
    "status",
    "status_claimed",
    "note",
    "err_quantity",
    "err_source",
    "end_quantity",
    "solution_hash",
    "host",
    "host_class",
    "suite_commit",
    "command",
    "cpu_set",
    "exit_signal",
    "started_utc",
    "build_hash",
    "part",
    "model",
    "flags",
    "effects_seen",
    "solver_version",
    "formulation_config",
    "solver_config",
    "missed",
    "effects_auto",
]
NUMBERS = [
    "step_s",
    "n_contacts",
    "n_active",
    "err_worst",
    "n_dof",
    "n_bodies",
    "lcp_dim",
    "rho",
    "res_ncp_rel",
    "err_ref",
    "penetration_m",
    "approach_m",
    "energy_drift_rel",
    "n_predictions",
    "n_predictions_missed",
    "n_steps",
    "workspace_B",
    "err_tol",
    "n_evaluations",
    "n_solves",
    "n_pivot",
    "n_iter",
    "t_limit_s",
    "rss_peak_B",
    "n_matvec",
    "stiffness_ratio",
    "end_value",
    "load1",
    "load_other",
    "canary_s",
    "share_1ms",
    "share_4ms",
    "share_16ms",
    "n_factor",
    "n_fallback",
    "active_change",
    "regressions",
    "regressions_time",
    "n_modes",
    "err_predicted",
]

# a ratio of times closer to 1 is a tie: where the noise floor was not measured, and at the least
TIE, LEAST_TIE = 1.05, 1.02
OTHERS = 0.25  # CPUs of other work that disturb (harness/campaign/compare.h)


class BadRows(Exception):
    pass


def file_of(folder: pathlib.Path | str) -> pathlib.Path:
    """Where the rows of a campaign folder are: as measured, or packed, as results/reference keeps
    them."""
    path = pathlib.Path(folder) / "results.csv"
    packed = path.with_name("results.csv.xz")
    return packed if packed.exists() and not path.exists() else path


def load(folder: pathlib.Path | str) -> pd.DataFrame:
    """All rows of one campaign folder as a DataFrame; a missing or empty file is an error, not an
    empty figure."""
    path = file_of(folder)
    if not path.exists():
        raise BadRows(f"{path}: no such file; run the campaign first")
    rows = pd.read_csv(path, dtype={c: "string" for c in TEXT}, low_memory=False)
    if rows.empty:
        raise BadRows(f"{path}: no rows")
    needed = {"cell_id", "problem", "formulation", "solver", "status", "verified"}
    if needed - set(rows.columns):
        raise BadRows(f"{path}: columns missing: {', '.join(sorted(needed - set(rows.columns)))}")
    for c in TEXT:
        if c in rows:
            rows[c] = rows[c].fillna("").astype(object)
    absent = {c: np.nan for c in set(NUMBERS + TIMES) - set(rows.columns)} | {
        c: "" for c in set(TEXT) - set(rows.columns)
    }
    rows = pd.concat([rows, pd.DataFrame(absent, index=rows.index)], axis=1)
    rows = rows.copy()  # in one piece again
    for column, option, by in SILENT:
        rows[column] = told(rows, column, option, by)
    rows["disturbed"] = disturbed(rows)
    rows["noise"] = noise_of(rows, floors(path.parent))
    rows["verified"] = rows["verified"].map(lambda v: str(v).lower() in ("true", "1", "1.0"))
    return rows


# What a process that was killed did not say: column, the option of its command that sets it, and
# the rows that share it where no option does
SILENT = [
    ("step_s", "--step", ["problem"]),
    ("duration_s", "--duration", ["problem"]),
    ("tol", "--tol", ["solver", "solver_options"]),
    ("effects", "--effects", ["problem"]),
]


def told(rows: pd.DataFrame, column: str, option: str, by: list[str]) -> pd.Series:
    """A column as its rows tell it; of a killed process as it was asked for, or, where its command
    leaves it to the problem or the solver, as the other rows of these say."""
    asked = rows["command"].str.extract(rf"{option} '?([^ ']+)")[0]
    said = rows[column].replace("", np.nan)
    same = said[asked.isna()].groupby([rows[k] for k in by], dropna=False).transform("first")
    if column in TEXT:  # the option changes what the column lists
        return said.where(said.notna() | asked.notna(), same.reindex(rows.index)).fillna("")
    return said.astype(float).fillna(asked.astype(float)).fillna(same.reindex(rows.index))


def disturbed(rows: pd.DataFrame) -> list[str]:
    """What disturbed the measuring of each row, as `lcpbench compare` tells it; "" for nothing."""
    out = []
    for flags, throttled, other, load in zip(
        rows["flags"],
        rows["throttled"] if "throttled" in rows else [""] * len(rows),
        rows["load_other"].astype(float),
        rows["load1"].astype(float),
        strict=True,
    ):
        words = ["canary drift"] if "canary_drift" in str(flags).split() else []
        words += ["throttled"] if str(throttled).lower() == "true" else []
        busy = load > 1 + OTHERS if np.isnan(other) else other > OTHERS
        out.append(", ".join(words + (["other work"] if busy else [])))
    return out


def floors(folder: pathlib.Path) -> list[tuple[float, float]]:
    """[(cells of a workspace up to so many bytes, ratio of times that is a tie)] as doctor.json of
    a campaign tells, the noisiest of its machines; [] where it was not measured."""
    found = {}
    for path in sorted(pathlib.Path(folder).glob("doctor*.json")):
        for c in json.loads(path.read_text()).get("classes", []):
            if c.get("noise_floor") is not None:
                up_to = c["up_to_B"] if c.get("up_to_B") is not None else np.inf
                found[up_to] = max(found.get(up_to, LEAST_TIE), float(np.exp(c["noise_floor"])))
    return sorted(found.items())


def noise_of(rows: pd.DataFrame, known: list[tuple[float, float]]) -> list[float]:
    """The ratio of times that is a tie for each row: the floor of its campaign and size. A
    disturbed row is known no better than the canaries of its campaign repeat."""
    canary = rows["canary_s"].astype(float)
    drift = float(canary.max() / canary.min()) if (canary > 0).any() else 1.0
    out = []
    for size, why in zip(rows["workspace_B"].astype(float), rows["disturbed"], strict=True):
        fits = [tie for up_to, tie in known if size <= up_to] or [tie for _, tie in known]
        base = (fits[0] if size == size else max(fits)) if fits else TIE
        out.append(base * (drift if why else 1.0))
    return out


def load_all(folder: pathlib.Path | str) -> tuple[pd.DataFrame, dict[str, dict]]:
    """Rows and manifests of a campaign folder, or of every campaign folder below it (by name)."""
    folder = pathlib.Path(folder)
    if any(folder.glob("results.csv*")):
        found = [folder]
    else:
        found = sorted({p.parent for p in folder.glob("*/results.csv*")})
    if not found:
        raise BadRows(f"{folder}: no results.csv here or one level below")
    return pd.concat([load(f) for f in found], ignore_index=True), {
        f.name: manifest(f) | begun(f) for f in found
    }


def noise(folder: pathlib.Path | str) -> float | None:
    """Ratio of times that is a tie: the A/A noise floor of small problems (doctor.json of the
    campaigns), at least 2 %; None if not measured."""
    floors = []
    for path in sorted(pathlib.Path(folder).glob("**/doctor.json")):
        found = json.loads(path.read_text())
        floors += [
            c["noise_floor"]
            for c in found.get("classes", [])
            if c.get("size") == "cache" and c.get("noise_floor") is not None
        ]
    return 1 + max(0.02, float(np.median(floors))) if floors else None


def manifest(folder: pathlib.Path) -> dict:
    path = pathlib.Path(folder) / "manifest.json"
    return json.loads(path.read_text()) if path.exists() else {}


def begun(folder: pathlib.Path) -> dict:
    """What the full form has that waits in cut/ beside a quick one (scripts/bench/budget.py)."""
    found = manifest(folder.parent / "cut" / folder.name).get("cut")
    return {"begun": found} if found else {}


def options(text: str) -> dict[str, str]:
    """'facets=8,side=in' -> {'facets': '8', 'side': 'in'}; a preset may stand alone, 'paper,k=1e5'
    -> {'variant': 'paper', 'k': '1e5'}"""
    parts = [part for part in str(text).split(",") if part and text == text]
    return dict(part.split("=", 1) if "=" in part else ("variant", part) for part in parts)


def formulation_label(name: str, opts: str, config: str = "") -> str:
    """Short name for a plot: 'velocity, 8 facets', 'regularized paper'; which variant of its
    formulation a row has stands in its config (all options) if it was not asked for by name."""
    o = options(opts)
    facets = o.pop("facets", None)
    variant = o.pop("variant", options(config).get("variant", ""))
    label = f"{name} {variant}".strip() + (f", {facets} facets" if facets else "")
    return label + (f" ({','.join(f'{k}={v}' for k, v in o.items())})" if o else "")


def from_last(start: str) -> str:
    return " from the last step" if start == "previous" else ""


def combination(form: str, form_opts: str, solver: str, solver_opts: str) -> str:
    def one(name: str, opts: str):
        return name + (f":{opts}" if opts else "")

    if not form:
        return one(solver, solver_opts)
    return f"{one(form, form_opts)} + {one(solver, solver_opts)}"


def sizes(cells: pd.DataFrame, by: Sequence[str] = ("problem",)) -> pd.Series:
    """Contacts of each problem: the median over its good cells of the contacts posed at most, so
    that a run that fell apart (and touched elsewhere) stands at the size of its problem."""
    keys = [cells[name] for name in by]
    posed = cells["n_active"].where(cells["n_active"] > 0, cells["n_contacts"])
    good = posed.where(cells["good"])
    found = good.groupby(keys).transform("median")
    return found.fillna(posed.groupby(keys).transform("median"))


def between(group: Sequence[dict]) -> float:
    """How many times as long the slowest process of a cell took as the fastest, by the medians of
    their samples; NaN where there is one."""
    by = {}
    for row in group:
        if np.isfinite(row["t_total_s"]):
            by.setdefault(row.get("process"), []).append(row["t_total_s"])
    middle = [float(np.median(t)) for t in by.values()]
    return max(middle) / min(middle) if len(middle) > 1 and min(middle) > 0 else np.nan


def tied(one: pd.Series, least: pd.Series, column: str = "t_total_s") -> bool:
    """Does nobody know whether a cell takes longer than the cheapest? Their medians are closer than
    the noise of their campaign and size, or the intervals of their samples overlap."""
    noise = max(one["noise"], least["noise"])
    within = one[column] <= noise * least[column]
    return bool(within or one[f"{column}_low"] <= least[f"{column}_high"])


def cells(rows: pd.DataFrame) -> pd.DataFrame:
    """One line per cell: worst status, verified only if every repetition is, median time with its
    interval.

    Times of rows that are not `ok` or not verified are not times of a solution: they stay in t_*_s
    for the record, and `cost` (what comparisons use) is infinite there.
    """
    groups, kept = {}, [c for c in rows.columns if c not in TIMES]
    for row in rows.to_dict("records"):  # plain rows: a frame of each group would take a minute
        groups.setdefault((row["campaign"], row["cell_id"]), []).append(row)
    out = []
    for group in groups.values():
        first = group[0]
        line = {c: first[c] for c in kept} | {
            "reps": len(group),
            "verified": all(row["verified"] for row in group),
        }
        bad = next((row for row in group if row["status"] != "ok"), None)
        if bad:
            line.update(status=bad["status"], note=bad.get("note", ""))
        line["disturbed"] = next((row["disturbed"] for row in group if row["disturbed"]), "")
        line["noise"] = max(row["noise"] for row in group)
        line["good"] = line["verified"] and line["status"] == "ok"
        for c in TIMES:
            line[c], line[c + "_low"], line[c + "_high"] = stats.median_interval(
                [row[c] for row in group]
            )
        line["between"] = between(group)
        line["cost"] = (
            line["t_total_s"] if line["good"] and np.isfinite(line["t_total_s"]) else np.inf
        )
        out.append(line)
    frame = pd.DataFrame(out)
    frame["label"] = [
        formulation_label(f, o, c)
        for f, o, c in zip(
            frame["formulation"],
            frame.get("formulation_options", frame["formulation"].map(lambda _: "")),
            frame.get("formulation_config", frame["formulation"].map(lambda _: "")),
            strict=True,
        )
    ]
    frame["combination"] = [
        combination(*r)
        for r in frame[
            ["formulation", "formulation_options", "solver", "solver_options"]
        ].itertuples(index=False)
    ]
    frame["p"] = sizes(frame)
    if "n_steps" in frame:
        for c in TIMES[:-1]:
            if c in frame:
                for end in ("", "_low", "_high"):
                    frame[c[:-2] + "_step_s" + end] = frame[c + end] / frame["n_steps"]
    return converged.judge(frame)

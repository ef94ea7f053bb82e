"""Measured rows as tables: results/FORMAT.md has the columns."""

from __future__ import annotations

import json
import os
import pathlib
import sys

import pandas as pd

from lcpbench._program import SCRIPTS
from lcpbench.errors import InvalidInput

sys.path.append(str(SCRIPTS))  # `bench`, what figures and report are made by
from bench import profiles as _profiles  # noqa: E402
from bench import rows as _rows  # noqa: E402
from bench import stats  # noqa: E402, F401 (figures draw with it)

BOOLEANS = ("verified", "quick", "throttled", "suite_dirty")
UNITS = {"s": "s", "m": "m", "J": "J", "B": "B", "Hz": "Hz", "MHz": "MHz", "rel": "1"}


def _unit(column: str) -> str | None:
    """Names carry their units; rho and counts are numbers."""
    return UNITS.get(column.rsplit("_", 1)[-1]) or ("1" if column in ("rho", "tol") else None)


def _files(source: pathlib.Path) -> list[pathlib.Path]:
    if source.is_file():
        return [source]
    found = sorted(source.glob("results.csv*")) or sorted(source.glob("*/results.csv*"))
    if not found:
        raise InvalidInput(f"{source}: no results.csv here or one level below")
    return [f for f in found if f.suffix in (".csv", ".xz")]


def load(source: str | os.PathLike) -> pd.DataFrame:
    """The rows of a campaign folder, of all folders one level below, or of a file (.csv, .csv.xz):
    one line per repetition. Columns of booleans are booleans (rows[rows.verified] works);
    attrs["units"] has the unit of each column that has one, attrs["manifests"] the manifests by
    folder. InvalidInput where there are no rows."""
    files = _files(pathlib.Path(source))
    frames, manifests = [], {}
    for file in files:
        try:
            frame = pd.read_csv(file, low_memory=False, dtype=dict.fromkeys(BOOLEANS, "string"))
        except (OSError, ValueError, EOFError) as why:
            raise InvalidInput(f"{file}: {why}") from None
        except Exception as why:  # lzma.LZMAError, which pandas lets through
            raise InvalidInput(f"{file}: damaged: {why}") from None
        if not {"cell_id", "problem", "solver", "status", "verified"} <= set(frame.columns):
            raise InvalidInput(f"{file}: not rows of lcpbench (columns missing)")
        frames.append(frame)
        manifest = file.with_name("manifest.json")
        if manifest.exists():
            manifests[file.parent.name] = json.loads(manifest.read_text(encoding="utf-8"))
    rows = pd.concat(frames, ignore_index=True)
    for column in set(BOOLEANS) & set(rows.columns):
        values = rows[column].map({"true": True, "false": False})
        known = column == "verified" or not values.isna().any()
        rows[column] = values.fillna(False).astype(bool) if known else values.astype("boolean")
    rows.attrs["units"] = {c: u for c in rows.columns if (u := _unit(c))}
    rows.attrs["manifests"] = manifests
    return rows


def profile(source: str | os.PathLike, factors: tuple[float, ...] = (1, 2, 5, 10)) -> pd.DataFrame:
    """Performance profile (Dolan & More 2002) over the problems of measured rows: of each solver
    the number of problems, how many of them it was asked, how many it solved and verified, and the
    share within each factor of the best time. What failed, and what is not defined or was not
    asked, counts as not solved."""
    try:
        cells = _rows.cells(_rows.load_all(source)[0])
    except _rows.BadRows as why:
        raise InvalidInput(str(why)) from None
    cost, problems, _, solvers = _profiles.matrix(cells)
    if len(solvers) < 2:
        raise InvalidInput(f"{source}: a profile compares two solvers or more")
    noise = _rows.noise(source) or _profiles.NOISE
    table = _profiles.shares(cells, noise, factors)
    table.attrs["cost"] = pd.DataFrame(cost, index=problems, columns=solvers)
    table.attrs["noise"] = noise
    return table

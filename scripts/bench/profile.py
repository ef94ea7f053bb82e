"""profile DIR [--out FOLDER] - performance profile of the solvers over the problems of measured
rows."""

import json
import pathlib
import sys

import numpy as np
import pandas as pd

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from bench import chart, library, profiles, rows, say, style  # noqa: E402


def written(table: pd.DataFrame, form: str) -> str:
    if form == "csv":
        return table.to_csv(index=False).rstrip()
    if form == "json":
        return json.dumps(table.to_dict("records"), indent=2)
    return table.to_string(index=False, float_format=lambda v: f"{v:.2f}")


def main() -> int:
    parser = say.Arguments(
        prog="scripts/profile", description="Performance profile of the solvers of measured rows."
    )
    parser.add_argument("folder", metavar="DIR", help="campaign, or folder of campaigns")
    parser.add_argument("--out", default=".", help="folder of profile.pdf and profile.png")
    parser.add_argument("--format", choices=["table", "csv", "json"], default="table")
    args = parser.parse_args()
    try:
        cells = rows.cells(rows.load_all(args.folder)[0])
    except rows.BadRows as problem:
        say.complain(problem)
        return 2
    if cells["combination"].nunique() < 2:
        say.complain(f"{args.folder}: a profile compares two solvers or more")
        return 2
    noise = rows.noise(args.folder) or profiles.NOISE
    cost, _, families, solvers = profiles.matrix(cells)
    if not np.isfinite(cost).any():
        say.complain(f"{args.folder}: no cell is ok and verified")
        return 3
    drawn = chart.draw(library.profiles(cells["campaign"].iloc[0], cost, families, solvers, noise))
    style.save(drawn, pathlib.Path(args.out), "profile")
    print(written(profiles.shares(cells, noise), args.format))
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""recommend DIR --scene S --error E [--yardstick Y]"""

import argparse
import difflib
import fnmatch
import pathlib
import sys

import pandas as pd

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from bench import accuracy, rows, say, style  # noqa: E402
from bench.section import error, si  # noqa: E402


def said(cell: pd.Series, column: str) -> str:
    """An error in words, with what its reference is worth where that is not a closed form."""
    if column != "err_ref" or not cell["converged"]:
        return error(cell[column])
    floor = error(cell["err_floor"])
    return (
        f"not resolved, below the {floor} of its reference"
        if cell["err_ref"] < cell["err_floor"]
        else f"{error(cell[column])} (to {floor}; {cell['err_source']})"
    )


def why_not(fit: pd.DataFrame, column: str, level: float) -> str:
    if fit.empty:
        return "not measured"
    if column != "err_ref":
        return f"the smallest is {error(fit[column].min())}"
    if fit["err_floor"].min() > level:
        return f"the reference itself is uncertain by {error(fit['err_floor'].min())}"
    return f"the smallest error that finer steps keep is {error(fit['err_sure'].min())}"


def error_of(text: str) -> tuple[float, bool]:
    """'1%' -> (0.01, True): of the scene's scale; '0.01' -> (0.01, False): in the unit of its
    quantity."""
    share = text.endswith("%")
    try:
        value = float(text.removesuffix("%")) / (100 if share else 1)
    except ValueError:
        value = -1.0
    if not 0 <= value < float("inf"):
        raise argparse.ArgumentTypeError(
            f"{text}: need a number of at least 0 in the unit of the scene's quantity, or 1%"
        )
    return value, share


def scale_of(group: pd.DataFrame) -> float:
    """What an error of 1 % is a share of: the size of the predicted value, or of the end value
    where the reference is a converged run; 0 where neither has a size."""
    predicted = group["err_predicted"].abs().median()
    ends = group["end_value"][group["converged"]].abs().median()
    found = predicted if predicted > 0 else ends
    return float(found) if found > 0 else 0.0


def main() -> int:
    parser = say.Arguments(
        prog="scripts/recommend",
        description="The cheapest verified combination for a scene and an error.",
    )
    parser.add_argument(
        "folder",
        metavar="DIR",
        nargs="?",
        default="results/runs",
        help="campaign, or folder of campaigns (default: results/runs)",
    )
    parser.add_argument(
        "--scene",
        required=True,
        help="problem as in the rows, or a pattern; its family name is enough",
    )
    parser.add_argument(
        "--error",
        required=True,
        type=error_of,
        metavar="E",
        help="error to stay below, in the unit of the scene's quantity, or 1%% of its size",
    )
    parser.add_argument("--yardstick", choices=list(accuracy.YARDSTICKS), default="trajectory")
    args = parser.parse_args()
    column = accuracy.YARDSTICKS[args.yardstick][0]
    try:
        cells = accuracy.confirmed(rows.cells(rows.load_all(args.folder)[0]))
    except rows.BadRows as problem:
        say.complain(problem)
        return 2
    match = [
        fnmatch.fnmatch(p, args.scene) or f == args.scene
        for p, f in zip(cells["problem"], cells["problem_family"], strict=True)
    ]
    found = cells[match]
    if found.empty:
        known = sorted(set(cells["problem_family"]))
        near = difflib.get_close_matches(args.scene, known, 1)
        hint = f"did you mean '{near[0]}'?" if near else f"there are {len(known)} families of them"
        say.complain(f"--scene {args.scene}: no such scene in the rows; {hint}")
        return 2
    status = 3
    for problem, group in found.groupby("problem"):
        level, share = args.error
        if share and column == "err_ref":
            scale = scale_of(group)
            if scale == 0.0:
                print(f"{problem}: its quantity has no size; give an error in its unit")
                continue
            print(f"{problem}: {level:.3g} of {scale:.3g} ({group['err_quantity'].iloc[0]})")
            level *= scale
        best = accuracy.cheapest(group, level, column)
        if best is None:
            print(
                f"{problem}: nothing confirmed reaches {level:g};"
                f" {why_not(accuracy.usable(group, column), column, level)}"
            )
            continue
        status = 0
        use = style.marked(best["combination"]) if sys.stdout.isatty() else best["combination"]
        print(
            f"{problem}: {use}, h = {best['step_s']:g} s: {args.yardstick} error"
            f" {said(best, column)}, {si(best['cost'], 's')}"
        )
        same = accuracy.ties(group, best, level, column)
        if same:
            print(
                f"  in the same time, to the noise or the spread of the samples: {'; '.join(same)}"
            )
        print(f"  {best['command']}")
    return status


if __name__ == "__main__":
    sys.exit(main())

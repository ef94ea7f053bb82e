#!/usr/bin/env python3
"""figures.py DIR --out FOLDER - the figures of a campaign, as PDF and PNG, the same bytes each
time."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from bench import chart, paper, rows, say, section, style  # noqa: E402


def main() -> int:
    parser = say.Arguments(description=__doc__)
    parser.add_argument("folder", metavar="DIR", help="folder of a campaign (results.csv)")
    parser.add_argument("--out", help="where the figures go (default: DIR/figures)")
    args = parser.parse_args()
    out = pathlib.Path(args.out or pathlib.Path(args.folder) / "figures")
    try:
        cells = rows.cells(rows.load(args.folder))
    except rows.BadRows as error:
        say.complain(error)
        return 2
    for make in paper.CHARTS:
        drawn = make(cells)
        if drawn is None:
            say.complain(f"figures: {make.__name__}: this campaign has no rows for it")
            continue
        style.save(chart.draw(drawn), out, drawn.name)
        (out / f"{drawn.name}.dat").write_text(chart.table(drawn))
        print(out / f"{drawn.name}.pdf")
    table = paper.summary(cells)
    if table is not None:
        (out / "summary.md").write_text(f"{table.caption}\n\n{section.table_md(table)}")
        print(out / "summary.md")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""experiments TABLE.KEY [COLUMN...] - prints an entry of scripts/experiments.toml for a shell
script: each item of a list on a line of its own, of tables the named columns with a tab between.

scripts/experiments.toml is the only place of scripts/ where components are named.
"""

from __future__ import annotations

import functools
import pathlib
import sys
import tomllib

PLACE = pathlib.Path(__file__).resolve().parents[1] / "experiments.toml"


@functools.cache
def read() -> dict:
    return tomllib.loads(PLACE.read_text(encoding="utf-8"))


Entry = dict | list | str | float  # of a TOML file


def of(path: str) -> Entry:
    """The entry at TABLE.KEY..."""
    found = read()
    for key in path.split("."):
        found = found[key]
    return found


def way(entry: dict) -> tuple[str, str]:
    """(formulation, solver) of an entry."""
    return entry["formulation"], entry["solver"]


def filled(text: str, *values: object) -> str:
    """The text with its {} in turn replaced."""
    for value in values:
        text = text.replace("{}", str(value), 1)
    return text


def main(path: str, *columns: str) -> None:
    for item in of(path):
        print(
            "\t".join(
                f"{item[c]:.10g}" if isinstance(item[c], float) else str(item[c]) for c in columns
            )
            if columns
            else item
        )


if __name__ == "__main__":
    main(*sys.argv[1:])

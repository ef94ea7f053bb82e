#!/usr/bin/env python3
"""scripts/check_circles.py [BUILD] - fails where files of one folder use each other in a circle, or
rooms do.

A file uses another when it calls a function that the other defines (read off the object files of
BUILD, so that macros and function-like tables hide nothing); a header uses another when it includes
it. Two kinds of circle are looked for: between the files of one folder, and between the rooms of
harness/ and of problems/, whose order stands in ROOMS. A registry that lists the constants of its
components calls none of them and is no circle. A folder of more than MOST C files fails too, the
lists of components and tests/unit excepted.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FLOORS = ("lcp", "problems", "formulations", "harness", "library")
# Each room uses only rooms that stand before it.
ROOMS = {
    "harness": [
        "util",
        "choice",
        "measure",
        "sequence",
        "control",
        "plan",
        "cell",
        "campaign",
        "check",
        "cli",
    ],
    "problems": [".", "spec", "geometry", "world", "families", "scenes", "read", "write", "import"],
}
MOST = 40
LISTS = ("problems/scenes", "lcp/solvers", "tests/unit")
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)


def sources(root: Path) -> list[str]:
    return sorted(
        f.relative_to(root).as_posix() for floor in FLOORS for f in (root / floor).rglob("*.[ch]")
    )


def includes(root: Path) -> dict[str, set[str]]:
    """Which files of the project each file includes."""
    known = set(sources(root))
    return {
        f: {
            target
            for target in INCLUDE.findall((root / f).read_text(encoding="utf-8"))
            if target in known
        }
        for f in known
    }


def calls(root: Path, build: Path) -> dict[str, set[str]]:
    """Which files each file calls, by the object files that the compile database names."""
    objects = {}
    for entry in json.loads((build / "compile_commands.json").read_text(encoding="utf-8")):
        source = (Path(entry["directory"]) / entry["file"]).resolve()
        output = Path(entry["directory"]) / entry["output"]
        if output.exists() and source.is_relative_to(root):
            name = source.relative_to(root).as_posix()
            if name.split("/")[0] in FLOORS:
                objects[name] = output
    defined: dict[str, str] = {}
    needed: dict[str, set[str]] = {}
    for name, output in objects.items():
        text = subprocess.run(["nm", "-g", output], capture_output=True, text=True, check=True)
        needed[name] = set()
        for line in text.stdout.splitlines():
            kind, symbol = line.split()[-2:]
            if kind == "U":
                needed[name].add(symbol)
            elif kind in "TWi":
                defined[symbol] = name
    return {
        name: {defined[s] for s in symbols if s in defined} - {name}
        for name, symbols in needed.items()
    }


def circles(uses: dict[str, set[str]]) -> list[list[str]]:
    """The strongly connected sets of more than one file (Tarjan 1972)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found = []

    def visit(v: str) -> None:
        index[v] = low[v] = len(index)
        stack.append(v)
        for w in sorted(uses.get(v, ())):
            if w not in index:
                visit(w)
                low[v] = min(low[v], low[w])
            elif w in stack:
                low[v] = min(low[v], index[w])
        if low[v] == index[v]:
            part = []
            while not part or part[-1] != v:
                part.append(stack.pop())
            if len(part) > 1:
                found.append(sorted(part))

    for v in sorted(uses):
        if v not in index:
            visit(v)
    return found


def within_folders(uses: dict[str, set[str]]) -> dict[str, set[str]]:
    return {
        a: {b for b in bs if b.rsplit("/", 1)[0] == a.rsplit("/", 1)[0]} for a, bs in uses.items()
    }


def against_the_rooms(uses: dict[str, set[str]]) -> list[str]:
    bad = []
    for a, bs in sorted(uses.items()):
        floor, *inner = a.split("/")
        order = ROOMS.get(floor)
        if order is None:
            continue
        here = inner[0] if len(inner) > 1 else "."
        for b in sorted(bs):
            other, *deep = b.split("/")
            there = deep[0] if len(deep) > 1 else "."
            if other != floor or there == here:
                continue
            if here not in order or there not in order:
                bad.append(f"{a} uses {b}: a room that has no place in ROOMS")
            elif order.index(there) > order.index(here):
                bad.append(f"{a} uses {b}: {floor}/{there} stands above {floor}/{here}")
    return bad


def corridors(root: Path) -> list[str]:
    """Folders with too many C files."""
    count = Counter(
        f.parent.relative_to(root).as_posix()
        for floor in (*FLOORS, "tests")
        for f in (root / floor).rglob("*.[ch]")
    )
    return [
        f"{folder} holds {n} C files, more than {MOST}"
        for folder, n in sorted(count.items())
        if n > MOST and folder not in LISTS
    ]


def main() -> int:
    build = (Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "build").resolve()
    if not (build / "compile_commands.json").exists():
        print(
            f"check_circles: no build in {build}: run scripts/configure and ninja", file=sys.stderr
        )
        return 2
    called = calls(ROOT, build)
    included = includes(ROOT)
    headers = {f: {g for g in gs if g.endswith(".h")} for f, gs in included.items() if f[-1] == "h"}
    found = circles(within_folders(called)) + circles(within_folders(headers))
    for part in found:
        print("circle: " + ", ".join(part))
        for a in part:
            for b in sorted((called.get(a, set()) | headers.get(a, set())) & set(part)):
                print(f"  {a} uses {b}")
    rooms = against_the_rooms(included) + against_the_rooms(called)
    for line in rooms:
        print("room: " + line)
    long = corridors(ROOT)
    for line in long:
        print("folder: " + line)
    return 1 if found or rooms or long else 0


if __name__ == "__main__":
    sys.exit(main())

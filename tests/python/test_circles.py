"""scripts/check_circles.py finds planted circles: two files that call each other, and a room used
from below."""

import json
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import check_circles

SOURCES = {
    "lcp/a.c": "int a(int);\nint b(int);\nint a(int x) { return x > 0 ? b(x - 1) : 0; }\n",
    "lcp/b.c": "int a(int);\nint b(int);\nint b(int x) { return a(x - 1); }\n",
    "lcp/c.c": "int a(int);\nint c(int);\nint c(int x) { return a(x); }\n",
    "harness/util/low.c": "int high(int);\nint low(int);\nint low(int x) { return high(x); }\n",
    "harness/cli/high.c": "int high(int);\nint high(int x) { return x; }\n",
}


def tree(sources: dict[str, str], folder: str) -> pathlib.Path:
    """The sources and a build of them, as meson leaves it."""
    root = pathlib.Path(folder).resolve()
    build = root / "build"
    build.mkdir()
    database = []
    for name, text in sources.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        output = name.replace("/", "_") + ".o"
        subprocess.run(["cc", "-c", path, "-o", build / output], check=True)
        database.append({"directory": str(build), "file": f"../{name}", "output": output})
    (build / "compile_commands.json").write_text(json.dumps(database), encoding="utf-8")
    return root


def verdict(sources: dict[str, str]) -> tuple[list[list[str]], list[str]]:
    with tempfile.TemporaryDirectory() as folder:
        root = tree(sources, folder)
        called = check_circles.calls(root, root / "build")
        inside = check_circles.circles(check_circles.within_folders(called))
        return inside, check_circles.against_the_rooms(called)


inside, rooms = verdict(SOURCES)
assert inside == [["lcp/a.c", "lcp/b.c"]], inside
assert len(rooms) == 1 and "harness/cli stands above harness/util" in rooms[0], rooms

mended = dict(SOURCES)
mended["lcp/b.c"] = "int b(int);\nint b(int x) { return x; }\n"
del mended["harness/util/low.c"]
assert verdict(mended) == ([], [])

with tempfile.TemporaryDirectory() as folder:
    long = pathlib.Path(folder) / "problems" / "world"
    long.mkdir(parents=True)
    for i in range(check_circles.MOST + 1):
        (long / f"f{i}.c").touch()
    assert len(check_circles.corridors(pathlib.Path(folder))) == 1
    (long / "f0.c").unlink()
    assert check_circles.corridors(pathlib.Path(folder)) == []

"""The committed catalogue of scenes says what the program says, and has a picture of every
scene."""

import pathlib
import subprocess
import sys

from support import LCPBENCH, run, tap

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER = ROOT / "problems" / "scenes"


def text_is_current(d):
    out = subprocess.run(
        [sys.executable, ROOT / "scripts" / "bench" / "catalogue.py", "--stdout"],
        check=True,
        capture_output=True,
        text=True,
        env={"LCPBENCH": LCPBENCH, "PATH": ""},
    ).stdout
    assert out == (FOLDER / "README.md").read_text(encoding="utf-8"), (
        "problems/scenes/README.md is old: run scripts/catalogue"
    )


def every_scene_has_a_picture(d):
    names = run("list", "scenes").stdout.split()
    assert {p.stem for p in (FOLDER / "pictures").iterdir()} == set(names)
    for name in names:
        data = (FOLDER / "pictures" / f"{name}.png").read_bytes()
        assert data.startswith(b"\x89PNG") and 1000 < len(data) < 40000, (name, len(data))


tap([text_is_current, every_scene_has_a_picture])

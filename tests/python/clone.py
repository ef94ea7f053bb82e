"""A copy of the sources with a build of its own, which takes over the objects of the build under
test: for tests that change the sources, or that take them away."""

import json
import os
import pathlib
import shutil
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("LCPBENCH_BUILD", ROOT / "build")).resolve()
KEPT = ("buildtype", "optimization", "debug", "werror", "warning_level", "b_ndebug", "siconos")


def copied(folder: pathlib.Path) -> None:
    """The sources with their times, so that objects that were made from them are not made again."""
    listed = subprocess.run(
        ["git", "-C", ROOT, "ls-files", "-co", "--exclude-standard"],
        capture_output=True,
        text=True,
        check=True,
    )
    for name in listed.stdout.splitlines():
        part = not name.startswith(("results/", "tests/")) or name.endswith("/choices.tsv")
        if part and (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)
    (folder / "tests").mkdir()
    (folder / "tests" / "meson.build").touch()
    (folder / ".venv").symlink_to(ROOT / ".venv")


def configured(folder: pathlib.Path, *more: str) -> pathlib.Path:
    """A build tree in the copy, with the options and the objects of the build under test, and more
    options."""
    told = json.loads((BUILD / "meson-info" / "intro-buildoptions.json").read_text())
    options = [f"-D{o['name']}={str(o['value']).lower()}" for o in told if o["name"] in KEPT]
    words = json.loads((BUILD / "compile_commands.json").read_text())[0]["command"].split()
    compiler = " ".join(words[: 2 if pathlib.Path(words[0]).name == "ccache" else 1])
    build = folder / "build"
    subprocess.run(
        ["meson", "setup", build, folder, "-Dtests=disabled", *options, *more],
        env=dict(os.environ, CC=compiler),
        check=True,
        capture_output=True,
    )
    for path in BUILD.rglob("*"):
        if path.suffix in (".o", ".a") or path.name in (".ninja_log", ".ninja_deps"):
            to = build / path.relative_to(BUILD)
            if not to.is_relative_to(build / "tests"):
                to.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(path, to)
    return build

"""The wheel: built from a copy of the sources, installed into an empty virtual environment, and
tested there when the sources are gone. Needs PyPI; without it the test is skipped, in so many
words."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

from clone import ROOT, copied

SKIPPED = 77  # meson's word


def run(command, cwd, home):
    """The lines that it prints; what fails ends the test with its last lines."""
    clean = {k: v for k, v in os.environ.items() if not k.startswith(("LCPBENCH", "PYTHON", "LD_"))}
    cache = os.environ.get("PIP_CACHE_DIR", str(pathlib.Path.home() / ".cache" / "pip"))
    own = {"HOME": str(home), "PIP_CACHE_DIR": cache, "PIP_DISABLE_PIP_VERSION_CHECK": "1"}
    own |= {"PIP_NO_COMPILE": "1"}  # of what is installed a tenth is imported
    done = subprocess.run(
        ["sh", "-c", command],
        cwd=cwd,
        env=clean | own | {"OPENBLAS_NUM_THREADS": "1"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise SystemExit(f"{command}: exit {done.returncode}\n{done.stdout[-3000:]}")
    return done.stdout.strip().splitlines()


def page():
    """The script, the commands and what the script prints, of docs/how/my-python.md."""
    text = (ROOT / "docs" / "how" / "my-python.md").read_text(encoding="utf-8")
    script = re.search(r"<!-- file: five.py -->\n```python\n(.*?)```", text, re.S)[1]
    commands = re.search(r"```sh\n(.*?)```", text, re.S)[1].splitlines()
    printed = re.search(r"```text\n(.*?)```", text, re.S)[1].strip()
    assert len(script.splitlines()) == 5 and len(commands) <= 5, (script, commands)
    readme = (ROOT / "python" / "README.md").read_text(encoding="utf-8")
    assert f"```python\n{script}```" in readme, "python/README.md has another script"
    return script, commands, printed


def main(scratch):
    source, away = scratch / "source", scratch / "away"
    script, commands, printed = page()
    source.mkdir()
    copied(source)
    (source / "five.py").write_text(script, encoding="utf-8")
    away.mkdir()
    for folder in ("tests", "examples"):
        shutil.copytree(source / "python" / folder, away / folder)
    run(commands[0], source, scratch)
    try:
        run("~/lcp/bin/pip download -q --no-deps -d ~/seen meson-python", source, scratch)
    except SystemExit as why:
        print(f"wheel: skipped, PyPI cannot be reached: {str(why).splitlines()[-1]}")
        return SKIPPED
    told = []
    for command in commands[1:]:
        began = time.monotonic()
        told.append(run(command, source, scratch))
        print(f"{time.monotonic() - began:.0f} s: {command}")
    assert told[1] == [printed], (told[1], printed)
    shutil.rmtree(source)
    print(run("~/lcp/bin/python -m pytest -q tests", away, scratch)[-1])
    return 0


if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="lcpbench-wheel-") as folder:
        sys.exit(main(pathlib.Path(folder)))

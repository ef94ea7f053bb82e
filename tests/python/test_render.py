"""Trajectories that are no trajectories are refused in one line; a real one becomes stills, a sheet
and an animation."""

import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from bench import render as renderer  # noqa: E402

LCPBENCH = os.environ["LCPBENCH"]
FOLDER = tempfile.TemporaryDirectory()
D = pathlib.Path(FOLDER.name)


def render(path, *more):
    return subprocess.run(
        [sys.executable, ROOT / "scripts" / "bench" / "render.py", path, *map(str, more)],
        capture_output=True,
        text=True,
    )


def trajectory(scene, path):
    subprocess.run(
        [
            LCPBENCH,
            "simulate",
            scene,
            "--formulation",
            "velocity",
            "--solver",
            "lemke",
            "--trajectory",
            path,
        ],
        check=True,
        capture_output=True,
    )
    return path.read_text()


def test_pictures():
    for scene in ("pile3:duration=0.1", "walking_foot:duration=0.05"):  # in the plane, in space
        path = D / f"{scene.split(':')[0]}.csv"
        trajectory(scene, path)
        done = render(path, "--frames", 3, "--times", "0,0.05")
        assert done.returncode == 0, done.stderr
        out = path.with_suffix("")
        for name, head in (
            ("still_0.png", b"\x89PNG"),
            ("still_1.png", b"\x89PNG"),
            ("sheet.png", b"\x89PNG"),
            ("run.gif", b"GIF8"),
        ):
            data = (out / name).read_bytes()
            assert data.startswith(head) and len(data) > 2000, (scene, name, len(data))


def test_malformed():
    good = trajectory("pile3:duration=0.02", D / "good.csv")
    assert renderer.Run(D / "good.csv").names == ["left", "right", "top"]
    lines = good.splitlines()
    head = lines[0]
    first = next(i for i, line in enumerate(lines) if ",body," in line)
    bad = {
        "empty": "",
        "binary": "\x00\x01\x02",
        "no header": "\n".join(lines[1:]),
        "other table": "a,b\n1,2\n",
        "no scene": "\n".join(line for line in lines if ",scene," not in line),
        "two scenes": "\n".join([*lines, lines[1]]),
        "dimension": good.replace(",scene,pile3,2,", ",scene,pile3,4,", 1),
        "no bodies": "\n".join(line for line in lines if ",body," not in line),
        "a word for a number": good.replace(
            lines[first], lines[first].replace(lines[first].split(",")[4], "left", 1)
        ),
        "not finite": good.replace(
            lines[first],
            ",".join(c if i != 5 else "nan" for i, c in enumerate(lines[first].split(","))),
        ),
        "a column short": good.replace(head, head.rsplit(",", 1)[0]),
        "unknown shape": good.replace(",shape,left,sphere,", ",shape,left,torus,", 1),
    }
    assert len(bad) >= 10
    for what, text in bad.items():
        path = D / "bad.csv"
        path.write_text(text)
        try:
            renderer.Run(path)
        except renderer.BadTrajectory as refusal:
            assert "bad.csv" in str(refusal) and "\n" not in str(refusal), (what, refusal)
        else:
            raise AssertionError(f"{what}: accepted")
    done = render(path)
    assert (
        done.returncode == 2 and len(done.stderr.splitlines()) == 1 and "bad.csv" in done.stderr
    ), done.stderr


test_pictures()
test_malformed()
print("ok")

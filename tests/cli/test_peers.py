"""Peers as plug-ins: those whose libraries are on this machine are built by `scripts/peers` and
hold what they declare; one whose answer is wrong is not believed. Nothing is fetched."""

import json
import os
import pathlib
import re
import shutil
import subprocess

from support import LCPBENCH, Skip, run_json, tap

ROOT = pathlib.Path(__file__).resolve().parents[2]
PEERS = ROOT / "peers"
TIES = "tridiagonal:n=12"  # Dantzig's method of ODE ends at a tie of this one
REGULAR = "random_spd:n=20"


def sources():
    return sorted({*PEERS.glob("*.c"), *PEERS.glob("*.cpp")})


def environment():
    kept = {k: v for k, v in os.environ.items() if k != "LCPBENCH_PLUGINS"}
    return dict(kept, LCPBENCH=LCPBENCH, OPENBLAS_NUM_THREADS="1")


def built(folder):
    """The completed run of scripts/peers, and what it built."""
    if shutil.which("c++") is None:
        raise Skip("no C++ compiler on this machine")
    done = subprocess.run(
        [ROOT / "scripts" / "peers", "--no-fetch", "--check", "--build", folder],
        capture_output=True,
        text=True,
        env=environment(),
        check=False,
    )
    files = sorted(folder.glob("*.so"))
    if not files:
        assert done.returncode == 1 and "0 of" in done.stdout, done.stdout + done.stderr
        raise Skip("no library of a peer on this machine: libbullet-dev has three")
    return done, files


def each_is_one_short_file(d):
    assert len(sources()) >= 8
    for file in sources():
        text = file.read_text()
        assert len(text.splitlines()) <= 150, file
        assert text.count("lcp_plugin_descriptor =") == 1 and f'.name = "{file.stem}"' in text, file


def what_is_there_conforms_and_what_is_not_is_named(d):
    done, files = built(d)
    assert done.returncode == 0, done.stdout + done.stderr
    told = dict(re.findall(r"^(\w+) +(built|absent) +\S+", done.stdout, re.M))
    assert sorted(told) == [f.stem for f in sources()], done.stdout
    assert [f.stem for f in files] == sorted(n for n, w in told.items() if w == "built")


def an_answer_is_judged_whatever_the_library_says(d):
    _, files = built(d)
    claims = 0
    for file in files:
        words = ("--plugin", file, "--solver", file.stem)
        o = run_json("solve", REGULAR, *words)
        assert (o["status"], o["verified"]) == ("ok", True), o
        o = run_json("solve", TIES, *words, code=None)
        assert o["status"] != "unverified", o
        if "claim=checked" in o["options"] and o["status"] == "stalled":
            believed = run_json(
                "solve", TIES, "--plugin", file, "--solver", f"{file.stem}:claim=library", code=3
            )
            assert not believed["verified"] and believed["rho"] > 0.1, json.dumps(believed)
            claims += believed["status"] == "unverified"
    if (d / "dart_dantzig.so").exists():
        assert claims > 0  # it says solved, and is not


tap(
    [
        each_is_one_short_file,
        what_is_there_conforms_and_what_is_not_is_named,
        an_answer_is_judged_whatever_the_library_says,
    ]
)

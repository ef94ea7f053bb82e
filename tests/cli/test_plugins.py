"""Plug-ins: one with no fault is a solver like any other; those that lie, crash, hang, leak, write
where they must not or change their minds get their word, in a campaign and from `conform`."""

import json
import os
import pathlib
import re
import shutil
import subprocess

from support import LCPBENCH, SANITIZED, campaign, one_line_error, rows, run, run_json, tap

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER = pathlib.Path(os.environ["LCPBENCH_PLUGIN_FOLDER"])
MANY = """
name: planted
limits: {time: 5s, memory: 1G, grace: 0.5s}
sampling: {processes: 1, samples: 200, max_samples: 200, inner: 1e-9s, budget: 10s}
parts:
  - name: a
    problems: ["random_spd:n=20"]
    solvers: [%s]
"""
WORDS = {
    "lemke": "ok",
    "plugin_good": "ok",
    "plugin_liar": "unverified",
    "plugin_prover": "unverified",  # infeasible, it said, and its proof does not hold
    "plugin_crash": "crash",
    "plugin_hang": "timeout",
    "plugin_leak": "oom",
    "plugin_overrun": "error",
    "plugin_writer": "error",  # into q, as routines do that overwrite what they factor
}
if SANITIZED:  # no memory limit there, and the sanitizer ends whoever writes behind a block
    del WORDS["plugin_leak"], WORDS["plugin_overrun"]


def plugin(name):
    return FOLDER / f"{name}.so"


def options(*names):
    return [w for n in names for w in ("--plugin", plugin(n))]


def a_good_one_is_a_solver_like_any_other(d):
    words = options("plugin_good")
    assert "plugin_good" in run("list", "solvers", *words).stdout.split()
    assert "plugin_good" not in run("list", "solvers").stdout.split()
    o = run_json("solve", "random_spd:n=20", "--solver", "plugin_good:depth=4,rule=first", *words)
    assert (o["status"], o["verified"]) == ("ok", True) and "depth=4,rule=first" in o["options"], o
    o = run_json(
        *words, "simulate", "stack:n=2,duration=0.02", "--formulation", "normal", "--solver",
        "plugin_good",
    )  # fmt: skip
    assert o["status"] == "ok", o
    alone = run("list", "solvers", f"--plugin={plugin('plugin_good')}").stdout.split()
    assert "plugin_good" in alone, alone
    env = {"LCPBENCH_PLUGINS": f"{plugin('plugin_good')}:{plugin('plugin_liar')}"}
    told = run("list", "solvers", **env).stdout.split()
    assert {"plugin_good", "plugin_liar"} <= set(told), told
    assert "a word that nothing depends on" in run("help", "plugin_good", *words).stdout
    one_line_error(*words, "solve", "random_spd:n=5", "--solver", "plugin_good:depth=12",
                   names=("plugin_good", "depth"))  # fmt: skip


def each_fault_has_its_row(d):
    names = [n for n in WORDS if n != "lemke"]
    c = campaign(d, MANY % ", ".join(WORDS))
    run("run", c, "--out", d / "out", "--quiet", *options(*names))
    got = {}
    for r in rows(d / "out"):
        got.setdefault(r["solver"], set()).add(r["status"])
    assert got == {n: {w} for n, w in WORDS.items()}, got
    assert all(r["verified"] != "true" for r in rows(d / "out") if r["status"] != "ok")
    manifest = json.loads((d / "out" / "manifest.json").read_text())
    assert set(manifest["plugins"]) == set(names)


def a_row_can_be_run_again(d):
    c = campaign(d, MANY % "plugin_good")
    run("run", c, "--out", d / "out", "--quiet", *options("plugin_good"))
    command = rows(d / "out")[0]["command"]
    assert "--plugin" in command, command
    words = command.replace("lcpbench ", f"{LCPBENCH} ", 1)
    done = subprocess.run(words, shell=True, capture_output=True, text=True)
    assert json.loads(done.stdout)["status"] == "ok", done.stderr


def a_changed_file_is_measured_again(d):
    mine = d / "mine.so"
    shutil.copy(plugin("plugin_good"), mine)
    c = campaign(d, MANY % "lemke, plugin_good")
    for change, count in ((b"", 2), (b"", 0), (b"\0", 1), (b"", 0)):
        with open(mine, "ab") as f:
            f.write(change)
        done = run("run", c, "--out", d / "out", "--quiet", "--plugin", mine)
        assert f" {count} measured now" in done.stdout, (change, done.stdout)
    assert (d / "out" / "stale.csv").exists()


def shards_load_it_too(d):
    c = campaign(d, MANY % "plugin_good")
    run("submit", c, "--engine", "parallel", "--shards", "2", "--dry-run", "--out", d / "s",
        *options("plugin_good"))  # fmt: skip
    text = (d / "s" / "parallel.sh").read_text()
    assert f"--plugin '{plugin('plugin_good').resolve()}' run" in text, text


def refused_in_one_line(d):
    solve = ("solve", "random_spd:n=5", "--solver", "lemke")
    for name, *words in (
        ("gone", "gone.so", "No such file"),
        ("no_plugin", "no_plugin.so", "lcp_plugin_descriptor"),
        ("plugin_old", "plugin_old.so", "interface 0", "need 1"),
        ("plugin_taken", "plugin_taken.so", "'lemke'"),
    ):
        one_line_error(*options(name), *solve, names=words)
    (d / "text.so").write_text("not an object")
    one_line_error("--plugin", d / "text.so", *solve, names=("text.so",))
    one_line_error(*solve, "--plugin", names=("--plugin",))
    one_line_error(*solve, "--plugin=", names=("--plugin",))
    one_line_error(*solve, f"--plugin={FOLDER / 'gone.so'}", names=("gone.so",))
    one_line_error(*solve, "--plugn", plugin("plugin_good"), names=("did you mean '--plugin'?",))
    done = run(*solve, code=2, LCPBENCH_PLUGINS=str(FOLDER / "gone.so"))
    assert "LCPBENCH_PLUGINS" in done.stderr and "gone.so" in done.stderr, done.stderr
    one_line_error("conform", "nobody", names=("nobody",))


def conform(name, code):
    return run("conform", plugin(name), code=code).stdout


def conform_finds_each_fault(d):
    out = conform("plugin_good", 0)
    assert "sets: orthant box; storages: dense" in out and "FAILED" not in out, out
    assert int(re.search(r"(\d+) passed, 0 failed", out)[1]) >= 50, out
    for name, check, words in (
        ("plugin_liar", "answer", "a false claim"),
        ("plugin_prover", "answer", "a false claim"),
        ("plugin_crash", "run", "crash by signal"),
        ("plugin_writer", "run", "third-party library"),
        ("plugin_fickle", "again", "another answer"),
    ) + (() if SANITIZED else (
        ("plugin_overrun", "run", "third-party library"),
        ("plugin_leak", "heap", "bytes more after each solve"),
    )):  # fmt: skip
        out = conform(name, 3)
        found = re.findall(rf"FAILED \S+ - {name} \[{check}\] : (.*)", out)
        assert found and all(words in line for line in found), (name, out)


def conform_ends_what_hangs(d):
    out = run("conform", plugin("plugin_hang"), "--time-limit", "0.2", code=3).stdout
    assert "timeout after 0.2 s" in out, out


def the_template_conforms(d):
    source = ROOT / "examples" / "plugin_pgs.c"
    assert len(source.read_text().splitlines()) <= 60
    target = d / "plugin_pgs.so"
    subprocess.run(
        ["cc", "-shared", "-fPIC", "-O2", f"-I{ROOT / 'include'}", source, "-o", target], check=True
    )
    if not SANITIZED:
        run("conform", target)


tap(
    [
        a_good_one_is_a_solver_like_any_other,
        each_fault_has_its_row,
        a_row_can_be_run_again,
        a_changed_file_is_measured_again,
        shards_load_it_too,
        refused_in_one_line,
        conform_finds_each_fault,
        conform_ends_what_hangs,
        the_template_conforms,
    ]
)

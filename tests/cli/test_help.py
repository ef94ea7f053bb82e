"""What the program says of itself: help, manual page, completion and hints, all from one table."""

import json
import os
import pathlib
import pty
import re
import shutil
import subprocess
import sys

from support import LCPBENCH, Skip, one_line_error, run, tap

TOP = run("--help").stdout
VERBS = re.findall(r"^  lcpbench (\w+)", TOP, re.M)


def options(verb):
    """Name -> (what stands behind it with unit and range, the sentence)."""
    lines = run(verb, "--help").stdout.splitlines()
    out = {}
    for line, below in zip(lines, lines[1:], strict=False):
        found = re.match(r"  (--[a-z-]+)(.*)$", line)
        if found:
            out[found[1]] = (found[2].strip(), below.strip())
    return out


def every_option_is_explained(_):
    assert {"solve", "simulate", "run", "verify", "help", "complete"} <= set(VERBS), VERBS
    for verb in VERBS:
        told = options(verb)
        usage = run(verb, "--help").stdout.splitlines()[0]
        assert set(re.findall(r"--[a-z-]+", usage)) == set(told), (verb, usage)
        assert told["--plugin"][0] == "FILE.so", (verb, told)
        for name, (_, sentence) in told.items():
            assert len(sentence) > 15 and not sentence.startswith("--"), (verb, name, sentence)
        assert run("help", verb).stdout == run(verb, "--help").stdout


def ranges_that_are_told_are_kept(d):
    """The number just outside is refused in the words of the help."""
    tried = 0
    for verb, words in (
        ("solve", ["solve", "murty:n=3", "--solver", "lemke"]),
        ("simulate", ["simulate", "stack:n=1", "--formulation", "velocity", "--solver", "lemke"]),
        ("run", ["run", "smoke", "--dry-run"]),
        ("doctor", ["doctor"]),
        ("submit", ["submit", "smoke", "--engine", "slurm", "--dry-run"]),
        ("verify", ["verify", d]),
    ):
        for name, (behind, _) in options(verb).items():
            found = re.search(r"\[.+?\], (above|of at least|from) (\S+)", behind)
            if found:
                bad = "0" if found[1] == "above" else str(int(found[2]) - 1)
                if behind.split()[0] in ("T", "B") and bad.startswith("-"):
                    continue  # no size is negative, whatever the range
                one_line_error(*words, f"{name}={bad}", names=[name, bad, found[1], found[2]])
                tried += 1
    assert tried >= 8, tried


def needed_options_are_told(_):
    one_line_error("solve", "murty:n=3", names=["--solver", "missing"])
    one_line_error("export", "murty:n=3", names=["--out", "missing"])
    one_line_error("merge", "a", names=["--out", "missing"])
    assert run("solve", "--help").stdout.startswith("lcpbench solve PROBLEM --solver SOLVER")


def components_are_explained(_):
    """Each with the defaults, ranges and sentences of its own table, as JSON tells them."""
    told = run("help", "stack").stdout
    scene = next(
        s
        for s in json.loads(run("list", "scenes", "--format", "json").stdout)
        if s["name"] == "stack"
    )
    assert told.startswith(f"scene stack: {scene['title']}"), told
    for p in scene["parameters"]:
        if p["kind"] != "choice":
            line = told[told.index(f"  {p['name']}=") :].splitlines()
            low = f"from {p['min']:.15g} to {p['max']:.15g}"
            assert f"[{p['unit']}]" in line[0] and low in line[0], line[0]
            assert line[1].strip() == p["help"], line[1]
    for kind, of in (
        ("solvers", "solver"),
        ("formulations", "formulation"),
        ("problems", "family"),
    ):
        for one in json.loads(run("list", kind, "--format", "json").stdout):
            told = run("help", one["name"]).stdout
            assert f"{of} " in told and one["title"] in told, (one["name"], told)
            assert one.get("words", "") in told and one.get("when", "") in told
            for option in re.findall(r"(\w+)=", one["options"]):
                assert f"  {option}=" in told, (one["name"], option)


def hints(_):
    """Whatever has a name has a hint."""
    small = ["simulate", "stack:n=1", "--formulation", "velocity", "--solver", "lemke"]

    def instead(old, new):
        return [new if w == old else w for w in small]

    for words, want in (
        (["solv"], "solve"),
        (["recomend"] if "recommend" in VERBS else ["simulat"], None),
        (["solve", "murty:n=3", "--solver", "lemk"], "lemke"),
        (["solve", "murthy:n=3", "--solver", "lemke"], "murty"),
        (["solve", "murty:n=3", "--solver", "lemke:toll=1"], "tol"),
        (["solve", "murty:n=3", "--sovler", "lemke"], "--solver"),
        (instead("stack:n=1", "stak"), "stack"),
        (instead("stack:n=1", "stack:nn=3"), "n"),
        (instead("velocity", "velocty"), "velocity"),
        (instead("velocity", "velocity:facet=8"), "facets"),
        (["run", "smokes"], "smoke"),
        (["list", "solver"], "solvers"),
        (["list", "solvers", "--format", "tabel"], "table"),
        (["help", "velocty"], "velocity"),
        (["complete", "--shell", "bsh"], "bash"),
    ):
        one_line_error(*words, names=[f"did you mean '{want}'?" if want else "did you mean"])
    assert "did you mean" not in run("help", "qwertz", code=2).stderr


def lists_have_titles_on_a_terminal(_):
    """As ls: columns for a reader, bare names for a pipe."""
    main, other = pty.openpty()
    done = subprocess.run([LCPBENCH, "list", "solvers"], stdout=other, check=True)
    os.close(other)
    seen = b""
    while True:
        try:
            more = os.read(main, 65536)
        except OSError:
            break
        if not more:
            break
        seen += more
    os.close(main)
    told = seen.decode().replace("\r\n", "\n")
    assert done.returncode == 0 and told == run("list", "solvers", "--format", "table").stdout
    assert re.match(r"name +title\n", told) and re.search(r"^lemke +Lemke", told, re.M), told
    names = run("list", "solvers").stdout.split()
    assert [line.split()[0] for line in told.splitlines()[1:]] == names


def complete(*words):
    return run("complete", "--", *words).stdout.split()


def words_are_completed(_):
    assert complete("") == VERBS and complete("sol") == ["solve"]
    assert complete("solve", "--tol", "1", "--ma") == ["--max-iter"]
    assert set(complete("solve", "x", "--")) == set(options("solve"))
    for kind, words in (
        ("solvers", ["solve", "x", "--solver", ""]),
        ("formulations", ["simulate", "x", "--formulation", ""]),
        ("scenes", ["simulate", ""]),
        ("problems", ["solve", ""]),
        ("campaigns", ["run", ""]),
    ):
        listed = run("list", kind).stdout.split()
        assert [w for w in complete(*words) if w != "all"] == listed, words
    assert complete("simulate", "x", "--start", "") == ["cold", "previous"]
    assert complete("solve", "x", "--z", "") == []  # files are the shell's
    assert complete("solve", "x", "--pl") == ["--plugin"] and complete("run", "--plugin", "") == []
    assert complete("nonsense", "") == []
    for kind in complete("list", ""):
        assert run("list", kind).stdout


def bash_completes(_):
    if not shutil.which("bash"):
        raise Skip("no bash")
    text = """eval "$("$1" complete --shell bash)"
lcpbench() { "$EXE" "$@"; }
COMP_WORDS=(lcpbench solve x --solver lem); COMP_CWORD=4; _lcpbench; echo "${COMPREPLY[@]}"
complete -p lcpbench"""
    done = subprocess.run(
        ["bash", "-c", text, "bash", LCPBENCH],
        capture_output=True,
        text=True,
        check=True,
        env=dict(os.environ, EXE=LCPBENCH),
    )
    first, second = done.stdout.splitlines()
    assert first == "lemke" and "-F _lcpbench lcpbench" in second, done
    for shell in ("zsh", "fish"):
        script = run("complete", "--shell", shell).stdout
        if shutil.which(shell):
            subprocess.run([shell, "-n"], input=script, text=True, check=True)


def manual_page_is_whole(d):
    page = run("help", "--man").stdout
    for verb in VERBS:
        part = page[page.index(f".SS {verb}\n") :].split("\n.S")[0].replace("\\-", "-")
        for name, (_, sentence) in options(verb).items():
            assert name in part and sentence in part, (verb, name)
    if not shutil.which("groff"):
        raise Skip("no groff")
    file = pathlib.Path(d) / "lcpbench.1"
    file.write_text(page)
    done = subprocess.run(
        ["groff", "-man", "-ww", "-Tutf8", file], capture_output=True, text=True, check=True
    )
    assert done.stderr == "" and "SIGTERM" in done.stdout, done.stderr


if __name__ == "__main__":
    sys.exit(
        tap(
            [
                every_option_is_explained,
                ranges_that_are_told_are_kept,
                needed_options_are_told,
                components_are_explained,
                hints,
                lists_have_titles_on_a_terminal,
                words_are_completed,
                bash_completes,
                manual_page_is_whole,
            ]
        )
    )

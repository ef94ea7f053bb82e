"""Every exit code that README.md lists occurs, and no other."""

import json
import pathlib
import re
import resource
import signal
import subprocess
import time

from support import FAULTY, LCPBENCH, SANITIZED, campaign, diagonal, run, tap

README = pathlib.Path(__file__).resolve().parents[2] / "README.md"
SEEN: set[int] = set()
SLOW = (
    "name: slow\nlimits: {time: 20s, grace: 0.2s}\nsampling: {processes: 9, samples: 1,"
    " max_samples: 1}\nparts: [{name: a, problems: ['%s'], solvers:"
    " ['faulty_sleeper:seconds=0.3']}]\n"
)


def ends(words: tuple, code: int, exe: str = LCPBENCH, **how) -> str:
    """Exit code and one line on stderr where it is no verdict; what was printed."""
    done = subprocess.run(
        [exe, *map(str, words)],
        stderr=subprocess.PIPE,
        text=True,
        check=False,
        timeout=60,
        **({"stdout": subprocess.PIPE} | how),
    )
    assert done.returncode == code, (words, done.returncode, done.stderr)
    assert code not in (1, 2) or done.stderr.count("\n") == 1, (words, done.stderr)
    SEEN.add(code)
    return done.stdout


def done_is_0(_):
    for words in (
        ("list", "solvers"),
        ("--help",),
        ("--version",),
        ("solve", "murty:n=4", "--solver", "lemke"),
        ("simulate", "incline", "--formulation", "velocity", "--solver", "lemke"),
    ):
        ends(words, 0)


def internal_errors_are_1(_):
    with open("/dev/full", "w", encoding="utf-8") as full:
        ends(("list", "solvers"), 1, stdout=full)

    def little_memory() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (400 << 20, 400 << 20))

    if not SANITIZED:  # their shadow memory knows no limit
        ends(("solve", "tridiagonal:n=9000000", "--solver", "pgs"), 1, preexec_fn=little_memory)


def bad_input_is_2(d):
    for words in (
        ("fly",),
        ("solve", "murty", "--solver", "nosuch"),
        ("status", d / "none"),
        ("solve", "murty", "--solver", "lemke", "--z", d / "none" / "z"),
    ):
        ends(words, 2)


def honest_failure_is_3(d):
    (d / "a.M.mtx").write_text("%%MatrixMarket matrix coordinate real general\n1 1 1\n1 1 -1\n")
    (d / "a.q.mtx").write_text("%%MatrixMarket matrix array real general\n1 1\n-1\n")
    ends(("solve", d / "a.M.mtx", "--solver", "lemke", "--certificate", d / "proof"), 3)
    ends(("verify", "random_spd:n=1", "--certificate", d / "proof"), 3)
    ends(("solve", "random_spd:n=9", "--solver", "pgs:max_iter=1"), 3)
    stack = ("simulate", "stack:n=10", "--formulation", "coulomb", "--start", "previous")
    spent = json.loads(ends((*stack, "--solver", "nsgs:budget=5"), 3))
    assert spent["status"] == spent["claimed"] == "budget" and not spent["verified"], spent
    assert spent["n_iter"] == 5 * spent["n_solves"] == 5 * spent["steps"] > 0, spent
    assert 0 < spent["res_ncp_rel_max"], spent
    c = campaign(
        d,
        "name: s\nsampling: {processes: 1, samples: 1, max_samples: 1}\n"
        "parts: [{name: a, problems: ['random_spd:n=9'], solvers: ['pgs:max_iter=1']}]\n",
    )
    run("run", c, "--out", d / "o", "--quiet")
    ends(("run", c, "--out", d / "o", "--quiet", "--strict"), 3)


def stopped(words: tuple, number: int) -> int:
    """Exit code after the signal; later and later, until it has met a program that listens."""
    for wait in (0.3, 0.6, 1.2, 2.4, 4.8):
        with subprocess.Popen(
            [FAULTY, *map(str, words)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
        ) as process:
            time.sleep(wait)
            process.send_signal(number)
            process.communicate(timeout=30)
        if process.returncode != -number:
            break
    return process.returncode


def stopped_is_4_or_130(d):
    c = campaign(d, SLOW % diagonal(d, 3))
    case = d / "case.json"
    case.write_text(
        '{"id": "s", "dim": 2, "T": 400, "hs": [1e-4], "bodies": [{"name": "b", "mass": 1.0, '
        '"shape": {"type": "disc", "r": 0.1}, "pos": [0, 1]}]}'
    )
    way = ("--formulation", "velocity", "--solver", "lemke")
    check, plain = ("check", case, *way), ("simulate", case, *way)
    for number, code in ((signal.SIGTERM, 4), (signal.SIGINT, 130)):
        for words in (("run", c, "--out", d / f"o{code}", "--quiet"), check, plain):
            assert stopped(words, number) == code, words
            SEEN.add(code)


def signals_at_once_are_one_request(_):
    """GNU timeout sends two, to its child and to the group of both: the second took the result.
    One that comes later ends what does not listen."""
    words = ("simulate", "stack:n=1", "--formulation", "normal", "--solver", "faulty_patient")
    for wait in (0.3, 0.6, 1.2, 2.4, 4.8):
        with subprocess.Popen([FAULTY, *words], stdout=subprocess.DEVNULL) as process:
            time.sleep(wait)
            process.send_signal(signal.SIGTERM)
            began = time.monotonic()
            time.sleep(0.02)
            heard = process.poll() is None
            process.send_signal(signal.SIGTERM)
            at_once = time.monotonic() - began < 0.2
            time.sleep(0.5)
            still_there = process.poll() is None
            process.send_signal(signal.SIGTERM)
            assert process.wait(timeout=30) == -signal.SIGTERM
        if heard and at_once:
            assert still_there
            return
    raise AssertionError("no pair of signals met a program that listens")


def the_table_lists_them_all(_):
    table = README.read_text(encoding="utf-8").split("| exit code |", 1)[1].split("\n\n", 1)[0]
    listed = {int(code) for code in re.findall(r"^\| (\d+) \|", table, re.MULTILINE)}
    assert listed == SEEN, (listed, SEEN)
    told = run("--help").stdout.split("Exit codes:", 1)[1]
    assert listed == {int(code) for code in re.findall(r"\b\d+\b", told)}, told


tap(
    [
        done_is_0,
        internal_errors_are_1,
        bad_input_is_2,
        honest_failure_is_3,
        stopped_is_4_or_130,
        signals_at_once_are_one_request,
        the_table_lists_them_all,
    ]
)

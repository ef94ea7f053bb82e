"""What the command-line tests share: running the program, rows of a campaign, a TAP runner."""

import csv
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import traceback

LCPBENCH = os.environ["LCPBENCH"]
FAULTY = os.environ["LCPBENCH_FAULTY"]
TESTS = pathlib.Path(__file__).resolve().parents[1]
CASES = TESTS / "cases" / "cases.json"
SANITIZED = os.environ.get("LCPBENCH_SANITIZE", "none") != "none"


class Skip(Exception):
    pass


class Inconclusive(Exception):
    """The machine was too busy to decide a test of the clock."""


def run(*args, exe=LCPBENCH, code=0, timeout=120, cwd=None, **env):
    """Runs lcpbench; checks the exit code (None: any) and returns the completed process."""
    full = {**os.environ, "OPENBLAS_NUM_THREADS": "1", **env}
    for name in [
        n for n in full if n.startswith("LCPBENCH_") and n not in env and n != "LCPBENCH_SANITIZE"
    ]:
        del full[name]
    done = subprocess.run(
        [exe, *map(str, args)], capture_output=True, text=True, timeout=timeout, cwd=cwd, env=full
    )
    if code is not None and done.returncode != code:
        raise AssertionError(
            f"{' '.join(map(str, args))}: exit {done.returncode}, want"
            f" {code}\n{done.stdout}{done.stderr}"
        )
    return done


def run_json(*args, **kw):
    return json.loads(run(*args, **kw).stdout)


def one_line_error(*args, names=(), exe=LCPBENCH, timeout=20):
    """Bad input: exit 2 at once, nothing on stdout, one line on stderr that names the culprit."""
    done = run(*args, exe=exe, code=2, timeout=timeout)
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1, f"{args}: want one line on stderr, got {lines}"
    assert done.stdout == "", f"{args}: wrote to stdout: {done.stdout[:100]}"
    for name in names:
        assert str(name) in lines[0], f"{args}: '{name}' is not named in: {lines[0]}"


def rows(folder):
    with open(pathlib.Path(folder) / "results.csv", newline="", encoding="utf-8") as f:
        return list(csv.DictReader(f))


# What may differ between two measurements of the same cell: times, and what the machine was doing
TIMES = set(
    """t_contacts_s t_assemble_s t_setup_s t_factor_s t_solve_s t_share_s t_advance_s t_watch_s
t_total_s t_step_s t_step_max_s t_step_p50_s t_step_p95_s t_step_p99_s share_1ms share_4ms
share_16ms t_cpu_s regressions_time n_inner rss_peak_B host cpu_set freq_MHz ctx_invol major_faults
load1 load_other throttled canary_s started_utc order""".split()
)
# What a row says that was measured while nothing else was at work
QUIET = {"load_other": "0", "load1": "0", "throttled": "", "flags": ""}
TIME_FLAGS = {"outlier", "remeasured", "canary_drift", "first_run"}


def fewer(items):
    """All of them; under sanitizers, where each runs the same code ten times as slowly, the first
    third, or the first one."""
    return items[: max(1, len(items) // 3)] if SANITIZED else items


def limited(words, size, why="File too large"):
    """The one line that lcpbench says where no file may grow beyond size bytes (`ulimit -f`): a
    full disk, as far as it can tell, and a signal that would kill what does not know SIGXFSZ."""

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    done = subprocess.run(
        [LCPBENCH, *map(str, words)],
        capture_output=True,
        text=True,
        check=False,
        env=dict(os.environ, OPENBLAS_NUM_THREADS="1"),
        preexec_fn=limit,
        timeout=60,
    )
    lines = done.stderr.strip().splitlines()
    assert done.returncode == 2 and len(lines) == 1 and why in lines[0], (words, done)
    assert done.stdout == "", done.stdout
    return lines[0]


def untimed(row):
    """A row without its times, as a set member."""
    flags = " ".join(sorted(set(row["flags"].split()) - TIME_FLAGS))
    return tuple((k, flags if k == "flags" else v) for k, v in row.items() if k not in TIMES)


def diagonal(folder, n, name="diag"):
    """M = diag(2, 3, ...), q = -1: a problem that the faulty solvers with a known cost do solve."""
    path = pathlib.Path(folder) / f"{name}{n}.M.mtx"
    entries = "".join(f"{i} {i} {i + 1}\n" for i in range(1, n + 1))
    path.write_text(f"%%MatrixMarket matrix coordinate real general\n{n} {n} {n}\n{entries}")
    path.with_name(f"{name}{n}.q.mtx").write_text(
        f"%%MatrixMarket matrix array real general\n{n} 1\n" + "-1\n" * n
    )
    return path


def campaign(folder, text, name="t.yaml"):
    path = pathlib.Path(folder) / name
    path.write_text(text)
    return path


def one_of(tests):
    """Runs the function that the command line names: a test of the clock is a meson test of its
    own, for quiet.py judges one at a time. Exit 77 where it is inconclusive, as there."""
    (test,) = (t for t in tests if t.__name__ == sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        try:
            test(pathlib.Path(folder))
        except Inconclusive as why:
            print(f"inconclusive: {why}", flush=True)
            sys.exit(77)


def tap(tests):
    """Runs the functions (each gets a fresh folder) and prints TAP; exit code for meson."""
    print(f"1..{len(tests)}")
    for i, test in enumerate(tests, 1):
        with tempfile.TemporaryDirectory() as folder:
            try:
                test(pathlib.Path(folder))
                print(f"ok {i} - {test.__name__}", flush=True)
            except Skip as why:
                print(f"ok {i} - {test.__name__} # SKIP {why}", flush=True)
            except Exception:
                print(f"not ok {i} - {test.__name__}")
                for line in traceback.format_exc().splitlines():
                    print(f"# {line}")
                sys.stdout.flush()
    sys.exit(0)

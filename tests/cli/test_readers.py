"""results.csv under a German locale and in the hands of pandas and R: the same numbers, the same
names, the same types."""

import csv
import json
import os
import pathlib
import shutil
import subprocess

from support import SANITIZED, Skip, campaign, rows, run, tap, untimed

TEXT = """
name: readers
seed: 3
limits: {time: 10s}
sampling: {processes: 1, samples: 2, max_samples: 2, inner: 0.0001s}
parts:
  - name: "scenes, with \\"quotes\\" and; separators"
    problems: ["stack:n={1,2},duration=0.02", "slide:speed=1"]
    formulations: ["velocity:facets={4,8}", penalty]
    solvers: [lemke, enumerate]
  - name: lcps
    problems: ["murty:n={4,6}"]
    solvers: [lemke, "pgs:max_iter=1"]
"""
WORDS = (
    "campaign part cell_id problem_family problem problem_sha256 formulation"
    " formulation_options formulation_config model solver solver_options solver_config"
    " solver_variant solver_version start contact_order islands effects effects_auto cache"
    " storage status status_claimed note flags err_quantity err_source end_quantity missed"
    " effects_seen solution_hash host host_class trace started_utc suite_commit build_hash"
    " base_hash command"
).split()
BOOLEANS = "quick verified throttled suite_dirty".split()


def measured(d, name="o", **env):
    run("run", campaign(d, TEXT), "--out", d / name, "--quiet", **env)
    return d / name / "results.csv"


def german(d):
    """A real de_DE.UTF-8, compiled into a folder of its own; the environment that uses it."""
    if shutil.which("localedef") is None:
        raise Skip("localedef is not installed")
    (d / "locale").mkdir()
    made = subprocess.run(
        ["localedef", "--no-archive", "-i", "de_DE", "-f", "UTF-8", d / "locale/de_DE.UTF-8"],
        capture_output=True,
        text=True,
    )
    env = {"LOCPATH": str(d / "locale"), "LC_ALL": "de_DE.UTF-8"}
    if SANITIZED:  # glibc keeps what it made of LOCPATH
        env["ASAN_OPTIONS"] = "detect_leaks=0:abort_on_error=1"
    point = subprocess.run(
        ["locale", "decimal_point"], capture_output=True, text=True, env=dict(os.environ, **env)
    ).stdout.strip()
    if point != ",":
        raise Skip(f"no German locale on this machine: {made.stderr.strip()[:80]}")
    return env


def g8_same_rows_under_a_german_locale(d):
    env = german(d)
    plain, other = measured(d, "C", LC_ALL="C"), measured(d, "de", **env)
    a, b = rows(d / "C"), rows(d / "de")
    assert {untimed(r) for r in a} == {untimed(r) for r in b} and len(a) == len(b)
    assert plain.read_bytes().splitlines()[0] == other.read_bytes().splitlines()[0]
    # reading and writing every number again changes no byte, under either locale
    for name, more in (("C", {"LC_ALL": "C"}), ("de", env)):
        run("merge", d / "C", "--out", d / f"m_{name}", **more)
    assert (d / "m_C/results.csv").read_bytes() == (d / "m_de/results.csv").read_bytes()
    assert sorted((d / "m_de/results.csv").read_bytes().splitlines()) == sorted(
        plain.read_bytes().splitlines()
    )


def g8_bytes_keep_the_rules(d):
    """RFC 4180 without the CR, UTF-8, one line a row, one header, plain names, numbers that
    parse."""
    path = measured(d)
    text = path.read_bytes()
    got = rows(path.parent)
    assert (
        b"\r" not in text
        and text.endswith(b"\n")
        and text.decode("utf-8").count("\n") == len(got) + 1
    )
    header = text.decode().splitlines()[0].split(",")
    assert len(header) == len(set(header)) and all(
        h.replace("_", "").isalnum() and h[0].isalpha() for h in header
    )
    assert set(WORDS) | set(BOOLEANS) <= set(header)
    for r in got:
        for name in set(header) - set(WORDS) - set(BOOLEANS) - {"cpu_set"}:
            assert r[name] == "" or float(r[name]) == float(r[name]), (name, r[name])
        assert all(r[name] in ("true", "false", "") for name in BOOLEANS)
    assert {r["status"] for r in got} >= {"ok", "unsupported"} and "" in {
        r["t_total_s"] for r in got
    }
    run("run", campaign(d, TEXT), "--out", d / "s", "--quiet", "--shard", "1/2")
    assert (d / "s/results.csv").read_bytes().splitlines()[0] == text.splitlines()[0], (
        "the header is the same for all shards"
    )


def every_column_is_explained(d):
    header = measured(d).read_text().splitlines()[0].split(",")
    page = (pathlib.Path(__file__).parents[2] / "results/FORMAT.md").read_text()
    missing = [h for h in header if f"`{h}`" not in page]
    assert not missing, f"results/FORMAT.md does not explain {missing}"


PANDAS = """
import json, sys
import pandas as pd
d = pd.read_csv(sys.argv[1])
print(json.dumps({"n": len(d), "names": list(d.columns),
                  "numeric": [c for c in d if pd.api.types.is_numeric_dtype(d[c])],
                  "bool": [c for c in d if pd.api.types.is_bool_dtype(d[c])],
                  "empty": [c for c in d if d[c].isna().all()],
                  "t": [repr(float(x)) for x in d["t_total_s"]],
                  "rho": [repr(float(x)) for x in d["rho"]]}))
"""


def agree(path, got, booleans=True):
    """What a reader found against the bytes: names, types, every number to the last bit. R 4.2
    keeps true and false as text."""
    with open(path, newline="") as f:
        want = list(csv.DictReader(f))
    assert got["n"] == len(want) and got["names"] == list(want[0])
    empty = {c for c in want[0] if all(r[c] == "" for r in want)}
    for name in set(want[0]) - set(WORDS) - set(BOOLEANS) - {"cpu_set"} - empty:
        assert name in got["numeric"], f"{name} was not read as numbers"
    for name in set(BOOLEANS) - empty if booleans else ():
        if all(r[name] for r in want):
            assert name in got["bool"], f"{name} was not read as true and false"
    for column, key in (("t_total_s", "t"), ("rho", "rho")):
        for text, value in zip((r[column] for r in want), got[key], strict=True):
            assert (
                (value.lower() in ("nan", "na")) if text == "" else float(text) == float(value)
            ), (column, text, value)


def g8_pandas_reads_the_same(d):
    python = pathlib.Path(__file__).parents[2] / ".venv/bin/python"
    if not python.exists():
        raise Skip("no .venv: scripts/setup python")
    path = measured(d)
    done = subprocess.run([python, "-c", PANDAS, path], capture_output=True, text=True, check=True)
    agree(path, json.loads(done.stdout))


R = """
d <- read.csv(commandArgs(TRUE)[1])
show <- function(key, x) cat(key, paste(x, collapse="\\t"), "\\n", sep="\\t")
show("n", nrow(d))
show("names", names(d))
show("numeric", names(d)[sapply(d, is.numeric)])
stopifnot(all(d$verified %in% c("true", "false")), is.numeric(d$n_iter))
show("t", sprintf("%.17g", d$t_total_s))
show("rho", sprintf("%.17g", d$rho))
"""


def g8_r_reads_the_same(d):
    if shutil.which("Rscript") is None:
        raise Skip("R is not installed")
    path = measured(d)
    (d / "read.R").write_text(R)
    done = subprocess.run(
        ["Rscript", "--vanilla", d / "read.R", path], capture_output=True, text=True, check=True
    )
    got = {}
    for line in done.stdout.splitlines():
        key, *values = line.rstrip("\t ").split("\t")
        got[key] = values
    got["n"] = int(got["n"][0])
    agree(path, got, booleans=False)


tap(
    [
        g8_same_rows_under_a_german_locale,
        g8_bytes_keep_the_rules,
        g8_pandas_reads_the_same,
        g8_r_reads_the_same,
        every_column_is_explained,
    ]
)

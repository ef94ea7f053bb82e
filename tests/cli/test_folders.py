"""Folders of results: what is measured in them stays, what does not belong together is refused."""

import csv
import json
import signal
import subprocess
import time

from support import (
    FAULTY,
    SANITIZED,
    TESTS,
    Skip,
    campaign,
    diagonal,
    limited,
    one_line_error,
    rows,
    run,
    tap,
)

SMALL = """
name: small
seed: 3
limits: {time: 10s, memory: 2G, grace: 1s}
sampling: {processes: 2, samples: 2, max_samples: 2, inner: 0.0001s%s}
parts:
  - name: lcps
    problems: ["murty:n={4,5}", "random_spd:n=6"]
    solvers: [lemke, pgs]
"""


def small(d, more=""):
    return campaign(d, SMALL % more)


def shipped_campaigns_measure_the_noise_floor(d):
    """In both forms; the plan says how long that takes, until it is there."""
    if SANITIZED:
        raise Skip("plans of thousands of cells: slow with sanitizers")
    for name in run("list", "campaigns").stdout.split():
        for quick in ((), ("--quick",)):
            last = run(
                "run",
                name,
                "--dry-run",
                "--out",
                d / "o",
                "--filter",
                "solver=lemke",
                *quick,
                cwd=TESTS.parent,
            ).stdout.splitlines()[-1]
            floor = 0 if name == "smoke" else 2 if quick else 6  # smoke tells no times
            assert f" {floor} s for the noise floor" in last, (name, last)
    c = small(d, ", doctor: 0.1s")
    assert ", 0.1 s for the noise floor" in run("run", c, "--dry-run", "--out", d / "o").stdout
    run("run", c, "--out", d / "o", "--quiet")
    assert ", 0 s for the noise floor" in run("run", c, "--dry-run", "--out", d / "o").stdout


def the_noise_floor_is_of_this_machine(d):
    """A folder that comes from another class of machine: measured anew, the other's floor is kept
    and counts for its rows."""
    if SANITIZED:
        raise Skip("noise is not measured with sanitizers")
    c = small(d, ", doctor: 0.1s")
    run("run", c, "--out", d / "o", "--quiet")
    path = d / "o/doctor.json"
    ours = json.loads(path.read_text())
    first = path.read_bytes()
    run("run", c, "--out", d / "o", "--quiet", "--rerun", "all")
    assert path.read_bytes() == first, "measured once"
    other = dict(
        ours,
        host_class="another processor",
        host="else/where",
        noise_floor=9.0,
        classes=[dict(x, noise_floor=9.0) for x in ours["classes"]],
    )
    path.write_text(json.dumps(other))
    run("run", c, "--out", d / "o", "--quiet")
    assert (
        json.loads(path.read_text())["host_class"] == ours["host_class"]
        and json.loads((d / "o/doctor.else_where.json").read_text()) == other
    )
    assert "noise floor 900.00 %" in run("compare", d / "o", d / "o").stdout
    run("merge", d / "o", "--out", d / "m")
    assert json.loads((d / "m/doctor.json").read_text())["noise_floor"] == 9.0, (
        "the noisiest speaks for all"
    )
    path.write_text("{")
    for words in (
        ("run", c, "--out", d / "o"),
        ("compare", d / "o", d / "o"),
        ("merge", d / "o", "--out", d / "n"),
    ):
        one_line_error(*words, names=["o/doctor.json:1", "JSON"])


def reruns_are_planned(d):
    """--dry-run with --rerun counts as to do what would be measured again."""
    c = small(d)
    run("run", c, "--out", d / "o", "--quiet")
    for what, todo in ((None, 0), ("failed", 0), ("pgs", 6), ("all", 12)):
        last = run(
            "run", c, "--out", d / "o", "--dry-run", *(("--rerun", what) if what else ())
        ).stdout.splitlines()[-1]
        assert f", {todo} to do;" in last, (what, last)
    assert "0 measured now" in run("run", c, "--out", d / "o", "--quiet").stdout
    # a cell is done when all of its processes are
    text = (d / "o/results.csv").read_text().splitlines(keepends=True)
    (d / "o/results.csv").write_text(
        "".join(
            line
            for line, r in zip(text, [{"process": ""}, *rows(d / "o")], strict=True)
            if r["process"] != "1"
        )
    )
    plan = run("run", c, "--out", d / "o", "--dry-run").stdout.splitlines()
    assert (
        all(line.startswith("todo ") for line in plan[:-1])
        and "12 processes: 6 done, 6 to do" in plan[-1]
    ), plan


def merging_does_not_mix_with_what_is_there(d):
    """OUT is another folder, without rows; refused before anything is written. What an interrupted
    merge left does no harm."""
    c = small(d)
    for k in (1, 2):
        run("run", c, "--out", d / f"s{k}", "--quiet", "--shard", f"{k}/2", "--trace")
    before = {p: p.read_bytes() for p in d.rglob("*") if p.is_file()}
    (d / "link").symlink_to(d / "s2")
    for out in (d / "s1", d / "s2/../s2", d / "link"):
        one_line_error("merge", d / "s1", d / "s2", "--out", out, names=["--out", out])
    one_line_error("merge", d / "s1", d / "s2", names=["--out"])
    (d / "s2/manifest.json").rename(d / "hidden")
    one_line_error("merge", d / "s2", d / "s1", "--out", d / "m", names=["s2/manifest.json"])
    assert not (d / "m").exists()
    (d / "hidden").rename(d / "s2/manifest.json")
    assert before == {
        p: p.read_bytes() for p in d.rglob("*") if p.is_file() and not p.is_relative_to(d / "link")
    }
    # an earlier merge that came as far as the canaries
    (d / "m").mkdir()
    (d / "m/canary.csv").write_text((d / "s1/canary.csv").read_text())
    run("merge", d / "s1", d / "s2", "--out", d / "m")
    lines = (d / "m/canary.csv").read_text().splitlines()
    assert (
        lines
        == (d / "s1/canary.csv").read_text().splitlines()
        + (d / "s2/canary.csv").read_text().splitlines()[1:]
    )
    index = (d / "m/traces/index.csv").read_text().splitlines()
    assert len(index) == 1 + 6 and len(set(index)) == len(index)
    one_line_error(
        "merge", d / "s1", d / "s2", "--out", d / "m", names=["m/results.csv", "holds rows already"]
    )
    assert (d / "m/canary.csv").read_text().splitlines() == lines


def every_row_is_verified(d):
    """Not the first of a cell alone: one falsified repetition of one process is found, by stored
    answers and by running again."""
    run("run", small(d), "--out", d / "o", "--quiet")
    path = d / "o/results.csv"
    lines = path.read_text().splitlines(keepends=True)
    got = rows(d / "o")
    assert f"; {len(got)} rows compared" in run("verify", d / "o").stdout and len(got) == 24
    i, r = next(
        (i, r)
        for i, r in enumerate(got)
        if (r["process"], r["rep"], r["solver"]) == ("1", "1", "pgs") and float(r["rho"]) > 0
    )
    for old, new, words in (
        (r["solution_hash"], "0123456789abcdef", ()),
        (r["solution_hash"], "0123456789abcdef", ("--rerun",)),
        (f",{r['rho']},", ",1e-3,", ()),
        (",pgs,", ",lemke,", ()),
        (",pgs,", ",lemke,", ("--rerun",)),
    ):
        assert old in lines[i + 1]
        path.write_text(
            "".join(lines[: i + 1] + [lines[i + 1].replace(old, new, 1)] + lines[i + 2 :])
        )
        out = run("verify", d / "o", *words, code=3).stdout
        assert (
            f"DIFFERS {r['cell_id']}" in out
            and "process 1, repetition 1:" in out
            and "5 cells verified" in out
            and ", 1 differ" in out
        ), out


def a_changed_file_is_told(d):
    """Not as a difference of verdicts."""
    path = diagonal(d, 3)
    run(
        "run",
        campaign(d, (SMALL % "").replace('"murty:n={4,5}", "random_spd:n=6"', f"'{path}'")),
        "--out",
        d / "o",
        "--quiet",
    )
    assert "2 cells verified" in run("verify", d / "o").stdout
    text = path.read_text()
    for name in (path, path.with_name(path.name.replace(".M.", ".q."))):
        whole = name.read_text()
        name.write_text(whole + "\n")
        out = run("verify", d / "o", code=3).stdout
        assert out.count("the file has changed since") == 2 and path.name in out, out
        name.write_text(whole)
    assert path.read_text() == text and "2 cells verified" in run("verify", d / "o").stdout


def answers_cut_by_the_clock_are_told_apart(d):
    """What a time limit leaves is another answer each time; neither a difference nor verified."""
    c = campaign(
        d,
        SMALL % ""
        + "  - {name: late, problems: ['%s'], solvers: [faulty_tired]}\n" % diagonal(d, 4),
    )
    run("run", c, "--out", d / "o", "--quiet", exe=FAULTY)
    late = [r for r in rows(d / "o") if r["solver"] == "faulty_tired"]
    assert [r["status"] for r in late] == ["time_limit"] and "not_repeatable" in late[0]["flags"], (
        late
    )
    out = run("verify", d / "o", exe=FAULTY).stdout
    assert (
        "6 cells verified (6 from stored answers, 0 run again), 0 differ, 0 without" in out
        and "1 cells not compared: the clock" in out
    ), out


def twins_that_die_are_run_once(d):
    """Not for every process, nor by the next session; with their rows they are forgotten. Each
    process is held against its twin."""
    c = campaign(
        d,
        SMALL.replace("[lemke, pgs]", "[lemke, faulty_quit, faulty_fickle]").replace(
            "random_spd:n=6", str(diagonal(d, 3))
        )
        % "",
    )

    def index(*more):
        run("run", c, "--out", d / "o", "--quiet", "--trace", *more, exe=FAULTY)
        lines = [line.split(",") for line in (d / "o/traces/index.csv").read_text().splitlines()]
        assert lines[0][:3] == ["cell_id", "solver", "status"]
        return sorted((line[0], line[1], line[2]) for line in lines[1:])

    first = index()
    assert (
        len(first) == 9 and sum(line[1:] == ("faulty_quit", "no_output") for line in first) == 3
    ), first
    assert (
        index() == first
        and index("--rerun", "failed") == first
        and index("--rerun", "all") == first
    )
    fickle = [
        r for r in rows(d / "o") if r["solver"] == "faulty_fickle" and r["problem"].endswith(".mtx")
    ]
    assert {r["process"] for r in fickle} == {"0", "1"} and all(
        "twin_differs" in r["flags"] for r in fickle
    ), fickle
    assert not any("twin_differs" in r["flags"] for r in rows(d / "o") if r["solver"] == "lemke")
    # histories of another build go with the rows of another build
    base = rows(d / "o")[0]["base_hash"]
    for name in ("results.csv", "traces/index.csv"):
        (d / "o" / name).write_text((d / "o" / name).read_text().replace(base, "0123456789abcdef"))
    assert index("--filter", "solver=lemke") == [f for f in first if f[1] == "lemke"]


def full_disks_lose_nothing(d):
    """One line that names the file; what was measured is there, and the same command goes on. A
    cell whose answers find no room is no failed cell."""
    c = small(d)
    run("run", c, "--out", d / "whole", "--quiet")
    want = {(r["cell_id"], r["process"], r["rep"]) for r in rows(d / "whole")}
    size = (d / "whole/results.csv").stat().st_size
    assert "o/results.csv" in limited(("run", c, "--out", d / "o", "--quiet"), size * 2 // 3)
    assert 0 < (d / "o/results.csv").read_text().count("\n") < 25
    run("run", c, "--out", d / "o", "--quiet")
    assert {(r["cell_id"], r["process"], r["rep"]) for r in rows(d / "o")} == want and len(
        rows(d / "o")
    ) == len(want)
    long = campaign(
        d,
        SMALL.split("parts:")[0]
        % ""
        + "parts: [{name: p, problems: ['stack:n=10,duration=2'], formulations: [velocity],"
        " solvers: [lemke]}]\n",
        "long.yaml",
    )
    assert "p/solutions/" in limited(("run", long, "--out", d / "p", "--quiet"), 16384)
    assert not rows(d / "p") and [f for f in (d / "p/solutions").iterdir()] == []
    run("run", long, "--out", d / "p", "--quiet")
    assert {r["status"] for r in rows(d / "p")} == {"ok"}
    assert (
        "m/" in limited(("merge", d / "whole", "--out", d / "m"), size - 1)
        and not (d / "m/results.csv").exists()
    )
    run("merge", d / "whole", "--out", d / "m")
    assert "t.csv" in limited(
        (
            "simulate",
            "slide",
            "--formulation",
            "velocity",
            "--solver",
            "lemke",
            "--trajectory",
            d / "t.csv",
        ),
        4096,
        "could not be written",
    )


def strict_counts_all_sessions(d):
    """--strict tells of a failed cell also when nothing was left to measure; status tells what the
    whole cell came to."""
    c = campaign(d, SMALL.replace("[lemke, pgs]", "[lemke, 'pgs:max_iter=1']") % "")
    for _ in range(2):
        done = run("run", c, "--out", d / "o", "--quiet", "--strict", code=3)
    assert (
        "0 measured now" in done.stdout
        and "max_iter    1 cells" in done.stdout
        and "ok          5 cells" in done.stdout
    ), done.stdout
    run("run", c, "--out", d / "o", "--quiet", "--strict", "--filter", "solver=lemke")
    # a cell that failed in its second process only
    text = (d / "o/results.csv").read_text().splitlines(keepends=True)
    at = next(
        i for i, r in enumerate(rows(d / "o"), 1) if (r["process"], r["solver"]) == ("1", "lemke")
    )
    (d / "o/results.csv").write_text(
        "".join(text[:at] + [text[at].replace(",ok,ok,", ",crash,ok,")] + text[at + 1 :])
    )
    out = run("status", d / "o").stdout
    assert "crash       1\n" in out and "ok          4\n" in out, out


def compare_takes_times_of_one_class_of_machine(d):
    run(
        "run",
        small(d),
        "--out",
        d / "o",
        "--quiet",
        "--filter",
        "problem=random*",
        "--filter",
        "solver=lemke",
    )
    before = run("compare", d / "o", d / "o").stdout.splitlines()[0]
    path = d / "o/results.csv"
    header, *lines = path.read_text().splitlines(keepends=True)
    got = rows(d / "o")
    far = [
        line.replace(r["t_total_s"], "1000").replace(r["host_class"], "another processor")
        for line, r in zip(lines, got, strict=True)
    ]
    path.write_text("".join([header, *lines, *far]))
    assert run("compare", d / "o", d / "o").stdout.splitlines()[0] == before


def campaigns_do_not_mix(d):
    """A folder holds one campaign in one form: another one is refused before anything changes. Rows
    measured again are set aside."""
    c = small(d)
    run("run", c, "--out", d / "o", "--quiet")
    before = {p: p.read_bytes() for p in (d / "o").rglob("*") if p.is_file()}
    other = campaign(d, (SMALL % "").replace("name: small", "name: other"), "other.yaml")
    one_line_error(
        "run", other, "--out", d / "o", names=["o/results.csv", "small", "other", "--out"]
    )
    one_line_error("run", c, "--quick", "--out", d / "o", names=["o/results.csv", "--quick"])
    assert before == {p: p.read_bytes() for p in (d / "o").rglob("*") if p.is_file()}
    run("run", c, "--out", d / "o", "--quiet", "--rerun", "pgs")
    with (d / "o/stale.csv").open(newline="") as f:
        assert [r["solver"] for r in csv.DictReader(f)] == ["pgs"] * 12 and len(rows(d / "o")) == 24


def a_second_run_waits_its_turn(d):
    """It does not touch the folder meanwhile, and can be stopped while it waits."""
    problems = ", ".join(f"'{diagonal(d, n)}'" for n in (2, 3, 4))
    c = campaign(
        d,
        SMALL.split("    problems")[0] % ""
        + f"    problems: [{problems}]\n    solvers: ['faulty_steady:seconds=0.15']\n",
    )
    first = subprocess.Popen(
        [FAULTY, "run", str(c), "--out", str(d / "o"), "--quiet"], stdout=subprocess.DEVNULL
    )
    while not (d / "o/canary.csv").exists():
        time.sleep(0.01)
    manifest = (d / "o/manifest.json").read_bytes()
    second = subprocess.Popen(
        [FAULTY, "run", str(c), "--out", str(d / "o"), "--filter", "problem=*diag2*"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert "another run is writing here; waiting" in second.stderr.readline()
    assert (d / "o/manifest.json").read_bytes() == manifest
    second.send_signal(signal.SIGTERM)
    assert second.wait(10) == 4 and first.poll() is None
    assert first.wait(60) == 0


tap(
    [
        compare_takes_times_of_one_class_of_machine,
        campaigns_do_not_mix,
        a_second_run_waits_its_turn,
        full_disks_lose_nothing,
        strict_counts_all_sessions,
        twins_that_die_are_run_once,
        every_row_is_verified,
        a_changed_file_is_told,
        answers_cut_by_the_clock_are_told_apart,
        merging_does_not_mix_with_what_is_there,
        shipped_campaigns_measure_the_noise_floor,
        the_noise_floor_is_of_this_machine,
        reruns_are_planned,
    ]
)

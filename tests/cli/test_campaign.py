"""Campaigns: plan, filters, resume, shards, rerun commands, stale rows, locale, readers'
conventions."""

import csv
import json
import lzma
import re
import shlex
import shutil
import signal
import subprocess
import time

from support import (
    FAULTY,
    LCPBENCH,
    TESTS,
    campaign,
    diagonal,
    one_line_error,
    rows,
    run,
    tap,
    untimed,
)

SMALL = """
name: small
title: two scenes
seed: 3
limits: {time: 10s, memory: 2G, grace: 1s}
sampling: {processes: 2, samples: 2, max_samples: 2, inner: 0.0001s}
parts:
  - name: scenes
    problems: ["stack:n={1,2},duration=0.02", "slide:speed=1"]
    formulations: ["velocity:facets={4,8}", regularized]
    solvers: [lemke, projected_gradient]
"""
FILES = """
name: files
limits: {time: 10s}
sampling: {processes: 1, samples: 2, max_samples: 2, inner: 0.0001s}
parts:
  - name: lcps
    problems: ["%s/*.M.mtx", "murty:n={4,6}"]
    solvers: [lemke, pgs]
"""


def cells(folder):
    return {(r["cell_id"], r["process"], r["rep"]) for r in rows(folder)}


def matrix(path, scale):
    path.with_suffix("").with_suffix(".M.mtx").write_text(
        f"%%MatrixMarket matrix coordinate real general\n2 2 2\n1 1 {scale}\n2 2 3\n"
    )
    path.with_suffix("").with_suffix(".q.mtx").write_text(
        "%%MatrixMarket matrix array real general\n2 1\n-1\n1\n"
    )


def plan_is_printed(d):
    out = run("run", campaign(d, SMALL), "--out", d / "o", "--dry-run").stdout.splitlines()
    assert (
        len([x for x in out if x.startswith("todo ")]) == 18
        and "18 cells, 36 processes: 0 done, 36 to do" in out[-1]
    ), out[-1]
    assert not (d / "o").exists()


def filters_choose(d):
    c = campaign(d, SMALL)

    def count(*filters):
        words = [w for f in filters for w in ("--filter", f)]
        return sum(
            x.startswith("todo") for x in run("run", c, "--dry-run", *words).stdout.splitlines()
        )

    assert count("solver=lemke") == 9 and count("-solver=lemke") == 9
    assert count("problem=stack*", "formulation=reg*") == 4
    one_line_error("run", c, "--filter", "solver=nosuch", names=["matches no cell"])
    one_line_error("run", c, "--filter", "colour=red", names=["colour=red"])


def schema_errors_name_line_and_key(d):
    def bad(old, new, *names):
        one_line_error(
            "run",
            campaign(d, SMALL.replace(old, new), "bad.yaml"),
            "--dry-run",
            names=["bad.yaml", *names],
        )

    bad("seed: 3", "sed: 3", ":4:", "sed", "unknown key")
    bad("time: 10s", "time: soon", ":5:", "time")
    bad("processes: 2", "processes: 0", ":6:", "processes")
    bad("    problems:", "    problem:", ":9:", "problem")
    bad("solvers: [lemke, projected_gradient]", "solvers: lemke", ":11:", "solvers")
    bad("solvers: [lemke, projected_gradient]", "solvers: [nosuch]", "nosuch")
    bad("{1,2}", "{1,2", "brace")
    bad("name: small", "name: [", "bad.yaml:")
    one_line_error("run", "nosuchcampaign", names=["nosuchcampaign", "list campaigns"])
    one_line_error("run", campaign(d, SMALL), "--shard", "3/2", names=["--shard", "3/2"])
    one_line_error("run", campaign(d, SMALL), "--rerun", "some", names=["--rerun", "some"])


ONE_PART = """
name: v
parts:
  - {name: p, problems: ['%s'], solvers: [lemke]}
"""


def files_stand_below_a_variable(d):
    """$NAME/ and ${NAME:-FOLDER}/; the shipped library needs no variable beside tests/."""
    for folder in ("a", "b"):
        (d / folder).mkdir()
        for name in ("diag", "e"):
            diagonal(d / folder, 4, name)

    def planned(which, cwd=d, **env):
        plan = run("run", which, "--quick", "--dry-run", "--out", d / "o", cwd=cwd, **env).stdout
        return set(re.findall(r" solve '([^']*)'", plan))

    braced = campaign(d, ONE_PART % "${LCPBENCH_LIB:-a}/{d,e}*4.M.mtx")
    assert planned(braced) == {"a/diag4.M.mtx", "a/e4.M.mtx"} == planned(braced, LCPBENCH_LIB="")
    assert planned(braced, LCPBENCH_LIB="b") == {"b/diag4.M.mtx", "b/e4.M.mtx"}
    plain = campaign(d, ONE_PART % "$LCPBENCH_LIB/*.M.mtx", "plain.yaml")
    assert planned(plain, LCPBENCH_LIB="b") == {"b/diag4.M.mtx", "b/e4.M.mtx"}
    one_line_error("run", plain, "--dry-run", names=["LCPBENCH_LIB", "not set"])
    for wrong in ("${LCPBENCH_LIB}/x.mtx", "${LCPBENCH_LIB:-a", "$/x.mtx"):
        one_line_error(
            "run",
            campaign(d, ONE_PART % wrong, "w.yaml"),
            "--dry-run",
            names=["w.yaml", wrong, "${NAME:-FOLDER}"],
        )
    assert planned("library", cwd=TESTS.parent) >= {
        "tests/data/lcp/lcp_mmc.dat",
        "tests/data/mlcp/m2n1_mlcp.dat",
        "tests/data/fclib/Box_Stacks-i0122-82-5.hdf5:facets=4",
        "tests/cases/contact_lcps/frand4_p5.M.mtx",
    }


def rows_are_whole_and_resumed(d):
    c = campaign(d, SMALL)
    run("run", c, "--out", d / "o", "--quiet")
    first = (d / "o/results.csv").read_bytes()
    assert len(rows(d / "o")) == 18 * 2 * 2
    done = run("run", c, "--out", d / "o", "--quiet")
    assert "0 measured now" in done.stdout and (d / "o/results.csv").read_bytes() == first
    for r in rows(d / "o"):
        assert r["status"] == "ok" and r["verified"] == "true" and float(r["t_total_s"]) > 0, r
    assert {r["process"] for r in rows(d / "o")} == {"0", "1"} and len(
        {r["order"] for r in rows(d / "o")}
    ) == 36
    # a torn last row is dropped and its process measured again
    (d / "o/results.csv").write_bytes(first[:-100])
    run("run", c, "--out", d / "o", "--quiet")
    assert cells(d / "o") == {
        (r["cell_id"], r["process"], r["rep"]) for r in csv.DictReader(first.decode().splitlines())
    }
    # what is asked for again is measured again, nothing else
    done = run("run", c, "--out", d / "o", "--quiet", "--rerun", "lemke")
    assert "18 measured now" in done.stdout, done.stdout
    assert (
        "0 measured now" in run("run", c, "--out", d / "o", "--quiet", "--rerun", "failed").stdout
    )


def manifest_is_complete(d):
    words = (campaign(d, SMALL), "--out", d / "o", "--quiet", "--filter", "solver=lemke")
    run("run", *words, OPENBLAS_NUM_THREADS="")  # one thread, though nobody says so
    m = json.loads((d / "o/manifest.json").read_text())
    assert m["campaign"]["seed"] == 3 and "stack:n={1,2}" in m["campaign"]["text"]
    for path in (
        "build/commit",
        "build/compiler",
        "build/build_hash",
        "machine/cpu",
        "machine/kernel",
        "machine/memory",
        "machine/clock_cost_s",
        "campaign/order",
        "campaign/cache",
        "libraries/openblas",
        "libraries/suitesparse",
        "libraries/gsl",
        "environment/OPENBLAS_NUM_THREADS",
        "results_sha256",
    ):
        value = m
        for key in path.split("/"):
            value = value[key]
        assert value not in (None, ""), path
    assert m["libraries"]["openblas_threads"] == 1
    assert m["inputs_sha256"] and (d / "o/canary.csv").read_text().count("\n") >= 3


def g5_shards_merge_to_the_whole(d):
    c = campaign(d, SMALL)
    run("run", c, "--out", d / "whole", "--quiet")
    for k in (1, 2, 3):
        run("run", c, "--out", d / f"s{k}", "--quiet", "--shard", f"{k}/3")
    assert all(
        len({r["problem"] for r in rows(d / f"s{k}")} & {r["problem"] for r in rows(d / f"s{j}")})
        == 0
        for k in (1, 2, 3)
        for j in range(1, k)
    ), "a problem with all its solvers belongs to one shard"
    run("merge", d / "s1", d / "s2", d / "s3", "--out", d / "merged")
    assert {untimed(r) for r in rows(d / "merged")} == {untimed(r) for r in rows(d / "whole")}
    one_line_error("merge", d / "s1", d / "s1", "--out", d / "twice", names=["twice"])
    text = (d / "s2/results.csv").read_text()
    commit = next((r["build_hash"] for r in rows(d / "s2")), None)
    if commit:
        (d / "s2/results.csv").write_text(text.replace(commit, "0" * len(commit)))
        one_line_error("merge", d / "s1", d / "s2", d / "s3", "--out", d / "mixed", names=["build"])
        run("merge", d / "s1", d / "s2", d / "s3", "--out", d / "mixed", "--allow-mixed")


def g6_one_bit_invalidates_its_cells_only(d):
    matrix(d / "a.x", "2")
    matrix(d / "b.x", "2")
    c = campaign(d, FILES % d)
    run("run", c, "--out", d / "o", "--quiet")
    before = {r["cell_id"]: r for r in rows(d / "o")}
    assert len(before) == 8
    matrix(d / "a.x", "2.0000000000000004")
    done = run("run", c, "--out", d / "o", "--quiet")
    assert "2 measured now" in done.stdout and "4 stale rows" in done.stdout, done.stdout
    after = {r["cell_id"]: r for r in rows(d / "o")}
    gone = [before[k] for k in before.keys() - after.keys()]
    assert len(gone) == 2 and all(r["problem"].endswith("a.M.mtx") for r in gone)
    # an option invalidates its solver's cells
    done = run(
        "run",
        campaign(d, (FILES % d).replace("pgs]", "'pgs:omega=1.1']")),
        "--out",
        d / "o",
        "--quiet",
    )
    assert "4 measured now" in done.stdout, done.stdout


def g6_other_shared_code_invalidates_all(d):
    """Rows of a build whose solvers are the same, but whose matrices, residuals or step loop are
    not, count as unmeasured."""
    c = campaign(d, SMALL)
    run("run", c, "--out", d / "o", "--quiet")
    text = (d / "o/results.csv").read_text()
    base = {r["base_hash"] for r in rows(d / "o")}
    assert len(base) == 1 and base != {""}
    other = text.replace(base.pop(), "0123456789abcdef")
    (d / "o/results.csv").write_text(other)
    done = run("run", c, "--out", d / "o", "--quiet", "--filter", "solver=lemke")
    assert "18 measured now" in done.stdout and "stale rows" in done.stdout, done.stdout
    done = run("run", c, "--out", d / "o", "--quiet")
    assert "18 measured now" in done.stdout or "0 measured now" not in done.stdout, done.stdout
    assert cells(d / "o") == {
        (r["cell_id"], r["process"], r["rep"]) for r in csv.DictReader(text.splitlines())
    }
    with open(d / "o/stale.csv", newline="") as f:
        assert len(list(csv.DictReader(f))) == 72, "nothing is thrown away"
    assert ", 0 differ" in run("verify", d / "o").stdout


def boxes(d):
    """Three boxes beside each other on a floor, pushed aslant: four feet each."""
    scene = {"id": "boxes", "dim": 3, "T": 0.05, "hs": [0.01], "gravity": [0, 0, -9.81]}
    box = {"shape": {"type": "box", "half": [0.5, 0.5, 0.5]}, "mass": 1, "quat": [1, 0, 0, 0]}
    scene["bodies"] = [{"name": f"b{k}", "pos": [2.0 * k, 0, 0.5]} | box for k in range(3)]
    push = {"type": "force_ramp", "dir": [0.8, 0.6, 0.0], "rate": 20.0}
    scene |= {"loads": [{"body": f"b{k}"} | push for k in range(3)]}
    scene |= {"friction": {"default": 0.5}, "observe": ["b0.pos"], "checks": [{"type": "finite"}]}
    scene |= {"static": [{"name": "floor", "normal": [0, 0, 1], "offset": 0}]}
    (d / "boxes.json").write_text(json.dumps(scene), encoding="utf-8")
    return d / "boxes.json"


def kinds_of_cells(d):
    """A campaign with a cell of every kind: scenes, with other effects, started warm, of other
    steps, in islands; files and families."""
    matrix(d / "a.x", "2")
    more = """
  - name: variants
    problems: ["stack:n=2,duration=0.03"]
    formulations: [velocity, coulomb]
    solvers: [nsgs]
    effects: [declared, all, "-friction"]
    starts: [cold, previous]
    steps: [0.005]
  - name: islands
    problems: ["%s"]
    formulations: [velocity, coulomb]
    solvers: [cone_newton]
    islands: [off, on]
  - name: integrators
    problems: ["drop:duration=0.05"]
    formulations: [penalty, event]
    solvers: [lemke]
  - name: tolerances
    problems: ["random_spd:n=12,seed=2"]
    solvers: [pgs, projected_gradient]
    tolerances: [1e-4, 1e-8]
  - name: hopeless
    problems: ["random_spd:n=20,seed=3"]
    solvers: ["pgs:max_iter=3", enumerate]
"""
    more %= boxes(d)
    return campaign(d, SMALL + (FILES % d).split("parts:")[1] + more)


def verdicts_come_from_stored_answers(d):
    run("run", kinds_of_cells(d), "--out", d / "o", "--quiet")
    n = len({r["cell_id"] for r in rows(d / "o")})
    empty = len({r["cell_id"] for r in rows(d / "o") if not r["solution_hash"]})
    done = run("verify", d / "o")
    assert (
        f"{n - empty} cells verified ({n - empty} from stored answers, 0 run again), 0 differ,"
        f" {empty} without" in done.stdout
    ), done.stdout
    text = (d / "o/results.csv").read_text()

    def falsified(old, new):
        assert old in text
        (d / "o/results.csv").write_text(text.replace(old, new))
        out = run("verify", d / "o", code=3).stdout
        (d / "o/results.csv").write_text(text)
        return out

    assert "solution_hash is" in falsified(rows(d / "o")[0]["solution_hash"], "0123456789abcdef")
    liar = next(r for r in rows(d / "o") if r["status"] == "max_iter")
    assert "status is max_iter, the row says ok" in falsified(
        ",max_iter,max_iter,", ",ok,max_iter,"
    ), liar["cell_id"]
    worst = next(
        r["rho"] for r in rows(d / "o") if r["solver"] == "pgs" and float(r["rho"] or 0) > 1e-15
    )
    assert "rho is" in falsified(f",{worst},", ",1e-17,")
    # one bit of one stored answer, a file cut short, one from another cell
    one = (
        d
        / "o/solutions"
        / (
            next(
                r
                for r in rows(d / "o")
                if r["problem"].startswith("stack") and r["solver"] == "lemke"
            )["cell_id"]
            + ".ans"
        )
    )
    whole = one.read_bytes()
    for broken in (
        whole[:-1] + bytes([whole[-1] ^ 4]),
        whole[:-3],
        whole + b"more",
        b"something else",
    ):
        one.write_bytes(broken)
        assert "1 differ" in run("verify", d / "o", code=3).stdout
    one.write_bytes(whole)
    # where nothing is stored, the command is run again
    run("run", campaign(d, SMALL), "--out", d / "p", "--quiet", "--solutions", "off")
    assert (
        "18 cells verified (0 from stored answers, 18 run again)" in run("verify", d / "p").stdout
    )


def commands_rerun_their_cells(d):
    """The command of a row of each kind gives its verdict, counters and solution hash."""
    run("run", kinds_of_cells(d), "--out", d / "o", "--quiet", "--shard", "1/2")
    run("run", kinds_of_cells(d), "--out", d / "p", "--quiet", "--shard", "2/2")
    run("merge", d / "o", d / "p", "--out", d / "m")
    done = run("verify", d / "m", "--rerun")
    assert ", 0 differ" in done.stdout and "(0 from stored" in done.stdout, done.stdout
    seen = set()
    for r in {r["cell_id"]: r for r in rows(d / "m")}.values():
        kind = (r["part"], r["formulation"], r["solver"], r["start"], r["effects"])
        if kind in seen:
            continue
        seen.add(kind)
        words = shlex.split(r["command"])
        assert words[0] == "lcpbench"
        o = json.loads(
            subprocess.run([LCPBENCH, *words[1:]], capture_output=True, text=True).stdout
        )
        got = [
            o["status"],
            o["solution_hash"] or "",
            str(o["n_iter"]),
            str(o["n_pivot"]),
            str(o["n_factor"]),
            str(o["n_matvec"]),
        ]
        want = [
            r[k] for k in ("status", "solution_hash", "n_iter", "n_pivot", "n_factor", "n_matvec")
        ]
        assert got == want or not r["solution_hash"] and got[0] == want[0], (
            r["command"],
            got,
            want,
        )
    assert len(seen) > 20, len(seen)


def histories_come_from_twins(d):
    """--trace writes a history per cell from a run that is not timed, and the timed rows name
    it."""
    c = campaign(d, SMALL + (FILES % d).split("parts:")[1].replace('"%s/*.M.mtx", ' % d, ""))
    run("run", c, "--out", d / "plain", "--quiet")
    assert not (d / "plain/traces").exists() and {r["trace"] for r in rows(d / "plain")} == {""}
    run("run", c, "--out", d / "o", "--quiet", "--trace")
    index = list(csv.DictReader((d / "o/traces/index.csv").open(newline="")))
    ids = {r["cell_id"]: r for r in rows(d / "o")}
    assert len(index) == len(ids) == len({i["cell_id"] for i in index})
    for i in index:  # recording disturbs nothing: the twin's answers have the timed run's bits
        r = ids[i["cell_id"]]
        assert i["solution_hash"] == r["solution_hash"] and "twin_differs" not in r["flags"]
    lengths = {}
    for r in ids.values():
        points = list(csv.DictReader((d / "o" / r["trace"]).open(newline="")))
        lengths[r["solver"]] = lengths.get(r["solver"], 0) + len(points)
        last = {p["solve"]: float(p["residual"]) for p in points}
        if r["solver"] == "pgs" and r["status"] == "ok":
            assert max(last.values()) <= float(r["tol"]) and len(points) > 1, (r["trace"], last)
    assert lengths["pgs"] >= 4 and lengths["projected_gradient"] > 20, lengths
    assert {untimed(r) for r in rows(d / "plain")} == {
        untimed(dict(r, trace="")) for r in rows(d / "o")
    }
    # a history that is missing is made afterwards; nothing is measured again
    (d / "o" / next(iter(ids.values()))["trace"]).unlink()
    assert "0 measured now" in run("run", c, "--out", d / "o", "--quiet", "--trace").stdout
    assert all((d / "o" / r["trace"]).exists() for r in rows(d / "o"))


def abba_runs_forth_and_back(d):
    text = SMALL[: SMALL.index("sampling")] + (
        "sampling: {processes: 4, samples: 1, max_samples: 1, order: abba}\n"
        "parts: [{name: a, problems: ['random_spd:n={5,6,7}'], solvers: [lemke, pgs, apgd]}]\n"
    )
    run("run", campaign(d, text), "--out", d / "o", "--quiet")
    forth = {}
    for r in sorted(rows(d / "o"), key=lambda r: int(r["order"])):
        forth.setdefault((r["problem"], int(r["process"])), []).append(r["solver"])
    assert len(forth) == 12 and all(len(v) == 3 for v in forth.values())
    for (problem, process), solvers in forth.items():
        assert solvers == (forth[problem, 0] if process % 2 == 0 else forth[problem, 0][::-1]), (
            problem,
            process,
        )


def interrupted_runs_flush_and_go_on(d):
    text = SMALL.replace("projected_gradient", "'faulty_steady:seconds=0.2'").replace(
        "velocity:facets={4,8}", "normal"
    )
    c = campaign(d, text)
    for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 4)):
        p = subprocess.Popen(
            [FAULTY, "run", str(c), "--out", str(d / "o")],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        while not (d / "o/results.csv").exists():
            assert p.poll() is None, p.communicate()
            time.sleep(0.02)
        p.send_signal(number)
        p.communicate(timeout=30)
        assert p.returncode == code, (number, p.returncode)
        assert (d / "o/manifest.json").exists()
        rows(d / "o")
        shutil.rmtree(d / "o")


def status_counts(d):
    run("run", campaign(d, SMALL), "--out", d / "o", "--quiet")
    assert "72 rows of 18 cells" in run("status", d / "o").stdout
    one_line_error("status", d / "nothing", names=["results.csv"])


def progress_is_plain_where_nobody_watches(d):
    """One line each with done/total, percent, time left, the cell and its verdict; no escape codes;
    nothing under --quiet."""
    c = campaign(d, SMALL)
    lines = run("run", c, "--out", d / "o", "--filter", "solver=lemke").stderr.splitlines()
    assert lines and "\x1b" not in "".join(lines) and "\r" not in "".join(lines)
    assert re.fullmatch(r"\[18/18\] 100\.0 % ETA 00:00 \S+/\S+/lemke ok \S+ s", lines[-1]), lines[
        -1
    ]
    assert run("run", c, "--out", d / "o", "--quiet").stderr == ""
    # what was there already is counted from the start
    lines = run("run", c, "--out", d / "o", "--rerun", "lemke").stderr.splitlines()
    assert re.match(r"\[(1[89]|2\d|3\d)/36\] ", lines[0]), lines[0]


def smoke_is_explained(d):
    """A row that is not ok says why."""
    run("run", "smoke", "--out", d / "o", "--quiet", timeout=300)
    got = rows(d / "o")
    explained = {"unsupported", "max_iter", "time_limit", "stalled", "near"}
    strange = [
        r for r in got if r["status"] != "ok" and (r["status"] not in explained or not r["note"])
    ]
    print(f"# {len(got)} rows, {len(strange)} unexplained")
    assert len({r["cell_id"] for r in got}) > 50 and not strange, strange[:1]


def paper_prints_its_plan(d):
    """Cells, what is done, and how long the rest will take: by earlier rows where there are any."""
    last = run("run", "paper", "--dry-run", "--out", d / "o").stdout.splitlines()[-1]
    form = (
        r"(\d+) cells, (\d+) processes: (\d+) done, (\d+) to do; about (\d+) s \((\S+) s by earlier"
        r" rows, (\d+) processes of .* at most (\d+) s"
    )
    m = re.fullmatch(form, last)
    assert (
        m and int(m[1]) > 100 and m[2] == m[4] == m[7] and 0 < int(m[5]) < int(m[8]) and m[6] == "0"
    ), last
    c = campaign(d, SMALL)
    run("run", c, "--out", d / "p", "--quiet", "--filter", "solver=lemke")
    m = re.fullmatch(form, run("run", c, "--dry-run", "--out", d / "p").stdout.splitlines()[-1])
    assert (m[1], m[2], m[3], m[4], m[7]) == ("18", "36", "18", "18", "0"), m[0]
    one_line_error("run", c, "--like", d / "p", names=["--like", "--dry-run"])


def rows_of_another_run_foretell_the_time(d):
    """0.1 s an evaluation: a warm-up and two samples, the judge's share, the start; a killed one
    takes the limit, a refused one nothing. One that fails ends its cell: no second process. Packed
    rows tell the same."""
    c = campaign(d, SMALL)
    run("run", c, "--out", d / "p", "--quiet")
    known = rows(d / "p")

    def about(name, *more, **of_all):
        (d / name).mkdir()
        changed = [{**r, "t_total_s": "0.1", "n_inner": "1", **of_all} for r in known]
        with open(d / name / "results.csv", "w", newline="") as to:
            out = csv.DictWriter(to, list(known[0]), lineterminator="\n")
            out.writeheader()
            out.writerows(changed)
        words = ("--dry-run", "--out", d / "none", "--like", d / name, *more)
        last = run("run", c, *words).stdout.splitlines()[-1]
        return float(re.search(r"about (\d+) s", last)[1])

    each = 0.005 + 1.3 * 3 * 0.1
    assert about("plain") == round(36 * each)
    assert about("one", "--filter", "solver=lemke") == round(18 * each)
    killed = {"status": "timeout", "t_total_s": "", "t_limit_s": "10"}
    assert about("killed", **killed) == 18 * 11
    assert about("failed", status="stalled") == round(18 * each)
    assert about("refused", t_total_s="", status="unsupported") == round(18 * 0.005)
    text = (d / "plain/results.csv").read_bytes()
    (d / "plain/results.csv.xz").write_bytes(lzma.compress(text))
    (d / "plain/results.csv").unlink()
    words = ("--dry-run", "--out", d / "none", "--like", d / "plain")
    assert f"about {36 * each:.0f} s" in run("run", c, *words).stdout


def rungs_of_a_family_foretell_the_next(d):
    """An evaluation of 1 ms at n = 2 and of 4 ms at n = 4 over 0.1 s: n = 8 over ten times as long
    takes 160 ms, in a warm-up and two samples of it each. The mean over all rungs was 2.5 ms."""
    head = (
        "name: rungs\nlimits: {time: 5s}\n"
        "sampling: {processes: 1, samples: 1, max_samples: 3, inner: 0.0001s}\nparts:\n"
    )
    part = (
        '  - {name: a, problems: ["stack:n=%s,duration=%s"], formulations: [normal], '
        "solvers: [lemke]}\n"
    )
    known = campaign(d, head + part % ("{2,4}", "0.1"), "known.yaml")
    run("run", known, "--out", d / "o", "--quiet")
    got = rows(d / "o")
    for r in got:
        r["t_total_s"] = "0.001" if "n=2" in r["problem"] else "0.004"
    (d / "p").mkdir()
    with open(d / "p/results.csv", "w", newline="") as to:
        out = csv.DictWriter(to, list(got[0]), lineterminator="\n")
        out.writeheader()
        out.writerows(got)
    asked = campaign(d, head + part % ("8", "{1,1.01,1.02,1.03,1.04,1.05}"), "asked.yaml")
    words = ("--dry-run", "--out", d / "none", "--like", d / "p")
    last = run("run", asked, *words).stdout.splitlines()[-1]
    each = [0.005 + 1.3 * 3 * 0.016 * 10 * (1 + k / 100) for k in range(6)]
    assert f"about {sum(each):.0f} s" in last, (sum(each), last)


def merged_folders_keep_their_answers(d):
    """verify works on the merged folder, without a solver; canaries, histories and the noisiest
    doctor come along."""
    c = campaign(d, SMALL.replace("inner: 0.0001s", "inner: 0.0001s, doctor: 1s"))
    run("run", c, "--out", d / "s1", "--quiet", "--shard", "1/2", "--trace")
    run("run", c, "--out", d / "s2", "--quiet", "--shard", "2/2", "--trace")
    noisy = json.loads((d / "s2/doctor.json").read_text())
    noisy["noise_floor"] = 99.0
    (d / "s2/doctor.json").write_text(json.dumps(noisy))
    run("merge", d / "s1", d / "s2", "--out", d / "m")
    assert (
        "18 cells verified (18 from stored answers, 0 run again), 0 differ"
        in run("verify", d / "m").stdout
    )
    assert all((d / "m" / r["trace"]).exists() and r["trace"] for r in rows(d / "m"))
    assert len(list(csv.DictReader((d / "m/traces/index.csv").open()))) == 18
    assert json.loads((d / "m/doctor.json").read_text())["noise_floor"] == 99.0
    canaries = {float(r["canary_s"]) for r in csv.DictReader((d / "m/canary.csv").open())}
    assert {float(r["canary_s"]) for r in rows(d / "m")} <= canaries and len(canaries) >= 4


tap(
    [
        plan_is_printed,
        filters_choose,
        schema_errors_name_line_and_key,
        files_stand_below_a_variable,
        rows_are_whole_and_resumed,
        manifest_is_complete,
        g5_shards_merge_to_the_whole,
        g6_one_bit_invalidates_its_cells_only,
        g6_other_shared_code_invalidates_all,
        verdicts_come_from_stored_answers,
        commands_rerun_their_cells,
        histories_come_from_twins,
        abba_runs_forth_and_back,
        interrupted_runs_flush_and_go_on,
        status_counts,
        smoke_is_explained,
        paper_prints_its_plan,
        rows_of_another_run_foretell_the_time,
        rungs_of_a_family_foretell_the_next,
        merged_folders_keep_their_answers,
        progress_is_plain_where_nobody_watches,
    ]
)

"""What `compare` may say: planted differences are found, disturbed pairs are inconclusive, failures
are counted, and the drift between two folders is no difference."""

import csv
import json
import os
import re
import subprocess
import sys

from support import FAULTY, QUIET, campaign, diagonal, run, tap

TEXT = """
name: pairs
seed: 3
limits: {time: 10s}
sampling: {processes: 3, samples: 5, max_samples: 5, inner: 0.0001s}
parts:
  - name: scenes
    problems: ["stack:n=1,duration=0.02"]
    formulations: ["velocity:facets={4,8}", regularized]
    solvers: [lemke]
    steps: [0.01, 0.005]
"""


def table(folder):
    with open(folder / "results.csv", newline="") as from_:
        found = csv.DictReader(from_)
        return found.fieldnames, list(found)


def planted(d, name, source, change):
    """A copy of a folder whose rows went through `change`; the floor is one per cent."""
    header, lines = table(source)
    (d / name).mkdir()
    with open(d / name / "results.csv", "w", newline="") as to:
        out = csv.DictWriter(to, header, lineterminator="\n")
        out.writeheader()
        for i, line in enumerate(lines):
            out.writerow(line | change(i, line))
    return d / name


def steady(i, line, factor=1.0, canary=0.004, **more):
    """The spread of the samples is a tenth of a per cent."""
    seconds = factor * (1e-3 + 1e-6 * (i % 2))
    return QUIET | {"t_total_s": repr(seconds), "canary_s": repr(canary)} | more


def words(*args):
    out = run("compare", *args, "--noise", 0.01).stdout.splitlines()
    return [line.rpartition("] ")[2] for line in out if "ratio " in line], out


def folders(d):
    run("run", campaign(d, TEXT), "--out", d / "o", "--quiet")
    return planted(d, "a", d / "o", steady)


def five_per_cent_are_found_on_a_quiet_machine(d):
    a = folders(d)
    slower = planted(d, "b", d / "o", lambda i, line: steady(i, line, 1.05))
    assert words(a, slower)[0] == ["slower"] * 6
    assert words(slower, a)[0] == ["faster"] * 6
    assert words(a, a)[0] == ["no difference"] * 6


def a_disturbed_row_makes_its_pair_inconclusive(d):
    """Per pair: of two cells, the one beside other work."""
    a = folders(d)
    for change in ({"load_other": "0.9"}, {"throttled": "true"}, {"flags": "canary_drift"}):

        def disturb(i, line, change=change):
            eight = line["formulation_options"] == "facets=8"
            return steady(i, line, 1.5, **(change if eight else {}))

        name = "b" + next(iter(change))
        found, out = words(a, planted(d, name, d / "o", disturb))
        assert sorted(found) == ["inconclusive: disturbed"] * 2 + ["slower"] * 4, out
        assert all(("facets=8" in x) == ("inconclusive" in x) for x in out if "ratio " in x), out
        assert "2 inconclusive" in out[-1]


def rows_of_an_older_version_are_judged_by_their_load(d):
    a = folders(d)
    old = planted(d, "b", d / "o", lambda i, line: steady(i, line, 1.5, load_other="", load1="2.1"))
    assert words(a, old)[0] == ["inconclusive: disturbed"] * 6


def the_drift_between_folders_is_no_difference(d):
    a = folders(d)
    later = planted(d, "b", d / "o", lambda i, line: steady(i, line, 1.05, canary=0.0043))
    found, out = words(a, later)
    assert found == ["no difference"] * 6
    assert any("canaries differ by up to 7.50 %" in line for line in out), out


def lines_name_facets_and_step(d):
    out = words(folders(d), d / "a")[1]
    assert any("velocity:facets=8 h = 0.005 s lemke -> lemke" in line for line in out), out


def failures_of_either_side_are_counted(d):
    """A side that solves nothing says so, beside the pairs that both solve."""
    a = folders(d)

    def fail(i, line, when):
        return steady(i, line, **({"status": "stalled"} if when(line) else {}))

    eight = planted(
        d, "b", d / "o", lambda i, x: fail(i, x, lambda r: r["formulation_options"] == "facets=8")
    )
    fine = planted(d, "c", d / "o", lambda i, x: fail(i, x, lambda r: r["step_s"] == "0.005"))
    line = "failed, and in no ratio: {} of A only, {} of B only, {} of both"
    assert line.format(0, 2, 0) in words(a, eight)[1]
    assert line.format(3, 0, 0) in words(fine, a)[1]
    assert line.format(2, 1, 1) in words(fine, eight)[1]


LONGER = """
name: beside
seed: 5
limits: {time: 20s}
sampling: {processes: 2, samples: 7, max_samples: 7, inner: 0.02s, order: abba}
parts:
  - name: a
    problems: ["%s"]
    solvers: ['faulty_steady:seconds={0.01,0.011,0.012}']
"""


def nobody_wins_beside_another_job(d):
    """One build, one machine, twice; beside the second run every CPU has another job."""
    c = campaign(d, LONGER % diagonal(d, 10))
    run("run", c, "--out", d / "a", "--quiet", exe=FAULTY)
    burn = [
        subprocess.Popen([sys.executable, "-c", "while True: pass"])
        for _ in os.sched_getaffinity(0)
    ]
    try:
        run("run", c, "--out", d / "b", "--quiet", exe=FAULTY)
    finally:
        for job in burn:
            job.kill()
            job.wait()
    out = run("compare", d / "a", d / "b", exe=FAULTY).stdout
    print("# " + out.splitlines()[-1])
    assert len(re.findall("inconclusive: disturbed", out)) == 3, out
    assert not re.search(r"\] (faster|slower)$", out, re.M), out


def the_class_of_a_machine_tells_its_kernels(d):
    run("run", campaign(d, TEXT), "--out", d / "o", "--quiet")
    (found,) = {r["host_class"] for r in table(d / "o")[1]}
    assert re.fullmatch(r".*; OpenBLAS \S+; \S+;( \d+[KM])*( caches unknown)?", found), found
    assert json.loads((d / "o/manifest.json").read_text())["machine"]["host_class"] == found


tap(
    [
        five_per_cent_are_found_on_a_quiet_machine,
        a_disturbed_row_makes_its_pair_inconclusive,
        rows_of_an_older_version_are_judged_by_their_load,
        the_drift_between_folders_is_no_difference,
        lines_name_facets_and_step,
        failures_of_either_side_are_counted,
        nobody_wins_beside_another_job,
        the_class_of_a_machine_tells_its_kernels,
    ]
)

"""Contacts in another order: another path to the same motion, recorded, repeatable, and an
experiment of its own."""

import json
import pathlib
import shlex
import subprocess
import sys

from support import FAULTY, SANITIZED, Skip, campaign, one_line_error, rows, run, run_json, tap

TEXT = """
name: orders
limits: {time: 20s, grace: 1s}
sampling: {processes: 1, samples: 1, max_samples: 1}
parts:
  - name: a
    problems: ["stack:n=3,duration=0.1"]
    formulations: ["velocity:facets=4", coulomb, penalty]
    solvers: ["pgs:tol=1e-10", nsgs]
    contact_orders: [given, "random:{1,2}"]
"""


def orders_are_experiments(d):
    """Each a cell of its own, whose command gives it back; other work for the same motion; stored
    answers are judged in their order."""
    c = campaign(d, TEXT)
    run("run", c, "--out", d / "o", "--quiet")
    got = rows(d / "o")
    assert len({r["cell_id"] for r in got}) == 18 and {r["contact_order"] for r in got} == {
        "given",
        "random:1",
        "random:2",
    }
    for r in got:
        if r["formulation"] == "penalty":  # detects its contacts itself
            assert (r["status"] == "unsupported") == (r["contact_order"] != "given"), r["note"]
    solved = [
        r
        for r in got
        if r["status"] == "ok"
        and r["formulation"] != "penalty"
        and r["problem"].startswith("stack")
    ]
    work = {}
    for r in solved:
        assert r["n_predictions_missed"] == "0" and int(r["n_predictions"]) > 0, (
            r["contact_order"],
            r["missed"],
        )
        work.setdefault((r["formulation"], r["solver"]), set()).add(r["n_iter"])
        if r["contact_order"] == "random:2" and SANITIZED:
            continue
        o = json.loads(run(*shlex.split(r["command"])[1:], code=None).stdout)
        assert (o["solution_hash"], str(o["n_iter"]), str(o["contact_order"])) == (
            r["solution_hash"],
            r["n_iter"],
            r["contact_order"].replace("given", "0")[-1],
        )
    assert len(solved) >= 6 and any(len(n) == 3 for n in work.values()), work
    assert ", 0 differ" in run("verify", d / "o").stdout
    # compare does not pair one order with another
    run("run", c, "--out", d / "given", "--quiet", "--filter", "contact_order=given")
    run("run", c, "--out", d / "other", "--quiet", "--filter", "contact_order=random:1")
    assert (
        len({r["cell_id"] for r in rows(d / "given")} | {r["cell_id"] for r in rows(d / "other")})
        == 12
    )
    one_line_error("compare", d / "given", d / "other", names=["no cell of", "given", "other"])


def a_death_keeps_its_order(d):
    text = TEXT.replace('"pgs:tol=1e-10", nsgs', "faulty_quit").replace(
        '"velocity:facets=4", coulomb, penalty', "normal"
    )
    run("run", campaign(d, text), "--out", d / "o", "--quiet", exe=FAULTY)
    assert sorted((r["status"], r["contact_order"], r["start"]) for r in rows(d / "o")) == [
        ("no_output", o, "cold") for o in ("given", "random:1", "random:2")
    ]


def the_spread_is_told(d):
    """The shipped campaign and the table of it."""
    if SANITIZED:
        raise Skip("slow with sanitizers")
    script = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "variability"

    def table(folder):
        return subprocess.run([sys.executable, script, folder], capture_output=True, text=True)

    run(
        "run",
        "variability",
        "--quick",
        "--out",
        d / "o",
        "--quiet",
        "--filter",
        "problem=stack*",
        "--filter",
        "formulation=regularized",
        "--filter",
        "solver=[lp][eg][ms]*",
        "--time-limit",
        20,
    )
    got = rows(d / "o")
    done = table(d / "o")
    lines = [line.split() for line in done.stdout.splitlines()]
    assert done.returncode == 0 and [line[:3] for line in lines[1:-1]] == [
        ["stack:n=10", "regularized", s] for s in ("lemke", "pgs")
    ], done
    for line in lines[1:-1]:
        work = [int(r["n_iter"]) + int(r["n_pivot"]) for r in got if r["solver"] == line[2]]
        assert (
            line[3:6] == ["5", "of", "5"]
            and line[7:9] == [str(min(work)), str(max(work))]
            and min(work) < max(work)
        ), (line, work)
    run(
        "run",
        campaign(d, TEXT),
        "--out",
        d / "p",
        "--quiet",
        "--filter",
        "contact_order=given",
        "--filter",
        "problem=stack*",
    )
    assert (
        table(d / "p").returncode == 2
        and "no cells in other orders" in table(d / "p").stderr
        and table(d / "nothing").returncode == 2
    )


def the_given_order_is_no_other_experiment(d):
    words = ("simulate", "stack:n=2", "--formulation", "velocity", "--solver", "lemke")
    assert (
        run_json(*words)["solution_hash"]
        == run_json(*words, "--contact-order", "given")["solution_hash"]
    )
    c = campaign(d, TEXT)
    plain = campaign(
        d, TEXT.replace('    contact_orders: [given, "random:{1,2}"]\n', ""), "plain.yaml"
    )
    todo = [
        set(
            x
            for x in run(
                "run", f, "--dry-run", "--filter", "contact_order=given"
            ).stdout.splitlines()
            if x.startswith("todo")
        )
        for f in (c, plain)
    ]
    assert todo[0] == todo[1] and len(todo[0]) == 6


def bad_orders_are_named(d):
    for order in ("shuffled", "random", "random:0", "random:-1", "random:x"):
        one_line_error(
            "simulate",
            "stack",
            "--formulation",
            "velocity",
            "--solver",
            "lemke",
            "--contact-order",
            order,
            names=[order, "random:N"],
        )
        one_line_error(
            "run",
            campaign(d, TEXT.replace("random:{1,2}", order)),
            "--dry-run",
            names=[order, "random:N"],
        )
    lcps = TEXT.replace('    formulations: ["velocity:facets=4", coulomb, penalty]\n', "").replace(
        '"stack:n=3,duration=0.1"', '"murty:n=3"'
    )
    one_line_error("run", campaign(d, lcps), "--dry-run", names=["contact_orders", "scenes"])


tap(
    [
        orders_are_experiments,
        a_death_keeps_its_order,
        the_spread_is_told,
        the_given_order_is_no_other_experiment,
        bad_orders_are_named,
    ]
)

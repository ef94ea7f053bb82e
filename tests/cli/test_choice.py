"""simulate --error alone: formulation and solver from measured rows, told and repeatable."""

import os
import re
import shlex
import subprocess

from support import LCPBENCH, SANITIZED, TESTS, Skip, one_line_error, run_json, tap

FEATURES = (
    "bodies contacts per_body redundant sliding closing spatial friction restitution resisting"
    " joints moving"
).split()
HEAD = ["problem", "error", "formulation", "solver", "kept", "t_total_s", *FEATURES]
QUICK, SLOW = ("regularized", "lemke"), ("coulomb", "nsgs")
FLAT = ("velocity:facets=8", "lemke")


def features(scene):
    o = run_json("simulate", scene, "--error", 0.1, "--formulation", FLAT[0], "--solver", FLAT[1])
    return o["error"]["features"]


def write(path, rows, head=HEAD):
    text = ["\t".join(head)] + ["\t".join(map(str, r)) for r in rows]
    path.write_text("\n".join(text) + "\n")
    return path


def row(problem, E, combination, kept, seconds, x):
    return [problem, E, *combination, kept, seconds, *(x[n] for n in FEATURES)]


def chosen(scene, rows, *more, error=0.1, **kw):
    o = run_json("simulate", scene, "--error", error, "--rows", rows, *more, **{"code": None, **kw})
    return o, [c for c in o["choice"]["candidates"] if c["tried"]]


def the_nearest_scene_decides(d):
    """Two scenes, each with its own best: every scene takes that of its like."""
    slide, bounce = features("slide"), features("bounce")
    assert slide != bounce
    rows = write(
        d / "choices.tsv",
        [
            row("slide", 0.1, QUICK, 1, 0.01, slide),
            row("slide", 0.1, SLOW, 1, 0.1, slide),
            row("bounce", 0.1, QUICK, 1, 0.1, bounce),
            row("bounce", 0.1, SLOW, 1, 0.01, bounce),
        ],
    )
    for scene, want in (("slide", QUICK), ("slide:speed=4", QUICK), ("bounce", SLOW)):
        o, tried = chosen(scene, d)
        assert (tried[0]["formulation"], tried[0]["solver"]) == want, (scene, o["choice"])
        assert len(tried) == 1 and tried[0]["tried"] == "ok" and 0 < tried[0]["sure"] <= 1
        assert o["choice"]["nearest"][0]["near"] == scene.split(":")[0]
        assert (o["formulation"], o["solver"]) == (want[0].split(":")[0], want[1])
        assert o["choice"]["scenes"] == 2 and o["choice"]["rows"] == str(rows)


def who_did_not_keep_the_error_is_not_taken(d):
    x = features("slide")
    rows = write(
        d / "r.tsv",
        [
            row("slide", E, c, int(c == SLOW or E > 0.05), 0.1 if c == SLOW else 0.01, x)
            for c in (QUICK, SLOW)
            for E in (0.1, 0.01)
        ],
    )
    taken = [chosen("slide", rows, error=E)[1][0]["formulation"] for E in (0.2, 0.1, 0.05, 0.01)]
    assert taken == [QUICK[0], QUICK[0], SLOW[0], SLOW[0]], taken


def one_row_does_not_turn_several(d):
    """Who is slower by a fifth at one error, and quicker by half at the others, is taken at all."""
    x = features("slide")
    rows = [
        row("slide", E, c, 1, 0.012 if (c, E) == (QUICK, 0.01) else (0.005, 0.01)[c == SLOW], x)
        for c in (QUICK, SLOW)
        for E in (0.1, 0.01, 0.001, 1e-4)
    ]
    taken = chosen("slide", write(d / "r.tsv", rows), error=0.01)[1][0]["formulation"]
    assert taken == QUICK[0], taken


def comes_first(d, first, quicker, slower, scene):
    """Of two combinations that keep the error, in the scene, whatever rows tell of their times."""
    x = features(scene)
    rows = [row("s", 0.01, quicker, 1, 0.001, x), row("s", 0.01, slower, 1, 0.01, x)]
    told = run_json("choose", scene, "--error", "1%", "--rows", write(d / "r.tsv", rows))
    assert told["candidates"][0]["formulation"] == first[0], (scene, told["candidates"])


def flat_cones_come_last_in_space(d):
    """Facets turn friction by an angle that no step shows: quicker, and never within the error."""
    comes_first(d, QUICK, FLAT, QUICK, "spin")
    comes_first(d, FLAT, FLAT, QUICK, "slide:dim=2")


def bristles_come_last_under_loads_that_vary(d):
    """What holds is never at rest by them while a load grows, so that they take steps."""
    comes_first(d, SLOW, QUICK, SLOW, "capacity")
    comes_first(d, QUICK, QUICK, SLOW, "spin")
    comes_first(d, QUICK, FLAT, QUICK, "capacity")


def what_cannot_run_gives_way(d):
    """event knows no generalised coordinates: the next candidate runs, and both are told."""
    x = features("slide")
    event = ("event", "lemke")
    rows = write(d / "r.tsv", [row("s", 0.1, event, 1, 0.001, x), row("s", 0.1, QUICK, 1, 0.01, x)])
    o, tried = chosen("woodpecker", rows, code=None)
    assert [t["tried"] for t in tried] == ["unsupported", "ok"], o["choice"]
    assert o["formulation"] == "regularized" and o["error"]["promised"]


def a_proof_says_more_than_a_failure(_):
    """Nothing solves a closing vise; Lemke's method proves that, sweeps only do not end."""
    o = run_json("simulate", "vise", "--error", 0.01, code=3)
    c = o["choice"]["candidates"]
    assert [x["tried"] for x in c if x["tried"]].count("infeasible") >= 1, c
    assert "infeasible" in o["error"]["reason"] and o["status"] == "infeasible", o["error"]
    proved = [x for x in c if x["tried"] == "infeasible"]
    ways = [f"'{x['formulation']}' --solver '{x['solver']}'" for x in proved]
    assert any(way in o["choice"]["repeat"] for way in ways), o["choice"]


def the_command_told_repeats_the_run(d):
    x = features("tip")
    rows = write(d / "r.tsv", [row("tip", 0.1, QUICK, 1, 0.01, x)])
    o, _ = chosen("tip", rows, "--write-steps", d / "steps.txt", code=None)
    words = shlex.split(o["choice"]["repeat"])
    assert words[0] == "lcpbench" and "--error" not in words and "--rows" not in words, words
    again = run_json(*words[1:], code=None)
    assert again["solution_hash"] == o["solution_hash"] and "choice" not in again


def the_program_comes_with_rows(_):
    for scene in ("slide", "bounce"):
        o = run_json("simulate", scene, "--error", "1%", code=None)
        assert o["error"]["promised"] and o["choice"]["scenes"] > 10, o["choice"]
        assert o["choice"]["nearest"][0]["distance"] < 1e-4, o["choice"]["nearest"]


def choose_predicts_and_measures(d):
    """What simulate would take, without a run; and with --measure who is really the quickest."""
    x = features("slide")
    rows = write(
        d / "r.tsv",
        [
            row("slide", 0.01, ("coulomb", "nsgs:max_iter=1"), 1, 0.001, x),  # fails
            row("slide", 0.01, QUICK, 1, 0.01, x),
            row("slide", 0.01, SLOW, 1, 0.1, x),
        ],
    )
    call = ("choose", "slide:speed=4", "--error", "1%", "--rows", rows)
    told = run_json(*call)
    ranked = [c["solver"] for c in told["candidates"]]
    assert ranked == ["nsgs:max_iter=1", "lemke", "nsgs"], ranked
    assert "t_total_s" not in told["candidates"][0] and told["nearest"][0]["near"] == "slide"
    seen = run_json(*call, "--measure", 2)["candidates"]
    assert [c["solver"] for c in seen] == ["lemke", "nsgs", "nsgs:max_iter=1"], seen
    assert seen[0]["promised"] and seen[0]["err_estimate"] <= 0.01 and seen[0]["t_total_s"] > 0
    assert not seen[2]["promised"] and "t_total_s" not in seen[1], seen
    again = run_json(*shlex.split(seen[0]["command"])[1:], code=None)
    assert again["error"]["err_estimate"] == seen[0]["err_estimate"]
    assert run_json(*call, "--measure", 1, code=3)["candidates"][-1]["solver"] == ranked[0]
    one_line_error("choose", "slide", names=["--error"])
    one_line_error(*call, "--measure", -1, names=["--measure"])


def measured_rows_are_read(d):
    """scripts/bench_error on two scenes: the program chooses from its rows."""
    if SANITIZED:
        raise Skip("more than a thousand runs of the program, and a table made by Python")
    done = subprocess.run(
        [TESTS.parent / "scripts" / "bench_error", "--out", d, "--limit", "2", "impact", "ledge"],
        env=dict(os.environ, LCPBENCH=LCPBENCH),
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )
    told = re.search(r"^scenes promised by the choice +(\d.*)$", done.stdout, re.MULTILINE)
    assert told and told[1].split() == ["2"] * 4, done.stdout
    o, tried = chosen("impact", d, error=0.01)
    assert o["choice"]["scenes"] == 2 and o["choice"]["nearest"][0]["near"] == "impact"
    kept = [r.split("\t") for r in (d / "choices.tsv").read_text().splitlines()[1:]]
    mine = [r[2:4] for r in kept if r[0] == "impact" and r[1] == "0.01" and r[4] == "1"]
    assert [tried[0]["formulation"], tried[0]["solver"]] in mine, (tried, mine)
    table = [r.split("\t") for r in (d / "table.tsv").read_text().splitlines()]
    assert len(table) == 9 and table[0][:2] == ["problem", "error"], table
    assert (d / "figure.svg").read_text().rstrip().endswith("</svg>")


def bad_rows_are_named(d):
    x = features("slide")
    good = row("slide", 0.1, QUICK, 1, 0.01, x)
    call = ("simulate", "slide", "--error", 0.1, "--rows")
    one_line_error(*call, d / "none.tsv", names=[d / "none.tsv"])
    one_line_error(*call, d, names=["choices.tsv"])
    one_line_error(*call, write(d / "empty.tsv", []), names=["empty.tsv"])
    one_line_error(*call, write(d / "head.tsv", [good], HEAD[1:]), names=["head.tsv", "problem"])
    for i, text in ((1, "0"), (1, "x"), (4, "2"), (5, "-1"), (6, "nan")):
        bad = write(d / "bad.tsv", [good, [*good[:i], text, *good[i + 1 :]]])
        one_line_error(*call, bad, names=["bad.tsv", "line 3"])
    one_line_error(*call, write(d / "short.tsv", [good[:-1]]), names=["short.tsv", "line 2"])
    lost = write(d / "lost.tsv", [row("slide", 0.1, QUICK, 0, 0.01, x)])
    one_line_error(*call, lost, names=["lost.tsv", "no combination"])
    many = [row("slide", 10.0 ** (-k / 20), QUICK, 1, 0.01, x) for k in range(65)]
    one_line_error(*call, write(d / "many.tsv", many), names=["many.tsv", "64 errors of slide"])
    none = write(d / "unknown.tsv", [row("slide", 0.1, ("nosuch", "lemke"), 1, 0.01, x)])
    one_line_error(*call, none, names=["nosuch"])
    whole = ("--formulation", QUICK[0], "--solver", QUICK[1])
    one_line_error(*call, lost, *whole, names=["--rows"])
    one_line_error("simulate", "slide", "--error", 0.1, *whole[:2], names=["--solver"])
    one_line_error("simulate", "slide", "--error", 0.1, *whole[2:], names=["--formulation"])


tap(
    [
        the_nearest_scene_decides,
        who_did_not_keep_the_error_is_not_taken,
        one_row_does_not_turn_several,
        flat_cones_come_last_in_space,
        bristles_come_last_under_loads_that_vary,
        what_cannot_run_gives_way,
        a_proof_says_more_than_a_failure,
        the_command_told_repeats_the_run,
        the_program_comes_with_rows,
        choose_predicts_and_measures,
        measured_rows_are_read,
        bad_rows_are_named,
    ]
)

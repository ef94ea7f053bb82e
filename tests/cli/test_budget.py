"""`run --budget`: the order keeps every axis wherever it is cut, the clock cuts it, the next call
goes on, and what was left out is told."""

import collections
import csv
import itertools
import json
import random
import re
import shlex
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
    fewer,
    one_line_error,
    rows,
    run,
    tap,
)

CAMPAIGNS = ["claims", "moving"]  # one code makes all plans: sanitized these are enough
if not SANITIZED:
    CAMPAIGNS += ["scaling", "warmstart", "paper", "effects", "families", "library", "accuracy"]
NAMED = ("problem", "--formulation", "--solver")
TIMED = """
name: timed
seed: 5
limits: {time: 10s, grace: 0.2s}
sampling: {processes: 2, samples: 2, max_samples: 2, inner: 0.0001s}
parts:
  - name: a
    problems: ["%s/*.M.mtx"]
    solvers: ["faulty_steady:seconds={0.02,0.03,0.04,0.05}"]
    quick: {solvers: ["faulty_steady:seconds=0.04"]}
"""


def cell(line):
    """(id, part, {axis: value}) of a line of the plan; the limit told to a solver is no axis."""
    head, command = line.split(" lcpbench ", 1)
    _, name, part = head.split(" ", 2)
    words = shlex.split(command)
    value = {
        "problem": words[1],
        "verb": words[0],
        **dict(zip(*[iter(words[2:])] * 2, strict=True)),
    }
    value.pop("--plugin", None)
    value["--solver"] = re.sub(r"[:,]max_seconds=[^,]*$", "", value["--solver"])
    return name, part, value


def order(which, *words):
    words = ("--dry-run", "--out", "none", *words)
    done = run("run", which, *words, cwd=TESTS.parent, timeout=500)
    return [cell(x) for x in done.stdout.splitlines() if x.startswith(("todo ", "done "))]


def key(one):
    return one[1], tuple(sorted(one[2].items()))


def values(one, axes):
    """Part, values, and the names without options."""
    _, part, value = one
    yield (part,)
    for axis in axes:
        yield part, axis, value.get(axis)
    for axis in NAMED:
        yield part, axis, "name", value.get(axis, "").split(":")[0]


def pairs(one, axes):
    for a, b in itertools.combinations(axes, 2):
        yield one[1], a, one[2].get(a), b, one[2].get(b)


def keeps(cells, axes, known=(), greedy=False):
    """Each cell brings a value that none before it has, until all are there; then a pair, until all
    are there; the rest brings nothing. greedy: and none that comes later would bring more."""
    covered = set(known)
    sizes = []
    at = 0
    for brings in (values, pairs):
        left = set().union(*(brings(c, axes) for c in cells)) - covered if cells else set()
        first = at
        while left:
            new = set(brings(cells[at], axes)) - covered
            assert new, (cells[at], "brings nothing", len(left))
            if greedy:
                most = max(len(set(brings(c, axes)) - covered) for c in cells[at:])
                assert len(new) == most, (cells[at], len(new), most)
            for every in (values, pairs):
                covered.update(every(cells[at], axes))
            left -= new
            at += 1
        sizes.append(at - first)
    return covered, (*sizes, len(cells) - at)


def check_order(which, *words, greedy=False):
    found = order(which, "--budget", "1h", *words)
    whole = order(which)
    assert sorted(found, key=key) == sorted(whole, key=key) and found != whole
    axes = sorted({a for c in found for a in c[2]})
    quick = {key(c) for c in order(which, "--quick")}
    n = sum(key(c) in quick for c in found)
    assert n == len(quick), (which, "the quick form is a part of the full one", n, len(quick))
    assert all(key(c) in quick for c in found[:n]), "the quick form comes first"
    covered, of_quick = keeps(found[:n], axes, greedy=greedy)
    _, rest = keeps(found[n:], axes, covered, greedy=greedy)
    return found, of_quick, rest


def any_prefix_keeps_every_axis(d):
    """On the real campaigns, with and without a forecast. Beyond the quick form, all values of all
    axes stand in the first cells, at most one for each value."""
    for which in CAMPAIGNS:
        like = TESTS.parent / "results/reference" / which
        found, of_quick, rest = check_order(which, "--like", like)
        assert sum(rest[:2]) < len(found), which
        print(f"# {which}: quick {of_quick}, then {rest} cells for values, pairs, nothing new")


def the_quick_form_is_a_part_of_the_full_one(d):
    """So a cut full form with all cells that the quick form names tells all that the quick one
    tells. Here the campaigns whose order is not checked above."""
    if SANITIZED:
        raise Skip("plans of twenty thousand cells: the other run reads them")
    names = {f.stem for f in (TESTS.parent / "harness/campaigns").glob("*.yaml")}
    assert set(CAMPAIGNS) < names
    for which in sorted(names - set(CAMPAIGNS)):
        over = {key(c) for c in order(which, "--quick")} - {key(c) for c in order(which)}
        assert not over, (which, len(over), min(over))


def each_cell_brings_the_most(d):
    for which in fewer(("moving", "scaling")):
        check_order(which, greedy=True)


def the_order_is_one(d):
    """The rows of the run itself do not change it, nor does the machine."""
    c = campaign(d, TIMED % d)
    for n in (2, 3):
        diagonal(d, n)
    first = plan_of(c, d / "o")
    run("run", c, "--out", d / "o", "--quiet", "--filter", "solver=*0.03", exe=FAULTY)
    assert plan_of(c, d / "o") == first


def plan_of(c, out):
    done = run("run", c, "--dry-run", "--budget", "9s", "--out", out, exe=FAULTY)
    return [cell(x)[0] for x in done.stdout.splitlines() if x.startswith(("todo ", "done "))]


def wrong_forecasts_cost_no_value(d):
    """Rows that foretell refusals, deaths and hours at random: values and pairs come as early."""
    rng = random.Random(3)
    (d / "like").mkdir()
    run("run", "smoke", "--quick", "--out", d / "small", "--quiet", "--filter", "solver=lemke")
    known = rows(d / "small")[0]
    with open(d / "like/results.csv", "w", newline="") as to:
        out = csv.DictWriter(to, list(known), lineterminator="\n")
        out.writeheader()
        for i, (_, part, value) in enumerate(order("claims")):
            status, seconds = rng.choice(
                [("ok", 1e-6), ("ok", 3e3), ("unsupported", ""), ("timeout", "")]
            )
            out.writerow(
                {
                    **known,
                    "campaign": "claims",
                    "part": part,
                    "problem": value["problem"],
                    "formulation": value.get("--formulation", "").split(":")[0],
                    "solver": value["--solver"].split(":")[0],
                    "status": status,
                    "t_total_s": seconds,
                    "t_limit_s": 10,
                    "cell_id": f"{i:016x}",
                }
            )
    found, _, _ = check_order("claims", "--like", d / "like")
    assert found != order("claims", "--budget", "1h"), "the planted rows were not asked"


def counted(out):
    return collections.Counter((r["cell_id"], r["process"], r["rep"]) for r in rows(out))


def small_campaign(d):
    """The campaign, and what all of it takes on this machine [s]: 3, of which budgets are parts."""
    c = campaign(d, TIMED % d)
    for n in (2, 3, 4):
        diagonal(d, n)
    began = time.monotonic()
    run("run", c, "--out", d / "whole", "--quiet", exe=FAULTY)
    return c, time.monotonic() - began


def left_of(out):
    return json.loads((out / "manifest.json").read_text()).get("cut")


def a_cut_run_goes_on(d):
    """Exit 4 and a prefix of the order as often as the budget is spent, then 0; nothing twice,
    manifest and status tell each time what is there and what is not."""
    c, seconds = small_campaign(d)
    budget = f"{seconds / 6:.3f}s"
    whole = counted(d / "whole")
    assert left_of(d / "whole") is None and "cut" not in run("status", d / "whole").stdout
    plan = plan_of(c, d / "o")
    codes = []
    seen = 0
    while not codes or codes[-1] == 4:
        done = run("run", c, "--out", d / "o", "--quiet", "--budget", budget, exe=FAULTY, code=None)
        codes.append(done.returncode)
        cells = list(dict.fromkeys(r["cell_id"] for r in rows(d / "o")))
        assert cells == plan[: len(cells)] and len(cells) >= seen, "not a prefix of the order"
        seen = len(cells)
        cut = left_of(d / "o")
        if codes[-1] == 4:
            assert re.search(r"cut: \d+ processes are left; a later run goes on", done.stdout)
            assert cut["cells"] == 12 and cut["measured"] + cut["begun"] == seen < 12 + cut["begun"]
            assert sum(a for a, _ in cut["stages"].values()) == cut["measured"]
            assert cut["stages"]["quick"][1] == 3 and cut["parts"]["a"] == [cut["measured"], 12]
            told = run("status", d / "o").stdout
            assert f"cut: {seen} of 12 cells have rows" in told, told
            assert f"left of part a: {12 - cut['measured']} of 12 cells" in told, told
            if 0 < cut["measured"] <= 3:
                assert "without a cell, a, solvers: faulty_steady:seconds=0.02 " in told, told
    assert codes[-1] == 0 and len(codes) > 2 and set(codes[:-1]) == {4}, codes
    assert cut is None and counted(d / "o") == whole
    run("run", c, "--out", d / "o", "--quiet", exe=FAULTY)
    assert counted(d / "o") == whole


def a_stage_can_be_the_last(d):
    """Whatever time there is: the quick form's cells, and the values of all axes, and no other."""
    c, _ = small_campaign(d)
    plan = plan_of(c, d / "none")
    words = ("run", c, "--out", d / "o", "--quiet", "--budget", "1h")
    for stage, n in (("quick", 3), ("values", 6), ("values", 6)):
        run(*words, "--stage", stage, exe=FAULTY, code=4)
        assert list(dict.fromkeys(r["cell_id"] for r in rows(d / "o"))) == plan[:n], stage
    assert left_of(d / "o")["stages"] == {"quick": [3, 3], "values": [3, 3], "pairs": [0, 6]}
    run(*words, "--stage", "rest", exe=FAULTY)
    assert counted(d / "o") == counted(d / "whole")


def rows_of_another_order_stay(d):
    """What was measured in the plan's own order is not measured again, and a run without a budget
    takes what a cut one left."""
    c, seconds = small_campaign(d)
    run("run", c, "--out", d / "o", "--quiet", "--filter", "solver=*0.03", exe=FAULTY)
    before = rows(d / "o")
    assert json.loads((d / "o/manifest.json").read_text())["filters"] == ["solver=*0.03"]
    words = ("run", c, "--out", d / "o", "--quiet", "--budget", f"{seconds / 8:.3f}s")
    run(*words, exe=FAULTY, code=4)
    assert rows(d / "o")[: len(before)] == before and len(rows(d / "o")) > len(before)
    middle = rows(d / "o")
    run("run", c, "--out", d / "o", "--quiet", exe=FAULTY)
    stay = [(r["cell_id"], r["process"], r["rep"], r["t_solve_s"]) for r in rows(d / "o")]
    assert stay[: len(middle)] == [
        (r["cell_id"], r["process"], r["rep"], r["t_solve_s"]) for r in middle
    ]
    assert left_of(d / "o") is None and counted(d / "o") == counted(d / "whole")


def killed_it_goes_on(d):
    """SIGKILL at random moments of runs with a budget: what is there is a prefix of the order."""
    c, seconds = small_campaign(d)
    words = ("run", c, "--out", d / "o", "--quiet", "--budget", f"{seconds / 5:.3f}s")
    plan = plan_of(c, d / "o")
    rng = random.Random(11)
    hits = 0
    code = None
    while code != 0:
        p = subprocess.Popen(
            [FAULTY, *map(str, words)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        time.sleep(seconds * rng.uniform(1 / 60, 1 / 10))
        p.send_signal(signal.SIGKILL)
        code = p.wait()
        hits += code == -signal.SIGKILL
        if (d / "o/results.csv").exists() and hits >= 5:
            code = run(*words, exe=FAULTY, code=None).returncode
            assert code in (0, 4)
            cells = list(dict.fromkeys(r["cell_id"] for r in rows(d / "o")))
            assert cells == plan[: len(cells)]
    assert hits >= 5 and counted(d / "o") == counted(d / "whole")


def the_dry_run_says_how_far_it_gets(d):
    """A budget between nothing and all: the cells that the forecast lets it reach, by stage."""
    c, _ = small_campaign(d)
    words = ("run", c, "--dry-run", "--out", d / "none", "--like", d / "whole", "--budget")
    form = r"a budget of \d+ s reaches about (\d+) of 12 cells: (\d+) of 3 by quick, .*"

    def told(budget):
        lines = run(*words, budget, exe=FAULTY).stdout.splitlines()
        whole = float(re.search(r"\((\S+) s by earlier rows", lines[-1])[1])
        return *map(int, re.fullmatch(form, lines[-2]).groups()), whole

    assert told("1h")[:2] == (12, 3) and told("0.0001s")[:2] == (0, 0)
    half = told(f"{told('1h')[2] / 2:.6f}s")
    assert 3 <= half[0] < 12, half


def nonsense_is_refused(d):
    one_line_error("run", "smoke", "--budget", "0", names=["--budget", "above 0"])
    one_line_error("run", "smoke", "--budget", "soon", names=["--budget", "soon"])
    one_line_error("run", "smoke", "--stage", "rest", names=["--stage", "--budget"])
    one_line_error("run", "smoke", "--budget", "9s", "--stage", "all", names=["all", "pairs"])
    one_line_error(
        "run", "smoke", "--budget", "9s", "--rerun", "all", names=["--rerun", "--budget"]
    )


tap(
    [
        any_prefix_keeps_every_axis,
        the_quick_form_is_a_part_of_the_full_one,
        each_cell_brings_the_most,
        the_order_is_one,
        wrong_forecasts_cost_no_value,
        a_cut_run_goes_on,
        a_stage_can_be_the_last,
        rows_of_another_order_stay,
        killed_it_goes_on,
        the_dry_run_says_how_far_it_gets,
        nonsense_is_refused,
    ]
)

"""bench_peers [--quick] [--rows] [--write] [--out DIR] - all solvers and all peers, one table.

A campaign asks every solver that takes rows z >= 0 for tol = 1e-8; whoever claims an answer with
rho > 1e-8 is asked again for 1e-10, then 1e-12. The time of a solver on a problem is set-up,
factorisation and solve, the least of its samples, at the first tolerance with rho <= 1e-8 by the
judge; it is a failure where none is. A false claim is an answer claimed at 1e-8 with rho > 1e-6.
Means are shifted geometric means, failures charged the time limit. Peers are those of
LCPBENCH_PLUGINS, or of scripts/peers, and what the build has, with the other settings of
experiments.toml; a library that tests nothing is taken at its word (claim=library). The problems
are those of the campaigns `library` (its contacts) and `families`.

Each group of the table ends with a referee: the faster of the best solver here and the best peer,
and whether it stays so under other shifts, other charges, and on the larger problems alone.
Rows: DIR (results/runs/bench_peers), --rows only reads them. A full run writes its table into
peers/README.md and who leads into README.md, a quick one with --write.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import os
import pathlib
import re
import statistics
import subprocess
import sys
from collections import defaultdict
from typing import NamedTuple

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from bench import experiments, stats  # noqa: E402
from bench.binary import LCPBENCH, ROOT, ask  # noqa: E402

RHO = 1e-8
FALSE = 1e-6
GROSS = 1e-3  # no tolerance makes this an answer
TOLERANCES = (1e-8, 1e-10, 1e-12)
SHIFT = 1e-3  # s
SHIFTS = (1e-4, 1e-3, 1e-2)
CHARGES = (1.0, 10.0)
LARGE = 100  # rows of a larger problem
PARTS = {"contact": "library", "families": "families"}  # of which campaign
LIMIT = {False: 5, True: 1}  # s a process; quick
BELIEVED = "claim=checked|library"
BEGIN, END = "<!-- begin: scripts/bench_peers -->\n", "<!-- end: scripts/bench_peers -->\n"
TABLE, SHORT = ROOT / "peers" / "README.md", ROOT / "README.md"


class Key(NamedTuple):
    part: str
    problem: str
    solver: str


class Found(NamedTuple):
    """What became of a solver on a problem."""

    time: float  # s, inf: failed
    false: float  # rho of a false claim, else 0
    taken: bool


Cells = dict[Key, Found]


def plugins() -> None:
    """Sets LCPBENCH_PLUGINS where it is not set."""
    if not os.environ.get("LCPBENCH_PLUGINS"):
        done = subprocess.run(
            [ROOT / "scripts" / "peers", "--list"], capture_output=True, text=True, check=True
        )
        os.environ["LCPBENCH_PLUGINS"] = done.stdout.strip()


def problems_of(part: str, quick: bool) -> list[str]:
    """The problems of a part of a shipped campaign, in its full or its quick form."""
    file = ROOT / "harness" / "campaigns" / f"{PARTS[part]}.yaml"
    block = re.search(rf"- name: {part}\n((?:    .*\n)+)", file.read_text(encoding="utf-8"))
    found = re.findall(r"problems: (\[.*\])", block[1] if block else "")
    if len(found) != 2:
        sys.exit(f"bench_peers: {file}: need the problems of part {part}, full and quick")
    return json.loads(found[quick])


def solvers() -> tuple[dict[str, str], dict[str, bool]]:
    """Of each solver and each other setting by its name here: what a campaign calls it, and whether
    it is a peer."""
    words, peers = {}, {}
    for s in ask("list", "solvers", "--format", "json"):
        if "orthant" in s["sets"]:
            words[s["name"]] = s["name"] + (":claim=library" if BELIEVED in s["options"] else "")
            peers[s["name"]] = s["peer"]
    for variant in experiments.of("bench_peers.variants"):
        if variant.split(":")[0] in words:
            words[variant], peers[variant] = variant, True
    return words, peers


def campaign(name: str, tol: float, limit: float, parts: list[dict]) -> str:
    """The text of a campaign file; JSON is YAML."""
    sampling = {"processes": 1, "samples": 3, "max_samples": 5, "budget": "0.5s"}
    return json.dumps(
        {
            "name": name,
            "limits": {"time": f"{limit}s", "memory": "4G", "grace": "0.5s"},
            "sampling": sampling | {"inner": "0.001s", "order": "abba"},
            "solutions": "off",
            "parts": [p | {"tolerances": [tol]} for p in parts],
        },
        indent=1,
    )


def measure(out: pathlib.Path, name: str, text: str) -> None:
    out.mkdir(parents=True, exist_ok=True)
    file = out / f"{name}.yaml"
    file.write_text(text)
    done = subprocess.run(
        [LCPBENCH, "run", file, "--out", out / name], cwd=ROOT, check=False, stdout=sys.stderr
    )
    if done.returncode not in (0, 3):
        sys.exit(f"bench_peers: lcpbench run {file}: exit {done.returncode}")


def name_of(row: dict) -> str:
    """The solver, or which other setting of it."""
    given = set(row["solver_options"].split(","))
    for variant in experiments.of("bench_peers.variants"):
        name, _, options = variant.partition(":")
        if row["solver"] == name and set(options.split(",")) <= given:
            return variant
    return row["solver"]


def read(folder: pathlib.Path) -> dict[Key, list[dict]]:
    found = defaultdict(list)
    if (folder / "results.csv").exists():
        with (folder / "results.csv").open(newline="", encoding="utf-8") as f:
            for row in csv.DictReader(f):
                found[Key(row["part"], row["problem"], name_of(row))].append(row)
    return found


def number(row: dict, name: str) -> float:
    return float(row[name]) if row[name] else math.nan


def claimed(rows: list[dict]) -> bool:
    return all(r["status_claimed"] == "ok" for r in rows)


def reached(rows: list[dict]) -> bool:
    return bool(rows) and claimed(rows) and all(number(r, "rho") <= RHO for r in rows)


def took(rows: list[dict]) -> float:
    parts = ("t_setup_s", "t_factor_s", "t_solve_s")
    return min(sum(number(r, p) for p in parts) for r in rows)


def again(rows: dict[Key, list[dict]], words: dict[str, str]) -> list[dict]:
    """The parts of the next campaign: who claimed an answer that is not good enough."""
    asked = defaultdict(list)
    for key, cell in rows.items():
        if claimed(cell) and not reached(cell):
            asked[key.part, key.problem].append(words[key.solver])
    return [
        {"name": f"{part}_{i}", "problems": [problem], "solvers": sorted(who)}
        for i, ((part, problem), who) in enumerate(sorted(asked.items()))
    ]


def run(out: pathlib.Path, plan: dict, words: dict[str, str]) -> None:
    """Three campaigns, one for each tolerance."""
    parts = [
        {"name": p, "problems": problems_of(p, plan["quick"]), "solvers": sorted(words.values())}
        for p in PARTS
    ]
    for tol in TOLERANCES:
        if not parts:
            return
        name = f"tol_{tol:.0e}"
        measure(out, name, campaign(name, tol, plan["limit"], parts))
        parts = again(read(out / name), words)


def cells(out: pathlib.Path) -> Cells:
    """What became of each solver on each problem, over the tolerances."""
    found: Cells = {}
    for tol in TOLERANCES:
        for key, rows in read(out / f"tol_{tol:.0e}").items():
            key = key._replace(part=key.part.split("_")[0])
            if key not in found:
                worst = max((number(r, "rho") for r in rows), key=lambda x: (math.isnan(x), x))
                false = 0.0 if worst <= FALSE or not claimed(rows) else worst
                taken = any(r["status"] != "unsupported" for r in rows)
                found[key] = Found(math.inf, false, taken)
            if math.isinf(found[key].time) and reached(rows):
                found[key] = found[key]._replace(time=took(rows))
    return found


def problems(out: pathlib.Path) -> dict[tuple[str, str], tuple[str, int]]:
    """(part, problem): its group, and its rows. Not symmetric is what a solver says that needs
    it."""
    groups: dict[tuple[str, str], tuple[str, int]] = {}
    for key, rows in read(out / f"tol_{TOLERANCES[0]:.0e}").items():
        old = groups.get((key.part, key.problem), ("symmetric", 0))
        sizes = [int(float(r["lcp_dim"])) for r in rows if r["lcp_dim"]]
        kind = "other" if any("known to be symmetric" in r["note"] for r in rows) else old[0]
        groups[key.part, key.problem] = (kind, max([old[1], *sizes]))
    return {k: (f"{k[0]}, {kind}", n) for k, (kind, n) in groups.items()}


class Group(NamedTuple):
    title: str
    members: list[tuple[str, str]]
    rows: list[int]


def grouped(kinds: dict[tuple[str, str], tuple[str, int]], found: Cells) -> list[Group]:
    """Of the problems that somebody solves."""
    solved = {(k.part, k.problem) for k, f in found.items() if math.isfinite(f.time)}
    kinds = {k: kind for k, kind in kinds.items() if k in solved}
    names = sorted({g for g, _ in kinds.values()}, key=lambda g: (g[0], g.endswith("other")))
    groups = []
    for name in names:
        members = sorted(k for k, (g, _) in kinds.items() if g == name)
        groups.append(Group(name, members, [kinds[k][1] for k in members]))
    return groups


def times(found: Cells, group: Group, solver: str) -> list[float]:
    """inf for each failure; empty where the solver takes none of the group."""
    got = [found.get(Key(*m, solver), Found(math.inf, 0.0, False)) for m in group.members]
    return [g.time for g in got] if any(g.taken for g in got) else []


def mean(cost: list[float], limit: float, shift: float = SHIFT, charge: float = 1.0) -> float:
    return stats.geometric_mean_shifted(cost, shift, limit, charge)


def told(cost: list[float], limit: float) -> str:
    if not cost:
        return "-"
    solved = sum(math.isfinite(c) for c in cost)
    return f"{solved}" if solved == 0 else f"{solved}, {1e3 * mean(cost, limit):.3g} ms"


def best(costs: dict[str, list[float]], limit: float, shift: float, charge: float) -> str:
    return min(costs, key=lambda s: mean(costs[s], limit, shift, charge))


def plain(x: float, digits: int = 3) -> str:
    """x to so many digits, without an exponent."""
    return f"{float(f'{x:.{digits}g}'):.15g}"


class Lead(NamedTuple):
    """The best solver of ours and the best peer on a group, and the ratio of their times."""

    title: str
    problems: int
    ours: str
    theirs: str
    solved: tuple[int, int]  # ours, theirs
    mean_s: tuple[float, float]
    ratio: float  # theirs over ours
    low: float  # over all settings
    high: float
    settings: int

    def verdict(self) -> str:
        same = (self.low > 1) == (self.high > 1)
        return "holds under every setting" if same else "depends on the setting"

    def words(self) -> str:
        return (
            f"{self.title}: `{self.theirs}`, the best peer, takes {self.ratio:.2g} times the time"
            f" of `{self.ours}` ({self.low:.2g} to {self.high:.2g} over {self.settings} settings;"
            f" who leads {self.verdict()})."
        )

    def row(self) -> str:
        side = [f"{n}, {plain(1e3 * t)} ms" for n, t in zip(self.solved, self.mean_s, strict=True)]
        return (
            f"| {self.title} ({self.problems}) | `{self.ours}`: {side[0]} | `{self.theirs}`:"
            f" {side[1]} | {plain(self.ratio, 2)} [{plain(self.low, 2)}, {plain(self.high, 2)}] |"
        )


def referee(found: Cells, group: Group, peers: dict[str, bool], limit: float) -> Lead | None:
    """Who leads, by what factor, and whether every other setting agrees; None: one side alone."""
    settings = [(s, c, 0) for s in SHIFTS for c in CHARGES]
    if any(n >= LARGE for n in group.rows):
        settings += [(SHIFT, 1.0, LARGE)]
    ratios = []
    for shift, charge, least in settings:
        keep = [i for i, n in enumerate(group.rows) if n >= least]
        costs = {s: times(found, group, s) for s in peers}
        costs = {s: [c[i] for i in keep] for s, c in costs.items() if c}
        sides = [{s: c for s, c in costs.items() if peers[s] == side} for side in (False, True)]
        if not all(sides):
            return None
        ours, theirs = (best(side, limit, shift, charge) for side in sides)
        ratio = mean(costs[theirs], limit, shift, charge) / mean(costs[ours], limit, shift, charge)
        ratios.append((ratio, ours, theirs))
    ratio, ours, theirs = ratios[settings.index((SHIFT, 1.0, 0))]
    cost = [times(found, group, s) for s in (ours, theirs)]
    return Lead(
        title=group.title,
        problems=len(group.members),
        ours=ours,
        theirs=theirs,
        solved=tuple(sum(math.isfinite(t) for t in c) for c in cost),
        mean_s=tuple(mean(c, limit) for c in cost),
        ratio=ratio,
        low=min(r[0] for r in ratios),
        high=max(r[0] for r in ratios),
        settings=len(settings),
    )


def table(found: Cells, groups: list[Group], peers: dict[str, bool], limit: float) -> list[str]:
    heads = [f"{g.title} ({len(g.members)})" for g in groups]
    lines = [
        "| solver | " + " | ".join(heads) + " | false claims |",
        "|---|" + "---|" * (len(heads) + 1),
    ]

    def rank(solver: str) -> float:
        every = [c for g in groups for c in (times(found, g, solver) or [math.inf] * len(g.rows))]
        return -sum(math.isfinite(c) for c in every) + 1e-3 * mean(every, limit)

    for solver in sorted(peers, key=rank):
        cost = [times(found, g, solver) for g in groups]
        if not any(cost):
            continue
        false = sum(f.false != 0 for k, f in found.items() if k.solver == solver)
        name = f"*{solver}*" if peers[solver] else f"`{solver}`"
        lines.append(f"| {name} | {' | '.join(told(c, limit) for c in cost)} | {false} |")
    return lines


class Study(NamedTuple):
    """What the two blocks are written from."""

    groups: list[Group]
    leads: list[Lead]
    measured: str  # by what, where
    left_out: int  # problems that nobody solves


def study(found: Cells, out: pathlib.Path, peers: dict[str, bool], plan: dict) -> Study:
    kinds = problems(out)
    groups = grouped(kinds, found)
    first = out / f"tol_{TOLERANCES[0]:.0e}"
    manifest = json.loads((first / "manifest.json").read_text())
    loads = [number(r, "load1") for rows in read(first).values() for r in rows]
    leads = [referee(found, g, peers, plan["limit"]) for g in groups]
    measured = (
        f"Measured by `scripts/bench_peers{' --quick' if plan['quick'] else ''}`, commit"
        f" {manifest['build']['commit']}, {manifest['machine']['cpu']}, one thread, at a load of"
        f" {statistics.median(loads):.1f}."
    )
    left_out = len(kinds) - sum(len(g.members) for g in groups)
    return Study(groups, [lead for lead in leads if lead], measured, left_out)


def table_words(s: Study, found: Cells, peers: dict[str, bool], limit: float) -> str:
    """The block of peers/README.md."""
    left_out = f" Left out: {s.left_out} problems that nobody solves." if s.left_out else ""
    lies = [f.false for f in found.values() if f.false != 0]
    gross = sum(not rho <= GROSS for rho in lies)
    lines = [
        f"Solved to rho <= {RHO:.0e}, and the shifted geometric mean (shift {1e3 * SHIFT:g} ms) of"
        f" the time, a failure charged {limit:g} s; peers in italics; - where a solver"
        f" takes none of a group.{left_out}",
        "",
        *table(found, s.groups, peers, limit),
        "",
        *(f"- {lead.words()}" for lead in s.leads),
        f"- False claims: {len(lies)}, {gross} of them with rho > {GROSS:.0e} or no number.",
        "",
        f"{s.measured} Settings of the referee: shifts of"
        f" {', '.join(f'{1e3 * shift:g}' for shift in SHIFTS)} ms, failures charged"
        f" {' and '.join(f'{c:g}' for c in CHARGES)} times the limit, and the problems of at least"
        f" {LARGE} rows alone.",
    ]
    return "\n".join(lines) + "\n"


def short_words(s: Study, found: Cells, peers: dict[str, bool], limit: float) -> str:
    """The block of README.md."""
    false = [
        sum(f.false != 0 for k, f in found.items() if peers[k.solver] is side)
        for side in (False, True)
    ]
    lines = [
        "| problems | the best of ours: solved, time | the best peer: solved, time |"
        " factor [over all settings] |",
        "|---|---|---|---|",
        *(lead.row() for lead in s.leads),
        "",
        f"Solved to rho <= {RHO:.0e}; shifted geometric means, a failure charged {limit:g} s. False"
        f" claims: {false[0]} of ours, {false[1]} of theirs. {s.measured}",
    ]
    return "\n".join(lines) + "\n"


def write(file: pathlib.Path, text: str) -> None:
    """The block of a file between its markers."""
    old = file.read_text(encoding="utf-8")
    if BEGIN not in old or END not in old:
        sys.exit(f"bench_peers: {file}: its markers are gone")
    before, rest = old.split(BEGIN)
    file.write_text(before + BEGIN + text + END + rest.split(END)[1], encoding="utf-8")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("--quick", action="store_true", help="fewer and smaller problems")
    parser.add_argument("--rows", action="store_true", help="measures nothing, reads the rows")
    parser.add_argument("--write", action="store_true", help="writes the table of a quick run")
    parser.add_argument("--out", type=pathlib.Path, help="results/runs/bench_peers where absent")
    args = parser.parse_args()
    plan = {"limit": LIMIT[args.quick], "quick": args.quick}
    name = "bench_peers_quick" if args.quick else "bench_peers"
    out = (args.out or ROOT / "results" / "runs" / name).resolve()
    plugins()
    words, peers = solvers()
    if not any(peers.values()):
        print("bench_peers: no peers: scripts/peers builds them", file=sys.stderr)
        return 2
    if not args.rows:
        run(out, plan, words)
    found = cells(out)
    if not found:
        sys.exit(f"bench_peers: no rows in {out}")
    what = study(found, out, peers, plan)
    text = table_words(what, found, peers, plan["limit"])
    print(text)
    if args.write or not args.quick:
        write(TABLE, text)
        write(SHORT, short_words(what, found, peers, plan["limit"]))
    return 0


if __name__ == "__main__":
    sys.exit(main())

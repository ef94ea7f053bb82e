"""The table that the paper draws, unknowns and time by formulation, from one box to a hundred
thousand contacts (scripts/bench_size --claim)."""

from __future__ import annotations

import statistics
from typing import NamedTuple

from bench import growth

FROM = ("previous", "cold")
HEAD = (
    "| scene | contacts | formulation | unknowns | from the last step [ms] | by |"
    " from nothing [ms] | by | unknowns of the first over these | its time over this, from the last"
    " step | from nothing |"
)


class Cost(NamedTuple):
    told: dict
    step: float  # of one step [s]: median,
    low: float  # least
    high: float  # and most
    run: float  # of the longest run [s]


class Kind(NamedTuple):
    formulation: str
    unknowns: int
    contacts: int
    fastest: dict[str, tuple[Cost, str]]  # by start: and by which solver


def solved(told: dict) -> bool:
    return told["status"] == "ok" and bool(told["verified"])


def cost(asked: dict, scene: str, way: tuple[str, str], steps: int, start: str, reps: int) -> Cost:
    """Median, least and most of so many runs. From the last step: without the first two, of which
    nothing was known before."""
    times, longest, told = [], 0.0, {}
    before = 2 if start == "previous" else 0
    for _ in range(reps):
        short = 0.0
        if before > 0:
            short = growth.run(scene, way, asked["step"], before, start=start)["t_total_s"]
        told = growth.run(scene, way, asked["step"], before + steps, start=start)
        times.append((told["t_total_s"] - short) / steps)
        longest = max(longest, told["t_total_s"])
        if not solved(told) or longest > asked["most"]:
            break
    return Cost(told, statistics.median(times), min(times), max(times), longest)


def measured(asked: dict, entry: dict, way: dict, reps: int) -> Kind | None:
    """By its fastest verified solver; the others are told. A solver that did not solve the scene,
    or took more than asked["most"] seconds for a run, is not asked again."""
    fastest: dict[str, tuple[Cost, str]] = {}
    unknowns = contacts = 0
    for solver in tuple(way["solvers"]):
        for start in FROM:
            c = cost(
                asked, entry["scene"], (way["formulation"], solver), entry["steps"], start, reps
            )
            if not solved(c.told):
                words = f"{c.told['status']} by `{solver}`, start {start}"
                print(f"| `{entry['scene']}` | | `{way['formulation']}` | | {words} |" + " |" * 6)
            elif c.low > 0:  # else it is below what the difference of two runs tells
                unknowns, contacts = c.told["lcp_dim_max"], c.told["n_active_max"]
                if start not in fastest or c.step < fastest[start][0].step:
                    fastest[start] = (c, solver)
            if (not solved(c.told) or c.run > asked["most"]) and solver in way["solvers"]:
                way["solvers"].remove(solver)
    return Kind(way["formulation"], unknowns, contacts, fastest) if unknowns > 0 else None


def ratio(first: Kind, kind: Kind, start: str) -> str:
    """Of the times of a step; none where one was not solved, or is below what the clock tells."""
    if start not in first.fastest or start not in kind.fastest:
        return ""
    one, other = first.fastest[start][0].step, kind.fastest[start][0].step
    return f"{one / other:.2g}" if min(one, other) > 0 else ""


def line(scene: str, first: Kind | None, kind: Kind) -> str:
    words = [f"`{scene}`", str(kind.contacts), f"`{kind.formulation}`", str(kind.unknowns)]
    for start in FROM:
        if start not in kind.fastest:
            words += ["", ""]
            continue
        c, by = kind.fastest[start]
        step, low, high = (f"{1e3 * t:.3g}" for t in (c.step, c.low, c.high))
        words += [f"{step} [{low}, {high}]", f"`{by}`"]
    if first is None or first is kind:
        words += ["", "", ""]
    else:
        words.append(f"{first.unknowns / kind.unknowns:.3g}")
        words += [ratio(first, kind, start) for start in FROM]
    return f"| {' | '.join(words)} |"


def table(asked: dict, reps: int, quick: bool) -> None:
    """Prints it. The first formulation is the one that the others are compared with."""
    print(HEAD)
    print("|---" * HEAD.count(" |") + "|", flush=True)
    for scenes in asked["families"]:
        ways = [way | {"solvers": list(way["solvers"])} for way in asked["ways"]]
        for entry in scenes[: asked["few"] if quick else None]:
            first = None
            for k, way in enumerate(ways):
                kind = measured(asked, entry, way, reps)
                first = kind if k == 0 else first
                if kind is not None:
                    print(line(entry["scene"], first, kind), flush=True)

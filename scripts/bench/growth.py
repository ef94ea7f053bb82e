"""A scene that grows: what a step and a contact cost, and by which power of the size
(scripts/bench_size --growth)."""

from __future__ import annotations

import collections
import math
import os
import statistics
from typing import NamedTuple

from bench import experiments
from bench.binary import simulate

MEMORY = ("usual", "least")
HEAD = (
    "| scene | contacts | way | unknowns | rho | a warm step [s] | all steps [s] | power |"
    " from the smallest | kB a contact | with `--memory least` | time then |"
)


class Cost(NamedTuple):
    told: dict
    warm: float  # of a step behind the first two [s]
    whole: float  # of all steps [s]
    memory: float  # [B]


def contacts(c: Cost) -> int:
    return c.told["n_active_max"]


def run(
    scene: str,
    way: tuple[str, str],
    step: float,
    steps: int,
    memory: str = "usual",
    start: str = "previous",
) -> dict:
    core = os.environ.get("CORE", str(max(os.sched_getaffinity(0))))
    return simulate(
        scene,
        *way,
        *("--step", step, "--duration", step * steps, "--start", start, "--memory", memory),
        before=("taskset", "-c", core),
    )


def cost(asked: dict, scene: str, way: tuple[str, str], reps: int, memory: str) -> Cost:
    """Medians of so many runs; of the memory the largest."""
    warm, whole, most, told = [], [], 0.0, {}
    for _ in range(reps):
        short = run(scene, way, asked["step"], 2, memory)
        told = run(scene, way, asked["step"], 2 + asked["steps"], memory)
        warm.append((told["t_total_s"] - short["t_total_s"]) / asked["steps"])
        whole.append(told["t_total_s"])
        most = max(most, told["rss_peak_B"])
        if told["status"] != "ok" or not told["verified"]:
            break
    return Cost(told, statistics.median(warm), statistics.median(whole), most)


def power(smaller: list[Cost], large: Cost) -> str:
    """Of the number of contacts, by which all steps grew from the smaller scene on, if any."""
    return "".join(
        f"{math.log(large.whole / c.whole) / math.log(contacts(large) / contacts(c)):.2f}"
        for c in smaller
    )


def line(scene: str, way: tuple[str, str], smaller: list[Cost], of: dict, base: float) -> str:
    usual, least = (of[m] for m in MEMORY)
    told, n = usual.told, contacts(usual)
    words = f"| `{scene}` | {n} | `{way[0]} + {way[1]}` | {told['lcp_dim_max']} |"
    if told["status"] != "ok" or not told["verified"]:
        return f"{words} {told['status']} | | | | | | | |"
    kB = [(of[m].memory - base) / 1024 / n for m in MEMORY]
    powers = f"{power(smaller[-1:], usual)} | {power(smaller[:1], usual)}"
    return (
        f"{words} {told['rho_max']:.0e} | {usual.warm:.3g} | {usual.whole:.3g} | {powers} |"
        f" {kB[0]:.2f} | {kB[1]:.2f} | {least.whole / usual.whole:.2f} |"
    )


def table(asked: dict, reps: int, quick: bool) -> bool:
    """Prints it; are all runs solved and verified?"""
    one = asked["nothing"]
    alone = run(one["scene"], experiments.way(one), asked["step"], 2, "usual")["rss_peak_B"]
    print(f"A run of one box: {alone / 2**20:.1f} MB.\n\n{HEAD}")
    print("|---" * HEAD.count(" |") + "|", flush=True)
    good, smaller = True, collections.defaultdict(list)
    for scene in asked["scenes"][: 2 if quick else None]:
        huge = scene in asked["scenes"][asked["often"] :]
        for way in map(experiments.way, asked["ways"][: asked["first"] if huge else None]):
            of = {m: cost(asked, scene, way, 1 if huge else reps, m) for m in MEMORY}
            print(line(scene, way, smaller[way], of, alone), flush=True)
            good &= all(c.told["status"] == "ok" and c.told["verified"] for c in of.values())
            smaller[way].append(of["usual"])
    return good

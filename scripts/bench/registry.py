"""What there is, as `lcpbench list` tells it: the only way by which scripts learn of components.

A component's name, words, situation and traits stand in its C constant (CONTRIBUTING.md). Its place
in the registry gives it a colour and a marker (style.py). Rows may hold names that this build does
not know: they have no words, and the neutral look.
"""

from __future__ import annotations

import functools

from bench import binary


@functools.cache
def listed(kind: str) -> dict[str, dict]:
    """The components of a kind by name, in the order of the registry."""
    return {c["name"]: c for c in binary.listed(kind)}


def formulations() -> list[str]:
    return list(listed("formulations"))


def solvers() -> list[str]:
    return list(listed("solvers"))


def scenes() -> dict[str, dict]:
    return listed("scenes")


def situations() -> list[str]:
    return list(listed("situations"))


def in_order(names: set[str], known: list[str]) -> list[str]:
    """Those of `known` in its order, then the others by name."""
    return [n for n in known if n in names] + sorted(set(names) - set(known))


def by_formulation(names: set[str]) -> list[str]:
    return in_order(names, formulations())


def by_solver(names: set[str]) -> list[str]:
    return in_order(names, solvers())


def words(name: str) -> str:
    """What a formulation or a solver is, in a sentence; empty for what this build does not know."""
    for kind in ("formulations", "solvers"):
        if name in listed(kind):
            return listed(kind)[name]["words"]
    return ""


def trait(formulation: str, name: str) -> bool:
    """A trait of a formulation: polyhedral, compliant, normal_only, frictionless, forces."""
    return listed("formulations").get(formulation, {}).get(name, False)


def with_trait(name: str) -> list[str]:
    return [f for f in formulations() if trait(f, name)]


def uses_solver(formulation: str) -> bool:
    """Does it pose problems to a solver? What integrates by itself does not."""
    return listed("formulations").get(formulation, {}).get("solver", True)


def reads_cones(solver: str) -> bool:
    return "cone" in listed("solvers").get(solver, {}).get("sets", [])


def apart(formulation: str) -> list[str]:
    """The options of a formulation of which every value is a curve of its own in figures."""
    return listed("formulations").get(formulation, {}).get("apart", [])


def situation(scene: str) -> str:
    """What a scene stands for; empty for none, and for what is no scene of this build."""
    return scenes().get(scene, {}).get("situation", "")


def redundant(scene: str) -> bool:
    return scenes().get(scene, {}).get("redundant", False)


def solvable(scene: str) -> bool:
    """False where no motion of rigid bodies exists, so that only a refusal is right."""
    return scenes().get(scene, {}).get("solvable", True)


def part_words(campaign: str, part: str) -> str:
    """What a part of a campaign asks, for a reader; empty where its file does not say."""
    parts = listed("campaigns").get(campaign, {}).get("parts", [])
    return next((p["words"] for p in parts if p["name"] == part), "")

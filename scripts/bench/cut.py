"""How much of a campaign was measured: its form, and of a full form that was cut off by the clock
(lcpbench run --budget) what is left, from the manifests."""

from bench import say
from bench.section import Table

# of the order: with all cells of these a cut campaign stands for its quick form
STAGES = ("quick", "values")


def stands(manifest: dict) -> bool:
    """Does this full form, cut or not, tell at least what the quick form tells?"""
    if manifest.get("campaign", {}).get("quick") is not False or manifest.get("filters"):
        return False
    cut = manifest.get("cut")
    if not cut:
        return True
    stages = cut.get("stages")
    return stages is not None and all(a == b for a, b in (stages.get(s, (0, 0)) for s in STAGES))


ORDER = ", in an order that keeps every axis"


def amount(cut: dict) -> str:
    return f"{cut['measured']} of {cut['cells']} cells{ORDER if 'stages' in cut else ''}"


def form(manifest: dict) -> str:
    """The form of one campaign in words; "" where its manifest does not tell."""
    quick = manifest.get("campaign", {}).get("quick")
    if quick is None:
        return ""
    words = "quick form" if quick else "full form"
    if manifest.get("filters"):
        words += f" of what {', '.join(manifest['filters'])} chose"
    if cut := manifest.get("cut"):
        words += f", cut: {amount(cut)}"
    if begun := manifest.get("begun"):
        words += f" (full form begun: {amount(begun)})"
    return words


def forms(manifests: dict[str, dict]) -> str:
    """In which form the campaigns were measured; "" where no manifest tells."""
    names: dict[str, list[str]] = {}
    for name, m in sorted(manifests.items()):
        if words := form(m):
            names.setdefault(words, []).append(name)
    order = sorted(names, key=lambda words: (words != "full form", words == "quick form"))
    if len(names) < 2:
        return "".join(order)
    told = [f"{', '.join(names[words])} in {words}" for words in order]
    head, said, rest = ("; " if len(told) > 2 else " and ").join(told).partition(ORDER)
    return head + said + rest.replace(ORDER, "")


def absent(axes: dict[str, list[str]]) -> str:
    return "; ".join(
        f"{axis} {', '.join(say.plain(v) or 'its own' for v in values)}"
        for axis, values in axes.items()
    )


def table(manifests: dict[str, dict]) -> Table | None:
    """What a cut, or a begun full form has left out; None where nothing is."""
    lines = []
    for name, m in sorted(manifests.items()):
        cut = m.get("cut") or m.get("begun")
        for part, (measured, cells) in (cut or {}).get("parts", {}).items():
            if measured < cells:
                found = absent(cut.get("absent", {}).get(part, {}))
                lines.append([name, part, str(measured), str(cells), found if measured else "all"])
    if not lines:
        return None
    return Table(
        "left_out",
        "Cells of the full form that are left out, and the values of which no cell is measured."
        " `scripts/reproduce --full --budget TIME` goes on with them.",
        ["campaign", "part", "cells measured", "of", "values without a cell"],
        lines,
        paper=False,
    )

"""What an effect is worth: everything on, as declared, watched, and each declared effect
dropped in turn."""

import re
from collections.abc import Iterator

import numpy as np
import pandas as pd

from bench import registry
from bench.chart import Chart, Line, Panel
from bench.section import Cell, Section, Table, error, si

ORDER = {"everything on": 0, "as declared": 1, "auto": 2}
SAME = 0.02  # times closer than this are equal, however quiet the machine


Group = tuple[str, str, dict[str, dict]]  # problem, combination, {kind: cell}


def kind(command: str) -> str:
    """What was asked for: the argument of --effects in the cell's command."""
    found = re.search(r"--effects '?([^' ]*)", command)
    text = found.group(1) if found else "declared"
    return {"declared": "as declared", "all": "everything on"}.get(
        text, "auto" if text.startswith("auto") else text
    )


def said(kind: str) -> str:
    """'-friction' -> 'without friction'"""
    return kind.replace("-", "without ", 1) if kind.startswith("-") else kind


def shortest(cell: dict) -> float:
    """The least of the samples: what the machine's other work adds to a sample is never
    negative."""
    return (
        cell["t_total_s_low"]
        if cell.get("t_total_s_low", np.nan) == cell.get("t_total_s_low", np.nan)
        else cell["t_total_s"]
    )


def groups(cells: pd.DataFrame) -> Iterator[Group]:
    """One scene with one combination at one step: {kind: cell}. Dropping what is not declared
    changes nothing and is left out."""
    for (problem, combo, _), g in cells.groupby(["problem", "combination", "step_s"]):
        by = {kind(c["command"]): c for c in g.to_dict("records")}
        declared = by.get("as declared")
        if declared is not None:
            by = {k: c for k, c in by.items() if k in ORDER or c["effects"] != declared["effects"]}
        yield problem, combo, by


def same_work(a: dict, b: dict) -> bool:
    return all(
        a.get(c) == b.get(c) for c in ("n_dof", "lcp_dim", "n_contacts", "n_pivot", "n_iter")
    )


def compare(found: list[Group]) -> list[tuple[str, str, float, bool, bool]]:
    """As declared against everything on, scene by scene: [(problem, combination, ratio, same work,
    errors equal)]."""
    out = []
    for problem, combo, by in found:
        a, b = by.get("as declared"), by.get("everything on")
        if a is None or b is None or not (a["good"] and b["good"]):
            continue
        difference = abs(a["err_ref"] - b["err_ref"])
        tolerance = max(
            a["err_tol"] if a.get("err_tol", np.nan) == a.get("err_tol", np.nan) else 0.0, 1e-12
        )
        out.append(
            (problem, combo, shortest(a) / shortest(b), same_work(a, b), not difference > tolerance)
        )
    return out


def noise_of(compared: list[tuple[str, str, float, bool, bool]]) -> float:
    """How far the times of pairs that do the same work are apart: nine of ten are closer. What
    differs by less is a tie."""
    spread = [abs(np.log(ratio)) for _, _, ratio, same, _ in compared if same]
    return max(SAME, float(np.expm1(np.quantile(spread, 0.9)))) if spread else SAME


def unknowns(cell: dict) -> tuple[float, float]:
    """Of the motion, and of each contact."""
    return cell["n_dof"], cell["lcp_dim"] / cell["n_active"] if cell["n_active"] > 0 else 0


def drawn(found: list[Group]) -> set[str]:
    """What is left out in the figure: effects without which most scenes that declare them have
    other unknowns, and contacts still."""
    out = {"everything on", "auto"}
    pairs = {}
    for _, _, by in found:
        declared = by.get("as declared")
        for name, c in by.items():
            if name.startswith("-") and declared is not None and declared["good"] and c["good"]:
                pairs.setdefault(name, []).append(
                    c["n_contacts"] > 0 and unknowns(c) != unknowns(declared)
                )
    return out | {name for name, differ in pairs.items() if 2 * sum(differ) > len(differ)}


def chart(found: list[Group]) -> Chart:
    """Time of a run relative to the one as declared, a row a scene, a mark for each change."""
    panels, shown = {}, drawn(found)
    for problem, combo, by in found:
        declared = by.get("as declared")
        for name, c in by.items():
            if declared is not None and declared["good"] and c["good"] and name in shown:
                panels.setdefault(combo, {}).setdefault(name, []).append(
                    (problem, shortest(c) / shortest(declared))
                )
    out = []
    for combo, kinds in sorted(panels.items()):
        names = sorted({p for points in kinds.values() for p, _ in points})
        halves = (
            [names[: -(-len(names) // 2)], names[-(-len(names) // 2) :]]
            if len(panels) == 1 and len(names) > 12
            else [names]
        )
        for half in halves:
            lines = [Line("as declared", [1.0] * len(half), list(range(len(half))), kind="points")]
            for name in registry.in_order(
                set(kinds),
                ["everything on", "auto"] + [f"-{e}" for e in registry.listed("effects")],
            ):
                points = [(p, r) for p, r in kinds.get(name, []) if p in half]
                if points:
                    lines.append(
                        Line(
                            said(name),
                            [r for _, r in points],
                            [half.index(p) for p, _ in points],
                            kind="points",
                            look_as=name,
                        )
                    )
            out.append(
                Panel(
                    lines,
                    title=combo,
                    xlabel="time of the run / as declared",
                    xlog=2,
                    ylog=0,
                    yticks=[s.replace("_", " ").split(":col")[0].split(":mult")[0] for s in half],
                )
            )
    if not out:
        return None
    return Chart(
        "effects",
        "What an effect is worth: time of the run with everything on, with the effects that the"
        " run called for (auto), and with one declared effect dropped (those that change the"
        " unknowns of most scenes), relative to the run as declared (least of the samples). Left is"
        " cheaper.",
        out,
        columns=2,
        height=0.6 + 0.135 * max(len(p.yticks) for p in out),
    )


def savings(found: list[Group]) -> Table:
    """What a declaration saves: the scenes that leave most out, and the planar scenes beside their
    spatial twins."""
    rows = []
    plain = {(p, combo): by.get("as declared") for p, combo, by in found}
    for problem, combo, by in found:
        a, b = by.get("as declared"), by.get("everything on")
        if (
            a is not None
            and b is not None
            and (a["n_dof"] < b["n_dof"] or a["lcp_dim"] < b["lcp_dim"])
        ):
            effects = a["effects"].split()
            what = [
                w
                for w, gone in (
                    ("no friction", "friction" not in effects),
                    ("no rotation", "rotation" not in effects),
                )
                if gone
            ]
            rows.append((", ".join(what) or "fewer effects", problem, combo, a, b, "everything on"))
        twin = plain.get((re.sub(r":dim=2$", "", problem), combo))
        if problem.endswith(":dim=2") and a is not None and twin is not None:
            rows.append(("planar", problem, combo, a, twin, "in space"))
    body = [
        [
            what,
            problem,
            combo,
            f"{a['n_dof']:g} / {b['n_dof']:g}",
            f"{a['lcp_dim']:g} / {b['lcp_dim']:g}",
            (
                f"{shortest(a) / shortest(b):.2f}"
                if a["good"] and b["good"]
                else f"({b['status']} {against})"
            ),
            against,
        ]
        for what, problem, combo, a, b, against in rows
    ]
    return Table(
        "savings",
        "What a declaration saves: velocity unknowns, unknowns of the complementarity problem and"
        " time, as declared against everything on, and in the plane against in space.",
        ["scene has", "scene", "combination", "dofs", "LCP", "time ratio", "against"],
        sorted(body),
    )


def line(
    problem: str, combo: str, name: str, c: dict, declared: dict, noise: float
) -> list[Cell | str]:
    ratio = (
        shortest(c) / shortest(declared)
        if declared is not None and c["good"] and declared["good"]
        else np.nan
    )
    saves = name != "as declared" and ratio < 1 / (1 + noise)
    return [
        problem,
        combo,
        said(name),
        f"{c['n_dof']:g}",
        f"{c['lcp_dim']:g}",
        Cell(si(shortest(c) / c["n_steps"], "s") if c["n_steps"] else "", sort=shortest(c)),
        Cell(
            f"{ratio:.2f}{'*' if saves else ''}" if ratio == ratio else "",
            "good" if saves else "",
            sort=ratio if ratio == ratio else None,
        ),
        Cell(error(c["err_ref"]), "" if c["good"] else "bad"),
        Cell(c["status"], title=c.get("effects_auto", "") or c.get("note", "")),
    ]


def section(cells: pd.DataFrame) -> Section | None:
    some = cells[cells["campaign"].str.startswith("effects")]
    if some.empty:
        return None
    found = list(groups(some))
    compared = compare(found)
    noise = noise_of(compared)
    dearer = [f"{p} ({r:.2f})" for p, _, r, same, _ in compared if not same and r > 1 + noise]
    unequal = [p for p, _, _, _, equal in compared if not equal]
    same = sum(s for _, _, _, s, _ in compared)
    table = [
        line(problem, combo, name, c, by.get("as declared"), noise)
        for problem, combo, by in found
        for name, c in sorted(by.items(), key=lambda kv: (ORDER.get(kv[0], 3), kv[0]))
    ]
    families = some["problem_family"].nunique()
    judged = (
        f"A scene pays only for what it declares. Of {len(compared)} pairs, {same} do the same work"
        " with everything on (same unknowns, contacts and pivots): how far their times are apart,"
        f" {noise:.0%} for nine of ten, is the noise of this run. Of the other"
        f" {len(compared) - same}, "
        + (
            "none is dearer as declared by more than that"
            if not dearer
            else f"{len(dearer)} are dearer as declared by more than that: {', '.join(dearer)}"
        )
        + "; the errors are equal within the tolerance of the scene's prediction "
        + ("in all of them." if not unequal else f"in all but {', '.join(unequal)}.")
    )
    made = chart(found)
    return Section(
        "effects",
        "What an effect is worth",
        judged + f" {families} scenes.",
        [made] if made else [],
        [
            savings(found),
            Table(
                "effects",
                "Unknowns, time per step and error with everything on, as declared, as the run"
                " called for (auto: what came in when is the tooltip of the status), and with each"
                " declared effect dropped; times are the least of the samples. *: less by more than"
                " the noise.",
                [
                    "scene",
                    "combination",
                    "effects",
                    "dofs",
                    "LCP",
                    "time per step",
                    "time / declared",
                    "error",
                    "status",
                ],
                table,
            ),
        ],
        {
            "EffectsScenes": str(families),
            "EffectsCompared": str(len(compared)),
            "EffectsDearer": str(len(dearer)),
        },
    )

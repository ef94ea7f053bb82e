"""The regularisation that reaches an error in the least time, against the rule of thumb (lcpbench
calibrate)."""

import json
import pathlib

from bench.section import Cell, Table, error, si

UNITS = {"ratio": "", "zeta": "", "k": "N/m", "c": "N s/m"}


def load(path: pathlib.Path) -> list[dict]:
    with open(path) as lines:
        return [json.loads(line) for line in lines if line.strip()]


def point(p: dict | None) -> Cell:
    parameters = ", ".join(
        f"{n} = {p[n]:.3g}{' ' + u if u else ''}" for n, u in UNITS.items() if n in p
    )
    if not p["reaches"]:
        return Cell(
            f"{parameters}\nnot reached",
            "bad",
            (
                f"the smallest error of the ladder is {error(p['error'])}"
                if p["error"] is not None
                else "no step of the ladder solves"
            ),
        )
    return Cell(
        f"{parameters}\nh = {p['step_s']:.2g} s, {si(p['t_total_s'], 's')}", title=p["command"]
    )


def gain(found: dict) -> Cell:
    if found["gain"] is None:
        return Cell(
            "reaches it, the rule does not" if found["best"]["reaches"] else "neither reaches it",
            "good" if found["best"]["reaches"] else "bad",
        )
    return Cell(f"{found['gain']:.2f}", "good" if found["gain"] > 1.05 else "", sort=found["gain"])


def table(found: list[dict]) -> Table:
    rows = [
        [
            f["scene"],
            f["yardstick"],
            f"≤ {f['error']:g}",
            point(f["rule"]),
            point(f["best"]),
            gain(f),
            str(f["simulations"]),
        ]
        for f in found
    ]
    return Table(
        "calibration",
        "Calibrated regularisation: the stiffness and damping that keep an error in the least time"
        " (NLopt's subplex, the step chosen for each pair), against the rule of thumb, which is the"
        " default (ratio = 100, zeta = 0.7; k = 1 MN/m, c = 1 kN s/m). Gain: time of the rule over"
        " time of the calibrated, runs interleaved (shaded above 1.05).",
        ["scene", "yardstick", "error", "rule of thumb", "calibrated", "gain", "simulations"],
        rows,
    )

"""Our own formulations on the same scenes: `lcpbench simulate`, whose trajectory is judged like the
others'."""

from __future__ import annotations

import csv
import dataclasses
import json
import pathlib
import subprocess
import tempfile

import numpy as np

from engine_room.motion import Contact, Motion
from engine_room.scene import Scene, Unsupported


def _arguments(text: str, way: dict, step: float) -> list[str]:
    return [
        "simulate",
        text,
        "--formulation",
        way["formulation"],
        "--solver",
        way["solver"],
        "--step",
        f"{step:g}",
        "--start",
        "previous",
    ]


def _numbers(row: dict, names: str) -> np.ndarray:
    return np.array([float(row[n]) for n in names.split()])


def read(scene: Scene, path: pathlib.Path) -> Motion:
    """The trajectory of a run (results/FORMAT.md), in the frame of the driven body as it moved: an
    engine's frame moves exactly, and what counts is the motion against it."""
    index = scene.index()
    times: list[float] = []
    states: list[list] = []
    contacts: list[list[Contact]] = []
    with path.open(newline="") as file:
        for row in csv.DictReader(file):
            t = float(row["t_s"])
            if row["kind"] not in ("body", "contact"):
                continue
            if not times or t != times[-1]:
                times.append(t)
                states.append([None] * len(index))
                contacts.append([])
            if row["kind"] == "contact":
                a, b = row["name"].split("|")
                contacts[-1].append(
                    Contact(a, b, _numbers(row, "x_m y_m z_m"), _numbers(row, "sx sy sz"))
                )
            else:
                states[-1][index[row["name"]]] = (
                    _numbers(row, "x_m y_m z_m"),
                    _numbers(row, "qw qx qy qz"),
                    _numbers(row, "vx_m_s vy_m_s vz_m_s"),
                    _numbers(row, "omega_x_rad_s omega_y_rad_s omega_z_rad_s"),
                )
    columns = [np.array([[s[k] for s in row] for row in states]) for k in range(4)]
    motion = Motion(np.array(times), *columns, contacts[1:])
    lead = scene.driven()
    if lead is None:
        return motion
    along = np.abs(scene.drive[0]) + np.abs(scene.drive[1]) > 0
    way = np.where(along, motion.pos[:, lead] - motion.pos[0, lead], 0.0)[:, None]
    speed = np.where(along, motion.vel[:, lead], 0.0)[:, None]
    return dataclasses.replace(motion, pos=motion.pos - way, vel=motion.vel - speed)


def simulate(binary: str, arguments: list[str], limit: float) -> dict:
    """What the program prints. Unsupported: what it says where it prints nothing; TimeoutError."""
    try:
        done = subprocess.run(
            [binary, *arguments], capture_output=True, text=True, check=False, timeout=limit
        )
    except subprocess.TimeoutExpired as late:
        raise TimeoutError(f"more than {limit:g} s") from late
    if not done.stdout.strip():
        raise Unsupported(done.stderr.strip().splitlines()[-1])
    return json.loads(done.stdout)


def run(
    binary: str,
    text: str,
    scene: Scene,
    way: dict,
    step: float,
    limit: float,
    repeats: int,
    timed: float,
) -> tuple[Motion, list[float], int, str, str]:
    """(motion, seconds a step of each repeat, how many, status, the command). The first run, which
    writes the trajectory, warms up; its own time is taken where it spent all that is given to
    `timed` [s], and then no repeat is."""
    arguments = _arguments(text, way, step)
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "motion.csv"
        first = simulate(binary, [*arguments, "--trajectory", str(path)], limit)
        if first["status"] == "unsupported" or not path.exists():
            raise Unsupported(first["note"] or first["status"])
        motion = read(scene, path)
    times, spent = [], first["t_total_s"]
    while len(times) < repeats and spent < timed:
        told = simulate(binary, arguments, limit)
        times.append(told["t_total_s"] / max(told["steps"], 1))
        spent += told["t_total_s"]
    alone = first["t_total_s"] / max(first["steps"], 1)
    lies = first["status"] == "ok" and not first["verified"]
    word = "unverified" if lies else first["status"]
    return motion, times or [alone], len(times), word, " ".join(arguments)

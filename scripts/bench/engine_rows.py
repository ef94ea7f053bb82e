"""Rows of scripts/engines: one line for each scene, engine, setting and step, columns as below, in
engines.csv. One writer, which puts the file in place whole."""

from __future__ import annotations

import csv
import dataclasses
import os
import pathlib

FILE = "engines.csv"


def _column(unit: str, words: str) -> str:
    return dataclasses.field(default="", metadata={"unit": unit, "words": words})


@dataclasses.dataclass
class Row:
    scene: str = _column("", "name of the scene")
    problem: str = _column("", "the scene as lcpbench takes it: name with parameters, or file")
    engine: str = _column("", "engine; lcpbench: our own")
    version: str = _column("", "of the engine's package, or of lcpbench")
    setting: str = _column("", "name of the setting in experiments.toml; of ours the formulation")
    options: str = _column("", "its options, key=value; empty: the engine's defaults")
    step_s: str = _column("s", "time step")
    steps: str = _column("", "steps of the run")
    status: str = _column(
        "", "ok diverged unsupported absent timeout crash error; ours: of simulate"
    )
    note: str = _column("", "why, where not ok")
    error: str = _column("see quantity", "of the first kinematic check of the scene")
    quantity: str = _column("", "what the error is of")
    penetration_m: str = _column("m", "largest overlap, of 40 states")
    creep_m_s: str = _column("m/s", "largest mean speed after the scene is at rest")
    energy_gain_J: str = _column("J", "largest rise over an earlier value; empty: loads or drives")
    coulomb: str = _column(
        "1", "residual of Coulomb's law (judge.py); empty: no forces, no friction"
    )
    n_contact: str = _column("", "most contacts of a step")
    t_step_s: str = _column("s", "time a step: median over repeats of their mean step")
    t_step_low_s: str = _column("s", "least of the repeats")
    t_step_high_s: str = _column("s", "largest of the repeats")
    repeats: str = _column("", "timed runs, after one that warms up; 0: there was only that")
    cpu: str = _column("", "model of the processor; one thread, pinned")
    load1: str = _column("", "load average when the run began")
    started_utc: str = _column("", "when the campaign began")
    command: str = _column("", "runs this row again")


NAMES = [f.name for f in dataclasses.fields(Row)]


def number(value: float | int | None) -> str:
    return "" if value is None else f"{value:.6g}"


def write(rows: list[Row], folder: pathlib.Path) -> pathlib.Path:
    """FOLDER/engines.csv, there whole or not at all."""
    folder.mkdir(parents=True, exist_ok=True)
    path, temporary = folder / FILE, folder / f".{FILE}.{os.getpid()}"
    with temporary.open("w", newline="") as file:
        writer = csv.DictWriter(file, NAMES, lineterminator="\n")
        writer.writeheader()
        writer.writerows(dataclasses.asdict(r) for r in rows)
        file.flush()
        os.fsync(file.fileno())
    temporary.replace(path)
    return path


def key(row: Row) -> tuple[str, ...]:
    """What a row is of."""
    return row.scene, row.engine, row.setting, row.step_s


def merged(old: list[Row], new: list[Row]) -> list[Row]:
    """The old rows in their order, each in the place of which a new one of the same key stands, and
    the others of the new; that an engine is absent is forgotten when it is asked for again."""
    fresh = {key(r): r for r in new}
    asked = {r.engine for r in new}
    kept = [
        fresh.pop(key(r), r)
        for r in old
        if key(r) in fresh or r.status != "absent" or r.engine not in asked
    ]
    return kept + list(fresh.values())


def read(path: pathlib.Path) -> list[Row]:
    """Rows of a file. ValueError: its columns are not these."""
    with path.open(newline="") as file:
        table = csv.DictReader(file)
        if table.fieldnames != NAMES:
            raise ValueError(f"{path}: not the columns of scripts/engines; measure again")
        return [Row(**r) for r in table]


def value(text: str) -> float:
    """A number of a row; NaN where there is none."""
    return float(text) if text else float("nan")

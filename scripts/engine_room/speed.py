"""speed.py ENGINE BINARY SCENE STEP COUNT OPTIONS ... - the cheap end in another engine: for each
OPTIONS (JSON) a line of JSON with the mean time of a step [s] (median, least and most of three
runs) and the largest speed of a body in the last quarter of COUNT steps [m/s]. Run by the Python
that has the engine (scripts/engines)."""

import importlib
import json
import pathlib
import statistics
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import numpy as np  # noqa: E402

from engine_room import scene  # noqa: E402

RUNS = 3


def once(module: object, told: scene.Scene, options: dict, step: float, count: int) -> tuple:
    """(seconds a step, largest speed) of one run."""
    made, spent, fastest = module.Simulation(told, options, step), 0.0, 0.0
    for k in range(count):
        begun = time.perf_counter()
        made.step()
        spent += time.perf_counter() - begun
        if k + 1 >= 0.75 * count:
            fastest = max(fastest, *(float(np.linalg.norm(s[2])) for s in made.states()))
    return spent / count, fastest


def main(engine: str, binary: str, text: str, step: str, count: str, *options: str) -> None:
    module = importlib.import_module(f"engine_room.engines.{engine}_room")
    told = scene.load(binary, text)
    for asked in map(json.loads, options):
        found = [once(module, told, asked, float(step), int(count)) for _ in range(RUNS)]
        times = [seconds for seconds, _ in found]
        said = {"s": statistics.median(times), "low": min(times), "high": max(times)}
        print(json.dumps(said | {"options": asked, "speed_m_s": max(v for _, v in found)}))


if __name__ == "__main__":
    main(*sys.argv[1:])

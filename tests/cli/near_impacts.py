"""A disc that falls into a groove nearly on its middle, a box that lands nearly flat: two impacts
follow each other more closely than a run to some error tells, and what comes of them goes with
their order. The offset is from 1e-7 to 1e-2 of the size."""

import json
import math
import pathlib
import random

from random_scenes import Scene


def scene_of(body: Scene, static: list[Scene], mu: float, e: float) -> Scene:
    return {
        **{"id": "near", "dim": 2, "T": 0.5, "hs": [0.01], "gravity": [0.0, -9.81]},
        **{"bodies": [{"name": "body", "mass": 1.0, **body}], "static": static, "joints": []},
        **{"friction": {"default": mu}, "restitution": {"default": e}},
        **{"observe": ["body.x", "body.y"], "checks": [{"type": "finite"}]},
    }


def groove(off: float, slope: float, mu: float, e: float) -> Scene:
    """A disc of radius 0.1, `off` beside the middle of a groove of two slopes [rad]."""
    sides = {"left": math.sin(slope), "right": -math.sin(slope)}
    static = [{"name": n, "normal": [s, math.cos(slope)], "offset": 0.0} for n, s in sides.items()]
    return scene_of({"shape": {"type": "disc", "r": 0.1}, "pos": [off, 0.3]}, static, mu, e)


def flat(tilt: float, half: list[float], mu: float, e: float) -> Scene:
    """A box tilted by `tilt` [rad] above a floor."""
    box = {"shape": {"type": "box", "half": half}, "pos": [0.0, 0.25], "angle": tilt}
    return scene_of(
        {**box, "vel": [0.3, 0.0]}, [{"name": "floor", "normal": [0.0, 1.0], "offset": 0.0}], mu, e
    )


def random_near(seed: int) -> Scene:
    rng = random.Random(f"near {seed}")
    off = 10 ** rng.uniform(-7, -2)
    mu, e = rng.choice((0.0, rng.uniform(0, 1))), rng.choice((0.0, rng.uniform(0, 1)))
    if rng.random() < 0.5:
        return groove(0.1 * off, rng.uniform(0.3, 0.7), mu, e)
    return flat(off, [rng.uniform(0.05, 0.15), rng.uniform(0.02, 0.15)], mu, e)


def scene_file(folder: pathlib.Path, name: str, scene: Scene) -> pathlib.Path:
    path = folder / f"{name}.json"
    path.write_text(json.dumps(scene))
    return path

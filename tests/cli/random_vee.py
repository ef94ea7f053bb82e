"""A ball or a box thrown into a groove of two planes in space, whose contacts hold each other: with
enough friction the two push against each other as hard as they like."""

import math
import random

from random_scenes import Scene


def random_vee(seed: int) -> Scene:
    rng = random.Random(f"v {seed}")
    mu, kind = rng.choice((0.2, 0.5, 1.0, 1.0, 1.5)), rng.choice(("sphere", "sphere", "box"))
    ahead, slopes = rng.uniform(0, 2 * math.pi), (rng.uniform(0.2, 1.3), rng.uniform(0.2, 1.3))
    ways = (ahead, ahead + math.pi + rng.choice((0, 0, rng.uniform(-0.3, 0.3))))
    normals = [
        [math.sin(a) * math.cos(w), math.sin(a) * math.sin(w), math.cos(a)]
        for a, w in zip(slopes, ways, strict=True)
    ]
    form: Scene = {"type": "sphere", "r": 0.1}
    if kind == "box":
        form = {"type": "box", "half": [0.1, 0.07, 0.05]}
    height = rng.uniform(0.2, 0.4) / min(n[2] for n in normals)
    thrown = {"name": "b", "shape": form, "mass": 1.0, "pos": [0.0, 0.0, height]}
    thrown["vel"] = [rng.uniform(-1, 1) for _ in range(3)]
    thrown["omega"] = [rng.uniform(-5, 5) for _ in range(3)]
    static = [{"name": f"p{k}", "normal": n, "offset": 0.0} for k, n in enumerate(normals)]
    return {
        **{"id": f"vee{seed}", "dim": 3, "T": 0.5, "hs": [0.005], "gravity": [0.0, 0.0, -9.81]},
        **{"static": static, "bodies": [thrown], "joints": [], "no_collision": []},
        **{"observe": ["b.pos"]},
        **{"friction": {"default": mu}, "restitution": {"default": 0.0}},
        **{"checks": [{"type": "finite"}]},
    }

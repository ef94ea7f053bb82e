"""Random scenes, event by event: a run ends, or says which problem has no solution; nothing sinks
in, and no energy comes from nowhere. `test_event_random.py 0 300` runs the seeds 0 to 299.

Newton's law of impact with friction can add energy (MATHEMATICS 2.1), so that energy is judged
where there is no restitution or no friction. At acceleration level a problem need not have a
solution (MATHEMATICS 2.3.8), nor an impact with restitution where friction can jam it; and lemke
can fail. At most `unsolved` runs may end so, each with its status."""

import json
import pathlib
import sys
import tempfile

from random_scenes import random_scene

from support import SANITIZED, Skip, run, tap

UNSOLVED = ("ray", "infeasible", "stalled", "unverified")


def troubles(seed: int, folder: pathlib.Path) -> tuple[str, str]:
    """Status of the run, and what it should not have done."""
    scene = random_scene(seed)
    lawful = scene["friction"]["default"] == 0 or scene["restitution"]["default"] == 0
    scene["checks"] = [
        {"type": "finite"},
        {"type": "energy_nonincrease", "tol": {"abs": 1e-7 if lawful else 1e3}},
        {"type": "max_penetration", "tol": {"abs": 1e-8}},
    ]
    path = folder / f"{seed}.json"
    path.write_text(json.dumps(scene))
    words = ("--formulation", "event", "--solver", "lemke", "--step", "0.02")
    said = json.loads(run("simulate", path, *words, code=None, timeout=300).stdout)
    if said["status"] in UNSOLVED:
        return said["status"], ""
    wrong = [f"{p['quantity']} = {p['value']}" for p in said["predictions"] if not p["ok"]]
    if said["status"] != "ok":
        wrong.append(f"{said['status']}: {said['note']}")
    return said["status"], "; ".join(wrong)


def judge(first: int, end: int, unsolved: int) -> None:
    found, without = [], []
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(first, end):
            status, wrong = troubles(seed, pathlib.Path(folder))
            if wrong:
                found.append(f"seed {seed}: {wrong}")
            if status in UNSOLVED:
                without.append(f"seed {seed}: {status}")
    assert not found, "\n".join(found)
    assert len(without) <= unsolved, "\n".join(without)


def thirty_random_scenes_end(d):
    if SANITIZED:
        raise Skip("thirty runs under error control: too slow with sanitizers")
    judge(0, 30, 4)


if len(sys.argv) == 3:
    judge(int(sys.argv[1]), int(sys.argv[2]), int(sys.argv[2]))
else:
    tap([thirty_random_scenes_end])

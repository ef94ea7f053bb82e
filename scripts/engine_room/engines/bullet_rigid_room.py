"""Bullet's rigid bodies, through bullet_rigid_room.cpp, which scripts/engines builds from Debian's
libbullet-dev, in its single precision. Options: iterations (0: Bullet's own number)."""

from __future__ import annotations

import subprocess

from engine_room.engines import plain_room
from engine_room.scene import Scene


def version() -> str:
    plain_room.library("bullet_rigid")
    told = subprocess.run(
        ["pkg-config", "--modversion", "bullet"], capture_output=True, text=True, check=True
    )
    return told.stdout.strip()


class Simulation(plain_room.Room):
    def __init__(self, scene: Scene, options: dict, step: float) -> None:
        super().__init__(plain_room.library("bullet_rigid"), scene, options["iterations"], step)

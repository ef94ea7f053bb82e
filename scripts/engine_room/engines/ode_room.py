"""ODE, through ode_room.c, which scripts/engines builds. Options: method (step, quickstep),
iterations of quickstep, erp, cfm."""

from __future__ import annotations

import ctypes
import subprocess

from engine_room.engines import plain_room
from engine_room.scene import Scene


def version() -> str:
    """Of the package: the library does not tell."""
    plain_room.library("ode")
    told = subprocess.run(
        ["pkg-config", "--modversion", "ode"], capture_output=True, text=True, check=True
    )
    return told.stdout.strip()


class Simulation(plain_room.Room):
    def __init__(self, scene: Scene, options: dict, step: float) -> None:
        self.options = options
        lib = plain_room.library("ode")
        lib.room_soften.argtypes = [ctypes.c_void_p, ctypes.c_double, ctypes.c_double]
        quick = int(options["method"] == "quickstep")
        super().__init__(lib, scene, options.get("iterations", 0), step, quick)

    def prepare(self) -> None:
        if "erp" in self.options or "cfm" in self.options:
            self.lib.room_soften(self.room, self.options["erp"], self.options["cfm"])

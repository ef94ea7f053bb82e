"""A world behind plain arrays, in a library that scripts/engines builds (ode_room.c,
bullet_rigid_room.cpp): what is called once for each contact would cost more in Python than the step
does."""

from __future__ import annotations

import ctypes
import os
import pathlib
import sys

import numpy as np

from engine_room.motion import Contact
from engine_room.scene import AXES, Body, Scene, Unsupported

HELD = {"": 0, "turns": 1, "fixed": 2}


def library(engine: str) -> ctypes.CDLL:
    """The one of an engine, beside the Python that scripts/engines made, or in LCPBENCH_ENGINES."""
    folder = pathlib.Path(os.environ.get("LCPBENCH_ENGINES", sys.prefix))
    lib = ctypes.CDLL(str(folder.resolve() / f"{engine}_room.so"))
    real, integer = ctypes.c_double, ctypes.c_int
    array = np.ctypeslib.ndpointer(dtype=float, flags="C_CONTIGUOUS")
    lib.room_new.restype = ctypes.c_void_p
    lib.room_new.argtypes = [array, real, real, integer]
    lib.room_plane.argtypes = [ctypes.c_void_p, array, real]
    lib.room_body.argtypes = [ctypes.c_void_p, integer, array, real, array, array, integer]
    lib.room_apart.argtypes = [ctypes.c_void_p, integer, integer]
    lib.room_push.argtypes = [ctypes.c_void_p, integer, array]
    lib.room_step.argtypes = [ctypes.c_void_p, real, integer]
    lib.room_states.argtypes = [ctypes.c_void_p, array]
    lib.room_n_contact.argtypes = [ctypes.c_void_p, real]
    lib.room_contact_at.argtypes = [ctypes.c_void_p, integer, ctypes.POINTER(integer * 2), array]
    return lib


class Room:
    """quick: what the step is told besides its length."""

    def __init__(
        self, lib: ctypes.CDLL, scene: Scene, iterations: int, step: float, quick: int = 0
    ) -> None:
        self.lib, self.scene, self.h, self.quick = lib, scene, step, quick
        self.room = lib.room_new(scene.gravity, scene.friction, scene.restitution, iterations)
        self.prepare()
        self.names = {}
        for b in scene.bodies:
            self.names[self._body(b)] = b.name
        for p in scene.planes:
            self.names[lib.room_plane(self.room, p.up, p.offset)] = p.name
        index = scene.index()
        for pair in scene.apart:
            a, b = sorted(pair)
            if lib.room_apart(self.room, index[a], index[b]):
                raise Unsupported("more than 64 pairs that pass through each other")
        self.pushed = [(i, b.force) for i, b in enumerate(scene.bodies) if np.any(b.force)]

    def prepare(self) -> None:
        """What an engine sets before there are bodies."""

    def _body(self, b: Body) -> int:
        if b.part.kind == "hull":
            raise Unsupported("a polygon: its convex hulls are not made here")
        holds = self.scene.holds(b)
        state = np.concatenate([b.pos, b.quat, b.vel, b.omega])
        return self.lib.room_body(
            self.room,
            int(b.part.kind == "ball"),
            b.part.size,
            b.mass,
            np.where(b.inertia > 0, b.inertia, 1.0),
            state,
            HELD[holds] if holds in HELD else 3 + AXES.index(holds),
        )

    def step(self) -> None:
        for i, force in self.pushed:
            self.lib.room_push(self.room, i, force)
        self.lib.room_step(self.room, self.h, self.quick)

    def states(self) -> list:
        out = np.zeros((len(self.scene.bodies), 13))
        self.lib.room_states(self.room, out)
        return [(r[:3], r[3:7], r[7:10], r[10:13]) for r in out]

    def contacts(self) -> list[Contact]:
        found = []
        side = (ctypes.c_int * 2)()
        for i in range(self.lib.room_n_contact(self.room, self.h)):
            out = np.zeros(6)
            self.lib.room_contact_at(self.room, i, ctypes.byref(side), out)
            a, b, sign = (side[0], side[1], 1.0) if side[0] >= 0 else (side[1], side[0], -1.0)
            found.append(Contact(self.names[a], self.names[b], out[:3], sign * out[3:]))
        return found

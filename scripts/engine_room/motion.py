"""What a run leaves: states of all bodies after every step, and, where they can be read, the forces
of its contacts."""

from __future__ import annotations

import dataclasses

import numpy as np

from engine_room.scene import Scene


@dataclasses.dataclass
class Contact:
    """The mean force of a step at a point, on body a; b is a body or a plane."""

    a: str
    b: str
    point: np.ndarray
    force: np.ndarray


@dataclasses.dataclass
class Motion:
    """K steps of B bodies. Row 0 is the start; velocities and turns in world axes."""

    t: np.ndarray  # K + 1
    pos: np.ndarray  # K + 1, B, 3
    quat: np.ndarray  # K + 1, B, 4 (w, x, y, z)
    vel: np.ndarray
    omega: np.ndarray
    contacts: list[list[Contact]] | None  # K lists: of the step that ends at t[k + 1]


class Recorder:
    """Collects a motion step by step."""

    def __init__(self, scene: Scene) -> None:
        self.start = [(b.pos, b.quat, b.vel, b.omega) for b in scene.bodies]
        self.t = [0.0]
        self.states = [self.start]
        self.contacts: list[list[Contact]] | None = []

    def add(self, t: float, states: list, contacts: list[Contact] | None) -> None:
        self.t.append(t)
        self.states.append(states)
        if contacts is None:
            self.contacts = None
        elif self.contacts is not None:
            self.contacts.append(contacts)

    def motion(self) -> Motion:
        columns = [np.array([[s[k] for s in row] for row in self.states]) for k in range(4)]
        return Motion(np.array(self.t), *columns, self.contacts)


def in_world(scene: Scene, m: Motion) -> Motion:
    """The motion in the world, of one in the frame of the scene's drive."""
    velocity, acceleration = scene.drive
    t = m.t[:, None, None]
    return dataclasses.replace(
        m,
        pos=m.pos + velocity * t + acceleration * t**2 / 2.0,
        vel=m.vel + velocity + acceleration * t,
    )

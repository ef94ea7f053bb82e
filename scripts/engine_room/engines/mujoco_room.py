"""MuJoCo: every body with the joints that it is free along, contacts of its own soft model.
Options are attributes of <option>, and solref of every geom."""

from __future__ import annotations

import mujoco
import numpy as np

from engine_room.geometry import rotation
from engine_room.motion import Contact
from engine_room.scene import AXES, Body, Scene, Unsupported


def version() -> str:
    return mujoco.__version__


def _numbers(values: np.ndarray) -> str:
    return " ".join(f"{v:.17g}" for v in np.ravel(values))


def _geom(body: Body, scene: Scene, extra: str) -> str:
    shape = {"ball": ("sphere", body.part.size), "box": ("box", body.part.size)}.get(body.part.kind)
    form = (
        f'type="{shape[0]}" size="{_numbers(shape[1])}"'
        if shape
        else (f'type="mesh" mesh="hull_{body.name}"')
    )
    return f'<geom {form} friction="{scene.friction:.17g} 0 0" {extra}/>'


def _joints(scene: Scene, body: Body) -> str:
    if scene.holds(body) == "":
        return "<freejoint/>"
    axes = {a: _numbers(np.eye(3)[i]) for i, a in enumerate(AXES)}
    return "".join(f'<joint type="slide" axis="{axes[a]}"/>' for a in body.free)


def _body(scene: Scene, body: Body, extra: str) -> str:
    inertia = _numbers(np.maximum(body.inertia, 1e-9))
    return (
        f'<body name="{body.name}" pos="{_numbers(body.pos)}" quat="{_numbers(body.quat)}">'
        f"{_joints(scene, body)}"
        f'<inertial pos="0 0 0" mass="{body.mass:.17g}" diaginertia="{inertia}"/>'
        f"{_geom(body, scene, extra)}</body>"
    )


def _xml(scene: Scene, options: dict, step: float) -> str:
    given = dict(options)
    extra = f'solref="{given.pop("solref")}"' if "solref" in given else ""
    words = " ".join(f'{k}="{v}"' for k, v in given.items())
    meshes = "".join(
        f'<mesh name="hull_{b.name}" vertex="{_numbers(b.part.points)}"/>'
        for b in scene.bodies
        if b.part.kind == "hull"
    )
    planes = "".join(
        f'<geom name="{p.name}" type="plane" size="50 50 1" pos="{_numbers(p.up * p.offset)}"'
        f' zaxis="{_numbers(p.up)}" friction="{scene.friction:.17g} 0 0" {extra}/>'
        for p in scene.planes
    )
    apart = "".join(
        '<exclude body1="{}" body2="{}"/>'.format(*sorted(pair)) for pair in scene.apart
    )
    return (
        f'<mujoco><compiler inertiafromgeom="false"/><asset>{meshes}</asset>'
        f'<option timestep="{step:.17g}" gravity="{_numbers(scene.gravity)}" {words}/>'
        f"<worldbody>{planes}{''.join(_body(scene, b, extra) for b in scene.bodies)}</worldbody>"
        f"<contact>{apart}</contact></mujoco>"
    )


class Simulation:
    def __init__(self, scene: Scene, options: dict, step: float) -> None:
        if scene.restitution > 0:
            raise Unsupported("no coefficient of restitution")
        self.scene = scene
        self.model = mujoco.MjModel.from_xml_string(_xml(scene, options, step))
        self.data = mujoco.MjData(self.model)
        self.ids = [self.model.body(b.name).id for b in scene.bodies]
        self.first = [self.model.body_dofadr[i] for i in self.ids]
        self.places = [
            self.model.jnt_qposadr[self.model.body_jntadr[i]] if b.free else 0
            for i, b in zip(self.ids, scene.bodies, strict=True)
        ]
        for b, at, i in zip(scene.bodies, self.first, self.ids, strict=True):
            self.data.xfrc_applied[i, :3] = b.force
            if not b.free:
                continue
            if scene.holds(b) == "":
                self.data.qvel[at : at + 3] = b.vel
                self.data.qvel[at + 3 : at + 6] = rotation(b.quat).T @ b.omega
            else:
                self.data.qvel[at : at + len(b.free)] = [b.vel[AXES.index(a)] for a in b.free]
        self.names = {i: b.name for i, b in zip(self.ids, scene.bodies, strict=True)}

    def step(self) -> None:
        mujoco.mj_step(self.model, self.data)

    def states(self) -> list:
        out = []
        for b, at, place in zip(self.scene.bodies, self.first, self.places, strict=True):
            q, v = self.data.qpos, self.data.qvel
            if not b.free:
                out.append((b.pos, b.quat, np.zeros(3), np.zeros(3)))
            elif self.scene.holds(b) == "":
                turn = q[place + 3 : place + 7].copy()
                out.append(
                    (
                        q[place : place + 3].copy(),
                        turn,
                        v[at : at + 3].copy(),
                        rotation(turn) @ v[at + 3 : at + 6],
                    )
                )
            else:
                pos, vel = b.pos.copy(), np.zeros(3)
                for k, a in enumerate(b.free):
                    pos[AXES.index(a)] += q[place + k]
                    vel[AXES.index(a)] = v[at + k]
                out.append((pos, b.quat, vel, np.zeros(3)))
        return out

    def _name(self, geom: int) -> str:
        body = int(self.model.geom_bodyid[geom])
        return self.names.get(body) or self.model.geom(geom).name

    def contacts(self) -> list[Contact]:
        out = []
        force = np.zeros(6)
        for i in range(self.data.ncon):
            c = self.data.contact[i]
            mujoco.mj_contactForce(self.model, self.data, i, force)
            on_second = c.frame.reshape(3, 3).T @ force[:3]
            a, b = self._name(c.geom[0]), self._name(c.geom[1])
            if b in self.names.values():
                out.append(Contact(b, a, c.pos.copy(), on_second))
            else:
                out.append(Contact(a, b, c.pos.copy(), -on_second))
        return out

"""Bullet, through pybullet: options are those of setPhysicsEngineParameter, and of changeDynamics
for every body (damping). Friction and restitution of a pair are products there, so each body has
the root."""

from __future__ import annotations

import math

import numpy as np
import pybullet

from engine_room.motion import Contact
from engine_room.scene import AXES, Body, Scene, Unsupported

DYNAMICS = ("linearDamping", "angularDamping")


def version() -> str:
    from importlib.metadata import version as installed

    return installed("pybullet")


def _xyzw(q: np.ndarray) -> list[float]:
    return [q[1], q[2], q[3], q[0]]


class Simulation:
    def __init__(self, scene: Scene, options: dict, step: float) -> None:
        self.scene = scene
        self.client = pybullet.connect(pybullet.DIRECT)
        engine = {k: v for k, v in options.items() if k not in DYNAMICS}
        if "constraintSolverType" in engine:
            engine["constraintSolverType"] = getattr(pybullet, engine["constraintSolverType"])
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=step, physicsClientId=self.client, **engine
        )
        pybullet.setGravity(*scene.gravity, physicsClientId=self.client)
        self.damping = {k: v for k, v in options.items() if k in DYNAMICS}
        self.names: dict[int, str] = {}
        self.bodies = [self._body(b) for b in scene.bodies]
        for p in scene.planes:
            self._plane(p.name, p.up, p.offset)
        ids = {name: i for i, name in self.names.items()}
        for pair in scene.apart:
            a, b = (ids[n] for n in sorted(pair))
            for i in (-1, 0):
                for j in (-1, 0):
                    pybullet.setCollisionFilterPair(a, b, i, j, 0, physicsClientId=self.client)
        self.pushed = [
            (i, b) for i, b in zip(self.bodies, scene.bodies, strict=True) if np.any(b.force)
        ]

    def _surface(self, body: int, link: int = -1, **more: object) -> None:
        pybullet.changeDynamics(
            body,
            link,
            lateralFriction=math.sqrt(self.scene.friction),
            restitution=math.sqrt(self.scene.restitution),
            physicsClientId=self.client,
            **more,
        )

    def _plane(self, name: str, up: np.ndarray, offset: float) -> None:
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_PLANE, planeNormal=list(up), physicsClientId=self.client
        )
        body = pybullet.createMultiBody(
            0, shape, basePosition=list(up * offset), physicsClientId=self.client
        )
        self.names[body] = name
        self._surface(body)

    def _shape(self, b: Body) -> int:
        if b.part.kind == "ball":
            kind = {"shapeType": pybullet.GEOM_SPHERE, "radius": float(b.part.size[0])}
        elif b.part.kind == "box":
            kind = {"shapeType": pybullet.GEOM_BOX, "halfExtents": b.part.size.tolist()}
        else:
            kind = {"shapeType": pybullet.GEOM_MESH, "vertices": b.part.points.tolist()}
        return pybullet.createCollisionShape(physicsClientId=self.client, **kind)

    def _body(self, b: Body) -> int:
        holds = self.scene.holds(b)
        if holds in AXES:
            return self._slider(b, holds)
        body = pybullet.createMultiBody(
            0.0 if holds == "fixed" else b.mass,
            self._shape(b),
            basePosition=b.pos.tolist(),
            baseOrientation=_xyzw(b.quat),
            physicsClientId=self.client,
        )
        self.names[body] = b.name
        inertia = np.zeros(3) if holds else b.inertia  # none: it does not turn
        moved = {} if holds == "fixed" else {"localInertiaDiagonal": inertia.tolist()}
        self._surface(body, **moved, **self.damping)
        pybullet.resetBaseVelocity(
            body, b.vel.tolist(), b.omega.tolist(), physicsClientId=self.client
        )
        return body

    def _slider(self, b: Body, axis: str) -> int:
        """A link on a prismatic joint; its motor, which there is by default, is switched off."""
        if np.any(b.vel):
            raise Unsupported("a slider that moves at the start")
        body = pybullet.createMultiBody(
            0.0,
            -1,
            basePosition=b.pos.tolist(),
            linkMasses=[b.mass],
            linkCollisionShapeIndices=[self._shape(b)],
            linkVisualShapeIndices=[-1],
            linkPositions=[[0, 0, 0]],
            linkOrientations=[[0, 0, 0, 1]],
            linkInertialFramePositions=[[0, 0, 0]],
            linkInertialFrameOrientations=[[0, 0, 0, 1]],
            linkParentIndices=[0],
            linkJointTypes=[pybullet.JOINT_PRISMATIC],
            linkJointAxis=[np.eye(3)[AXES.index(axis)].tolist()],
            physicsClientId=self.client,
        )
        self.names[body] = b.name
        pybullet.setJointMotorControl2(
            body, 0, pybullet.VELOCITY_CONTROL, force=0, physicsClientId=self.client
        )
        self._surface(body, 0, **self.damping)
        return body

    def step(self) -> None:
        for i, b in self.pushed:
            link = 0 if self.scene.holds(b) in AXES else -1
            pos = self._state(i, b)[0]
            pybullet.applyExternalForce(
                i,
                link,
                b.force.tolist(),
                list(pos),
                pybullet.WORLD_FRAME,
                physicsClientId=self.client,
            )
        pybullet.stepSimulation(physicsClientId=self.client)

    def _state(self, i: int, b: Body) -> tuple:
        if self.scene.holds(b) in AXES:
            s = pybullet.getLinkState(
                i, 0, computeLinkVelocity=1, computeForwardKinematics=1, physicsClientId=self.client
            )
            return s[0], s[1], s[6], s[7]
        pos, turn = pybullet.getBasePositionAndOrientation(i, physicsClientId=self.client)
        return (pos, turn, *pybullet.getBaseVelocity(i, physicsClientId=self.client))

    def states(self) -> list:
        out = []
        for i, b in zip(self.bodies, self.scene.bodies, strict=True):
            pos, turn, vel, omega = self._state(i, b)
            out.append(
                (np.array(pos), np.array([turn[3], *turn[:3]]), np.array(vel), np.array(omega))
            )
        return out

    def contacts(self) -> list[Contact]:
        out = []
        moving = {b.name for b in self.scene.bodies}
        for c in pybullet.getContactPoints(physicsClientId=self.client) or ():
            force = np.array(c[7]) * c[9] + np.array(c[11]) * c[10] + np.array(c[13]) * c[12]
            a, b = self.names[c[1]], self.names[c[2]]
            if a in moving:
                out.append(Contact(a, b, np.array(c[5]), force))
            else:
                out.append(Contact(b, a, np.array(c[5]), -force))
        return out

"""DART, through dartpy: one skeleton a body. Options: detector (fcl, bullet, dart, ode), method
(dantzig, gauss_seidel; DART by default takes the first, and the second where that fails)."""

from __future__ import annotations

import dartpy as dart
import numpy as np

from engine_room.geometry import rotation
from engine_room.motion import Contact
from engine_room.scene import AXES, Body, Plane, Scene, Unsupported

FAR, THICK = 50.0, 1.0  # half length and half thickness of a box that stands for a half-space [m]


def version() -> str:
    return dart.__version__


def _detector(word: str) -> dart.collision.CollisionDetector:
    return {
        "fcl": dart.collision.FCLCollisionDetector,
        "bullet": dart.collision.BulletCollisionDetector,
        "dart": dart.collision.DARTCollisionDetector,
        "ode": dart.collision.OdeCollisionDetector,
    }[word]()


def _transform(turn: np.ndarray, pos: np.ndarray) -> dart.math.Isometry3:
    t = dart.math.Isometry3()
    t.set_rotation(turn)
    t.set_translation(pos)
    return t


class Simulation:
    def __init__(self, scene: Scene, options: dict, step: float) -> None:
        self.scene = scene
        self.world = dart.simulation.World()
        self.world.setTimeStep(step)
        self.world.setGravity(scene.gravity)
        constraints = self.world.getConstraintSolver()
        if "detector" in options:
            constraints.setCollisionDetector(_detector(options["detector"]))
        if "method" in options:
            first = {
                "dantzig": dart.constraint.DantzigBoxedLcpSolver,
                "gauss_seidel": dart.constraint.PgsBoxedLcpSolver,
            }[options["method"]]
            constraints.setBoxedLcpSolver(first())
        self.nodes = [self._body(b) for b in scene.bodies]
        self.apart(scene, constraints)
        for p in scene.planes:
            self._plane(p)
        self.names = {n.getName() for n in self.nodes}

    def apart(self, scene: Scene, constraints: dart.constraint.ConstraintSolver) -> None:
        index = scene.index()
        for pair in scene.apart:
            a, b = (self.nodes[index[n]] for n in sorted(pair))
            group = constraints.getCollisionOption().collisionFilter
            group.addBodyNodePairToBlackList(a, b)

    def _collides(self, node: dart.dynamics.BodyNode, shape: dart.dynamics.Shape) -> None:
        made = node.createShapeNode(shape)
        made.createCollisionAspect()
        surface = made.createDynamicsAspect()
        surface.setFrictionCoeff(self.scene.friction)
        surface.setRestitutionCoeff(self.scene.restitution)

    def _plane(self, p: Plane) -> None:
        skeleton = dart.dynamics.Skeleton()
        joint, node = skeleton.createWeldJointAndBodyNodePair()
        node.setName(p.name)
        side = np.eye(3)[int(np.argmin(np.abs(p.up)))]
        x = np.cross(side, p.up) / np.linalg.norm(np.cross(side, p.up))
        turn = np.column_stack([x, np.cross(p.up, x), p.up])
        joint.setTransformFromParentBodyNode(_transform(turn, p.up * (p.offset - THICK)))
        self._collides(node, dart.dynamics.BoxShape([2 * FAR, 2 * FAR, 2 * THICK]))
        self.world.addSkeleton(skeleton)

    def _shape(self, b: Body) -> dart.dynamics.Shape:
        if b.part.kind == "ball":
            return dart.dynamics.SphereShape(float(b.part.size[0]))
        if b.part.kind == "box":
            return dart.dynamics.BoxShape(2 * b.part.size)
        raise Unsupported("a polygon: no convex shape of points in dartpy")

    def _body(self, b: Body) -> dart.dynamics.BodyNode:
        skeleton = dart.dynamics.Skeleton()
        holds = self.scene.holds(b)
        make = {
            "": skeleton.createFreeJointAndBodyNodePair,
            "turns": skeleton.createTranslationalJointAndBodyNodePair,
            "fixed": skeleton.createWeldJointAndBodyNodePair,
        }.get(holds, skeleton.createPrismaticJointAndBodyNodePair)
        joint, node = make()
        node.setName(b.name)
        joint.setName(f"joint_{b.name}")
        if b.inertia.any():
            node.setInertia(dart.dynamics.Inertia(b.mass, np.zeros(3), np.diag(b.inertia)))
        else:
            node.setMass(b.mass)
        turn = rotation(b.quat)
        joint.setTransformFromParentBodyNode(_transform(turn, b.pos))
        if holds == "":
            skeleton.setVelocities(np.concatenate([turn.T @ b.omega, turn.T @ b.vel]))
        elif holds == "turns":
            skeleton.setVelocities(turn.T @ b.vel)
        elif holds in AXES:
            joint.setAxis(turn.T @ np.eye(3)[AXES.index(holds)])
            skeleton.setVelocities([b.vel[AXES.index(holds)]])
        self._collides(node, self._shape(b))
        self.world.addSkeleton(skeleton)
        return node

    def step(self) -> None:
        for node, b in zip(self.nodes, self.scene.bodies, strict=True):
            if np.any(b.force):
                node.addExtForce(b.force, np.zeros(3), False, True)
        self.world.step()

    def states(self) -> list:
        out = []
        for node in self.nodes:
            t = node.getWorldTransform()
            turn = t.to_quaternion() if hasattr(t, "to_quaternion") else t.quaternion()
            q = np.array([turn.w(), turn.x(), turn.y(), turn.z()])
            out.append(
                (
                    np.array(t.translation()),
                    q,
                    np.array(node.getCOMLinearVelocity()),
                    np.array(node.getAngularVelocity()),
                )
            )
        return out

    def contacts(self) -> list[Contact]:
        out = []
        for c in self.world.getLastCollisionResult().getContacts():
            a, b = (_node(o).getName() for o in (c.collisionObject1, c.collisionObject2))
            point, force = np.array(c.point), np.array(c.force)
            out.append(
                Contact(a, b, point, force) if a in self.names else Contact(b, a, point, -force)
            )
        return out


def _node(thing: dart.collision.CollisionObject) -> dart.dynamics.BodyNode:
    return thing.getShapeFrame().asShapeNode().getBodyNodePtr()

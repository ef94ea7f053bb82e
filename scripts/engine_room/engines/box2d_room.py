"""Box2D (pybox2d 2.3): planar scenes as they are. Options are the iterations of its step. Its
polygons and edges touch by a skin of 10 mm; they are made smaller by it, so that bodies are as
large as the scene says."""

from __future__ import annotations

import Box2D
import numpy as np

from engine_room.motion import Contact
from engine_room.scene import AXES, Body, Scene, Unsupported

SKIN = 2 * 0.005  # b2_polygonRadius [m]
FAR = 100.0  # half length of an edge that stands for a half-space [m]


def version() -> str:
    return Box2D.__version__


class Listener(Box2D.b2ContactListener):
    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple] = []

    def PostSolve(self, contact: Box2D.b2Contact, impulse: Box2D.b2ContactImpulse) -> None:
        a, b = contact.fixtureA.body.userData, contact.fixtureB.body.userData
        manifold = contact.worldManifold
        up = np.array([*manifold.normal, 0.0])
        along = np.array([up[1], -up[0], 0.0])
        for k in range(impulse.count):  # fewer than points where two of them say the same
            on_b = up * impulse.normalImpulses[k] + along * impulse.tangentImpulses[k]
            self.found.append((a, b, np.array([*manifold.points[k], 0.0]), on_b))


class Simulation:
    def __init__(self, scene: Scene, options: dict, step: float) -> None:
        if scene.dim != 2:
            raise Unsupported("planar scenes only")
        self.scene, self.h, self.options = scene, step, options
        self.world = Box2D.b2World(gravity=scene.gravity[:2].tolist(), doSleep=False)
        self.ground = self.world.CreateStaticBody()
        self.listener = Listener()
        self.world.contactListener = self.listener
        for p in scene.planes:
            along = np.array([-p.up[1], p.up[0]])
            foot = p.up[:2] * (p.offset - SKIN)
            body = self.world.CreateStaticBody()
            body.userData = p.name
            body.CreateEdgeFixture(
                vertices=[(foot - FAR * along).tolist(), (foot + FAR * along).tolist()],
                friction=scene.friction,
                restitution=scene.restitution,
            )
        self.bodies = [self._body(b) for b in scene.bodies]

    def _body(self, b: Body) -> Box2D.b2Body:
        holds = self.scene.holds(b)
        surface = {
            "friction": self.scene.friction,
            "restitution": self.scene.restitution,
            "density": 1.0,
        }
        if any(b.name in pair for pair in self.scene.apart):
            surface["groupIndex"] = -1
        turn = 2.0 * np.arctan2(b.quat[3], b.quat[0])
        make = self.world.CreateStaticBody if holds == "fixed" else self.world.CreateDynamicBody
        body = make(
            position=b.pos[:2].tolist(), angle=float(turn), fixedRotation=holds not in ("", "fixed")
        )
        if b.part.kind == "ball":
            body.CreateCircleFixture(radius=float(b.part.size[0]), **surface)
        else:
            half = len(b.part.points) // 2
            corners = b.part.points[:half, :2] if b.part.kind == "hull" else _rectangle(b.part.size)
            inner = smaller(corners, SKIN)
            body.CreatePolygonFixture(vertices=[tuple(map(float, c)) for c in inner], **surface)
        body.userData = b.name
        if holds != "fixed":
            body.massData = Box2D.b2MassData(mass=b.mass, I=float(b.inertia[2]), center=(0, 0))
            body.linearVelocity = b.vel[:2].tolist()
            body.angularVelocity = float(b.omega[2])
        if holds in AXES:
            self.world.CreatePrismaticJoint(
                bodyA=self.ground,
                bodyB=body,
                anchor=body.position,
                axis=np.eye(3)[AXES.index(holds)][:2].tolist(),
            )
        return body

    def step(self) -> None:
        self.listener.found = []
        for body, b in zip(self.bodies, self.scene.bodies, strict=True):
            if np.any(b.force):
                body.ApplyForceToCenter(b.force[:2].tolist(), True)
        self.world.Step(
            self.h, self.options["velocityIterations"], self.options["positionIterations"]
        )
        self.world.ClearForces()

    def states(self) -> list:
        out = []
        for body in self.bodies:
            half = body.angle / 2.0
            out.append(
                (
                    np.array([*body.worldCenter, 0.0]),
                    np.array([np.cos(half), 0.0, 0.0, np.sin(half)]),
                    np.array([*body.linearVelocity, 0.0]),
                    np.array([0.0, 0.0, body.angularVelocity]),
                )
            )
        return out

    def contacts(self) -> list[Contact]:
        moving = {b.name for b in self.scene.bodies}
        return [
            Contact(b, a, point, on_b / self.h)
            if b in moving
            else Contact(a, b, point, -on_b / self.h)
            for a, b, point, on_b in self.listener.found
        ]


def smaller(corners: np.ndarray, skin: float) -> np.ndarray:
    """A convex polygon, counter-clockwise, with every side moved inwards. Unsupported: it is too
    thin for that."""
    sides = np.roll(corners, -1, axis=0) - corners
    inward = np.column_stack([-sides[:, 1], sides[:, 0]])
    inward /= np.linalg.norm(inward, axis=1)[:, None]
    reach = np.sum(inward * corners, axis=1) + skin
    out = np.array(
        [np.linalg.solve(inward[[k - 1, k]], reach[[k - 1, k]]) for k in range(len(corners))]
    )
    turned = np.sum((np.roll(out, -1, axis=0) - out) * sides, axis=1)
    if np.any(turned <= 0) or np.any(out @ inward.T < reach - 1e-12):
        raise Unsupported(f"a polygon thinner than its skin of {1e3 * skin:g} mm on each side")
    return out


def _rectangle(half: np.ndarray) -> np.ndarray:
    return np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half[:2]

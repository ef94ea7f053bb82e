"""Drake: a discrete MultibodyPlant. Options: discrete_contact_approximation, compliance (compliant:
hydroelastic contact of every shape; without it, point contact), and the other settings of
MultibodyPlantConfig."""

from __future__ import annotations

import numpy as np
from pydrake import all as drake

from engine_room.geometry import rotation
from engine_room.motion import Contact
from engine_room.scene import AXES, Body, Scene, Unsupported


def version() -> str:
    from importlib.metadata import version as installed

    return installed("drake")


def _obj(points: np.ndarray) -> str:
    """A Wavefront text of corners; Drake takes their convex hull, and wants a face."""
    lines = [f"v {x:.17g} {y:.17g} {z:.17g}" for x, y, z in points]
    return "\n".join([*lines, "f 1 2 3", ""])


def _shape(b: Body) -> drake.Shape:
    if b.part.kind == "ball":
        return drake.Sphere(float(b.part.size[0]))
    if b.part.kind == "box":
        return drake.Box(*(2 * b.part.size))
    mesh = drake.InMemoryMesh(mesh_file=drake.MemoryFile(_obj(b.part.points), ".obj", b.name))
    return drake.Convex(mesh, 1.0)


class Simulation:
    def __init__(self, scene: Scene, options: dict, step: float) -> None:
        if scene.restitution > 0:
            raise Unsupported("no coefficient of restitution")
        self.scene, self.h, self.steps = scene, step, 0
        given = dict(options)
        self.compliance = given.pop("compliance", "")
        builder = drake.DiagramBuilder()
        graph = drake.SceneGraphConfig()
        if self.compliance:
            graph.default_proximity_properties.compliance_type = self.compliance
        config = drake.MultibodyPlantConfig(time_step=step, **given)
        self.plant, scene_graph = drake.AddMultibodyPlant(config, graph, builder)
        self.plant.mutable_gravity_field().set_gravity_vector(scene.gravity)
        self.bodies = [self._body(b) for b in scene.bodies]
        self._planes()
        self._apart(scene_graph)
        self.plant.Finalize()
        self.diagram = builder.Build()
        self.simulator = drake.Simulator(self.diagram)
        self.context = self.plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        self._start()
        self._push()
        self.simulator.Initialize()

    def _surface(
        self, body: drake.RigidBody, pose: drake.RigidTransform, shape: drake.Shape, name: str
    ) -> None:
        rub = drake.CoulombFriction(self.scene.friction, self.scene.friction)
        surface = drake.ProximityProperties()
        drake.AddContactMaterial(friction=rub, properties=surface)
        if self.compliance and isinstance(shape, drake.HalfSpace):
            drake.AddRigidHydroelasticProperties(properties=surface)
        self.plant.RegisterCollisionGeometry(body, pose, shape, name, surface)

    def _planes(self) -> None:
        for p in self.scene.planes:
            pose = drake.HalfSpace.MakePose(p.up, p.up * p.offset)
            self._surface(self.plant.world_body(), pose, drake.HalfSpace(), p.name)

    def _body(self, b: Body) -> drake.RigidBody:
        holds = self.scene.holds(b)
        inertia = b.inertia if b.inertia.any() else np.full(3, b.mass * 0.01)
        i, j, k = inertia / b.mass
        spatial = drake.SpatialInertia(b.mass, np.zeros(3), drake.UnitInertia(i, j, k))
        body = self.plant.AddRigidBody(b.name, spatial)
        self._surface(body, drake.RigidTransform(), _shape(b), b.name)
        if holds:
            self._rail(b, body, b.free)
        return body

    def _rail(self, b: Body, body: drake.RigidBody, axes: tuple[str, ...]) -> None:
        """A chain of prismatic joints along the axes that are left; none: welded."""
        frame = self.plant.world_frame()
        start = drake.RigidTransform(drake.RotationMatrix(rotation(b.quat)), b.pos)
        if not axes:
            self.plant.WeldFrames(frame, body.body_frame(), start)
            return
        nothing = drake.SpatialInertia.Zero()
        foot = self.plant.AddFrame(
            drake.FixedOffsetFrame(f"{b.name}_foot", frame, drake.RigidTransform(b.pos))
        )
        for k, a in enumerate(axes):
            last = k == len(axes) - 1
            child = body if last else self.plant.AddRigidBody(f"{b.name}_{a}", nothing)
            turn = drake.RigidTransform(drake.RotationMatrix(rotation(b.quat)).inverse())
            end = (
                self.plant.AddFrame(
                    drake.FixedOffsetFrame(f"{b.name}_end", body.body_frame(), turn)
                )
                if last
                else child.body_frame()
            )
            axis = np.eye(3)[AXES.index(a)]
            self.plant.AddJoint(drake.PrismaticJoint(f"{b.name}_{a}", foot, end, axis))
            foot = end

    def _apart(self, scene_graph: drake.SceneGraph) -> None:
        index = self.scene.index()
        for pair in self.scene.apart:
            ids = [
                self.plant.GetCollisionGeometriesForBody(self.bodies[index[n]])
                for n in sorted(pair)
            ]
            scene_graph.collision_filter_manager().Apply(
                drake.CollisionFilterDeclaration().ExcludeBetween(
                    *(drake.GeometrySet(i) for i in ids)
                )
            )

    def _start(self) -> None:
        for b, body in zip(self.scene.bodies, self.bodies, strict=True):
            if self.scene.holds(b):
                for a in b.free:
                    joint = self.plant.GetJointByName(f"{b.name}_{a}")
                    joint.set_translation_rate(self.context, b.vel[AXES.index(a)])
                continue
            pose = drake.RigidTransform(drake.RotationMatrix(rotation(b.quat)), b.pos)
            self.plant.SetFreeBodyPose(self.context, body, pose)
            self.plant.SetFreeBodySpatialVelocity(
                self.context, body, drake.SpatialVelocity(b.omega, b.vel)
            )

    def _push(self) -> None:
        forces = []
        for b, body in zip(self.scene.bodies, self.bodies, strict=True):
            if np.any(b.force):
                one = drake.ExternallyAppliedSpatialForce()
                one.body_index = body.index()
                one.p_BoBq_B = np.zeros(3)
                one.F_Bq_W = drake.SpatialForce(np.zeros(3), b.force)
                forces.append(one)
        if forces:
            port = self.plant.get_applied_spatial_force_input_port()
            port.FixValue(self.context, forces)

    def step(self) -> None:
        self.steps += 1
        self.simulator.AdvanceTo(self.steps * self.h)

    def states(self) -> list:
        out = []
        for body in self.bodies:
            pose = self.plant.EvalBodyPoseInWorld(self.context, body)
            v = self.plant.EvalBodySpatialVelocityInWorld(self.context, body)
            q = pose.rotation().ToQuaternion().wxyz()
            out.append(
                (pose.translation().copy(), q, v.translational().copy(), v.rotational().copy())
            )
        return out

    def _named(self, geometry: drake.GeometryId) -> str:
        body = self.plant.GetBodyFromFrameId(self.inspector.GetFrameId(geometry))
        if body.index() == self.plant.world_body().index():
            return self.inspector.GetName(geometry).rpartition("::")[2]
        return body.name()

    def contacts(self) -> list[Contact]:
        results = self.plant.get_contact_results_output_port().Eval(self.context)
        port = self.plant.get_geometry_query_input_port()
        self.inspector = port.Eval(self.context).inspector()
        moving = {b.name for b in self.scene.bodies}
        found = []
        for i in range(results.num_point_pair_contacts()):
            c = results.point_pair_contact_info(i)
            pair = c.point_pair()
            found.append(
                (
                    self._named(pair.id_B),
                    self._named(pair.id_A),
                    c.contact_point(),
                    c.contact_force(),
                )
            )
        for i in range(results.num_hydroelastic_contacts()):
            c = results.hydroelastic_contact_info(i)
            s = c.contact_surface()
            found.append(
                (
                    self._named(s.id_M()),
                    self._named(s.id_N()),
                    s.centroid(),
                    c.F_Ac_W().translational(),
                )
            )
        return [
            Contact(a, b, np.array(p), np.array(f))
            if a in moving
            else Contact(b, a, np.array(p), -np.array(f))
            for a, b, p, f in found
        ]

"""The judge of scripts/engines against closed forms, the translation of scenes, the isolation of
runs, the rows; and, where an engine is installed, what its documentation's formula says of it."""

import dataclasses
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from bench import engine_rows, engines  # noqa: E402
from engine_room import geometry, isolate, judge, motion, run, scene  # noqa: E402

BINARY = os.environ.get("LCPBENCH", str(ROOT / "build" / "lcpbench"))
VENV = pathlib.Path(os.environ.get("LCPBENCH_ENGINES", ROOT / ".venv-engines"))
LAWS = ["coulomb"]
UPRIGHT = [1.0, 0.0, 0.0, 0.0]


def body(name="b", half=(0.1, 0.1, 0.1), mass=2.0, **more):
    """One of a scene file."""
    shape = {"type": "box", "half": list(half)}
    return {
        "name": name,
        "shape": shape,
        "mass": mass,
        "inertia": [0.1, 0.2, 0.3],
        "pos": [0, 0, 0.1],
        "quat": UPRIGHT,
    } | more


def data(bodies, **more):
    """A scene file with a floor."""
    floor = {"name": "floor", "normal": [0, 0, 1], "offset": 0}
    return {
        "id": "test",
        "dim": 3,
        "T": 1.0,
        "gravity": [0, 0, -10.0],
        "bodies": bodies,
        "static": [floor],
        "loads": [],
        "joints": [],
        "no_collision": [],
        "checks": [],
        "friction": {"default": 0.5, "pairs": []},
        "restitution": {"default": 0.0, "pairs": []},
    } | more


def moving(s, at, t=None, contacts=None):
    """A motion of the scene's bodies: at(t) tells (pos, quat, vel, omega) of each."""
    t = np.linspace(0, 1, 11) if t is None else t
    rows = [at(x) for x in t]
    columns = [
        np.array([[np.array(b[k], dtype=float) for b in row] for row in rows]) for k in range(4)
    ]
    return motion.Motion(t, *columns, contacts)


def turned(axis, by):
    return [np.cos(by / 2), *(np.sin(by / 2) * np.array(axis, dtype=float))]


class Checks(unittest.TestCase):
    def value(self, check, at):
        s = scene.of(data([body()], checks=[check]))
        return judge.error(s, moving(s, at), LAWS)

    def test_a_state_is_interpolated(self):
        check = {"type": "state", "var": "b.x", "t": 0.55, "value": 1.0}
        wrong, what = self.value(check, lambda t: [([2 * t, 0, 0], UPRIGHT, [2, 0, 0], [0] * 3)])
        self.assertAlmostEqual(wrong, 0.1)
        self.assertEqual(what, "state b.x")

    def test_drift_of_a_vector_is_a_distance_and_along_a_direction_a_component(self):
        way = {"type": "max_drift", "var": "b.pos", "value": 0.0}
        at = lambda t: [([3 * t, 4 * t, 7.0], UPRIGHT, [0] * 3, [0] * 3)]  # noqa: E731
        self.assertAlmostEqual(self.value(way, at)[0], 5.0)
        self.assertAlmostEqual(self.value(way | {"dir": [0, 1, 0]}, at)[0], 4.0)

    def test_a_window_is_a_part_of_the_run(self):
        check = {"type": "window_max", "var": "b.z", "t0": 0.0, "t1": 0.5, "value": 0.5}
        wrong, _ = self.value(check, lambda t: [([0, 0, t], UPRIGHT, [0] * 3, [0] * 3)])
        self.assertAlmostEqual(wrong, 0.0)

    def test_an_angle_goes_on_beyond_a_turn(self):
        q = np.array([turned([0, 0, 1], 7.0 * t) for t in np.linspace(0, 1, 30)])
        self.assertAlmostEqual(judge.angle(q)[-1], 7.0)

    def test_checks_of_other_laws_and_of_facets_are_left_out(self):
        check = {"type": "state", "var": "b.x", "t": 1, "value": 0}
        self.assertTrue(judge.applies(check, LAWS))
        self.assertFalse(judge.applies(check | {"forms": ["penalty"]}, LAWS))
        self.assertFalse(judge.applies(check | {"nd": 4}, LAWS))
        self.assertFalse(judge.applies({"type": "contact_force", "value": 1}, LAWS))


class Overlaps(unittest.TestCase):
    def depth(self, bodies, *poses, **more):
        s = scene.of(data(bodies, **more))
        at = lambda t: [(p, q, [0] * 3, [0] * 3) for p, q in poses]  # noqa: E731
        return judge.penetration(s, moving(s, at))

    def test_a_box_in_the_floor(self):
        self.assertAlmostEqual(self.depth([body()], ([0, 0, 0.09], UPRIGHT)), 0.01)
        self.assertEqual(self.depth([body()], ([0, 0, 0.11], UPRIGHT)), 0.0)

    def test_a_box_on_its_edge_reaches_further(self):
        edge = turned([1, 0, 0], np.pi / 4)
        self.assertAlmostEqual(self.depth([body()], ([0, 0, 0.1], edge)), 0.1 * 2**0.5 - 0.1)

    def test_two_boxes_and_one_that_is_turned_about_the_way_between_them(self):
        two = [body(), body("c")]
        for by in (0.0, 0.7):
            pose = ([0, 0, 1.19], turned([0, 0, 1], by))
            self.assertAlmostEqual(self.depth(two, ([0, 0, 1], UPRIGHT), pose), 0.01)

    def test_a_pair_that_passes_through_each_other_is_left_out(self):
        two = [body(), body("c")]
        pose = ([0, 0, 1], UPRIGHT)
        self.assertAlmostEqual(self.depth(two, pose, pose), 0.2)
        self.assertEqual(self.depth(two, pose, pose, no_collision=[["b", "c"]]), 0.0)

    def test_balls_and_a_ball_on_a_box(self):
        ball = body(shape={"type": "sphere", "r": 0.2})
        two = [ball, body("c", shape={"type": "sphere", "r": 0.3})]
        self.assertAlmostEqual(
            self.depth(two, ([0, 0, 1], UPRIGHT), ([0.3, 0.0, 1.3], UPRIGHT)), 0.5 - 0.18**0.5
        )
        on_box = [ball, body("c")]
        self.assertAlmostEqual(
            self.depth(on_box, ([0, 0, 1.25], UPRIGHT), ([0, 0, 1], UPRIGHT)), 0.05
        )

    def test_edges_that_cross_are_told_by_their_common_normal(self):
        a = scene.of(data([body()])).bodies[0]
        up = turned([0, 1, 0], np.pi / 4)
        across = turned([1, 0, 0], np.pi / 4)
        reach = 2 * 0.1 * 2**0.5
        gap, way = geometry.between(
            a, np.array([0, 0, reach - 0.01]), np.array(up), a, np.zeros(3), np.array(across)
        )
        self.assertAlmostEqual(gap, -0.01)
        np.testing.assert_allclose(way, [0, 0, 1], atol=1e-12)


class Motions(unittest.TestCase):
    def setUp(self):
        self.scene = scene.of(data([body()]))

    def test_creep_is_a_mean_speed_after_rest(self):
        at = lambda t: [([1e-3 * t, 0, 0.1], UPRIGHT, [0] * 3, [0] * 3)]  # noqa: E731
        m = moving(self.scene, at)
        self.assertAlmostEqual(judge.creep(self.scene, m, 0.5), 1e-3)
        self.assertIsNone(judge.creep(self.scene, m, None))

    def test_free_fall_keeps_its_energy_and_a_kick_does_not(self):
        fall = lambda t: [([0, 0, 9 - 5 * t * t], UPRIGHT, [0, 0, -10 * t], [0] * 3)]  # noqa: E731
        self.assertAlmostEqual(judge.energy_gain(self.scene, moving(self.scene, fall)), 0.0)
        kick = lambda t: [([0, 0, 0.1], UPRIGHT, [3.0 * (t > 0.5), 0, 0], [0] * 3)]  # noqa: E731
        self.assertAlmostEqual(judge.energy_gain(self.scene, moving(self.scene, kick)), 9.0)

    def test_a_turn_counts_in_the_axes_of_the_body(self):
        q = turned([0, 1, 0], np.pi / 2)  # the body's z is the world's x
        spin = lambda t: [([0, 0, 0.1], q, [0] * 3, [2.0, 0, 0])]  # noqa: E731
        m = moving(self.scene, spin)
        rest = 2.0 * 10 * 0.1
        self.assertAlmostEqual(judge.energy(self.scene, m)[0] - rest, 0.5 * 0.3 * 4.0)

    def test_work_of_loads_is_no_gain(self):
        load = {"type": "constant_force", "body": "b", "force": [1, 0, 0], "torque": [0, 0, 0]}
        s = scene.of(data([body()], loads=[load]))
        self.assertIsNone(judge.energy_gain(s, moving(s, lambda t: [([0] * 3, UPRIGHT) * 2])))


class Law(unittest.TestCase):
    """A block of 2 kg on the floor, 20 N, mu = 0.5, steps of 0.1 s: m/h = 20 kg/s."""

    def residual(self, force, speed):
        s = scene.of(data([body()]))
        at = lambda t: [([0, 0, 0.1], UPRIGHT, speed, [0] * 3)]  # noqa: E731
        point = np.array([0, 0, 0.1])
        contact = [motion.Contact("b", "floor", point, np.array(force, dtype=float))]
        return judge.coulomb(s, moving(s, at, contacts=[contact] * 10))

    def test_exact_friction_has_none(self):
        self.assertAlmostEqual(self.residual([-10, 0, 20], [1, 0, 0]), 0.0)  # slips
        self.assertAlmostEqual(self.residual([-7, 3, 20], [0, 0, 0]), 0.0)  # sticks
        self.assertAlmostEqual(self.residual([-6, -8, 20], [3, 4, 0]), 0.0)

    def test_no_friction_and_friction_the_wrong_way(self):
        self.assertAlmostEqual(self.residual([0, 0, 20], [1, 0, 0]), 0.5)
        self.assertAlmostEqual(self.residual([10, 0, 20], [1, 0, 0]), 1.0)

    def test_too_much_friction(self):
        self.assertAlmostEqual(self.residual([-15, 0, 20], [1, 0, 0]), 0.25)

    def test_creep_below_the_bound_is_the_force_that_would_stop_it(self):
        self.assertAlmostEqual(self.residual([-4, 0, 20], [1e-2, 0, 0]), 20 * 1e-2 / 20)

    def test_the_arm_of_a_turn_counts(self):
        s = scene.of(data([body()]))
        at = lambda t: [([0, 0, 0.1], UPRIGHT, [0] * 3, [0, 0, 2.0])]  # noqa: E731
        c = motion.Contact("b", "floor", np.array([0.1, 0, 0]), np.array([0, -10.0, 20]))
        self.assertAlmostEqual(judge.coulomb(s, moving(s, at, contacts=[[c]] * 10)), 0.0)


class Scenes(unittest.TestCase):
    def load(self, text):
        return scene.load(BINARY, text)

    def test_a_planar_scene_is_slabs_with_the_moment_that_it_gave(self):
        s = self.load("card_house:levels=1")
        self.assertEqual([b.part.kind for b in s.bodies], ["hull", "hull"])
        self.assertEqual(s.bodies[0].part.points.shape, (8, 3))
        self.assertTrue(all(len(b.free) == 6 for b in s.bodies))
        normals, edges = geometry.hull(s.bodies[0].part.points)
        self.assertEqual((len(normals), len(edges)), (4, 4))  # two of six faces are parallel

    def test_driven_bodies_stand_still_in_a_frame_that_moves(self):
        s = self.load("gripper:lift=2,duration=0.5")
        np.testing.assert_allclose(s.gravity, [0, -11.81, 0])
        self.assertEqual([s.holds(b) for b in s.bodies], ["turns", "x", "x"])
        m = motion.in_world(s, moving(s, lambda t: [([0] * 3, UPRIGHT, [0] * 3, [0] * 3)] * 3))
        np.testing.assert_allclose(m.pos[-1, 0], [0, 1.0, 0])
        np.testing.assert_allclose(m.vel[-1, 0], [0, 2.0, 0])

    def test_what_is_not_given_to_engines_is_named(self):
        for text, word in (("chain", "joints"), ("conveyor", "moving"), ("stack:n=-1", "n=-1")):
            with self.assertRaisesRegex(scene.Unsupported, word):
                self.load(text)

    def test_a_scene_of_ones_own_takes_the_place_of_those_listed(self):
        """As lcpbench takes it, or a file, which is told by its whole name."""
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "mine.json"
            path.write_text("{}", encoding="utf-8")
            self.assertEqual(run.own(str(path)), str(path.resolve()))
        self.assertEqual(run.own("stack:n=2,dim=2"), "stack:n=2,dim=2")
        arguments = ["--engines", "lcpbench", "--steps", "0.01", "stack:n=2,duration=0.1"]
        with unittest.mock.patch.object(sys, "argv", ["run.py", "--binary", BINARY, *arguments]):
            asked = run.Campaign(run.arguments())
        found = asked.jobs("lcpbench")
        self.assertEqual({j.row.problem for j in found}, {"stack:n=2,duration=0.1"})
        self.assertIn("--steps 0.01 stack:n=2,duration=0.1", found[0].row.command)

    def test_our_own_run_is_exact_where_theory_is(self):
        entry = next(e for e in run.experiments.of("engines.entries") if run.called(e) == "incline")
        s = self.load(entry["scene"])
        way = {"formulation": "velocity", "solver": "lemke"}
        found, times, _, status, _ = run.ours.run(BINARY, entry["scene"], s, way, 0.01, 60, 1, 9)
        verdict = judge.judge(s, found, found, ["velocity"], entry["rests"])
        self.assertEqual(status, "ok")
        self.assertEqual(len(times), 1)
        for small in (verdict.error, verdict.penetration, verdict.creep, verdict.coulomb):
            self.assertLess(small, 1e-9)
        self.assertEqual(verdict.n_contact, 4)


class Isolation(unittest.TestCase):
    def test_every_end_has_its_word(self):
        def refuses():
            raise scene.Unsupported("no wheels")

        self.assertEqual(isolate.call(lambda: 6 * 7, 10), ("ok", 42))
        self.assertEqual(isolate.call(os.abort, 10), ("crash", "SIGABRT"))
        self.assertEqual(isolate.call(refuses, 10), ("unsupported", "no wheels"))
        word, said = isolate.call(lambda: 1 / 0, 10)
        self.assertEqual(word, "error")
        self.assertIn("ZeroDivisionError", said)
        self.assertEqual(isolate.call(lambda: os._exit(3), 10)[0], "crash")

    def test_a_run_that_hangs_is_ended(self):
        began = time.monotonic()
        self.assertEqual(isolate.call(lambda: time.sleep(60), 0.3)[0], "timeout")
        self.assertLess(time.monotonic() - began, 20)


class Rows(unittest.TestCase):
    row = engine_rows.Row(
        scene="slide",
        engine="mujoco",
        version="1",
        setting="defaults",
        step_s="0.01",
        status="ok",
        error="0.1",
        quantity="state b.x",
        t_step_s="1e-5",
        options='cone=elliptic,solref="1 2"',
    )

    def test_rows_come_back_and_other_columns_are_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            path = engine_rows.write([self.row], pathlib.Path(folder) / "new")
            self.assertEqual(engine_rows.read(path), [self.row])
            self.assertEqual([p.name for p in path.parent.iterdir()], ["engines.csv"])
            path.write_text("scene,engine\n")
            with self.assertRaisesRegex(ValueError, "columns"):
                engine_rows.read(path)

    def test_a_row_that_is_measured_again_takes_its_place(self):
        other = dataclasses.replace(self.row, step_s="0.02")
        again = dataclasses.replace(self.row, error="0.3")
        gone = engine_rows.Row(engine="mujoco", status="absent")
        stays = engine_rows.Row(engine="ode", status="absent")
        found = engine_rows.merged([gone, self.row, stays, other], [again])
        self.assertEqual(found, [again, stays, other])
        self.assertEqual(engine_rows.merged([], [self.row]), [self.row])

    def test_the_figure_shows_what_has_an_error_and_crosses_what_did_not_end_well(self):
        late = dataclasses.replace(self.row, step_s="0.001", error="0", t_step_s="2e-5")
        bad = dataclasses.replace(self.row, engine="lcpbench", setting="a + b", status="stalled")
        gone = dataclasses.replace(self.row, scene="wall", error="", status="timeout")
        absent = engine_rows.Row(engine="ode", status="absent", note="no library")
        section = engines.section([self.row, late, bad, gone, absent])
        panel = section.charts[0].panels[0]
        self.assertEqual(len(section.charts[0].panels), 1)
        self.assertEqual([line.name for line in panel.lines], ["mujoco defaults", "a + b"])
        self.assertEqual(panel.lines[0].x, [1e-2, 2e-2])
        self.assertEqual(panel.lines[0].y, [0.1, engines.FLOOR])
        self.assertEqual(panel.lines[1].bad, [(1e-2, 0.1)])
        self.assertIn("ode (no library)", section.lead)
        self.assertEqual(len(section.tables[1].rows), 4)
        self.assertIsNone(engines.section([]))


@unittest.skipUnless((VENV / "installed").exists(), "engines are not installed: scripts/engines")
class Engines(unittest.TestCase):
    def rows(self, *arguments):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(
                [ROOT / "scripts" / "engines", "--binary", BINARY, "--out", folder, *arguments],
                capture_output=True,
                text=True,
            )
            self.assertEqual(done.returncode, 0, done.stderr)
            return engine_rows.read(pathlib.Path(folder) / engine_rows.FILE)

    def test_soft_friction_creeps_as_its_formula_says(self):
        """MuJoCo, elliptic cone: a friction row in steady creep carries f = b v/R with
        R = (1 - d)/(d m impratio), b = 2/(d_max timeconst), f = m g sin(theta)/4; d = 0.9 at no
        depth, d_max = 0.95, timeconst = 0.02 s."""
        row = self.rows(
            "--engines",
            "mujoco",
            "--scenes",
            "incline",
            "--settings",
            "elliptic",
            "--steps",
            "0.005",
        )[0]
        slope = 9.81 * np.sin(np.radians(20))
        speed = slope / 4 * (0.1 / 0.9) / 10 / (2 / (0.95 * 0.02))
        self.assertEqual(row.status, "ok")
        self.assertAlmostEqual(engine_rows.value(row.creep_m_s) / speed, 1.0, delta=0.03)

    def test_a_thrown_cube_is_lifted_by_the_default_cone(self):
        row = self.rows(
            "--engines",
            "mujoco",
            "--scenes",
            "thrown_cube",
            "--steps",
            "0.01",
            "--settings",
            "defaults",
        )[0]
        self.assertGreater(engine_rows.value(row.error), 0.2)

    def test_a_lifted_cube_slips_with_the_default_cone_only(self):
        found = self.rows(
            "--engines",
            "mujoco",
            "--scenes",
            "lifted_cube",
            "--steps",
            "0.005",
            "--settings",
            "defaults,elliptic,noslip",
        )
        slip = {r.setting: engine_rows.value(r.error) for r in found}
        self.assertGreater(slip["defaults"], 3e-3)
        self.assertLess(slip["elliptic"], slip["defaults"] / 10)
        self.assertLess(slip["noslip"], 1e-6)

    def test_bullets_rigid_bodies_carry_their_weight(self):
        """Two boxes at rest: the forces of the floor add up to m g, four corners a face."""
        built = VENV / "bullet_rigid_room.so"
        if not built.exists():
            self.skipTest("no libbullet-dev when the engines were installed")
        row = self.rows(
            *("--engines", "bullet_rigid", "--settings", "iterated", "--steps", "0.01"),
            "stack:n=2,duration=0.5",
        )[0]
        self.assertEqual((row.status, row.n_contact), ("ok", "8"))
        self.assertRegex(row.version, r"^[0-9]+\.[0-9]+")
        self.assertLess(engine_rows.value(row.penetration_m), 2e-3)
        with unittest.mock.patch.dict(os.environ, {"LCPBENCH_ENGINES": str(VENV)}):
            from engine_room.engines import bullet_rigid_room

            told = scene.load(BINARY, "stack:n=2,duration=0.5")
            made = bullet_rigid_room.Simulation(told, {"iterations": 200}, 0.01)
        for _ in range(100):
            made.step()
        planes = {p.name for p in told.planes}
        held = [c for c in made.contacts() if c.b in planes]
        weight = sum(b.mass for b in told.bodies) * np.linalg.norm(told.gravity)
        self.assertEqual(len(held), 4)
        self.assertAlmostEqual(sum(c.force[2] for c in held) / weight, 1.0, delta=2e-3)
        self.assertLess(max(np.abs(s[2]).max() for s in made.states()), 1e-2)


if __name__ == "__main__":
    unittest.main()

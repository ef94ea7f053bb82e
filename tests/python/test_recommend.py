"""The recommended commands, rerun: the error and the counters of the rows, to the last bit."""

import contextlib
import io
import json
import os
import pathlib
import shlex
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from bench import accuracy, recommend, rows  # noqa: E402

LCPBENCH = os.environ.get("LCPBENCH", str(ROOT / "build" / "lcpbench"))
CAMPAIGN = """
name: accuracy
limits: {time: 20s, memory: 2G, grace: 1s}
sampling: {processes: 1, samples: 1, max_samples: 1, inner: 1e-9s}
parts:
  - name: steps
    problems: ["slide:speed=1,angle_deg=22.5", "gripper:duration=0.1", "bounce:duration=0.6",
               "incline:theta_deg=40,duration=0.1"]
    formulations: ["velocity:facets={4,16}", "regularized:ratio={10,1000}"]
    solvers: [lemke]
    steps: [0.01, 0.0025]
  - name: tolerances
    problems: ["slide:speed=1,angle_deg=22.5"]
    formulations: [regularized]
    solvers: [pgs]
    steps: [0.01]
    tolerances: [1e-3, 1e-6]
"""
LEVELS = ("0.1", "0.01", "0.001", "0.0001")
SAME = {
    "trajectory_error": "err_ref",
    "end_quantity": "end_quantity",
    "end_value": "end_value",
    "res_ncp_rel_max": "res_ncp_rel",
    "rho_max": "rho",
    "n_pivot": "n_pivot",
    "n_iter": "n_iter",
    "n_solves": "n_solves",
    "solution_hash": "solution_hash",
    "lcp_dim_max": "lcp_dim",
    "steps": "n_steps",
}


class Pipes(unittest.TestCase):
    def test_a_reader_that_has_seen_enough_gets_no_traceback(self) -> None:
        """`scripts/recommend ... | head`: more lines than a pipe holds, to a reader that closes it
        at once."""
        words = [sys.executable, "-c", "import bench\nwhile True:\n    print('x' * 1000)"]
        with subprocess.Popen(
            words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=ROOT / "scripts"
        ) as writer:
            writer.stdout.readline()
            writer.stdout.close()
            said = writer.stderr.read()
        self.assertEqual(said, b"")


class Recommended(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.tmp = tempfile.TemporaryDirectory()
        folder = pathlib.Path(cls.tmp.name)
        (folder / "accuracy.yaml").write_text(CAMPAIGN)
        cls.runs = folder / "runs"
        subprocess.run(
            [LCPBENCH, "run", folder / "accuracy.yaml", "--out", cls.runs / "accuracy", "--quiet"],
            check=True,
            stdout=subprocess.DEVNULL,
            stdin=subprocess.DEVNULL,
        )
        cls.cells = rows.cells(rows.load(cls.runs / "accuracy"))

    @classmethod
    def tearDownClass(cls):
        cls.tmp.cleanup()

    def asked(self, *args):
        out, err = io.StringIO(), io.StringIO()
        with (
            mock.patch.object(sys, "argv", ["recommend", str(self.runs), *args]),
            contextlib.redirect_stdout(out),
            contextlib.redirect_stderr(err),
        ):
            code = recommend.main()
        return code, out.getvalue(), err.getvalue()

    def test_printed_commands_repeat_error_and_counters(self):
        commands = set()
        for yardstick in accuracy.YARDSTICKS:
            for level in LEVELS:
                _, text, _ = self.asked("--scene", "*", "--error", level, "--yardstick", yardstick)
                commands.update(
                    line.strip() for line in text.splitlines() if line.startswith("  lcpbench")
                )
        self.assertGreater(len(commands), 5)
        for command in commands:
            row = self.cells[self.cells["command"] == command].iloc[0]
            words = shlex.split(command)
            again = json.loads(
                subprocess.run(
                    [LCPBENCH, *words[1:]], stdin=subprocess.DEVNULL, capture_output=True, text=True
                ).stdout
            )
            again |= {
                key: again["trajectory_error"].get(key) for key in ("end_quantity", "end_value")
            }
            again["trajectory_error"] = again["trajectory_error"].get("error")
            for now, then in SAME.items():
                if again[now] is None:  # no closed form for this scene: the row has none either
                    self.assertNotEqual(row[then], row[then], f"{command}: {now}")
                    continue
                self.assertEqual(again[now], row[then], f"{command}: {now}")

    def test_the_value_at_the_end_is_what_the_prediction_is_held_against(self):
        found = self.cells[(self.cells["problem_family"] == "gripper") & self.cells["good"]]
        self.assertEqual(set(found["end_quantity"]), {"object.y"})
        self.assertEqual(set(found["err_quantity"]), {"state object.y"})
        self.assertEqual(
            (found["end_value"] - found["err_predicted"]).abs().tolist(), found["err_ref"].tolist()
        )

    def test_the_recommended_error_is_kept_by_the_yardstick(self):
        _, text, _ = self.asked("--scene", "slide", "--error", "0.1")
        self.assertIn("regularized", text)  # the faceted cones leave the line
        worst = self.cells[self.cells["formulation_options"] == "facets=4"]["err_ref"].max()
        self.assertGreater(worst, 0.01)

    def test_an_error_may_be_a_share(self):
        """Of the size of the predicted value; the line says of what."""
        size = self.cells[self.cells["problem_family"] == "slide"]["err_predicted"].abs().median()
        _, share, _ = self.asked("--scene", "slide", "--error", "4%")
        first, _, rest = share.partition("\n")
        self.assertRegex(first, rf"slide\S*: 0.04 of {size:.3g} \(")
        _, unit, _ = self.asked("--scene", "slide", "--error", f"{0.04 * size:.17g}")
        self.assertEqual(rest, unit)

    def test_out_of_reach_and_unknown_are_said(self):
        code, text, _ = self.asked("--scene", "bounce", "--error", "1e-12")
        self.assertEqual(code, 3)
        self.assertIn("nothing confirmed reaches 1e-12", text)
        code, _, err = self.asked("--scene", "nosuch", "--error", "1")
        self.assertEqual(code, 2)
        self.assertIn("nosuch", err)


if __name__ == "__main__":
    unittest.main()

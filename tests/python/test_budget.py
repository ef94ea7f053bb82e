"""scripts/reproduce --full --budget: what the reference has is taken from there, a full form that
was begun waits until it tells what the quick form tells, and nothing is lost on the way."""

import contextlib
import io
import lzma
import os
import pathlib
import shutil
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from bench import budget, cut, rows  # noqa: E402

TEXT = """
name: small
limits: {time: 10s}
sampling: {processes: 1, samples: 2, max_samples: 2, inner: 0.0001s}
parts:
  - name: a
    problems: ["random_spd:n={3,4,5,6}"]
    solvers: [lemke, pgs]
    tolerances: [1e-8, 1e-9]
    quick: {solvers: [lemke], tolerances: [1e-8]}
"""


class Budget(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        os.environ["LCPBENCH_CAMPAIGNS"] = str(self.folder / "campaigns")
        self.addCleanup(os.environ.pop, "LCPBENCH_CAMPAIGNS")
        (self.folder / "campaigns").mkdir()
        (self.folder / "campaigns" / "small.yaml").write_text(TEXT)
        self.runs, self.reference = self.folder / "runs-full", self.folder / "reference"
        self.measured = self.folder / "measured"
        for name in ("runs", "runs-full/cut", "reference/cut", "measured/cut"):
            (self.folder / name).mkdir(parents=True)

    def lcpbench(self, *args, code=0):
        done = budget.subprocess.run(
            [os.environ["LCPBENCH"], *map(str, args)], capture_output=True, text=True, check=False
        )
        self.assertEqual(done.returncode, code, done.stderr)

    def commit(self, *names):
        """As scripts/reference packs them."""
        for name in names:
            shutil.copytree(self.measured / name, self.reference / name)
            found = self.reference / name / "results.csv"
            found.with_name("results.csv.xz").write_bytes(lzma.compress(found.read_bytes()))
            found.unlink()

    def spend(self, seconds):
        with contextlib.redirect_stdout(io.StringIO()) as said:
            budget.measure(os.environ["LCPBENCH"], seconds, self.runs, ["small"], self.reference)
        return said.getvalue()

    def test_times_are_read_as_lcpbench_reads_them(self):
        self.assertEqual(
            [budget.seconds(t) for t in ("90", "90s", "40m", "4h")], [90, 90, 2400, 14400]
        )
        for wrong in ("", "0", "-1", "4d", "m", "1h30"):
            with self.assertRaises(ValueError):
                budget.seconds(wrong)

    def test_a_quick_form_stays_until_the_full_one_tells_as_much(self):
        self.lcpbench("run", "small", "--quick", "--quiet", "--out", self.measured / "small")
        (self.measured / "small" / "limits.csv").write_text("build\n")
        self.commit("small")
        budget.adopt(self.reference, self.runs)
        self.assertTrue((self.runs / "small").is_symlink())
        seen = 0
        work = self.runs / "cut" / "small"
        while (self.runs / "small").is_symlink():
            words = self.spend(0.001)  # one process
            count = len(rows.load(work if work.exists() else self.runs / "small"))
            self.assertGreater(count, seen)
            seen = count
            if (self.runs / "small").is_symlink():
                self.assertIn("waits in", words)
                _, manifests = rows.load_all(self.runs)
                self.assertIn("full form begun", cut.forms(manifests))
        found = rows.manifest(self.runs / "small")
        self.assertEqual(found["cut"]["stages"]["quick"], [4, 4])
        self.assertLess(found["cut"]["measured"], 12)
        self.assertTrue((self.runs / "small" / "limits.csv").exists())
        self.assertFalse(work.exists())
        self.assertEqual(cut.form(rows.load_all(self.runs)[1]["small"])[:14], "full form, cut")

    def test_begun_and_whole_forms_of_the_reference_are_gone_on_with(self):
        self.lcpbench("run", "small", "--quick", "--quiet", "--out", self.measured / "small")
        out = self.measured / "cut" / "small"
        self.lcpbench("run", "small", "--quiet", "--budget", "0.001s", "--out", out, code=4)
        self.commit("small", "cut/small")
        budget.adopt(self.reference, self.runs)
        before = (self.runs / "cut" / "small" / "results.csv").read_text()
        self.assertEqual(before, (out / "results.csv").read_text())
        self.assertIn("full form", self.spend(60))
        after = rows.manifest(self.runs / "small")
        self.assertNotIn("cut", after)
        first = before.splitlines()[1].split(",")[:5]
        text = (self.runs / "small" / "results.csv").read_text()
        self.assertIn(first, [line.split(",")[:5] for line in text.splitlines()])
        self.assertTrue(budget.whole(self.runs / "small"))
        self.assertEqual(self.spend(60), "small: nothing is left\n")
        self.assertEqual((self.runs / "small" / "results.csv").read_text(), text)

    def test_what_stands_is_not_lost_to_another_build(self):
        """Rows of another build are measured anew in a copy; the old ones stand until then."""
        out = self.measured / "small"
        self.lcpbench("run", "small", "--quiet", "--out", out)
        base = rows.load(out)["base_hash"].iloc[0]
        text = (out / "results.csv").read_text().replace(base, "0" * len(base))
        (out / "results.csv").write_text(text)
        self.commit("small")
        budget.adopt(self.reference, self.runs)
        self.assertFalse((self.runs / "small").is_symlink())
        self.spend(0.001)
        self.assertEqual((self.runs / "small" / "results.csv").read_text(), text)
        self.assertTrue((self.runs / "cut" / "small" / "stale.csv").exists())
        self.spend(60)
        self.assertNotIn("cut", rows.manifest(self.runs / "small"))
        self.assertEqual(set(rows.load(self.runs / "small")["base_hash"]), {base})

    def test_a_campaign_that_fails_is_told(self):
        (self.folder / "campaigns" / "small.yaml").write_text("name: small\n")
        with self.assertRaisesRegex(budget.Failed, "small"):
            self.spend(1)


if __name__ == "__main__":
    unittest.main()

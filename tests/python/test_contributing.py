"""A solver and a scene by CONTRIBUTING.md alone: in a copy of the sources each is the one file and
the one word that its section names, and from then on a campaign measures them and the report shows
them, with their words, a colour and a marker of their own. The files are those of docs/how.
"""

import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from clone import ROOT, configured, copied

HOW = {"solver": "docs/how/my-solver.md", "scene": "docs/how/my-scene.md"}
CAMPAIGN = """
name: accuracy
limits: {time: 20s, memory: 2G, grace: 1s}
sampling: {processes: 1, samples: 1, max_samples: 1, inner: 1e-9s}
parts:
  - name: steps
    words: one new scene with one new solver
    problems: [SCENE]
    formulations: [regularized]
    solvers: [SOLVER, lemke, jacobi]
    steps: [0.01, 0.005, 0.0025]
"""


def asked(kind: str) -> tuple[str, str, str]:
    """What CONTRIBUTING.md asks for: the path of the new file, the list, the file of the list."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    section = re.search(rf"^## A {kind}: `(\S+)`\n(.*?)^## ", text, re.M | re.S)
    word = re.search(r"^\d+\. Add NAME to `(\w+)` in `(\S+?)`", section[2], re.M)
    return section[1], word[1], word[2]


def given(page: str) -> tuple[str, str]:
    """Path and text of the C file that a page of docs/how shows."""
    text = (ROOT / page).read_text(encoding="utf-8")
    return re.search(r"<!-- (?:file|source): (\S+\.c) -->\n```c\n(.*?)```\n", text, re.S).groups()


class Contributing(unittest.TestCase):
    def test_a_solver_and_a_scene_are_one_file_and_one_word_each(self):
        with tempfile.TemporaryDirectory(prefix="lcpbench-add-") as name:
            self.folder = pathlib.Path(name)
            copied(self.folder)
            build = configured(self.folder)
            new = {kind: self.added(kind) for kind in HOW}
            made = subprocess.run(["ninja", "-C", build], capture_output=True, text=True)
            self.assertEqual(made.returncode, 0, made.stdout[-2000:])
            print(f"# {made.stdout.count(' Compiling C object ')} objects compiled", flush=True)
            self.env = dict(os.environ, LCPBENCH=str(build / "lcpbench"), OPENBLAS_NUM_THREADS="1")
            self.scene_is_in_the_catalogue(new["scene"])
            self.report_shows(new["solver"], new["scene"])

    def added(self, kind: str) -> str:
        """Follows the section of a kind; the name of what was added."""
        pattern, listed, place = asked(kind)
        path, text = given(HOW[kind])
        name = re.fullmatch(re.escape(pattern).replace("NAME", r"(\w+)"), path)[1]
        (self.folder / path).write_text(text, encoding="utf-8")
        place = self.folder / place
        before = place.read_text(encoding="utf-8")
        after = re.sub(rf"^({listed} = \[.*?)^\]", rf"\1  '{name}',\n]", before, flags=re.M | re.S)
        self.assertNotEqual(before, after)
        place.write_text(after, encoding="utf-8")
        return name

    def run_in(self, *words: object) -> str:
        done = subprocess.run(
            list(map(str, words)),
            cwd=self.folder,
            env=self.env,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=300,
        )
        self.assertEqual(done.returncode, 0, (words, done.stdout, done.stderr))
        return done.stdout

    def listed(self, what: str) -> dict[str, dict]:
        told = self.run_in("build/lcpbench", "list", what, "--format", "json")
        return {c["name"]: c for c in json.loads(told)}

    def scene_is_in_the_catalogue(self, scene: str) -> None:
        self.run_in("scripts/catalogue", "--pictures", scene)
        scenes = self.folder / "problems" / "scenes"
        self.assertIn(f"\n## {scene}\n", (scenes / "README.md").read_text(encoding="utf-8"))
        self.assertGreater((scenes / "pictures" / f"{scene}.png").stat().st_size, 1000)
        way = ("--formulation", "velocity", "--solver", "lemke")
        said = json.loads(self.run_in("build/lcpbench", "simulate", scene, *way))
        self.assertTrue(said["predictions"] and all(p["ok"] for p in said["predictions"]), said)

    def report_shows(self, solver: str, scene: str) -> None:
        (self.folder / "mine.yaml").write_text(
            CAMPAIGN.replace("SOLVER", solver).replace("SCENE", scene)
        )
        self.run_in("build/lcpbench", "run", "mine.yaml", "--out", "rows/accuracy", "--quiet")
        self.run_in("scripts/report", "rows")
        page = (self.folder / "rows/report/index.html").read_text(encoding="utf-8")
        looks = json.loads(
            self.run_in(
                ".venv/bin/python",
                "-c",
                "import json, sys; sys.path.insert(0, 'scripts')\n"
                "from bench import registry, style\n"
                "print(json.dumps({n: [style.code(n)[1], style.glyph(n)] for n in sys.argv[1:]}))",
                *self.listed("formulations"),
                *self.listed("solvers"),
            )
        )
        colour, marker = looks.pop(solver)
        self.assertNotIn([colour, marker], looks.values(), "colour and marker of its own")
        told = self.listed("solvers")[solver]
        look = rf'<i class="look" style="color:{colour}">{marker}[^<]*</i>{solver}'
        words = re.escape(told["words"]) + "<td>" + re.escape(told["when"])
        self.assertRegex(page, f"{look}<td>solver<td>{words}", "the table of names")
        for step in ("0.01", "0.005", "0.0025"):
            row = f"<td>{scene}<td>{scene}<td>regularized<td>{solver}<td>{step}<td>ok"
            self.assertIn(row, page, "the table of all cells")
        card = re.search(rf'<p class="cost">[^<]*<small>{scene}, \d+ contacts', page)
        self.assertTrue(card, "the card of its situation")
        latex = self.folder / "rows/report/latex"
        drawn = "".join(p.read_text() for p in latex.glob("figures/*.dat"))
        table = "".join(p.read_text() for p in latex.glob("tables/*.tex"))
        self.assertTrue(len(drawn.splitlines()) > 3 and scene in table and solver in table)


if __name__ == "__main__":
    unittest.main()

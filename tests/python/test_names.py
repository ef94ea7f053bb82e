"""No script names a component: what a solver, a formulation or a scene is called stands in its own
file, in one list of meson, in campaigns, and in scripts/experiments.toml, and nowhere else."""

import ast
import pathlib
import re
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from bench import experiments, registry  # noqa: E402

PLACE = "experiments.toml"
KINDS = ("formulations", "solvers", "scenes")


def names() -> set[str]:
    return {name for kind in KINDS for name in registry.listed(kind)}


def python_literals(text: str) -> list[tuple[int, str]]:
    """Every string of a program that is no docstring, with its line; the fixed parts of f-strings
    too."""
    tree = ast.parse(text)
    said = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef))
        and node.body
        and isinstance(node.body[0], ast.Expr)
    }
    return [
        (node.lineno, node.value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in said
    ]


def shell_literals(text: str) -> list[tuple[int, str]]:
    """Every word of a shell script that is no comment: there a string needs no quotes."""
    out = []
    for number, line in enumerate(text.splitlines(), 1):
        code = re.sub(r"(^|\s)#.*", "", line)
        out += [(number, word) for word in re.split(r"[\s'\"();&<>]+", code) if word]
    return out


def quoted_literals(text: str) -> list[tuple[int, str]]:
    """JavaScript and style sheets: what stands in quotes or backquotes on a line."""
    return [
        (number, found[2])
        for number, line in enumerate(text.splitlines(), 1)
        for found in re.finditer(r"(['\"`])((?:(?!\1).)*)\1", line)
    ]


def template_literals(text: str) -> list[tuple[int, str]]:
    """A page's text, its attributes and its expressions, piece by piece."""
    return [
        (number, piece.strip())
        for number, line in enumerate(text.splitlines(), 1)
        for piece in re.split(r"[<>\"'{}%]+", line)
        if piece.strip()
    ]


def literals(path: pathlib.Path) -> list[tuple[int, str]]:
    text = path.read_text(encoding="utf-8")
    first = text.partition("\n")[0]
    if path.suffix == ".py" or (first.startswith("#!") and "python" in first):
        return python_literals(text)
    if first.startswith("#!"):
        return shell_literals(text)
    if path.suffix in (".js", ".css"):
        return quoted_literals(text)
    if path.suffix == ".j2":
        return template_literals(text)
    return []


def uses(literal: str, known: set[str]) -> list[str]:
    """Names of components that a literal uses as such: alone, with options, in a combination or a
    list, in backquotes, after an option of lcpbench, or beside the word for its kind. A word of
    prose is no use.
    """
    a_name = "|".join(sorted(map(re.escape, known), key=len, reverse=True))
    kind = r"(?:formulations?|solvers?|scenes?|runs?)"
    patterns = (
        rf"^\s*({a_name})(?::.*)?\s*$",
        rf"(?<![\w/.-])({a_name}):[a-z]\w*=",
        rf"(?<![\w/.-])({a_name})(?::\S+)? \+ ",
        rf" \+ ({a_name})(?![\w/.-])",
        rf"`({a_name})(?::[^`]*)?`",
        rf"--(?:formulation|solver|scene)[ =]({a_name})(?![\w/.-])",
        rf"(?<![\w/.-])({a_name}) {kind}\b",
        rf"\b{kind} ({a_name})(?![\w/.-])",
    )
    found = {name for pattern in patterns for name in re.findall(pattern, literal)}
    words = [w for w in re.split(r"[\s,;|]+", literal) if w]
    if len(words) > 1 and all(w.partition(":")[0] in known for w in words):
        found |= {w.partition(":")[0] for w in words}
    return sorted(found)


def violations(folder: pathlib.Path, known: set[str]) -> list[str]:
    out = []
    for path in sorted(folder.rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts and path.name != PLACE:
            for line, literal in literals(path):
                out += [
                    f"{path.relative_to(folder)}:{line}: names {name}: {literal.strip()[:60]!r}"
                    for name in uses(literal, known)
                ]
    return out


def strings(entry: object, key: str = "") -> list[tuple[str, str]]:
    """(key, text) of every string in an entry; those of a list stand under its key in the
    singular."""
    if isinstance(entry, dict):
        return [pair for k, v in entry.items() for pair in strings(v, k)]
    if isinstance(entry, list):
        return [pair for v in entry for pair in strings(v, key.rstrip("s"))]
    return [(key, entry)] if isinstance(entry, str) else []


def asked() -> list[tuple[str, str]]:
    """(kind, text) of everything in scripts/experiments.toml that is asked for by name."""
    return [(key + "s", text) for key, text in strings(experiments.read()) if key + "s" in KINDS]


def stray(entry: object, known: set[str]) -> list[tuple[str, str]]:
    """(key, text) of the names in an entry that stand under a key of no kind: the check that what
    is asked for exists would pass over them."""
    return [
        (key, text)
        for key, text in strings(entry)
        if key + "s" not in KINDS and text.partition(":")[0] in known
    ]


class Names(unittest.TestCase):
    def test_no_script_names_a_component(self):
        self.assertEqual(violations(ROOT / "scripts", names()), [])

    def test_what_is_asked_for_exists(self):
        found = asked()
        self.assertGreater(len(found), 100)
        peers = {
            "siconos_lemke"
        }  # of builds that have them; a target of bench_solvers is not measured without
        for kind, text in found:
            if kind == "scenes" and "/" in text:  # a file of the sources
                self.assertTrue((ROOT / text).is_file(), text)
                continue
            for way in re.split(r"/\d+:", text):  # A/STEPS:B goes on by another one
                self.assertIn(way.partition(":")[0], set(registry.listed(kind)) | peers, text)
        for row in experiments.of("claims.rows"):
            self.assertIn(row.get("impacts", "impact"), registry.situations())

    def test_names_are_names_in_that_place_only_under_their_keys(self):
        found = stray(experiments.read(), names())
        self.assertEqual(found, [("impacts", "impact")])  # the situation

    def test_names_under_other_keys_are_found(self):
        pairs = {"scenes": ["slide"], "pairs": [["regularized:ratio=9", "lemke"]], "words": ["no"]}
        found = stray(pairs, {"slide", "regularized", "lemke"})
        self.assertEqual(found, [("pair", "regularized:ratio=9"), ("pair", "lemke")])

    def test_planted_names_are_found(self):
        plants = {
            "a.py": 'X = {"pgs": 1}\n',
            "b.py": 'def f(n):\n    return simulate(f"stack:n={n}")\n',
            "c.py": 'print("regularized + lemke")\n',
            "d.py": 'print("the regularized formulation is small")\n',
            "e.py": 'NAMES = "velocity position".split()\n',
            "f": '#!/usr/bin/env python3\nprint("`coulomb` is exact")\n',
            "g": "#!/bin/sh\nfor form in coulomb velocity:facets=4; do echo; done\n",
            "h.js": 'menu.append("lemke");\n',
            "i.html.j2": "<p>{{ card }} beside nsgs: <b>incline:mu=1</b></p>\n",
            "j.py": 'run("simulate --solver ppm")\n',
        }
        clean = {
            "k.py": (
                '"""With pgs on stack:n=3."""\nX = "the position of the event, a row of bodies"\n'
            ),
            "l": "#!/bin/sh\n# lemke on stack:n=2\necho lemke_dense tests/bench_lemke\n",
            "m.js": "/* pgs */ const row = 1;\n",
        }
        with tempfile.TemporaryDirectory() as folder:
            for name, text in {**plants, **clean}.items():
                (pathlib.Path(folder) / name).write_text(text)
            found = {line.partition(":")[0] for line in violations(pathlib.Path(folder), names())}
        self.assertEqual(found, set(plants))


if __name__ == "__main__":
    unittest.main()

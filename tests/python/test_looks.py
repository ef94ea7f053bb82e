"""One colour and one marker for a component in every figure, told apart by colour-blind readers
too."""

import itertools
import pathlib
import sys
import unittest
from unittest import mock

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from bench import chart, page, registry, section, style  # noqa: E402

# Machado, Oliveira & Fernandes (2009), severity 1, on linear RGB
SEEN_BY = {
    "all": np.eye(3),
    "deuteranopes": np.array(
        [[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]]
    ),
    "protanopes": np.array(
        [[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]]
    ),
}
TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


def lab(colour: str, seen_by: np.ndarray) -> np.ndarray:
    """L*a*b* of a colour, as some reader sees it."""
    rgb = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    xyz = TO_XYZ @ np.clip(seen_by @ linear, 0, 1) / np.array([0.9505, 1, 1.089])
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def least_distance(colours: list[str], reader: str) -> float:
    seen = [lab(c, SEEN_BY[reader]) for c in colours]
    return min(float(np.linalg.norm(a - b)) for a, b in itertools.combinations(seen, 2))


def registry_of(n: int):
    """A build with n formulations, n solvers and no effects."""
    made = {
        "formulations": {f"f{i}": {"solver": True} for i in range(n)},
        "solvers": {f"s{i}": {} for i in range(n)},
        "effects": {},
    }
    return mock.patch.object(registry, "listed", lambda kind: made[kind])


class Looks(unittest.TestCase):
    def test_hues_are_told_apart(self):
        self.assertGreater(least_distance(style.HUES, "all"), 25)
        for reader in ("deuteranopes", "protanopes"):  # and by lightness, dashes and marker
            self.assertGreater(least_distance(style.HUES, reader), 10, reader)

    def test_every_component_has_a_code_of_its_own(self):
        rounds = len(style.HUES) * len(style.SHADES)
        with registry_of(40):
            codes = [style.code(f"{kind}{i}")[1:] for kind in "fs" for i in range(40)]
            colours = [style.code(f"f{i}")[1] for i in range(rounds)]
        self.assertEqual(len(set(codes)), len(codes))
        self.assertEqual(len(set(colours)), rounds)
        self.assertGreater(least_distance(colours, "all"), 9)

    def test_a_new_component_at_the_end_changes_no_other(self):
        with registry_of(5):
            before = [style.code(f"{kind}{i}") for kind in "fs" for i in range(5)]
        with registry_of(6):
            self.assertEqual([style.code(f"{kind}{i}") for kind in "fs" for i in range(5)], before)
            self.assertNotEqual(style.code("s5")[1], style.NEUTRAL)

    def test_names_of_this_build_do_not_meet(self):
        seen = [n for kind in style.KINDS for n in registry.listed(kind)]
        self.assertEqual(len(set(seen)), len(seen))

    def test_figure_page_map_and_terminal_agree(self):
        for name in [*registry.formulations(), *registry.solvers()]:
            _, colour, marker = style.code(name)
            drawn = chart.Line(f"{name}, 8 facets", [1.0], [1.0], variant=1).look()
            self.assertEqual((drawn["color"], drawn["marker"]), (colour, marker))
            self.assertIn(f'{colour}">{style.GLYPHS[marker]}', style.swatch(f"{name}:a=1"))
            rgb = ";".join(str(int(colour[k : k + 2], 16)) for k in (1, 3, 5))
            said = style.marked(f"{name}:a=1")
            self.assertTrue(said.startswith(f"\x1b[38;2;{rgb}m{style.GLYPHS[marker]}"), said)
            self.assertIn(marker, chart.PLOTLY_MARKER)
        panel = chart.HeatPanel("", ["velocity", "penalty (no solver)"], [[("", 1.0)], [("", 0.0)]])
        figure = chart.draw(chart.Heat("x", "", ["part"], [panel]))
        marks = [(line.get_color(), line.get_marker()) for line in figure.axes[0].lines]
        self.assertEqual(marks, [style.code("velocity")[1:], style.code("penalty")[1:]])
        style.plt.close(figure)

    def test_what_this_build_does_not_know_is_neutral_and_without_words(self):
        self.assertEqual(style.code("liar")[1], style.NEUTRAL)
        self.assertEqual((registry.words("liar"), page.plain("liar")), ("", ""))
        self.assertTrue(registry.uses_solver("liar") and registry.solvable("liar"))
        self.assertIn(
            "liar",
            section.table_html(
                section.Table("t", "", ["x"], [[section.Cell("liar", look="liar")]])
            ),
        )


if __name__ == "__main__":
    unittest.main()

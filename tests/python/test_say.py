"""Scripts say one line, and no control character of a name reaches the terminal."""

import pathlib
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from bench import say  # noqa: E402

NAME = "no\x1b[31msuch\nfile\udcff"
SHOWN = r"no\x1b[31msuch\nfile\xff"


class Lines(unittest.TestCase):
    def test_what_is_shown(self) -> None:
        for text, shown in (
            (NAME, SHOWN),
            ("a\tb\r", r"a\tb\r"),
            ("Kövecses: µ = 0.5", "Kövecses: µ = 0.5"),
            ("\x9b2J\x7f", r"\xc2\x9b2J\x7f"),
        ):
            self.assertEqual(say.plain(text), shown)

    def test_scripts(self) -> None:
        for script in (
            ("scripts/recommend", "--scene", "x", "--error", "1"),
            ("scripts/report",),
            ("scripts/render",),
            ("scripts/reference",),
            ("scripts/redundancy",),
            ("scripts/report", "also"),
        ):
            with self.subTest(script=script):
                done = subprocess.run(
                    [*script, NAME], cwd=ROOT, capture_output=True, check=False, timeout=120
                )
                said = done.stderr.decode()
                self.assertEqual(done.returncode, 2, said)
                self.assertIn(SHOWN, said)
                self.assertNotIn("\x1b", said)
                self.assertNotIn("Traceback", said)


if __name__ == "__main__":
    unittest.main()

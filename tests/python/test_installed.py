"""What `meson install` leaves, used as a stranger uses it: the examples are compiled against it by
pkg-config alone, the program runs its campaigns, and the sources are gone by then. The tree is
moved once, too."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from clone import ROOT, configured, copied

EXAMPLES = sorted(set((ROOT / "examples").glob("*.c")) - set((ROOT / "examples").glob("plugin_*")))
HEADER = "include/lcpbench/lcpbench.h"
STRICT = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wstrict-prototypes", "-Werror"]


def declared() -> set[str]:
    """Functions of the public header."""
    text = re.sub(r"/\*.*?\*/", "", (ROOT / HEADER).read_text(encoding="utf-8"), flags=re.S)
    return set(re.findall(r"\b(lcp_\w+)\(", text))


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """Installs with DESTDIR from a copy of the sources, removes the copy, moves what stands."""
        cls.scratch = tempfile.TemporaryDirectory(prefix="lcpbench-installed-")
        cls.addClassCleanup(cls.scratch.cleanup)
        scratch = pathlib.Path(cls.scratch.name)
        source = scratch / "source"
        source.mkdir()
        copied(source)
        build = configured(source, "--prefix=/opt/some where")
        for words in (["ninja", "-C", build], ["meson", "install", "-C", build, "--no-rebuild"]):
            done = subprocess.run(
                words,
                env=dict(os.environ, DESTDIR=str(scratch / "staged")),
                capture_output=True,
                text=True,
                check=False,
            )
            if done.returncode != 0:
                raise AssertionError(done.stdout[-2000:] + done.stderr[-2000:])
        shutil.rmtree(source)
        cls.prefix = scratch / "moved"
        (scratch / "staged" / "opt" / "some where").rename(cls.prefix)
        (cls.pc,) = cls.prefix.rglob("lcpbench.pc")
        cls.lib = cls.pc.parent.parent

    def run_in(self, *words, code=0, **env):
        full = {k: v for k, v in os.environ.items() if not k.startswith("LCPBENCH")}
        full |= {"OPENBLAS_NUM_THREADS": "1", "PKG_CONFIG_PATH": str(self.pc.parent), **env}
        done = subprocess.run(
            list(map(str, words)),
            cwd=self.scratch.name,
            env=full,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        self.assertEqual(done.returncode, code, f"{words}\n{done.stdout}{done.stderr}")
        return done.stdout

    def flags(self, *words):
        return self.run_in("pkg-config", "--cflags", "--libs", *words, "lcpbench").split()

    def test_examples_against_the_shared_library(self):
        self.assertGreaterEqual(len(EXAMPLES), 3)
        for path in EXAMPLES:
            exe = pathlib.Path(self.scratch.name, path.stem)
            self.run_in("cc", *STRICT, path, *self.flags(), "-lm", "-o", exe)
            self.run_in(exe, LD_LIBRARY_PATH=str(self.lib))

    def test_a_plugin_in_a_program_and_in_the_installed_one(self):
        plugin = pathlib.Path(self.scratch.name, "plugin_pgs.so")
        flags = self.run_in("pkg-config", "--cflags", "lcpbench").split()
        source = ROOT / "examples" / "plugin_pgs.c"
        self.run_in("cc", *STRICT, "-shared", "-fPIC", source, *flags, "-o", plugin)
        self.run_in(self.prefix / "bin" / "lcpbench", "conform", plugin)
        path = pathlib.Path(self.scratch.name, "load.c")
        path.write_text(
            "#include <lcpbench/lcpbench.h>\n"
            "int main(int n, char **file) {\n"
            "  const double M[] = {2, 1, 1, 2}, q[] = {-5, -6};\n"
            "  double z[] = {0, 0};\n"
            "  lcp_problem *p = lcp_problem_dense(2, M, 0, q);\n"
            '  if (n != 2 || lcp_solve(p, "my_pgs", z, NULL) != LCP_INVALID) return 1;\n'
            "  if (lcp_plugin_load(file[1]) != LCP_OK) return 2;\n"
            "  if (lcp_plugin_load(file[1]) != LCP_INVALID) return 3;\n"
            '  if (lcp_solve(p, "my_pgs:omega=1.1", z, NULL) != LCP_OK) return 4;\n'
            "  lcp_problem_free(p);\n"
            "  return 0;\n"
            "}\n"
        )
        exe = pathlib.Path(self.scratch.name, "load")
        self.run_in("cc", *STRICT, path, *self.flags(), "-o", exe)
        self.run_in(exe, plugin, LD_LIBRARY_PATH=str(self.lib))

    def test_an_example_against_the_static_library(self):
        alone = pathlib.Path(self.scratch.name, "static")
        shutil.copytree(self.prefix, alone, ignore=shutil.ignore_patterns("*.so*"))
        exe = pathlib.Path(self.scratch.name, "warm_static")
        pc = alone / self.pc.parent.relative_to(self.prefix)
        flags = self.run_in(
            "pkg-config", "--static", "--cflags", "--libs", "lcpbench", PKG_CONFIG_PATH=str(pc)
        ).split()
        self.run_in("cc", ROOT / "examples" / "warm_start.c", *flags, "-lm", "-o", exe)
        self.run_in(exe)

    def test_the_library_exports_what_the_header_declares(self):
        out = self.run_in("nm", "-D", "--defined-only", self.lib / "liblcpbench.so")
        found = {line.split()[-1].split("@")[0] for line in out.splitlines() if " T " in line}
        self.assertEqual(found, declared())
        others = [line for line in out.splitlines() if not re.search(r" T | A LCPBENCH_", line)]
        self.assertEqual(others, [])

    def test_the_header_is_cplusplus_too(self):
        if shutil.which("c++") is None:
            self.skipTest("no C++ compiler")
        path = pathlib.Path(self.scratch.name, "header.cpp")
        program = "int main() { return lcp_api_version(); }"
        path.write_text(f"#include <lcpbench/lcpbench.h>\n{program}\n")
        self.run_in("c++", "-Wall", "-Wextra", "-Werror", "-c", path, *self.flags())

    def test_versions_are_one(self):
        text = (ROOT / HEADER).read_text(encoding="utf-8")
        version = re.search(r'#define LCP_VERSION "(.*)"', text)[1]
        program = self.run_in(self.prefix / "bin" / "lcpbench", "--version").split()[-1]
        told = self.run_in("pkg-config", "--modversion", "lcpbench").strip()
        self.assertEqual({version, program, told}, {version})

    def test_the_program_needs_no_sources(self):
        program = self.prefix / "bin" / "lcpbench"
        self.assertIn("smoke", self.run_in(program, "list", "campaigns").split())
        out = self.run_in(program, "run", "smoke", "--quick", "--out", "rows", "--quiet")
        self.assertIn("rows/results.csv", out)

    def test_scripts_manual_and_completion_are_installed(self):
        program = self.prefix / "bin" / "lcpbench"
        rows = ROOT / "results" / "reference" / "library"
        out = self.run_in(
            program, "profile", rows, "--out", "figures", LCPBENCH_PYTHON=sys.executable
        )
        self.assertIn("lemke", out)
        self.assertTrue(pathlib.Path(self.scratch.name, "figures", "profile.pdf").exists())
        share = self.prefix / "share"
        self.assertIn(".SH VERBS", (share / "man" / "man1" / "lcpbench.1").read_text())
        for file in (
            "bash-completion/completions/lcpbench",
            "zsh/site-functions/_lcpbench",
            "fish/vendor_completions.d/lcpbench.fish",
        ):
            self.assertIn("lcpbench complete --", (share / file).read_text(), file)

    def test_without_its_data_the_program_says_so(self):
        bare = pathlib.Path(self.scratch.name, "bare")
        bare.mkdir()
        shutil.copy2(self.prefix / "bin" / "lcpbench", bare / "lcpbench")
        self.run_in(bare / "lcpbench", "run", "smoke", "--out", "none", code=2)


if __name__ == "__main__":
    unittest.main()

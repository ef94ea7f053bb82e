"""The documents: what the sources lean on exists, the examples in them run, and the checker finds
what is planted."""

import pathlib
import re
import shutil
import subprocess
import sys

from support import SANITIZED, run, tap

ROOT = pathlib.Path(__file__).resolve().parents[2]


def check(root):
    return subprocess.run(
        [sys.executable, ROOT / "scripts/check_docs", root], capture_output=True, text=True
    )


def copied(d):
    """The texts of the repository, to be spoilt."""
    root = d / "tree"
    for entry in ROOT.iterdir():
        if (
            entry.is_dir()
            and entry.name not in (".git", ".venv", ".venv-check", ".venv-engines", "subprojects")
            and not (entry / "meson-private").exists()
        ):
            shutil.copytree(
                entry,
                root / entry.name,
                ignore=shutil.ignore_patterns("runs", "__pycache__", "*.xz"),
            )
        elif entry.is_file():
            root.mkdir(exist_ok=True)
            shutil.copy(entry, root / entry.name)
    return root


def documents_hold(d):
    done = check(ROOT)
    assert done.returncode == 0, done.stdout


def the_interface_is_what_the_headers_say(d):
    words = [sys.executable, ROOT / "scripts/api_docs", "--check"]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    root = copied(d)
    header = root / "include/lcpbench/lcpbench.h"
    whole = header.read_text(encoding="utf-8")
    for before, after, said in (
        ("/* Number of unknowns. */", "/* The number of rows. */", "docs/API.md is not"),
        ("/* Number of unknowns. */\n", "", "one comment on lcp_problem_declare, lcp_problem_size"),
    ):
        assert whole.count(before) == 1
        header.write_text(whole.replace(before, after), encoding="utf-8")
        words[1] = root / "scripts/api_docs"
        done = subprocess.run(words, capture_output=True, text=True)
        assert done.returncode == 1 and said in done.stderr, done.stderr


# What is checked is this file as well: a name that leads nowhere is put together from two.
_ = " "
# file, what stands there, what is put in its place, what the checker must say
PLANTED = [
    (
        "lcp/lcp_judge.c",
        "\n",
        f"\n/* MATHEMATICS{_}2.99 */\n",
        f"MATHEMATICS{_}2.99: docs/MATHEMATICS.md has no such section",
    ),
    ("lcp/lcp_judge.c", "\n", f"\n/* RESIDUALS{_}1 and 77 */\n", f"RESIDUALS{_}77"),
    ("lcp/lcp_judge.c", "\n", "\n/* MATH 2.3.6 */\n", "'MATH' names nothing"),
    ("lcp/lcp_judge.c", "\n", f"\n/* after Nobody{_}1999 */\n", f"cites Nobody{_}1999"),
    ("lcp/lcp_judge.c", "\n", f"\n/* case{_}A99.1 */\n", f"case{_}A99.1"),
    ("lcp/lcp_judge.c", "\n", "\n/* see gone.md */\n", "gone.md: no such file"),
    ("lcp/solvers/solver_lemke.c", '.cite = "', '.cite = "nobody1999; ', "cites 'nobody1999'"),
    (
        "docs/references.bib",
        "@article{bai2010",
        "@article{bai2011",
        "need a key of first author and year",
    ),
    (
        "docs/references.bib",
        "@article{bai2010",
        (
            "@article{nobody1999,\n  author = {Nobody, N.},\n  title = {None},\n  journal = {None},"
            " year = {1999}\n}\n\n@article{bai2010"
        ),
        "nobody1999 is cited nowhere",
    ),
    (
        "docs/references.bib",
        "journal = {Numerical Linear Algebra with Applications}",
        "journal = {}",
        "bai2010: @article without journal",
    ),
    ("docs/RESIDUALS.md", "\n## ", "\n[gone](gone.md)\n## ", "link to gone.md: no such file"),
    (
        "docs/RESIDUALS.md",
        "\n## ",
        "\n[gone](MATHEMATICS.md#gone)\n## ",
        "link to MATHEMATICS.md#gone: no such anchor",
    ),
    ("docs/MATHEMATICS.md", '<a id="2.3.6"></a>\n', "", "heading 2.3.6: need its anchor"),
    ("docs/MATHEMATICS.md", "\n## ", "\n$a\\;b$\n## ", "a backslash before punctuation"),
    ("results/FORMAT.md", "`metric_version` |", "`gone_version` |", "gone_version is no column"),
    (
        "docs/RESIDUALS.md",
        "`stiffness_ratio`",
        "stiffness_ratio",
        "the column stiffness_ratio is not defined",
    ),
    (
        "docs/FORMATS.md",
        "`anchor_vel`",
        "anchor_vel",
        "`anchor_vel` of read_load.c is not described",
    ),
    (
        "docs/CAMPAIGNS.md",
        "`half_width`",
        "half_width",
        "the key `half_width` of campaigns is not described",
    ),
]


def planted_faults_are_found(d):
    root = copied(d)
    good = check(root)
    for name, old, new, wanted in PLANTED:
        path = root / name
        text = path.read_text(encoding="utf-8")
        assert old in text, (name, old)
        path.write_text(
            text.replace(old, new) if old[0] in "`<" else text.replace(old, new, 1),
            encoding="utf-8",
        )
        bad = check(root)
        path.write_text(text, encoding="utf-8")
        assert bad.returncode == 1 and wanted in bad.stdout, (name, wanted, bad.stdout, bad.stderr)
        assert wanted not in good.stdout, wanted


def example(page, name):
    found = re.search(
        rf"^```\w+ {re.escape(name)}\n(.*?)^```$",
        (ROOT / "docs" / page).read_text(encoding="utf-8"),
        re.M | re.S,
    )
    assert found, (page, name)
    return found[1]


def examples_of_formats_pass(d):
    for name in ("ramp.yaml", "cases.json"):
        (d / name).write_text(example("FORMATS.md", name), encoding="utf-8")
        out = run("check", d / name).stdout
        passed, failed = re.search(r"(\d+) passed, (\d+) failed", out).groups()
        assert int(passed) > 0 and failed == "0", out


def example_of_campaigns_runs(d):
    (d / "tiny.yaml").write_text(example("CAMPAIGNS.md", "tiny.yaml"), encoding="utf-8")
    assert "26 cells" in run("run", d / "tiny.yaml", "--dry-run").stdout
    run("run", d / "tiny.yaml", "--quick", "--quiet", "--out", d / "out")
    assert "verified" in (d / "out/results.csv").read_text(encoding="utf-8")


OF_TEXTS = [documents_hold, the_interface_is_what_the_headers_say, planted_faults_are_found]

# no sanitizer sees what only reads texts
tap((OF_TEXTS if not SANITIZED else []) + [examples_of_formats_pass, example_of_campaigns_runs])

"""Ten malformed files of every format: exit code 2, nothing on stdout, one line that names the file
and the rule.

Each is one edit of a good file (tests/fuzz/seeds), which must be accepted as it is. FCLIB files:
tests/unit/test_import_hostile.c; certificates: tests/unit/test_certificate.c; trajectories:
tests/python/test_render.py."""

import pathlib

from support import one_line_error, run, tap

SEEDS = pathlib.Path(__file__).resolve().parents[1] / "fuzz" / "seeds"
CUT = object()  # the second half is missing


def solve(path):
    return ("solve", path, "--solver", "nsgs")


def lemke(path):
    return ("solve", path, "--solver", "lemke")


def simulate(path):
    return ("simulate", path, "--formulation", "velocity", "--solver", "lemke")


def check(path):
    return ("check", path, "--solver", "lemke")


def dry_run(path):
    return ("run", path, "--dry-run")


JSON_SCENE = [
    (CUT, "JSON"),
    ('"id": "ramp"', '"id": 7', "id"),
    ('"dim": 2', '"dim": 5', "dim = 5"),
    ('"T": 0.02', '"T": -1', "T = -1"),
    ('"mass": 2', '"mass": 0', "mass = 0"),
    ('"type": "box"', '"type": "torus"', "torus"),
    ('"half": [0.2, 0.1]', '"half": [0.2]', "half"),
    ('"vel": [1.5, 0]', '"vel": [1.5, "fast"]', "vel"),
    ('"body": "ball"', '"body": "nobody"', "nobody"),
    ('"type": "constant_force"', '"type": "wind"', "wind"),
    ("[2, 0.3]", "[2]", "anchor"),
    ('"var": "block.x"', '"var": "block.q"', "'q'"),
    ('"normal": [0, 1]', '"normal": [0, 0]', "normal"),
    ("[-0.2, -0.1], [0.2, -0.1]", "[0.2, -0.1], [-0.2, -0.1]", "counter-clockwise"),
]
YAML_SCENE = [
    ("id: ramp", "id: [ramp", "line"),
    ("dim: 2", "dim: two", "dim"),
    ("T: 0.02", "T: .inf", "T"),
    ("hs: [0.01]", "hs: [0]", "h = 0"),
    ("mass: 2", "mass: -2", "mass = -2"),
    ("type: box", "type: blob", "blob"),
    ("name: floor", "name: block", "twice"),
    ("0.6]]", "-0.6]]", "0.6"),
    ("k: 10", "k: -10", "k"),
    ("type: state", "type: mood", "mood"),
    ("gravity:", "levity:", "levity"),
    ("dim: 2", "dim: 2\ndim: 2", "twice"),
    ("pos: [0, 0.1]", "pos: [0, *a]", "line"),
]
CASES = [
    (CUT, "JSON"),
    ('"n": 2', '"n": -2', "n"),
    ('"q": [-5, -6]', '"q": {}', "q"),
    ("[[2, 1], [1, 2]]", "7", "M"),
    ("[[2, 1], [1, 2]]", '[[2, "x"], [1, 2]]', "M"),
    ('["solved"]', '["guessed"]', "guessed"),
    ('"title"', '"titel"', "titel"),
    ('"equivalences": []', '"equivalences": [1]', "equivalence"),
    ('"stress"', '"stresses"', "stresses"),
    ('"equivalences": []', '"equivalences": [{"id": "E", "a": "x"}]', "'b'"),
    ('"lcp": [', '"lcp": ["", ', "object"),
]
CAMPAIGN = [
    ("parts:", "bits:", "bits"),
    ("limits: {time: 5s", "limits: {time: soon", "time"),
    ("memory: 512M", "memory: -1", "memory"),
    ("seed: 1", "seed: one", "seed"),
    ("processes: 1", "processes: 0", "processes"),
    ("solvers: [lemke]", "solvers: [lemon]", "lemon"),
    ("facets={4,8}", "facets={4,8", "facets={4,8"),
    ("problems: [slide]", "problems: slide", "problems"),
    ("steps: [0.01]", "step: [0.01]", "step"),
    ("    problems: [slide]\n", "", "problems"),
    ("    solvers: [lemke]\n    steps", "    steps", "solvers"),
    ("name: tiny", "name: [tiny", ":"),
    ("parts:\n", "parts: []\nrest:\n", ":"),
    ("seed: 1", "seed: 1\nseed: 2", "twice"),
    ("problems: [slide]", "problems: [glide]", "glide"),
    ("problems: [slide]", 'problems: ["slide:hue=1"]', "hue"),
    ("name: tiny", "name: a/b", "/"),
    ("steps: [0.01]", "effects: ['-magic']", "magic"),
    ("steps: [0.01]", "effects: ['auto:x']", "auto:x"),
    ("steps: [0.01]", "tolerances: [abc]", "abc"),
    ("steps: [0.01]", "tolerances: [2]", "tol=2"),
    ("    formulations: [", "    solver: [", "solver"),
    ("steps: [0.01]", "steps: [-0.01]", "-0.01"),
    ("starts: [cold]", "starts: [warm]", "warm"),
]
LCP = [
    (CUT, "left"),
    ("2\n0\n", "3\n0\n", "rows"),
    ("2\n0\n", "2\n7\n", ""),
    ("2 2\n2 1", "2 3\n2 1", "2"),
    ("-5 -6", "-5 nan", "nan"),
    ("-5 -6", "-5", "file ends"),
    ("2 1\n", "2 x\n", "x"),
    ("1 2\n", "1 2e999\n", "2e999"),
    ("2\n0\n2\n2\n2 2", "999999\n0\n999999\n999999\n999999 999999", "left"),
    ("2\n0\n", "-2\n0\n", "-2"),
    ("2\n0\n2", "2\n0\n3", ""),
]
MLCP = [
    (CUT, "left"),
    ("1 1\n2", "0 1\n2", "flag"),
    ("1 1\n2\n2", "1 1\n0\n0", "without"),
    ("0 1 2 4", "0 1 2 3", "block"),
    ("0 1 2 4", "0 2 1 4", "block"),
    ("0 0 1\n", "0 0 2\n", "flag"),
    ("4 4\n2", "4 5\n2", "columns"),
    ("0\n4\n4\n", "1\n4\n4\n", "storage"),
    ("-1 -2 -3 -4", "-1 -2 -3 inf", "inf"),
    ("-1 -2 -3 -4", "-1 -2 -3", "q"),
    ("1 0 2 0\n", "1 0 two 0\n", "two"),
]
FRICTION_DENSE = [
    (CUT, "left"),
    ("2\n1\n0", "4\n1\n0", ":2"),
    ("2\n1\n0", "2\n0\n0", ":3"),
    ("2\n1\n0", "2\n1\n9", ":2"),
    ("2 2\n1 0.25", "2 3\n1 0.25", "2"),
    ("0.25 1", "0.25 nan", "nan"),
    ("-1 0.5", "-1 y", "y"),
    ("-1 0.5\n0.5", "-1 0.5\n-0.5", "mu"),
    ("-1 0.5\n0.5", "-1 0.5", "mu"),
    ("2\n1\n0\n2\n2\n2 2", "2\n900000\n0\n1800000\n1800000\n1800000 1800000", "left"),
    ("1 0.25", "1 .25.5", ".25.5"),
]
FRICTION_BLOCKS = [
    (CUT, ""),
    ("2\n2 2\n2 4\n2 4", "3\n2 2\n2 4\n2 4", "3"),
    ("2 4\n2 4", "2 3\n2 4", "end before"),
    ("2 4\n2 4", "4 2\n2 4", "block row"),
    ("3 2\n", "9 2\n", "row index"),
    ("3 2\n", "3 1\n", "stored blocks"),
    ("0 1 2\n", "1 1 2\n", "row index"),
    ("0 1\n0\n", "0 7\n0\n", "column is '7'"),
    ("1\n1 0\n", "4\n1 0\n", "number of a block"),
    ("0 1\n-1", "0 inf\n-1", "inf"),
    ("0.5 0.3", "0.5 -0.3", "mu"),
    ("0.5 0.3", "0.5", "mu"),
]
FRICTION_CSPARSE = [
    (CUT, ""),
    ("CSparse Version", "Matlab Version", "CSparse"),
    ("2-by-2", "2-by-3", "2-by-2"),
    ("nnz: 2", "nnz: 2000000", "left"),
    ("nnz: 2", "nnz: -2", "nnz"),
    ("1 1 : 1", "1 5 : 1", "column"),
    ("1 1 : 1", "-1 1 : 1", "row"),
    ("1 1 : 1", "1 1 = 1", "':'"),
    ("1 1 : 1", "1 1 : nan", "nan"),
    ("-1 0.5\n0.5", "-1 0.5", "mu"),
    ("2\n1\n2\n2\n2\n1\n", "2\n1\n2\n2\n2\n8\n", "kind"),
]
GLOBAL = [
    (CUT, "left"),
    ("3\n3\n3 3\n", "3\n4\n3 3\n", ""),
    ("2 0 0\n", "-2 0 0\n", "M"),
    ("0 2 0\n", "0.5 2 0\n", "symmetric"),
    ("0 0 1\n0\n", "0 0 0\n0\n", "M"),
    ("3 2\n1 0 0", "3 1\n1 0 0", "columns"),
    ("0 1 0.5", "0 1 nan", "nan"),
    ("0 -9.81 0\n", "0 -9.81\n", ""),
    ("0 0\n0.5", "0 0", "mu"),
    ("0 0\n0.5", "0 0\n-0.5", "mu"),
    ("0\n3\n2\n3 2", "5\n3\n2\n3 2", "storage"),
    ("0\n3\n2\n3 2", "0\n2\n2\n2 2", ""),
]
ROLLING = [
    (CUT, "left"),
    ("5\n1\n0", "6\n1\n0", ":2"),
    ("0.05", "", "mu_r"),
    ("0.05", "-0.05", "mu_r"),
    ("0.05", "wheel", "wheel"),
    ("0.5\n0.05", "-0.5\n0.05", "mu"),
    ("5 5\n1", "5 4\n1", "columns"),
    ("0 0 0 0 2", "0 0 0 0 inf", "inf"),
    ("-1 0.5 0 0.1 0", "-1 0.5 0 0.1", ""),
    ("5\n1\n0\n5\n5\n", "5\n2\n0\n5\n5\n", ""),
    ("0 0 0 2 0", "0 0 0 2", ""),
]
MATRIX = [
    (CUT, "small.M.mtx"),
    ("%%MatrixMarket", "%MatrixMarket", "MatrixMarket"),
    ("coordinate", "diagonal", "diagonal"),
    ("real general", "complex general", "complex"),
    ("2 2 3", "2 3 3", "square"),
    ("2 2 3", "-2 -2 3", "2"),
    ("2 2 3", "2 2 4", ""),
    ("2 2 3\n", "900000000 900000000 3\n", ""),
    ("1 1 2", "3 1 2", "3"),
    ("1 1 2", "0 1 2", "0"),
    ("1 1 2", "1 1 nan", "nan"),
    ("1 1 2", "1 1", ""),
    ("2 2 3\n1", "2 2 2\n1", ""),
]
VECTOR = [
    (CUT, "small.q.mtx"),
    ("2 1", "3 1", "3"),
    ("2 1", "2 2", "2"),
    ("array", "coordinate", ""),
    ("-1\n", "nan\n", "nan"),
    ("-1\n", "one\n", "one"),
    ("-1\n", "", ""),
    ("real", "pattern", "pattern"),
    ("%%MatrixMarket", "MatrixMarket", "MatrixMarket"),
    ("2 1", "2000000000 1", ""),
    ("-1\n1", "-1e999\n1", "1e999"),
]
ROWS = [
    (",", ";", "header"),
    ("\n", "\nx\n", ":2"),
    (",lemke,", ",lemke,lemke,", ":2"),
    (",lemke,", ",", ":2"),
    (",ok,", ",fine,", "fine"),
    (",1,false,", ",one,false,", ":2"),
    (",lemke,", ',"lemke,', ":2"),
    (",true,", ",perhaps,", "perhaps"),
    ("cell_id", "", "header"),
    (",dense,", ",dense;", ":2"),
]


def malformed(text, edit):
    if edit[0] is CUT:
        return text[: len(text) // 2]
    assert edit[0] in text, f"the good file has no {edit[0]!r}"
    return text.replace(edit[0], edit[1], 1)


def refused(path, good, edits, command, names):
    """Every edit of the good text is refused in one line; all that are not are named."""
    assert len(edits) >= 10
    wrong = []
    for edit in edits:
        path.write_text(malformed(good, edit))
        try:
            one_line_error(*command, names=[*names, edit[-1]])
        except AssertionError as why:
            wrong.append(f"{edit}: {str(why)[:300]}")
    assert not wrong, f"{path.name}: " + "; ".join(wrong)


def each(d, seed, edits, command, beside=()):
    """The good file is accepted (0 or an honest 3), its edits are not."""
    path = d / seed
    for other in (seed, *beside):
        (d / other).write_text((SEEDS / other).read_text())
    done = run(*command(path), code=None)
    assert done.returncode in (0, 3) and done.stdout, f"{seed}: {done.stderr}"
    refused(path, path.read_text(), edits, command(path), [seed])


def scenes_in_json(d):
    each(d, "scene.json", JSON_SCENE, simulate)


def scenes_in_yaml(d):
    each(d, "scene.yaml", YAML_SCENE, simulate)


def case_files(d):
    each(d, "cases.json", CASES, check)


def campaigns(d):
    each(d, "campaign.yaml", CAMPAIGN, dry_run)


def siconos_text(d):
    for seed, edits in (
        ("lcp.dat", LCP),
        ("mlcp.dat", MLCP),
        ("fc2d_dense.dat", FRICTION_DENSE),
        ("fc2d_blocks.dat", FRICTION_BLOCKS),
        ("fc2d_csparse.dat", FRICTION_CSPARSE),
        ("global.dat", GLOBAL),
        ("rolling.dat", ROLLING),
    ):
        each(d, seed, edits, solve)


def matrix_market(d):
    each(d, "small.M.mtx", MATRIX, lemke, beside=["small.q.mtx"])
    (d / "small.M.mtx").write_text((SEEDS / "small.M.mtx").read_text())
    each(
        d,
        "small.q.mtx",
        VECTOR,
        lambda q: lemke(q.with_name("small.M.mtx")),
        beside=["small.M.mtx"],
    )


def a_file_that_crashes_its_library(d):
    """A damaged local heap: libhdf5 1.10.8 reads through a null pointer; found by scripts/fuzz."""
    one_line_error(
        "solve", SEEDS / "damaged_heap.hdf5", "--solver", "nsgs", names=["damaged_heap.hdf5"]
    )


def result_rows(d):
    """The rows of a campaign, read again by status."""
    run("run", SEEDS / "campaign.yaml", "--filter", "part=families", "--out", d / "run")
    path = d / "run" / "results.csv"
    refused(path, path.read_text(), ROWS, ("status", d / "run"), ["results.csv"])
    path.write_text((SEEDS / "rows.csv").read_text())
    assert "2 rows" in run("status", d / "run").stdout, (
        "scripts/fuzz begins with rows that are no longer read: take new ones"
    )


tap(
    [
        scenes_in_json,
        scenes_in_yaml,
        case_files,
        campaigns,
        siconos_text,
        matrix_market,
        a_file_that_crashes_its_library,
        result_rows,
    ]
)

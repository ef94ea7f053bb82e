"""The installed package, without the sources: answers against closed forms, what is refused, rows
that the program measures here, the notebook."""

import json
import lzma
import os
import pathlib
import subprocess
import sys

import lcpbench
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
import pandas as pd  # noqa: E402
import pytest  # noqa: E402
import scipy.io  # noqa: E402
import scipy.sparse as sp  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
N, G, H = 200, 9.81, 0.01


def column():
    """N equal spheres on each other: M tridiagonal, the k-th contact carries the N - k above it."""
    diagonals = [-np.ones(N - 1), np.r_[1, 2 * np.ones(N - 1)], -np.ones(N - 1)]
    return sp.diags_array(diagonals, offsets=[-1, 0, 1]), np.r_[-G * H, np.zeros(N - 1)]


def contacts(seed, count, mu):
    """Delassus matrix of `count` points with friction of random bodies: J J', and its cones."""
    rng = np.random.default_rng(seed)
    J = sp.random_array((3 * count, 4 * count), density=0.02, rng=rng) + sp.eye_array(
        3 * count, 4 * count
    )
    q = rng.normal(size=3 * count)
    return (J @ J.T).tocsc(), q, [(3 * k, 3, mu) for k in range(count)]


# ---- solving and judging ----


@pytest.mark.parametrize(
    "form", [lambda M: M, sp.csc_matrix, sp.csr_array, sp.coo_matrix, lambda M: M.toarray()]
)
def test_two_hundred_contacts(form):
    M, q = column()
    solution = lcpbench.solve(form(M), q)
    assert solution.status == "ok" and solution.verified
    assert np.allclose(solution.z, np.arange(N, 0, -1) * G * H, rtol=1e-12)
    assert lcpbench.verify(form(M), q, solution.z)


def test_matrices_are_not_turned():
    """M z of an unsymmetric M, dense in both orders and sparse, is numpy's."""
    M = np.array([[2.0, 1.0, 0.0], [0.5, 3.0, -1.0], [0.0, 0.25, 1.5]])
    q = np.array([-3.0, -2.0, -3.0])
    want = np.linalg.solve(M, -q)
    assert (want > 0).all()
    for one in (M, np.asfortranarray(M), M.astype(np.float32), sp.csr_array(M), M.tolist()):
        assert np.allclose(lcpbench.solve(one, q, "lemke").z, want, rtol=1e-12)


def test_every_solver_that_takes_it():
    M, q = contacts(1, 4, 0.0)[:2]
    found = 0
    for name, about in lcpbench.solvers().iterrows():
        try:
            solution = lcpbench.solve(M, q, name, check=False)
        except lcpbench.Unsupported as why:
            assert name in str(why) or "n = " in str(why), why
            continue
        found += solution.verified
        assert bool(about.title)
    assert found >= 10


def test_friction_cones_and_their_law():
    M, q, cones = contacts(2, 200, 0.4)
    p = lcpbench.Problem(M, q, cones=cones)
    z = lcpbench.solve(p).z.reshape(-1, 3)
    u = (M @ z.ravel() + q).reshape(-1, 3)
    slip = np.linalg.norm(u[:, 1:], axis=1)
    assert (np.linalg.norm(z[:, 1:], axis=1) <= 0.4 * z[:, 0] + 1e-8).all()
    assert np.abs(np.minimum(z[:, 0], u[:, 0])).max() < 1e-6  # normal complementarity
    assert (slip > 1e-3).any() and (z[:, 0] > 1e-3).any()
    against = (z[:, 1:] * u[:, 1:]).sum(axis=1) + 0.4 * z[:, 0] * slip
    assert np.abs(against).max() < 1e-6  # full friction, against the slip
    z[0, 0] += 0.1
    assert not lcpbench.verify(p, z=z.ravel(), tolerance=1e-6)


def test_bounds_by_hand():
    M, q = np.diag([2.0, 4.0, 1.0]), [1.0, -8.0, 5.0]
    bounds = {"lo": [-1, -1, -np.inf], "hi": [0.5, 0.5, np.inf]}
    assert np.allclose(lcpbench.solve(M, q, **bounds).z, [-0.5, 0.5, -5.0], atol=1e-6)


def test_warm_start_and_options():
    M, q = column()
    cold = lcpbench.solve(M, q, "pgs:tol=1e-8,max_iter=300000", check=False)
    warm = lcpbench.solve(M, q, "pgs", z0=np.arange(N, 0, -1) * G * H)
    assert warm.iterations < cold.iterations and warm.verified


def test_the_judge_believes_nobody():
    M, q = column()
    z = lcpbench.solve(M, q).z
    assert lcpbench.judge(M, q, z)
    for k in (0, 57, N - 1):
        bad = z.copy()
        bad[k] *= 1.001
        verdict = lcpbench.judge(M, q, bad)
        assert not verdict and verdict.rho > 1e-9 and not lcpbench.verify(M, q, bad)
    assert lcpbench.judge(M, q, -z).infeasible_z == pytest.approx(N * G * H)
    assert lcpbench.judge(M, q, 0 * z).infeasible_w == pytest.approx(G * H)
    assert not lcpbench.judge(M, q, np.full(N, np.nan))


def test_honest_failure_is_an_exception_with_what_there_is():
    with pytest.raises(lcpbench.NotSolved, match="infeasible") as why:
        lcpbench.solve([[-1.0]], [-1.0], "lemke")
    assert why.value.result.status == "infeasible" and not why.value.result.verified
    M, q = column()
    with pytest.raises(lcpbench.NotSolved, match="max_iter"):
        lcpbench.solve(M, q, "pgs:max_iter=2")
    assert lcpbench.solve(M, q, "pgs:max_iter=2", check=False).status == "max_iter"


@pytest.mark.parametrize(
    "arguments, line",
    [
        (([[1.0, 2.0]], [1.0]), "square"),
        (([[1.0]], [1.0, 2.0]), "q"),
        (([[np.nan]], [1.0]), "finite"),
        (([[1.0]], [np.inf]), "finite"),
        (([[1j]], [1.0]), "complex"),
        (([["a"]], [1.0]), "M.*real numbers"),
        (([[1.0], [1.0, 2.0]], [1.0, 1.0]), "M"),
        (([[1.0]], None), "q is missing"),
        (([[1.0]], [1.0], "lemk"), "did you mean 'lemke'"),
        (([[1.0]], [1.0], "lemke:toll=1"), "did you mean 'tol'"),
        (([[1.0]], [1.0], "lemke:tol=2"), "tol"),
        (("missing.npz",), "missing.npz"),
        (("murthy:n=3",), "did you mean 'murty'"),
        (("a.mtx",), "needs q"),
    ],
)
def test_what_is_refused(arguments, line):
    with pytest.raises(lcpbench.InvalidInput, match=line) as why:
        lcpbench.solve(*arguments)
    assert isinstance(why.value, ValueError) and "\n" not in str(why.value)


@pytest.mark.parametrize(
    "cones, bounds, line",
    [
        ([(0, 2.9, 0.5)], {}, "cones: rows: need integers, not 2.9"),
        ([(0.5, 3, 0.5)], {}, "cones: first row: need integers"),
        ([(0, 2**40, 0.5)], {}, "cones: rows: need integers"),
        ([("a", 3, 0.5)], {}, "cones: first row: need integers"),
        ([(0, 3, 0.5)], {"lo": np.zeros(4)}, "lo: a cone has the rows 0 to 2, need -inf"),
        ([(1, 3, 0.5)], {"hi": np.ones(4)}, "hi: a cone has the rows 1 to 3, need inf"),
    ],
)
def test_cones_that_would_be_read_as_others_are_refused(cones, bounds, line):
    with pytest.raises(lcpbench.InvalidInput, match=line):
        lcpbench.Problem(np.eye(4), -np.ones(4), cones=cones, **bounds)


def test_cones_beside_bounds():
    """The row of no cone has its bounds; whole numbers of any kind are rows."""
    lo, hi = [-np.inf, -np.inf, -np.inf, 0.0], [np.inf, np.inf, np.inf, 0.5]
    for cone in ((0, 3, 0.5), (0.0, 3.0, 0.5), (np.int64(0), np.uint8(3), 0.5)):
        p = lcpbench.Problem(np.eye(4), [-1, 0, 0, -1], lo=lo, hi=hi, cones=[cone])
        assert lcpbench.verify(p, z=[1, 0, 0, 0.5])


def test_masked_arrays_are_refused():
    """They would be solved with what is behind the mask."""
    M, q = np.eye(2) * 2.0, -np.ones(2)
    hidden = np.ma.masked_array(M, mask=[[0, 0], [0, 1]])
    with pytest.raises(lcpbench.InvalidInput, match="M: has 1 masked entries"):
        lcpbench.solve(hidden, q)
    with pytest.raises(lcpbench.InvalidInput, match="q: has 2 masked entries"):
        lcpbench.solve(M, np.ma.masked_array(q, mask=True))
    assert lcpbench.verify(np.ma.masked_array(M), q, [0.5, 0.5])  # nothing is masked


def test_unsupported_says_what_is_missing():
    M, q, cones = contacts(3, 3, 0.5)
    with pytest.raises(lcpbench.Unsupported, match="lemke"):
        lcpbench.solve(M, q, "lemke", cones=cones)


def test_problems_are_freed():
    """A million numbers each: five hundred of them at a time would not fit."""
    import resource

    M = np.eye(1000)
    for _ in range(20):
        lcpbench.Problem(M, -np.ones(1000))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(200):
        lcpbench.Problem(M, -np.ones(1000))
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000  # KiB


# ---- files ----


def saved(folder, M, q, form, **more):
    path = folder / f"{form}.npz"
    if form == "dense":
        np.savez(path, M=M.toarray(), q=q, **more)
        return path
    A = M.asformat(form)
    parts = (
        {"row": A.coords[0], "col": A.coords[1]}
        if form == "coo"
        else {"indices": A.indices, "indptr": A.indptr}
    )
    np.savez_compressed(path, q=q, data=A.data, shape=A.shape, format=A.format, **parts, **more)
    return path


@pytest.mark.parametrize("form", ["dense", "csc", "csr", "coo"])
def test_numpy_files_mean_the_same_to_package_and_program(tmp_path, form):
    M, q = contacts(4, 5, 0.0)[:2]
    M = sp.coo_array(M + sp.eye_array(15, k=1) * 0.125)  # not symmetric
    path = saved(tmp_path, M, q, form)
    p = lcpbench.read(path)
    A = p.M if form == "dense" else p.M.toarray()
    assert (A == M.toarray()).all() and (p.q == q).all()
    z = lcpbench.solve(path, solver="lemke").z
    program("solve", path, "--solver", "lemke", "--z", tmp_path / "z.mtx")
    assert np.abs(scipy.io.mmread(tmp_path / "z.mtx").ravel() - z).max() < 1e-12
    assert lcpbench.verify(path, z=z)


def test_bounds_in_numpy_files(tmp_path):
    M = sp.coo_array(np.diag([2.0, 4.0]))
    path = saved(tmp_path, M, np.array([1.0, -8.0]), "csr", lo=np.array([-1.0, 0]), hi=np.ones(2))
    assert np.allclose(lcpbench.solve(path).z, [-0.5, 1.0], atol=1e-6)


def test_matrix_market_and_families(tmp_path):
    M, q = column()
    scipy.io.mmwrite(tmp_path / "c.M.mtx", M.tocoo())
    scipy.io.mmwrite(tmp_path / "c.q.mtx", q[:, None])
    assert np.allclose(lcpbench.solve(tmp_path / "c.M.mtx").z, np.arange(N, 0, -1) * G * H)
    assert lcpbench.solve(tmp_path / "c.M.mtx", tmp_path / "c.q.mtx").verified
    p = lcpbench.read("murty:n=6")
    assert p.n == 6 and lcpbench.solve(p, solver="lemke").iterations > 6


@pytest.mark.parametrize("form", ["dense", "csc"])
def test_the_program_writes_what_numpy_reads(tmp_path, form):
    M, q = contacts(4, 5, 0.0)[:2]
    lo, hi = np.full(15, -np.inf), np.arange(15.0)
    path = saved(tmp_path, sp.coo_array(M), q, form, lo=lo, hi=hi)
    program("export", path, "--format", "npz", "--out", tmp_path / "again.npz")
    p = lcpbench.read(tmp_path / "again.npz")
    A = p.M if form == "dense" else p.M.toarray()
    assert (A == M.toarray()).all() and (p.q == q).all()
    assert (p.lo == lo).all() and (p.hi == hi).all()


def test_damaged_files_are_refused(tmp_path):
    M, q = column()
    path = saved(tmp_path, M, q, "csr")
    whole = path.read_bytes()
    cases = [(whole[:100], "csr.npz"), (b"", "csr.npz"), (b"no zip at all", "csr.npz")]
    for data, line in cases:
        path.write_bytes(data)
        with pytest.raises(lcpbench.InvalidInput, match=line):
            lcpbench.read(path)
    np.savez(path, M=np.eye(2), q=np.ones(2), low=np.zeros(2))
    with pytest.raises(lcpbench.InvalidInput, match="low"):
        lcpbench.read(path)
    np.savez(path, M=np.eye(2), q=np.array([{}, {}], dtype=object))  # nothing is unpickled
    with pytest.raises(lcpbench.InvalidInput, match="csr.npz"):
        lcpbench.read(path)


# ---- studies ----


def test_a_solver_in_python_is_judged_like_the_others():
    def right(M, q):
        return lcpbench.solve(M, q, "lemke").z

    def liar(M, q):
        return np.zeros(len(q))

    def broken(M, q):
        raise RuntimeError("no")

    def shapeless(M, q):
        return "zero"

    def greedy(M, q):
        q[:] = 1.0  # changes its own copy only
        return np.zeros(len(q))

    using = ["lemke", right, liar, broken, shapeless, greedy]
    t = lcpbench.study({"column": lcpbench.Problem(*column())}, using).set_index("solver")
    assert t.verified.dtype == bool and t.verified.to_dict() == {
        "lemke": True,
        "right": True,
        "liar": False,
        "broken": False,
        "shapeless": False,
        "greedy": False,
    }
    assert t.status["liar"] == "unverified" and t.status["broken"] == "error"
    assert "RuntimeError: no" in t.note["broken"] and t.rho["liar"] > 1e-6


# ---- scenes ----


def test_a_scene_as_a_dict_and_as_a_file(tmp_path):
    scene = {
        "id": "drop",
        "dim": 2,
        "T": 0.1,
        "g": 9.81,
        "bodies": [{"name": "b", "shape": {"type": "disc", "r": 0.1}, "mass": 1.0, "pos": [0, 9]}],
    }
    scene.pop("g")
    one = lcpbench.simulate(scene, "velocity", "lemke", step=0.01, trajectory=True)
    (tmp_path / "drop.json").write_text(json.dumps(scene))
    other = lcpbench.simulate(tmp_path / "drop.json", "velocity", "lemke", step=0.01)
    assert one["solution_hash"] == other["solution_hash"] and one["steps"] == 10
    assert isinstance(one["trajectory"], pd.DataFrame) and len(one["trajectory"]) >= 10
    for name in ("#1", "a, b", "NA", "7"):  # what a reader of CSV may take for something else
        scene["bodies"][0]["name"] = name
        way = lcpbench.simulate(scene, "velocity", "lemke", trajectory=True)["trajectory"]
        assert set(way["name"]) == {"drop", name} and way["sz"].notna().all(), name
    assert lcpbench.simulate("stack:n=2", "regularized", "lemke")["verified"]
    chosen = lcpbench.simulate("incline", error=0.01)  # from the table that the program ships
    assert chosen["verified"] and chosen["formulation"] and chosen["solver"]


def test_bad_scenes_and_honest_failures():
    with pytest.raises(lcpbench.InvalidInput, match="did you mean 'stack'"):
        lcpbench.simulate("stak", "velocity", "lemke")
    with pytest.raises(lcpbench.InvalidInput, match="bodies"):
        lcpbench.simulate({"id": "x", "dim": 2, "T": 1, "boddies": []}, "velocity", "lemke")
    with pytest.raises(lcpbench.InvalidInput, match="no JSON"):
        lcpbench.simulate({"id": object()}, "velocity", "lemke")
    with pytest.raises(lcpbench.InvalidInput, match="--step"):
        lcpbench.simulate("stack", "velocity", "lemke", step=-1)
    with pytest.raises(lcpbench.InvalidInput, match="did you mean"):
        lcpbench.simulate("stack", "velocity", "lemke", contact_ordre="given")
    with pytest.raises(lcpbench.NotSolved, match="max_iter") as why:
        lcpbench.simulate("stack:n=2", "velocity", "pgs:max_iter=1")
    assert why.value.result["status"] == "max_iter"


# ---- rows ----


def program(*words, code=0):
    done = subprocess.run(
        [sys.executable, "-m", "lcpbench", *map(str, words)],
        capture_output=True,
        text=True,
        check=False,
        env=dict(os.environ, OPENBLAS_NUM_THREADS="1"),
    )
    assert done.returncode == code, (words, done)
    return done.stdout


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rows")
    (folder / "c.yaml").write_text(
        "name: mine\nlimits: {time: 20s}\n"
        "sampling: {processes: 1, samples: 3, max_samples: 3, budget: 1s}\nparts:\n"
        "  - name: all\n    problems: ['murty:n={4,8,12}', 'random_spd:n=20']\n"
        "    solvers: [lemke, newton, 'pgs:max_iter=3']\n"
    )
    program("run", folder / "c.yaml", "--out", folder / "rows", "--quiet")
    return folder / "rows"


def test_rows_have_booleans_and_units(measured):
    rows = lcpbench.load(measured)
    assert rows.verified.dtype == bool and rows.quick.dtype == bool
    good = rows[rows.verified]
    assert 0 < len(good) < len(rows) and set(good.solver) >= {"lemke", "newton"}
    assert not rows[rows.status == "max_iter"].verified.any()
    units = rows.attrs["units"]
    assert units["t_total_s"] == "s" and units["rss_peak_B"] == "B" and units["rho"] == "1"
    assert "problem" not in units and "n_iter" not in units
    assert rows.attrs["manifests"]["rows"]["campaign"]


def test_packed_rows_and_files(measured, tmp_path):
    rows = lcpbench.load(measured)
    packed = tmp_path / "results.csv.xz"
    packed.write_bytes(lzma.compress((measured / "results.csv").read_bytes()))
    for source in (packed, tmp_path, measured / "results.csv"):
        pd.testing.assert_frame_equal(lcpbench.load(source), rows, check_like=True)
    packed.write_bytes(packed.read_bytes()[:-40])
    with pytest.raises(lcpbench.InvalidInput, match="results.csv.xz"):
        lcpbench.load(tmp_path)
    with pytest.raises(lcpbench.InvalidInput, match="nowhere"):
        lcpbench.load(tmp_path / "nowhere")


def test_profiles_count_failures(measured):
    table = lcpbench.profile(measured, factors=(1, 1e9)).set_index("solver")
    rows = lcpbench.load(measured)
    for name, line in table.iterrows():
        mine = rows[rows.solver == name.partition(":")[0]]
        solved = mine.groupby("problem").verified.all() & (
            mine.groupby("problem").status.agg(lambda s: (s == "ok").all())
        )
        assert line.problems == 4 and line.solved == solved.sum()
        assert line["within_1e+09"] == pytest.approx(solved.sum() / 4)
    assert table.loc["lemke"].solved == 4 and table.within_1.sum() >= 1
    axes = lcpbench.plot.profile(lcpbench.profile(measured))
    curve = {line.get_label(): line.get_ydata()[-1] for line in axes.get_lines()}
    assert curve["lemke"] == 1.0 and len(curve) == 3
    plt.close("all")


def test_work_precision_leaves_failures_out():
    rows = pd.DataFrame(
        {
            "formulation": list("aab"),
            "status": ["ok", "max_iter", "ok"],
            "verified": [True, False, True],
            "err_ref": [1e-2, 1e-9, 1e-3],
            "t_total_s": [1.0, 1.0, 2.0],
        }
    )
    (a, b) = lcpbench.plot.work_precision(rows).get_lines()
    assert a.get_ydata().tolist() == [1e-2] and b.get_xdata().tolist() == [2.0]
    plt.close("all")


def test_the_program_of_the_package(measured, tmp_path):
    assert program("--version").split()[-1] == lcpbench.__version__ == lcpbench.version()
    assert "smoke" in program("list", "campaigns").split()
    out = program("profile", measured, "--out", tmp_path / "figures")
    assert "lemke" in out and (tmp_path / "figures" / "profile.pdf").stat().st_size > 1000


def test_importing_changes_no_figures_of_others():
    text = (
        "import matplotlib; matplotlib.use('svg'); a = dict(matplotlib.rcParams)\n"
        "import lcpbench; b = dict(matplotlib.rcParams)\n"
        "assert a == b and matplotlib.get_backend() == 'svg', (set(a.items()) ^ set(b.items()))"
    )
    subprocess.run([sys.executable, "-c", text], check=True)


def test_the_package_is_typed():
    assert (pathlib.Path(lcpbench.__file__).parent / "py.typed").exists()
    for name in lcpbench.__all__:
        item = getattr(lcpbench, name)
        assert item.__doc__, name
        if callable(item) and not isinstance(item, type):
            assert "return" in item.__annotations__, name


def test_the_notebook_runs():
    nbclient = pytest.importorskip("nbclient")
    import nbformat

    book = nbformat.read(HERE.parent / "examples" / "work_precision.ipynb", 4)
    nbclient.NotebookClient(book, timeout=300, kernel_name="python3").execute()
    outputs = [o for c in book.cells for o in c.get("outputs", [])]
    assert any("image/png" in o.get("data", {}) for o in outputs)

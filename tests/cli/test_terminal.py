"""Tables of a terminal, files of numpy, packed rows and standard input."""

import csv
import io
import json
import lzma
import math
import re
import shutil
import struct
import subprocess
import sys
import zipfile

from support import FAULTY, LCPBENCH, TESTS, diagonal, one_line_error, run, run_json, tap

REFERENCE = TESTS.parent / "results" / "reference"
M = [[2.0, 1.0, 0.0], [1.0, 2.0, 0.5], [0.0, 0.5, 3.0]]
Q = [-1.0, 0.25, -3.0]


# ---- tables ----


def every_solver_has_a_row(_):
    done = run("solve", "box_stack:n=3", "--solver", "all")
    header, *lines = done.stdout.splitlines()
    assert header.split()[:6] == ["solver", "status", "verified", "rho", "time_s", "n_iter"]
    assert sorted(line.split()[0] for line in lines) == sorted(
        run("list", "solvers").stdout.split()
    )
    assert not any(line != line.rstrip() for line in [header, *lines])
    rows = run_json("solve", "box_stack:n=3", "--solver", "all", "--format", "json")
    good = [r["verified"] for r in rows]
    assert any(good) and good == sorted(good, reverse=True), good  # verified answers come first
    one = run_json("solve", "box_stack:n=3", "--solver", "lemke")
    of_table = next(r for r in rows if r["solver"] == "lemke")
    same = ("rho", "n_iter", "solution_hash", "certificate", "certificate_holds", "status")
    assert {k: one[k] for k in same} == {k: of_table[k] for k in same}
    assert of_table["time_s"] == sum(of_table[f"t_{k}_s"] for k in ("setup", "factor", "solve"))
    table = list(
        csv.DictReader(
            io.StringIO(run("solve", "box_stack:n=3", "--solver", "all", "--format", "csv").stdout)
        )
    )
    assert {r["solver"]: r["rho"] for r in table}["lemke"] == f"{one['rho']:.17g}"


def some_solvers_with_their_options(_):
    rows = run_json(
        "solve",
        "murty:n=4",
        "--solver",
        "lemke:tol=1e-8",
        "--solver",
        "pgs",
        "--max-iter",
        "7",
        "--format",
        "json",
        code=None,
    )
    assert {r["solver"] for r in rows} == {"lemke", "pgs"}
    assert all("max_iter=7" in r["options"] for r in rows)
    one_line_error("solve", "murty", "--solver", "all", "--z", "z.mtx", names=["--z"])
    one_line_error(
        "solve", "murty", "--solver", "lemke", "--time-limit", "1", names=["--time-limit"]
    )
    one_line_error("solve", "murty", "--solver", "all", "--solver", "lemke", names=["all"])


def friction_has_its_residual_in_the_table(_):
    fclib = next((TESTS / "data").rglob("*.hdf5"), None) or next(
        p for p in (TESTS / "data" / "friction").rglob("*.dat")
    )
    rows = run_json("solve", fclib, "--solver", "all", "--format", "json", code=None)
    assert any(r["verified"] and r["res_ncp"] < 1e-6 for r in rows), rows
    assert all("res_ncp" in r for r in rows if r["claimed"])


def faults_cost_one_row_each(d):
    """What lies, crashes or hangs earns its word and takes no row along; nothing verified: 3."""
    problem = diagonal(d, 4)
    faulty = ["faulty_liar", "faulty_crash", "faulty_hang", "lemke"]
    words = [w for s in faulty for w in ("--solver", s)]
    rows = json.loads(
        run(
            "solve",
            problem,
            *words,
            "--time-limit",
            "5",
            "--format",
            "json",
            exe=FAULTY,
            timeout=60,
        ).stdout
    )
    word = {r["solver"]: (r["status"], r["verified"]) for r in rows}
    assert rows[0]["solver"] == "lemke" and word["lemke"] == ("ok", True), word
    assert word["faulty_crash"] == ("crash", False) and word["faulty_hang"] == ("timeout", False), (
        word
    )
    assert word["faulty_liar"] == ("unverified", False), word
    assert all(r["n_iter"] is None and r["rho"] is None for r in rows if r["status"] == "crash")
    run("solve", problem, "--solver", "faulty_liar", "--solver", "faulty_crash", exe=FAULTY, code=3)


def status_has_a_line_for_each_combination(_):
    rows = json.loads(run("status", REFERENCE / "paper", "--format", "json").stdout)
    with lzma.open(REFERENCE / "paper" / "results.csv.xz", "rt", encoding="utf-8") as f:
        own = list(csv.DictReader(f))

    def name(r, kind):
        return r[kind] + (":" + r[f"{kind}_options"] if r[f"{kind}_options"] else "")

    cells = {}
    for r in own:
        key = name(r, "formulation"), name(r, "solver")
        cells.setdefault(key, {}).setdefault(r["cell_id"], []).append(r)
    assert {(r["formulation"], r["solver"]) for r in rows} == set(cells)
    for r in rows:
        mine = cells[r["formulation"], r["solver"]]
        ok = [c for c in mine.values() if all(x["status"] == "ok" for x in c)]
        verified = [c for c in mine.values() if all(x["verified"] == "true" for x in c)]
        times = sorted(float(x["t_total_s"]) for c in ok for x in c if x["verified"] == "true")
        assert (r["cells"], r["ok"], r["verified"]) == (len(mine), len(ok), len(verified)), r
        if times:
            n = len(times)
            assert math.isclose(r["time_s"], (times[(n - 1) // 2] + times[n // 2]) / 2), r
    table = run("status", REFERENCE / "paper", "--table").stdout.splitlines()
    assert len(table) == len(rows) + 1 and table[0].split()[:3] == [
        "formulation",
        "solver",
        "cells",
    ]


# ---- packed rows ----


def packed_rows_are_read_by_every_verb(d):
    """The same rows, plain and packed, say the same."""
    plain, packed = d / "plain", d / "packed"
    for folder in (plain, packed):
        shutil.copytree(REFERENCE / "library", folder)
    (plain / "results.csv.xz").unlink()
    text = lzma.decompress((packed / "results.csv.xz").read_bytes())
    (plain / "results.csv").write_bytes(text)
    for words in (["status"], ["status", "--table"]):
        a, b = (run(words[0], f, *words[1:]).stdout for f in (plain, packed))
        assert a.replace("plain", "") == b.replace("packed", ""), words
    same = run("status", packed / "results.csv.xz").stdout.splitlines()[1:]
    assert same == run("status", plain / "results.csv").stdout.splitlines()[1:]
    # Each pair is one measurement; rows that were disturbed are inconclusive all the same.
    told = run("compare", plain, packed).stdout
    pairs = told.splitlines()[:-3]  # then the mean, the failures, the noise
    words = [p.split("] ")[-1] for p in pairs]
    assert len(pairs) > 100 and set(words) <= {"no difference", "inconclusive: disturbed"}, told
    assert all("ratio 1.0000 [" in p for p in pairs), told
    alike = words.count("no difference")
    assert f"{alike} no difference, 0 faster, 0 slower" in told, told
    assert alike == len(pairs) or f"{len(pairs) - alike} inconclusive" in told, told
    assert "noise floor" in run("compare", plain / "results.csv", packed / "results.csv.xz").stdout
    # merge writes what it read, whole
    run("merge", packed, "--out", d / "merged")
    got = list(csv.DictReader((d / "merged" / "results.csv").open(newline="", encoding="utf-8")))
    assert len(got) == len(list(csv.DictReader(io.StringIO(text.decode()))))
    one_line_error("run", "smoke", "--quick", "--out", packed, names=["results.csv.xz", "xz -d"])


def verify_reads_packed_rows(d):
    run("run", "smoke", "--quick", "--out", d / "rows", "--quiet", "--filter", "solver=lemke")
    plain = run("verify", d / "rows").stdout
    path = d / "rows" / "results.csv"
    path.with_name("results.csv.xz").write_bytes(lzma.compress(path.read_bytes()))
    one_line_error("verify", d / "rows", names=["results.csv", "results.csv.xz", "need one"])
    path.unlink()
    assert run("verify", d / "rows").stdout == plain and "0 differ" in plain


def damaged_packed_rows_are_refused(d):
    data = (REFERENCE / "library" / "results.csv.xz").read_bytes()
    path = d / "rows.csv.xz"
    for bad, word in (
        (data[: len(data) // 2], "ends early"),
        (data[:4000] + bytes([data[4000] ^ 255]) + data[4001:], "damaged"),
        (b"schema,part\n", "is not packed with xz"),
        (b"", "packed"),
    ):
        path.write_bytes(bad)
        one_line_error("status", path, names=["rows.csv.xz", word])


# ---- numpy ----


def npy(values, shape, kind="<f8", fortran=False):
    """An array as numpy writes it (NEP 1, version 1.0)."""
    pack = {"<f8": "d", "<f4": "f", "<i4": "i", "<i8": "q", "<u2": "H", ">f8": ">d", "|b1": "?"}
    head = f"{{'descr': '{kind}', 'fortran_order': {fortran}, 'shape': {shape}, }}"
    head += " " * (-(len(head) + 11) % 64) + "\n"
    if kind[1] in "SU":
        body = values.encode("utf-32-le" if kind[1] == "U" else "ascii")
    else:
        body = b"".join(struct.pack("<" + pack[kind].lstrip(">"), v) for v in values)
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head.encode() + body


def npz(path, packed=True, **arrays):
    method = zipfile.ZIP_DEFLATED if packed else zipfile.ZIP_STORED
    with zipfile.ZipFile(path, "w", method) as z:
        for name, data in arrays.items():
            with z.open(f"{name}.npy", "w", force_zip64=True) as f:  # as numpy.savez does
                f.write(data)
    return path


def flat(m):
    return [x for row in m for x in row]


def sparse(m, form):
    """The arrays of scipy.sparse.save_npz."""
    n = len(m)
    look = (lambda a, b: m[b][a]) if form == "csc" else (lambda a, b: m[a][b])
    data, indices, indptr = [], [], [0]
    for a in range(n):
        some = [(b, look(a, b)) for b in reversed(range(n)) if look(a, b)]  # not sorted: allowed
        indices += [b for b, _ in some]
        data += [x for _, x in some]
        indptr.append(len(data))
    out = {"data": npy(data, (len(data),)), "shape": npy([n, n], (2,), "<i8")}
    if form == "coo":
        rows = [a for a in range(n) for _ in range(indptr[a + 1] - indptr[a])]
        out |= {"row": npy(rows, (len(rows),), "<i4"), "col": npy(indices, (len(rows),), "<i4")}
    else:
        out |= {
            "indices": npy(indices, (len(data),), "<i4"),
            "indptr": npy(indptr, (n + 1,), "<i4"),
        }
    return out | {"format": npy(form, (), "|S3")}


def numpy_problems_are_read(d):
    """Dense in both orders, three kinds of sparse, four kinds of numbers, stored and deflated: the
    answer is that of the same problem in Matrix Market."""
    q = npy(Q, (3,))
    turned = [M[j][i] + (i != j) * 0.125 * i for i in range(3) for j in range(3)]  # not symmetric
    skew = [turned[i * 3 : i * 3 + 3] for i in range(3)]
    (d / "p.M.mtx").write_text(
        "%%MatrixMarket matrix array real general\n3 3\n"
        + "".join(f"{skew[i][j]}\n" for j in range(3) for i in range(3))
    )
    (d / "p.q.mtx").write_text(
        "%%MatrixMarket matrix array real general\n3 1\n" + "".join(f"{x}\n" for x in Q)
    )
    want = run_json("solve", d / "p.M.mtx", "--solver", "lemke")["solution_hash"]
    columns = [skew[i][j] for j in range(3) for i in range(3)]
    tried = 0
    for arrays in (
        {"M": npy(flat(skew), (3, 3))},
        {"M": npy(columns, (3, 3), fortran=True)},
        {"M": npy(flat(skew), (3, 3), "<f4")},
        {"M": npy(flat(skew), (3, 3)), "lo": npy([0.0] * 3, (3,)), "hi": npy([math.inf] * 3, (3,))},
        *(sparse(skew, form) for form in ("csc", "csr", "coo")),
    ):
        for packed in (True, False):
            path = npz(d / "p.npz", packed, q=q, **arrays)
            o = run_json("solve", path, "--solver", "lemke")
            assert o["verified"] and o["solution_hash"] == want, (tried, o)
            assert o["storage"] == ("csc" if "indptr" in arrays or "row" in arrays else "dense")
            tried += 1
    assert tried == 14
    text = sparse(M, "csr") | {
        "format": npy("csr", (), "<U3"),
        "q": npy([-1, 0, -3], (3, 1), "<i8"),
    }
    assert run_json("solve", npz(d / "t.npz", **text), "--solver", "lemke")["verified"]


def bounds_of_numpy_problems(d):
    """-1 <= z <= 0.5 by hand: M diagonal, z = clip(-q / m)."""
    diag = npy([2, 0, 0, 0, 4, 0, 0, 0, 1], (3, 3))
    path = npz(
        d / "b.npz",
        M=diag,
        q=npy([1.0, -8.0, 5.0], (3,)),
        lo=npy([-1.0, -1.0, -math.inf], (3,)),
        hi=npy([0.5, 0.5, math.inf], (3,)),
    )
    run("solve", path, "--solver", "pgs", "--z", d / "z.mtx")
    z = [float(x) for x in (d / "z.mtx").read_text().splitlines()[2:]]
    assert [round(x, 6) for x in z] == [-0.5, 0.5, -5.0], z
    rows = run_json("solve", path, "--solver", "all", "--format", "json")
    word = {r["solver"]: r["status"] for r in rows}
    assert word["pgs"] == "ok" and "unsupported" in word.values(), word
    want = run_json("solve", path, "--solver", "pgs")
    run("export", path, "--format", "npz", "--out", d / "again.npz")
    assert (
        run_json("solve", d / "again.npz", "--solver", "pgs")["solution_hash"]
        == want["solution_hash"]
    )
    once = (d / "again.npz").read_bytes()
    run("export", d / "again.npz", "--format", "npz", "--out", d / "third.npz")
    assert (d / "third.npz").read_bytes() == once
    friction = next(p for p in (TESTS / "data" / "friction").rglob("*.dat"))
    for form in ("mtx", "npz"):
        one_line_error("export", friction, "--format", form, "--out", d / "f", names=["holds"])


def every_verb_reads_numpy_problems(d):
    path = npz(d / "p.npz", M=npy(flat(M), (3, 3)), q=npy(Q, (3,)))
    run("export", path, "--format", "mtx", "--out", d / "again")
    run("solve", path, "--solver", "lemke", "--certificate", d / "proof")
    assert run_json("verify", path, "--certificate", d / "proof")["holds"]
    (d / "c.yaml").write_text(
        "name: mine\nlimits: {time: 10s}\n"
        "sampling: {processes: 1, samples: 1, max_samples: 1}\n"
        f"parts:\n  - name: all\n    problems: ['{d}/*.npz']\n    solvers: [lemke, ppm]\n"
    )
    assert "ok          2 cells" in run("run", d / "c.yaml", "--out", d / "rows", "--quiet").stdout
    assert "2 cells verified" in run("verify", d / "rows").stdout
    path.write_bytes(npz(d / "q.npz", M=npy(flat(M), (3, 3)), q=npy([-2.0] * 3, (3,))).read_bytes())
    assert "differ" in run("verify", d / "rows", code=3).stdout  # the file changed under the rows


def bad_numpy_problems_are_refused(d):
    m, q = npy(flat(M), (3, 3)), npy(Q, (3,))
    parts = sparse(M, "csc")
    twice = parts | {"indices": npy([0] * 7, (7,), "<i4")}
    cases = [
        ({"M": m}, ["has no q"]),
        ({"q": q}, ["need M"]),
        ({"M": m, "q": q, **parts}, ["need M"]),
        ({"M": npy([1.0] * 6, (3, 2)), "q": q}, ["M", "square"]),
        ({"M": m, "q": npy([1.0] * 4, (4,))}, ["q", "4", "3"]),
        ({"M": m, "q": npy([1.0, math.nan, 0.0], (3,))}, ["q[1]", "nan"]),
        ({"M": m, "q": npy(Q, (3,), ">f8")}, ["q", ">f8", "little-endian"]),
        ({"M": m, "q": npy([True] * 3, (3,), "|b1")}, ["q", "|b1"]),
        ({"M": m, "q": q, "low": q}, ["low", "did you mean 'lo'"]),
        ({"M": m, "q": q, "lo": npy([1.0] * 3, (3,)), "hi": npy([0.0] * 3, (3,))}, ["lo <= hi"]),
        ({"M": npy(flat(M), (3, 3))[:-8], "q": q}, ["M", "number of elements"]),
        ({"M": b"no array", "q": q}, ["M", "not an array"]),
        ({"q": q, **twice}, ["stands twice"]),
        ({"q": q, **parts, "format": npy("bsr", (), "|S3")}, ["bsr", "csc"]),
        ({"q": q, **parts, "indptr": npy([0, 2, 1, 7], (4,), "<i4")}, ["indptr[2]"]),
        ({"q": q, **parts, "indices": npy([9] * 7, (7,), "<i4")}, ["indices[0]", "0..2"]),
        ({"q": q, **parts, "shape": npy([10**9, 10**9], (2,), "<i8")}, ["shape"]),
    ]
    for arrays, names in cases:
        path = npz(d / "p.npz", **arrays)
        one_line_error("solve", path, "--solver", "lemke", names=["p.npz", *names])
    whole = npz(d / "p.npz", M=m, q=q).read_bytes()
    at = whole.index(b"M.npy") + 5 + 20 + 40  # inside the deflated M
    for bad, name in (
        (whole[:-10], "ZIP"),
        (whole[: len(whole) // 2], "ZIP"),
        (whole[:at] + bytes([whole[at] ^ 85]) + whole[at + 1 :], "damaged"),
        (b"", "ZIP"),
    ):
        path.write_bytes(bad)
        one_line_error("solve", path, "--solver", "lemke", names=["p.npz", name])
    stored = npz(d / "s.npz", False, M=m, q=q).read_bytes()
    at = stored.index(m) + len(m) - 3  # a number that only the sum of its file knows
    (d / "s.npz").write_bytes(stored[:at] + bytes([stored[at] ^ 1]) + stored[at + 1 :])
    one_line_error("solve", d / "s.npz", "--solver", "lemke", names=["s.npz", "damaged", "M"])
    one_line_error(
        "solve",
        npz(d / "g.npz", M=m, q=q),
        "--solver",
        "lemke",
        "--q",
        "x",
        names=["--q", "has a q already"],
    )
    one_line_error("solve", d / "g.npz", "--solver", "lemke", "--facets", "4", names=["friction"])


# ---- standard input ----


def piped(data, *words, code=0):
    done = subprocess.run(
        [LCPBENCH, *map(str, words)], input=data, capture_output=True, timeout=60, check=False
    )
    assert done.returncode == code, (words, done)
    return done


def problems_from_standard_input(d):
    files = {"npz": npz(d / "p.npz", M=npy(flat(M), (3, 3)), q=npy(Q, (3,)))}
    run("export", files["npz"], "--format", "siconos", "--out", d / "p.dat")
    files["dat"] = d / "p.dat"
    files["friction"] = next(p for p in (TESTS / "data" / "friction").rglob("*.dat"))
    run("export", files["friction"], "--format", "fclib", "--out", d / "f.hdf5")
    files["hdf5"] = d / "f.hdf5"
    for kind, path in files.items():
        solver = "lemke" if kind in ("npz", "dat") else "nsgs"
        want = run_json("solve", path, "--solver", solver, code=None)
        got = piped(
            path.read_bytes(),
            "solve",
            "-",
            "--solver",
            solver,
            code=0 if want["status"] == "ok" and want["verified"] else 3,
        )
        assert json.loads(got.stdout)["solution_hash"] == want["solution_hash"], kind
    run("export", files["npz"], "--format", "mtx", "--out", d / "m")
    got = piped(
        (d / "m.M.mtx").read_bytes(), "solve", "-", "--solver", "lemke", "--q", d / "m.q.mtx"
    )
    assert json.loads(got.stdout)["verified"]
    table = piped(files["npz"].read_bytes(), "solve", "-", "--solver", "all", "--format", "csv")
    assert b"lemke,ok,true" in table.stdout
    run("solve", files["npz"], "--solver", "lemke", "--certificate", d / "proof")
    assert (
        b'"holds": true'
        in piped(files["npz"].read_bytes(), "verify", "-", "--certificate", d / "proof").stdout
    )
    for bad in (b"", b"no problem", b"PK\x03\x04"):
        done = piped(bad, "solve", "-", "--solver", "lemke", code=2)
        assert done.stderr.count(b"\n") == 1 and b"lcpbench: -" in done.stderr, done


def scenes_from_standard_input(d):
    scene = {
        "id": "drop",
        "dim": 2,
        "T": 0.05,
        "bodies": [{"name": "b", "shape": {"type": "disc", "r": 0.1}, "mass": 1.0, "pos": [0, 1]}],
    }
    (d / "s.json").write_text(json.dumps(scene))
    (d / "s.yaml").write_text(
        "id: drop\ndim: 2\nT: 0.05\nbodies:\n"
        "  - {name: b, shape: {type: disc, r: 0.1}, mass: 1.0, pos: [0, 1]}\n"
    )
    way = ["--formulation", "velocity", "--solver", "lemke"]
    want = run_json("simulate", d / "s.json", *way)
    for name in ("s.json", "s.yaml"):
        got = json.loads(piped((d / name).read_bytes(), "simulate", "-", *way).stdout)
        assert got["scene"] == "drop" and got["solution_hash"] == want["solution_hash"], name
    two = json.dumps([dict(scene, id="other"), scene]).encode()
    assert json.loads(piped(two, "simulate", "-#drop", *way).stdout)["scene"] == "drop"
    assert b"lcpbench: -" in piped(b"{", "simulate", "-", *way, code=2).stderr
    assert piped((d / "s.json").read_bytes(), "check", "-").returncode == 0


# ---- scripts as verbs ----


def verbs_of_scripts_have_the_options_of_their_scripts(_):
    for verb in ("recommend", "report", "profile", "render"):
        ours = set(re.findall(r"^  (--[a-z-]+)", run("help", verb).stdout, re.M)) - {"--plugin"}
        text = (TESTS.parent / "scripts" / "bench" / f"{verb}.py").read_text(encoding="utf-8")
        theirs = set(re.findall(r'add_argument\(\s*"(--[a-z-]+)"', text))
        assert ours == theirs and theirs, (verb, ours, theirs)
    done = run("report", "x", code=2, LCPBENCH_SCRIPTS="/nowhere")
    assert done.stderr.count("\n") == 1 and "LCPBENCH_SCRIPTS" in done.stderr, done


def a_profile_from_packed_rows(d):
    done = run(
        "profile", REFERENCE / "library", "--out", d / "figures", "--format", "json", timeout=120
    )
    rows = json.loads(done.stdout)
    assert {p.name for p in (d / "figures").iterdir()} == {"profile.pdf", "profile.png"}
    assert rows[0]["solved"] == max(r["solved"] for r in rows) and rows[0]["problems"] > 50
    for r in rows:
        assert 0 <= r["within_1"] <= r["within_2"] <= r["within_10"] <= r["solved"] / r["problems"]
    one_line_error("profile", d / "nowhere", names=["nowhere"], timeout=60)
    asked = ("recommend", REFERENCE / "claims", "--scene")  # accuracy: 8 s a time
    done = run(*asked, "incline", "--error", "0.01")
    assert "lcpbench simulate" in done.stdout
    one_line_error(*asked, "inclin", "--error", "1%", names=["inclin", "incline"], timeout=60)
    one_line_error(*asked, "incline", "--error", "2cm", names=["--error", "2cm"], timeout=60)
    one_line_error(*asked, "incline", names=["--error"], timeout=60)
    (d / "scene.yaml").write_text("id: a\nbodies: [b, c, d]\n")
    one_line_error("render", d / "scene.yaml", names=["scene.yaml", "trajectory"], timeout=60)


if __name__ == "__main__":
    sys.exit(
        tap(
            [
                every_solver_has_a_row,
                some_solvers_with_their_options,
                friction_has_its_residual_in_the_table,
                faults_cost_one_row_each,
                status_has_a_line_for_each_combination,
                packed_rows_are_read_by_every_verb,
                verify_reads_packed_rows,
                damaged_packed_rows_are_refused,
                numpy_problems_are_read,
                bounds_of_numpy_problems,
                every_verb_reads_numpy_problems,
                bad_numpy_problems_are_refused,
                problems_from_standard_input,
                scenes_from_standard_input,
                verbs_of_scripts_have_the_options_of_their_scripts,
                a_profile_from_packed_rows,
            ]
        )
    )

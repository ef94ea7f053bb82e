"""Certificates from the command line: what any solver claims of an unsolvable problem is written,
read back and checked in rational arithmetic by `lcpbench verify`, which refuses planted ones."""

import json

from support import CASES, SANITIZED, fewer, one_line_error, run, run_json, tap


def catalogue():
    return {c["id"]: c for c in json.loads(CASES.read_text())["lcp"]}


def write_problem(d, case):
    """Matrix Market files of a case, entries with 17 digits."""
    n, m = case["n"], case["M"]
    path = d / f"{case['id']}.M.mtx"
    entries = "".join(f"{m[i][j]!r}\n" for j in range(n) for i in range(n))
    path.write_text(f"%%MatrixMarket matrix array real general\n{n} {n}\n{entries}")
    q = "".join(f"{v!r}\n" for v in case["q"])
    (d / f"{case['id']}.q.mtx").write_text(f"%%MatrixMarket matrix array real general\n{n} 1\n{q}")
    return path


def write_certificate(path, kind, rows):
    path.write_text(
        f"lcpbench certificate 1\nkind {kind}\nn {len(rows)}\n"
        + "".join(f"{i} {row}\n" for i, row in enumerate(rows))
    )
    return path


def holds(problem, certificate):
    v = json.loads(run("verify", problem, "--certificate", certificate, code=None).stdout)
    assert run("verify", problem, "--certificate", certificate, code=0 if v["holds"] else 3)
    return v


def solvers():
    return [s["name"] for s in json.loads(run("list", "solvers", "--format", "json").stdout)]


def claim(problem, solver, certificate):
    """What the solver says of the problem; a proof or a ray goes to the file."""
    ask = ("solve", problem, "--solver", solver, "--max-iter", "2000")
    said = json.loads(run(*ask, code=None).stdout)["claimed"]
    if said in ("infeasible", "ray"):
        assert json.loads(run(*ask, "--certificate", certificate, code=3).stdout)["claimed"] == said
    return said


def unsolvable_cases_end_with_certificates_that_hold(d):
    cases = [c for c in catalogue().values() if c["kind"] in ("infeasible", "unsolvable")]
    assert len(cases) >= 14
    exact, rays = set(), set()
    for k, case in enumerate(cases):
        problem = write_problem(d, case)
        asked = solvers()
        if SANITIZED:  # a sixth of those that need not prove anything, each on some cases
            asked = [s for m, s in enumerate(asked) if s in ("lemke", "ppm") or (k + m) % 6 == 0]
        for solver in asked:
            path = d / f"{case['id']}.{solver}.txt"
            said = claim(problem, solver, path)
            assert said != "ok", f"{solver} claims to have solved {case['id']}"
            if said in ("infeasible", "ray"):
                v = holds(problem, path)
                assert v["holds"], f"{solver} on {case['id']}: {said}, but {v['why']}"
                assert v["certificate"] == ("farkas" if said == "infeasible" else "ray"), v
                assert v["exact"] == (said == "infeasible"), v
                (exact if v["exact"] else rays).add((case["id"], solver))
    for case in (
        cases
    ):  # all of these are monotone or copositive-plus, or have a row that no z >= 0 can help
        if case["kind"] == "infeasible":
            assert (case["id"], "lemke") in exact, f"lemke proves nothing of {case['id']}"
        else:
            assert (case["id"], "lemke") in rays, f"lemke ends without a ray on {case['id']}"
    proved_by_others = {solver for _, solver in exact} - {"lemke"}
    assert "ppm" in proved_by_others, proved_by_others
    print(f"# {len(exact)} proofs, {len(rays)} rays, by {sorted({s for _, s in exact | rays})}")


def planted_certificates_are_refused(d):
    cases = catalogue()
    walls = write_problem(d, cases["A4.05"])  # infeasible by 2^-20
    assert holds(walls, write_certificate(d / "y", "farkas", ["1", "1"]))["exact"]
    for wrong in (
        ["1", "1.0000000000000002"],
        ["-1", "-1"],
        ["0", "0"],
        ["1", "0"],
        ["1e-300", "2e-300"],
    ):
        assert not holds(walls, write_certificate(d / "y", "farkas", wrong))["holds"], wrong
    soft = write_problem(d, cases["A4.06"])  # its feasible neighbour
    assert not holds(soft, write_certificate(d / "y", "farkas", ["1", "1"]))["holds"]
    feasible = write_problem(
        d, cases["A8.03"]
    )  # copositive, feasible, without a solution: a ray is no proof
    said = claim(feasible, "lemke", d / "ray")
    assert said == "ray" and holds(feasible, d / "ray")["holds"]
    (d / "y").write_text((d / "ray").read_text().replace("kind ray", "kind farkas"))
    assert not holds(feasible, d / "y")["holds"]
    spd = write_problem(d, cases["A2.01"])
    assert not holds(spd, write_certificate(d / "v", "ray", ["1", "1"]))[
        "holds"
    ]  # reverses no sign
    assert run_json("solve", spd, "--solver", "lemke", "--certificate", d / "basis")["verified"]
    assert holds(spd, d / "basis")["exact"]
    text = (d / "basis").read_text()
    assert "\n0 1 " in text
    other = write_certificate(d / "other", "basis", ["0 0", "1 2.3333333333333335"])
    assert not holds(spd, other)["holds"]
    one_line_error("verify", spd, "--certificate", d / "none", names=["none"])
    one_line_error(
        "verify",
        spd,
        "--certificate",
        write_certificate(d / "long", "farkas", ["1", "1", "1"]),
        names=["3", "2"],
    )
    one_line_error("verify", d, "--q", d / "a.q.mtx", names=["--certificate"])


def solve_and_verify_say_the_same(d):
    """Of every kind: what `solve` says of the certificate is what `verify` finds in the file."""
    cases = [
        write_problem(d, case)
        for case in catalogue().values()
        if case["kind"] in ("infeasible", "unsolvable")
    ][:6]
    families = [
        "murty:n=8",
        "fathi:n=8",
        "csizmadia:n=8",
        "random_spd:n=20",
        "random_psd:n=40",
        "random_p:n=12",
        "random_psd:n=80",
        "box_stack",
        "stack:n=3",
        "random_copositive:n=10",
    ]
    kinds = set()
    for problem in (*families[:: 4 if SANITIZED else 1], *fewer(cases)):
        for solver in ("lemke", "ppm", "block_pivoting", "murty", "enumerate", "newton"):
            path = d / "proof"
            path.unlink(missing_ok=True)
            done = run("solve", problem, "--solver", solver, "--certificate", path, code=None)
            said = json.loads(done.stdout)
            if said["certificate"] is None:  # nothing proved, or not for this solver
                assert not path.exists() and done.stderr.count("\n") == 1, done.stderr
                assert done.returncode == 3
                continue
            v = holds(problem, path)
            assert (
                said["certificate"],
                said["certificate_holds"],
                said["certificate_exact"],
                said["certificate_why"],
            ) == (v["certificate"], v["holds"], v["exact"], v["why"]), (problem, solver, said, v)
            kinds.add((v["certificate"], v["holds"], v["exact"]))
    assert {("basis", True, True), ("basis", True, False), ("farkas", True, True)} <= kinds, kinds
    o = run_json("solve", "random_spd:n=5", "--solver", "pgs")
    assert o["certificate"] is None and o["certificate_holds"] is None, o


tap(
    [
        unsolvable_cases_end_with_certificates_that_hold,
        planted_certificates_are_refused,
        solve_and_verify_say_the_same,
    ]
)

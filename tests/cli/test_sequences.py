"""Sequences: exported, read back, solved from cold and warm starts; cells that are sequences."""

import json
import pathlib

from support import TESTS, campaign, fewer, one_line_error, rows, run, run_json, tap

PAIR = ("--sequence", "--formulation", "regularized", "--solver", "lemke", "--step", "0.01")
COUNTERS = ("n_iter", "n_pivot", "n_factor", "n_matvec")


def manifest(folder: pathlib.Path) -> dict:
    return json.loads((folder / "manifest.json").read_text())


def the_manifest_tells_every_problem(d: pathlib.Path) -> None:
    run("export", "clatter", *PAIR, "--count", "60", "--out", d / "s")
    m = manifest(d / "s")
    assert m["format"] == "lcpbench sequence 1" and m["scene"] == "clatter" and m["step_s"] == 0.01
    assert m["steps"] == m["count"] == 60 and m["status"] == "ok" and m["n_unverified"] == 0
    assert m["n_problems"] == len(m["problems"]) > 30
    before: set = set()
    for p in m["problems"]:
        z = [float(x) for x in (d / "s" / p["answer"]).read_text().split("\n")[2:] if x]
        names = [r["id"] for r in p["rows"]]  # one row each: the normal impulses
        now = {name for name, x in zip(names, z, strict=True) if x > 0}
        assert p["n"] == len(z) == len(names) and p["active"] == len(now), p
        assert p["changed"] == len(now ^ before), (p["step"], p["changed"])
        assert p["verified"] and p["rho"] <= m["tolerance"] and p["sets"] == ["orthant"], p
        before = now
    assert len({len(p["rows"]) for p in m["problems"]}) > 1  # contacts come and go


def a_cold_pass_is_every_file_alone(d: pathlib.Path) -> None:
    run("export", "clatter", *PAIR, "--count", "60", "--out", d / "s")
    for solver in fewer(("lemke", "newton", "pgs")):
        alone = dict.fromkeys(COUNTERS, 0)
        for p in manifest(d / "s")["problems"]:
            one = run_json("solve", d / "s" / p["file"], "--solver", solver)
            alone = {k: alone[k] + one[k] for k in COUNTERS}
        cold = run_json("solve", d / "s", "--solver", solver)
        assert {k: cold[k] for k in COUNTERS} == alone, (solver, alone)
        warm = run_json("solve", d / "s", "--solver", solver, "--start", "previous")
        assert warm["n_iter"] < cold["n_iter"] and warm["verified"], solver
        assert warm["regressions"] <= warm["n_solves"] == cold["n_solves"]
        assert "regressions" not in cold


def what_has_no_verified_answer_is_said(d: pathlib.Path) -> None:
    """Closing jaws: no velocity satisfies both contacts."""
    done = run("export", "vise", *PAIR, "--count", "5", "--out", d / "v", code=3)
    assert "1 without a verified answer" in done.stdout, done.stdout
    m = manifest(d / "v")
    p = m["problems"][-1]
    assert m["steps"] < m["count"] == 5 and m["status"] != "ok" and m["note"] and not p["verified"]
    assert p["answer"] is None and (d / "v" / p["iterate"]).exists() and m["n_unverified"] == 1
    o = run_json("solve", d / "v", "--solver", "lemke", code=3)
    assert o["status"] == m["status"] and o["n_unsolved"] == 1, o


def bad_input_is_one_line(d: pathlib.Path) -> None:
    out = ("--out", d / "x")
    one_line_error("export", "clatter", "--sequence", *out, names=["--formulation"])
    one_line_error("export", "clatter", *PAIR[:3], *out, names=["--solver"])
    one_line_error("export", "clatter", *PAIR, *out, "--count", "0", names=["--count"])
    one_line_error("export", "clatter", *PAIR[:-1], "0", *out, names=["--step"])
    one_line_error("export", "clatter", *PAIR, *out, "--format", "mtx", names=["--format"])
    one_line_error(
        "export", "clatter", "--format", "scene", "--count", "3", *out, names=["--count"]
    )
    one_line_error("export", "murty:n=3", *out, names=["--format"])
    one_line_error("export", "no_scene", *PAIR, *out, names=["no_scene"])
    cones = ("--sequence", "--formulation", "coulomb", "--solver", "nsgs", "--count", "2")
    ball = {"shape": {"type": "sphere", "r": 0.1}, "mass": 1}
    scene = {"id": "smooth_and_rough", "dim": 3, "T": 0.1, "hs": [0.01], "gravity": [0, 0, -9.81]}
    scene["bodies"] = [ball | {"name": n, "pos": [x, 0, 0.1]} for n, x in (("a", 0), ("b", 1))]
    scene["static"] = [{"name": "floor", "normal": [0, 0, 1], "offset": 0}]
    scene["friction"] = {"default": 0.5, "pairs": [["b", "floor", 0]]}
    scene |= {"observe": ["a.z"], "checks": [{"type": "finite"}]}
    (d / "scene.json").write_text(json.dumps(scene))
    one_line_error("export", d / "scene.json", *cones, *out, names=["no file format"])
    one_line_error("export", "top", *PAIR, *out, "--count", "2", names=["posed no problem"])
    one_line_error("solve", "incline@regularized@lemke@x@5", "--solver", "lemke", names=["step"])
    one_line_error(
        "solve", "incline@regularized@lemke@0.01@0", "--solver", "lemke", names=["count"]
    )
    good = "incline@regularized@lemke@0.01@5"
    one_line_error(
        "solve", good, "--solver", "lemke", "--start", "warm", names=["warm", "predicted"]
    )
    one_line_error("solve", good, "--solver", "all", names=["one solver"])
    one_line_error("solve", good, "--solver", "lemke", "--z", d / "z", names=["--z"])
    one_line_error("solve", "murty:n=3", "--solver", "lemke", "--start", "cold", names=["--start"])


def boxes_are_files_of_numpy(d: pathlib.Path) -> None:
    """A contact has its normal and its box; read back, the run of the solver is the same."""
    box = ("--sequence", "--formulation", "boxed", "--solver", "ppm", "--step", "0.01")
    for scene, joints in (("spin", ""), ("gripper", ""), ("chain", ":joints=mixed")):
        words = [w if w != "boxed" else f"boxed{joints}" for w in box]
        run("export", scene, *words, "--count", "5", "--out", d / scene)
        problems = manifest(d / scene)["problems"]
        assert problems and all(
            p["file"].endswith(".npz") == ("box" in p["sets"]) for p in problems
        )
        posed = f"{scene}@boxed{joints}@ppm@0.01@5"
        for start in ("cold", "previous"):
            for solver in ("ppm", "pgs"):
                o = [
                    run_json("solve", source, "--solver", solver, "--start", start, code=None)
                    for source in (d / scene, posed)
                ]
                assert o[0]["solution_hash"] == o[1]["solution_hash"], (scene, start, solver)
                assert o[0]["n_iter"] == o[1]["n_iter"], (scene, start, solver)
    rows = [p["rows"] for p in manifest(d / "spin")["problems"]]
    assert all(
        [(a["id"], a["set"], b["set"]) for a, b in zip(r[::2], r[1::2], strict=True)]
        == [(b["id"], "orthant", "box") for b in r[1::2]]
        for r in rows
    ), rows[0]


def changed_folders_are_refused(d: pathlib.Path) -> None:
    run("export", "clatter", *PAIR, "--count", "20", "--out", d / "s")
    whole = (d / "s" / "manifest.json").read_text()
    first = manifest(d / "s")["problems"][0]
    solve = ("solve", d / "s", "--solver", "lemke")

    def broken(old: str, new: str, *names: str) -> None:
        assert old in whole, old
        (d / "s" / "manifest.json").write_text(whole.replace(old, new, 1))
        one_line_error(*solve, names=["manifest.json", *names])

    broken("lcpbench sequence 1", "lcpbench sequence 9", "format")
    broken('"file"', '"fil"', "file")
    broken(first["sha256"], "0" * 64, "sha256")
    broken('"n": 1', '"n": 2', "n")
    broken('"set": "orthant"', '"set": "circle"', "rows")
    broken(f'"file": "{first["file"]}"', '"file": "../other.M.mtx"', "file")
    (d / "s" / "manifest.json").write_text(whole[:200])
    one_line_error(*solve, names=["manifest.json"])
    (d / "s" / "manifest.json").write_text(whole)
    run(*solve)
    answer = d / "s" / first["answer"]
    answer.write_text(answer.read_text().replace("\n", "\n1", 2))
    one_line_error(*solve, names=["sha256"])


def cells_are_sequences(d: pathlib.Path) -> None:
    """All arms of one sequence solve the same problems; columns stand where they apply; the stored
    answers and the commands give the rows back."""
    run("export", "clatter", *PAIR, "--count", "40", "--out", d / "s")
    scene = TESTS / "cases" / "regressions" / "scenes" / "feet4_pushed.json"
    text = (
        "name: w\nparts:\n  - name: p\n"
        f"    problems: ['clatter@regularized@lemke@0.01@40', '{d}/s',"
        f" '{scene}@regularized@lemke@0.01@5']\n"
        "    solvers: [lemke, pgs]\n    starts: [cold, previous, basis, predicted]\n"
        "  - name: q\n    problems: ['murty:n=4']\n    solvers: [lemke]\n"
        "sampling: {processes: 1, samples: 1, max_samples: 1, inner: 1e-9s}\n"
    )
    run("run", campaign(d, text), "--out", d / "o")
    found = {(r["problem"].split("@")[0], r["solver"], r["start"]): r for r in rows(d / "o")}
    assert len(found) == 25
    posed = {k[1:]: r for k, r in found.items() if k[0] == "clatter"}
    read = {k[1:]: r for k, r in found.items() if k[0] == f"{d}/s"}
    same = (
        "status",
        "n_pivot",
        "n_iter",
        "n_solves",
        "rho",
        "solution_hash",
        "active_change",
        "lcp_dim",
    )
    for arm, r in posed.items():
        assert [r[c] for c in same] == [read[arm][c] for c in same], arm
        refused = arm == ("pgs", "basis")
        assert r["status"] == ("unsupported" if refused else "ok"), r
        assert (r["regressions"] == "") == (arm[1] == "cold" or refused), r
        assert 0 < float(r["active_change"]) < 1 and r["problem_family"] == "clatter", r
    assert int(posed["lemke", "previous"]["n_pivot"]) < int(posed["lemke", "cold"]["n_pivot"])
    plain = found["murty:n=4", "lemke", ""]
    assert plain["active_change"] == plain["regressions"] == plain["regressions_time"] == "", plain
    for how in ((), ("--rerun",)):
        done = run("verify", d / "o", *how)
        assert " 0 differ" in done.stdout, done.stdout
    wrong = text.replace("starts: [cold,", "starts: [warm,")
    one_line_error("run", campaign(d, wrong, "a.yaml"), "--out", d / "a", names=["warm"])
    wrong = text.replace("solvers: [lemke]\n", "solvers: [lemke]\n    starts: [cold]\n")
    one_line_error("run", campaign(d, wrong, "b.yaml"), "--out", d / "b", names=["starts"])
    wrong = text.replace(f"'{d}/s'", "'murty:n=3'")
    one_line_error("run", campaign(d, wrong, "c.yaml"), "--out", d / "c", names=["murty"])


tap(
    [
        the_manifest_tells_every_problem,
        a_cold_pass_is_every_file_alone,
        what_has_no_verified_answer_is_said,
        boxes_are_files_of_numpy,
        bad_input_is_one_line,
        changed_folders_are_refused,
        cells_are_sequences,
    ]
)

"""Bad input gives one line on stderr that names the culprit and the rule, and exit code 2."""

import csv
import json
import pathlib
import subprocess

from support import CASES, LCPBENCH, SANITIZED, TESTS, Skip, one_line_error, run, run_json, tap

GOOD_M = "%%MatrixMarket matrix coordinate real general\n2 2 2\n1 1 2\n2 2 3\n"
GOOD_Q = "%%MatrixMarket matrix array real general\n2 1\n-1\n1\n"


def problem(d, m=GOOD_M, q=GOOD_Q):
    (d / "a.M.mtx").write_text(m)
    (d / "a.q.mtx").write_text(q)
    return d / "a.M.mtx"


def usage_errors(d):
    one_line_error("fly", names=["fly"])
    one_line_error("solve", names=["PROBLEM"])
    one_line_error("solve", problem(d), names=["--solver"])
    one_line_error("solve", problem(d), "--solver", "nosuch", names=["nosuch", "list solvers"])
    one_line_error("solve", problem(d), "--solver", "pgs", "--nosuch", names=["--nosuch"])
    one_line_error("solve", problem(d), "--solver", "pgs:omega=7", names=["omega", "7"])
    one_line_error("solve", problem(d), "--solver", "pgs:nosuch=1", names=["nosuch", "omega"])
    one_line_error("solve", problem(d), "--solver", "pgs", "--tol", "big", names=["tol", "big"])
    one_line_error(
        "solve", problem(d), "--solver", "pgs", "--max-iter", "0", names=["max_iter", "0"]
    )
    one_line_error("solve", problem(d), "--solver", names=["--solver"])
    one_line_error("list", "colours", names=["colours"])
    one_line_error("list", "solvers", "--format", "xml", names=["xml"])


def options_out_of_range_are_refused(d):
    """Not taken for their defaults."""
    plan = ("run", "smoke", "--dry-run")
    for option, value in (
        ("--reps", 0),
        ("--reps", -1),
        ("--seed", -5),
        ("--time-limit", 0),
        ("--time-limit", "-3s"),
        ("--memory-limit", "-1"),
        ("--out", ""),
    ):
        one_line_error(*plan, option, value, names=[option])
    for folder in ("x" * 2000, "/".join(["y" * 200] * 6)):
        one_line_error("run", "smoke", "--out", d / folder, names=["999"])
    one_line_error("doctor", "--seconds", 0, names=["--seconds"])
    one_line_error("doctor", "--out", "/proc/none", names=["/proc/none"])
    one_line_error("check", problem(d), "--time-limit", 0, names=["--time-limit"])
    one_line_error(
        "export", "murty:n=4", "--format", "fclib", "--out", d / "x", names=["murty", "fclib"]
    )
    far = f"{d}/{'./' * 150}a.M.mtx"
    (d / "long.yaml").write_text(
        f"name: long\nparts: [{{name: a, problems: ['{far}'], solvers: [lemke]}}]\n"
    )
    one_line_error("run", d / "long.yaml", "--dry-run", names=["long.yaml", "319"])
    (d / "few.yaml").write_text(
        "name: few\nparts: [{name: a, problems: ['murty:n=4'], solvers: [lemke]}]\n"
        "sampling:\n  samples: 5\n  max_samples: 3\nquick:\n  sampling: {samples: 2}\n"
    )
    few = "max_samples: is below samples"
    one_line_error("run", d / "few.yaml", "--dry-run", names=[f"few.yaml:5: {few}"])
    run("run", d / "few.yaml", "--dry-run", "--quick")


def nearest_names_are_proposed(d):
    """In the same one line; nothing is proposed for nonsense."""
    m = problem(d)
    sim, dry = (
        ("simulate", "incline", "--formulation", "velocity", "--solver"),
        ("run", "smoke", "--dry-run"),
    )
    cases = [
        (("simulat", "incline"), "simulate"),
        (("list", "solver"), "solvers"),
        (("solve", m, "--solver", "lemk"), "lemke"),
        (("solve", m, "--solver", "LEMKE"), "lemke"),
        (("solve", m, "--solver", "lmeke"), "lemke"),
        (("solve", m, "--solver", "interior"), "interior_point"),
        (("solve", m, "--solver", "pgs:omga=1"), "omega"),
        (("solve", m, "--solver", "lemke", "--certifcate", "x"), "--certificate"),
        (("solve", "murtz:n=4", "--solver", "lemke"), "murty"),
        (("solve", "murty:m=4,gh=1", "--solver", "lemk"), "lemke"),
        (("simulate", "inclyne", "--formulation", "velocity", "--solver", "lemke"), "incline"),
        ((*sim[:3], "velocty", "--solver", "lemke"), "velocity"),
        (("simulate", "incline:theta=3", *sim[2:], "lemke"), "theta_deg"),
        ((*sim, "lemke", "--effects", "+fricton"), "friction"),
        ((*sim[:3], "regularized:model=bristel", "--solver", "lemke"), "bristle"),
        ((*sim, "lemke", "--trajectori", "x"), "--trajectory"),
        (("run", "smok", "--dry-run"), "smoke"),
        ((*dry, "--filter", "solvr=lemke"), "solver"),
        ((*dry, "--filter", "-formulations_=x"), "formulations"),
        ((*dry, "--rerun", "faild"), "failed"),
        ((*dry, "--rerun", "lemk"), "lemke"),
        (("compare", d, d, "--column", "t_totl_s"), "t_total_s"),
        (("export", m, "--fromat", "mtx"), "--format"),
        (("submit", "papr", "--engine", "slurm"), "paper"),
    ]
    texts = {
        "solver": "solvers: [lemk]",
        "axis": "solvrs: [lemke]",
        "family": "problems: ['murtz:n=4'], solvers: [lemke]",
        "parameter": "problems: ['stack:nn=1,mass_rtio=2'], solvers: [lemke]",
        "form": "problems: [incline], formulations: [velocty], solvers: [lemke]",
        "scene": "problems: [inclin], formulations: [velocity], solvers: [lemke]",
    }
    wants = {
        "solver": "lemke",
        "axis": "solvers",
        "family": "murty",
        "parameter": "n",
        "form": "velocity",
        "scene": "incline",
    }
    for word, text in texts.items():
        text = text if "problems" in text else f"problems: ['{m}'], {text}"
        (d / f"{word}.yaml").write_text("name: x\nparts: [{name: a, %s}]\n" % text)
        cases.append((("run", d / f"{word}.yaml", "--dry-run"), wants[word]))
    (d / "key.yaml").write_text("name: x\nsamplin: {samples: 1}\nparts: []\n")
    cases.append((("run", d / "key.yaml", "--dry-run"), "sampling"))
    scene = {
        "id": "one",
        "dim": 2,
        "T": 0.1,
        "bodies": [{"name": "b", "shape": {"type": "dics", "r": 0.1}, "mass": 1.0, "pos": [0, 1]}],
    }
    (d / "kind.json").write_text(json.dumps(scene))
    (d / "member.json").write_text(json.dumps(dict(scene, boddies=[])))
    scene["bodies"][0]["shape"]["type"] = "disc"
    (d / "two.json").write_text(json.dumps([scene, dict(scene, id="ramp")]))
    cases += [
        (("simulate", d / "kind.json", *sim[2:], "lemke"), "disc"),
        (("simulate", d / "member.json", *sim[2:], "lemke"), "bodies"),
        (("simulate", f"{d}/two.json#rmap", *sim[2:], "lemke"), "ramp"),
    ]
    for words, want in cases:
        one_line_error(*words, names=[f"did you mean '{want}'?"])
    for words in (
        ("xyzzy",),
        ("solve", m, "--solver", "xyzzy"),
        ("list", "tea"),
        ("simulate", "qqqqqq", *sim[2:], "lemke"),
    ):
        assert "did you mean" not in run(*words, code=2).stderr, words


def steps_longer_than_the_run_are_refused(d):
    """They used to be `ok` after no step at all."""
    words = ("simulate", "incline", "--formulation", "velocity", "--solver", "lemke")
    for step, duration in (
        ("2", "1"),
        ("1e9", "1"),
        ("0.01", "0.001"),
        ("1e300", "1e-300"),
        ("1.0001", "1"),
    ):
        one_line_error(
            *words,
            "--step",
            step,
            "--duration",
            duration,
            "--trajectory",
            d / "t",
            names=["step", f"{float(step):g} s", f"{float(duration):g} s"],
        )
    one_line_error(*words, "--duration", "1e-3", names=["0.01 s", "0.001 s"])
    for option in ("--step", "--duration"):
        for value in ("0", "-0", "-1", "nan", "-nan", "inf", "1e999", "", "x"):
            if value:
                one_line_error(*words, option, value, names=[option, value])
    one_line_error(*words, "--step", "1e-300", names=["1e-300", "2e9 steps"])
    assert not (d / "t").exists()
    assert run_json(*words, "--step", "1", "--duration", "1", code=None)["steps"] == 1
    ball = {"name": "b", "shape": {"type": "disc", "r": 0.1}, "mass": 1.0, "pos": [0, 1]}
    (d / "h.json").write_text(
        json.dumps({"id": "s", "dim": 2, "T": 0.1, "hs": [0.5], "bodies": [ball]})
    )
    one_line_error("simulate", d / "h.json", *words[2:], names=["0.5 s", "0.1 s"])
    one_line_error("calibrate", "slide", "--error", "1", "--step", "1e9", names=["1e+09 s"])
    # in a campaign it is a row with its reason
    (d / "c.yaml").write_text(
        "name: c\nsampling: {processes: 1, samples: 1, max_samples: 1}\nparts: [{name: a, problems:"
        " [incline], formulations: [velocity], solvers: [lemke], steps: [5], durations: [0.1]}]\n"
    )
    run("run", d / "c.yaml", "--out", d / "o", "--quiet")
    (row,) = csv.DictReader((d / "o/results.csv").read_text().splitlines())
    assert row["status"] == "unsupported" and "5 s" in row["note"] and "0.1 s" in row["note"], row


def options_without_a_meaning_are_refused(d):
    """Not accepted and forgotten."""
    m = problem(d)
    solve = ("solve", "murty:n=4", "--solver", "lemke")
    for words, names in (
        ((*solve, "--facets", 8), ["facets", "murty"]),
        ((*solve, "--formulation", "coulomb"), ["--formulation", "murty"]),
        ((*solve, "--formulation", "velocity"), ["facets"]),
        ((*solve, "--q", d / "a.q.mtx"), ["--q", "murty"]),
        (("solve", m, "--solver", "lemke", "--facets", 4), ["facets", "a.M.mtx"]),
        (
            ("export", "murty:n=4", "--format", "mtx", "--out", d / "x", "--q", d / "a.q.mtx"),
            ["--q"],
        ),
        (("verify", m, "--certificate", d / "c", "--rerun"), ["--rerun"]),
        (("compare", d, d, "--noise", -1), ["--noise"]),
        (("compare", d, d, "--column", "rho"), ["--column", "rho"]),
        # nor one of two
        (("solve", "murty:n=4,n=5", "--solver", "lemke"), ["murty", "n=5", "twice"]),
        (("solve", "murty:n=4", "--solver", "pgs:omega=1,omega=1"), ["pgs", "omega=1", "twice"]),
        ((*solve, "--tol", 1e-9, "--start=cold", "--tol=1e-8"), ["--tol", "twice"]),
    ):
        one_line_error(*words, names=names)
    lcp = pathlib.Path(__file__).resolve().parents[1] / "fuzz" / "seeds" / "lcp.dat"
    for path in (lcp, lcp.with_name("mlcp.dat")):
        one_line_error(
            "solve", f"{path}:facets=4", "--solver", "lemke", names=["facets", path.name]
        )
    submit = ("submit", "smoke", "--out", d / "s", "--dry-run", "--engine")
    one_line_error(*submit, "slurm", "--jobs", 2, names=["--jobs", "slurm"])
    one_line_error(*submit, "parallel", "--slurm-time", 10, names=["--slurm-time", "parallel"])
    one_line_error(*submit, "slurm", "--slurm-time", "1; rm", names=["--slurm-time", "1; rm"])
    for folder in ("it's", "two words", "100%", "a\\b"):  # a line of #SBATCH knows no quoting
        one_line_error(
            "submit",
            "smoke",
            "--out",
            d / folder,
            "--dry-run",
            "--engine",
            "slurm",
            names=["--out", "Slurm"],
        )


def output_that_does_not_arrive_is_no_success(d):
    problem(d)
    for words in (
        ("list", "solvers"),
        ("list", "scenes", "--format", "json"),
        ("--help",),
        ("run", "smoke", "--dry-run"),
        ("solve", d / "a.M.mtx", "--solver", "lemke"),
    ):
        with open("/dev/full", "w") as full:
            done = subprocess.run(
                [LCPBENCH, *map(str, words)], stdout=full, stderr=subprocess.PIPE, text=True
            )
        assert (
            done.returncode == 1
            and done.stderr.startswith("lcpbench: stdout: ")
            and done.stderr.count("\n") == 1
        ), (words, done.returncode, done.stderr)


def problem_errors(d):
    one_line_error("solve", d / "missing.dat", "--solver", "pgs", names=["missing.dat"])
    one_line_error("solve", "nosuchfamily:n=3", "--solver", "pgs", names=["nosuchfamily"])
    one_line_error("solve", "murty:n=-3", "--solver", "pgs", names=["n", "-3"])
    m = problem(d, m=GOOD_M.replace("2 2 3\n", ""))
    one_line_error("solve", m, "--solver", "pgs", names=["a.M.mtx"])
    m = problem(d, q=GOOD_Q.replace("-1", "nan"))
    one_line_error("solve", m, "--solver", "pgs", names=["a.q.mtx"])
    m = problem(d, q=GOOD_Q.replace("2 1", "1 1").replace("-1\n", ""))
    one_line_error("solve", m, "--solver", "pgs", names=["q.mtx"])
    m = problem(d, m="not a matrix\n")
    one_line_error("solve", m, "--solver", "pgs", names=["a.M.mtx"])
    m = problem(d, m=GOOD_M.replace("2 2 2", "900000000 900000000 1"))
    one_line_error("solve", m, "--solver", "pgs", names=["a.M.mtx"])
    (d / "cut.dat").write_text("3\n0\n3\n3\n3 3\n1 0 0\n0 1\n")
    one_line_error("solve", d / "cut.dat", "--solver", "pgs", names=["cut.dat"])


def scene_errors(d):
    def sim(scene, *more, names):
        one_line_error(
            "simulate", scene, "--formulation", "velocity", "--solver", "lemke", *more, names=names
        )

    sim("nosuchscene", names=["nosuchscene"])
    sim("incline:mass=-1", names=["mass", "-1"])
    sim("incline:nosuch=1", names=["nosuch"])
    sim("incline", "--step", "0", names=["--step"])
    sim("incline", "--duration", "-1", names=["--duration"])
    sim("incline", "--start", "lukewarm", names=["lukewarm"])
    sim("incline", "--effects", "+magic", names=["magic"])
    one_line_error(
        "simulate", "incline", "--formulation", "nosuch", "--solver", "lemke", names=["nosuch"]
    )
    one_line_error(
        "simulate",
        "incline",
        "--formulation",
        "velocity:facets=1",
        "--solver",
        "lemke",
        names=["facets"],
    )
    scene = {
        "id": "x",
        "title": "t",
        "dim": 2,
        "gravity": [0, -9.81],
        "T": 0.1,
        "static": [],
        "checks": [],
        "bodies": [
            {
                "name": "b",
                "shape": {"type": "disc", "r": 0.1},
                "mass": -1.0,
                "pos": [0, 0],
                "inertia": 0.1,
            }
        ],
    }
    (d / "x.json").write_text(json.dumps(scene))
    sim(d / "x.json", names=["mass", "-1"])
    (d / "y.json").write_text('{"id": "x", ')
    sim(d / "y.json", names=["y.json"])


def check_errors(d):
    one_line_error("check", d / "none.json", names=["none.json"])
    one_line_error("check", CASES, "--filter", "id=ZZZ*", names=["filter"])
    one_line_error("check", CASES, "--filter", "name=A*", names=["name=A*"])


def check_skips_no_case_for_want_of_anything(d):
    """Every case of tests/cases is run; a skip is the model's or the solver's limit, never a
    missing shape, effect or load."""
    if SANITIZED:
        raise Skip("a thousand processes: too slow with sanitizers")
    o = run_json("check", CASES, "--formulation", "velocity", "--solver", "lemke", "--json")
    cases = json.loads(CASES.read_text())
    wanted = {c["id"] for group in ("lcp", "scenes", "stress") for c in cases[group]}
    assert wanted <= {c["id"] for c in o["checks"]}, wanted - {c["id"] for c in o["checks"]}
    for c in o["checks"]:
        assert c["result"] != "skipped" or c["reason"].startswith(
            ("models no ", "honest failure: ")
        ), c
    # the stiffest compliant contact, 1e16 N/m, is inside the range of the formulation made for it
    o = run_json(
        "check",
        CASES,
        "--filter",
        "id=C07.5",
        "--formulation",
        "penalty",
        "--solver",
        "lemke",
        "--json",
    )
    assert o["passed"] == 4, o


def check_fails_what_it_cannot_run(d):
    """A scene that asks for something that does not exist is a failure, not a skip."""
    ball = {
        "name": "b",
        "shape": {"type": "disc", "r": 0.1},
        "mass": 1.0,
        "pos": [0, 1],
        "vel": [0, 1],
    }
    good = {
        "id": "s",
        "dim": 2,
        "T": 0.02,
        "bodies": [ball],
        "checks": [{"type": "state", "var": "b.y", "t": 0.02, "value": 1.02, "tol": {"abs": 1e-9}}],
    }
    wants = [
        {"bodies": [dict(ball, shape={"type": "torus", "r": 0.1})]},
        {"needs": ["magnetism"]},
        {"loads": [{"body": "b", "type": "wind"}]},
    ]
    for want in wants:
        (d / "s.json").write_text(json.dumps([dict(good, id="good"), dict(good, **want)]))
        done = run("check", d / "s.json", "--formulation", "velocity", "--solver", "lemke", code=3)
        assert "FAILED s - - [run]" in done.stdout and done.stdout.endswith(
            " 1 failed, 0 skipped\n"
        ), done.stdout


def forms_that_nobody_goes_by_are_refused(d):
    """A misspelt word would switch its check off, or leave a formulation in, without a sound."""
    check = {"type": "state", "var": "b.y", "t": 0.02, "value": 5, "tol": {"abs": 1e-9}}
    off = {"var": "b.y", "value": 1.02, "tol": {"abs": 1e-9}}
    good = {
        "id": "s",
        "dim": 2,
        "T": 0.02,
        "gravity": [0, -9.81],
        "bodies": [{"name": "b", "shape": {"type": "disc", "r": 0.1}, "mass": 1, "pos": [0, 1]}],
    }
    wants = (
        ({"checks": [dict(check, forms=["velo"])]}, "check 1: forms 'velo'", "velocity"),
        ({"if_off": {"gravity": dict(off, forms=["normel"])}}, "if_off 1: forms", "normal"),
        ({"not_applicable": ["penaltie"]}, "not_applicable 'penaltie'", "penalty"),
    )
    path = d / "s.json"
    use = ("--formulation", "velocity", "--solver", "lemke")
    for want, said, meant in wants:
        names = ["scene 's'", said, f"did you mean '{meant}'?"]
        path.write_text(json.dumps([dict(good, **want), dict(good, id="good")]))
        done = run("check", path, "--formulation", "velocity", code=3)
        assert done.stdout.count("FAILED s - - [run]") == 1, done.stdout
        assert done.stdout.endswith(" 1 failed, 0 skipped\n"), done.stdout
        assert all(name in done.stdout for name in names), (names, done.stdout)
        one_line_error("simulate", f"{path}#s", *use, names=names)
        one_line_error("export", f"{path}#s", "--format", "scene", "--out", d / "o", names=names)
        one_line_error("export", f"{path}#s", "--sequence", *use, "--out", d / "o", names=names)
        one_line_error("calibrate", f"{path}#s", "--error", "0.1", names=names)
    for word in ("velocity", "boxed", "coulomb", "regularized", "position"):
        path.write_text(json.dumps(dict(good, not_applicable=[word])))
        run("check", path, "--formulation", "velocity")


def an_id_has_one_scene(d):
    """The first would stand for both: `FILE#ID` names one, and check prints both under one name."""
    ball = {"name": "b", "shape": {"type": "disc", "r": 0.1}, "mass": 1.0, "pos": [0, 1]}
    one = {"id": "a", "dim": 2, "T": 0.02, "bodies": [ball]}
    path = d / "two.json"
    for file in (
        [one, dict(one, id="b"), dict(one, T=0.03)],
        {"scenes": [one, dict(one, id="b")], "stress": [dict(one, T=0.03)]},
    ):
        path.write_text(json.dumps(file))
        use = ("--formulation", "velocity", "--solver", "lemke")
        one_line_error("simulate", f"{path}#a", *use, names=["two.json", "'a'", "used twice"])
        run_json("simulate", f"{path}#b", *use)
        done = run("check", path, *use, code=3)
        assert "FAILED a - - [run] : scene 'a': the id is used twice" in done.stdout, done.stdout
        assert done.stdout.endswith(" 1 failed, 0 skipped\n"), done.stdout


def truths_that_do_not_hold_are_refused(d):
    """What a complementarity problem states of itself: it would judge nobody, or wrongly."""
    good = {
        "id": "s",
        "n": 2,
        "M": [[2, 1], [1, 2]],
        "q": [-5, -6],
        "status_correct": ["solved"],
        "solutions": [{"z": [4 / 3, 7 / 3], "z_exact": ["4/3", "7/3"], "w": [0, 0]}],
        "w": [0, 0],
        "forward_tol": 1e-9,
    }
    walls = {
        "id": "s",
        "n": 2,
        "M": [[1, -1], [-1, 1]],
        "q": [-1, -1],
        "farkas_y": ["1", "1"],
        "status_correct": ["infeasible"],
    }
    made = {"id": "s", "n": 2, "gen": {"name": "murty", "n": 2}, "status_correct": ["solved"]}
    made |= {"M": [[1, 0], [2, 1]], "q": [-1, -1]}
    path = d / "s.json"

    def check(case, code):
        path.write_text(json.dumps({"lcp": [case]}))
        return run("check", path, "--solver", "lemke", code=code).stdout

    for case in (good, walls, made):
        check(case, 0)
    wrong = {"z": [1, 1]}
    for case, said in (
        (good | {"forward_tol": -1}, "forward_tol = -1, need > 0"),
        (good | {"solutions": [{"z": [1, 1], "z_exact": ["1", "3"]}]}, "z_2 is 1, z_exact says 3"),
        (good | {"solutions": [good["solutions"][0] | {"w": [0, 1]}]}, "solution 1: w_2 is 1"),
        (good | {"w": [1, 0]}, "w_1 is 1"),
        (good | {"farkas_y": ["1", "1"]}, "farkas_y proves that there is no solution"),
        (made | {"M": [[1, 0], [3, 1]]}, "M is not that of gen"),
        (made | {"q": [-1, -2]}, "q is not that of gen"),
        (made | {"q": [-1]}, "q is not that of gen"),
    ):
        path.write_text(json.dumps({"lcp": [case]}))
        one_line_error("check", path, "--solver", "lemke", names=["s.json", "lcp 's'", said])
    for case, said in (
        (good | {"solutions": [wrong], "w": [-2, -3]}, "solution 1 does not solve the problem"),
        (made | {"example_solution": wrong}, "example_solution does not solve the problem"),
        (walls | {"farkas_y": ["1", "0"]}, "farkas_y proves nothing"),
        (walls | {"farkas_y": ["-1", "-1"]}, "farkas_y proves nothing"),
    ):
        out = check(case, 3)
        assert f"FAILED s - - [run] : {said}" in out, (case, out)
        assert out.endswith("0 passed, 1 failed, 0 skipped\n"), out


def a_check_that_names_a_formulation_judges_it(d):
    """Also one whose model leaves out an effect of the scene: penalty has no rigid contact."""
    scene = {
        "id": "s",
        "dim": 2,
        "T": 0.02,
        "gravity": [0, -9.81],
        "bodies": [
            {"name": "b", "shape": {"type": "disc", "r": 0.1}, "mass": 1.0, "pos": [0, 0.1]}
        ],
        "static": [{"name": "floor", "normal": [0, 1], "offset": 0}],
    }
    for forms, said in (([], "skipped"), (["velocity"], "skipped"), (["penalty"], "failed")):
        scene["checks"] = [
            {
                "type": "state",
                "var": "b.y",
                "value": 5,
                "tol": {"abs": 1e-9},
                **({"forms": forms} if forms else {}),
            }
        ]
        (d / "s.json").write_text(json.dumps(scene))
        words = ("check", d / "s.json", "--formulation", "penalty", "--solver", "lemke", "--json")
        checks = json.loads(run(*words, code=None).stdout)["checks"]
        got = {c["check"]: c["result"] for c in checks}
        assert got.pop("status") == got.pop("finite") == "passed", got
        assert list(got.values()) == [said], (forms, got)


def lists_are_bare_names(d):
    for what in (
        "problems",
        "scenes",
        "formulations",
        "solvers",
        "campaigns",
        "effects",
        "situations",
    ):
        names = run("list", what).stdout.splitlines()
        assert names and all(n and " " not in n and "," not in n for n in names), (what, names)
        assert [o["name"] for o in run_json("list", what, "--format", "json")] == names
        assert run("list", what, "--format", "csv").stdout.startswith("name,")
    assert "velocity x lemke" in run("list", "compat").stdout


def scenes_are_described_in_full(d):
    """What a tool needs to offer every scene: parameters with ranges and units, effects,
    observables, sourced predictions."""
    effects = set(run("list", "effects").stdout.split())
    situations = run("list", "situations").stdout.split()
    assert not next(
        s for s in run_json("list", "scenes", "--format", "json") if s["name"] == "vise"
    )["solvable"]
    for s in run_json("list", "scenes", "--format", "json"):
        where = s["name"]
        assert s["situation"] in {"", *situations}, where
        assert (
            len(s["title"]) > 5 and len(s["about"]) > 80 and s["parameters"] and s["predictions"]
        ), where
        assert s["dim"] in (2, 3) and s["duration_s"] > 0 and s["step_s"] > 0, where
        assert (
            s["effects"]
            and set(s["effects"]) <= effects
            and ("spatial" in s["effects"]) == (s["dim"] == 3)
        ), where
        for p in s["parameters"]:
            assert p["unit"] and len(p["help"]) > 3, (where, p)
            if p["kind"] == "choice":
                assert p["default"] in p["words"] and len(p["words"]) > 1, (where, p)
            else:
                assert p["kind"] in ("integer", "real") and p["min"] <= p["default"] <= p["max"], (
                    where,
                    p,
                )
        for o in s["observables"]:
            assert o["name"] and o["unit"], (where, o)
        for c in s["predictions"]:
            assert c["quantity"] and c["unit"] and c["source"], (where, c)
            assert all(t is not None and t >= 0 for t in c["tolerance"].values()), (where, c)
            assert c["value"] is not None or c["quantity"] in ("finite", "energy_nonincrease"), (
                where,
                c,
            )


def solve_prints_one_object(d):
    o = run_json("solve", problem(d), "--solver", "lemke", "--z", d / "z.mtx")
    for key in (
        "problem n nnz storage solver options status claimed verified rho res_natural"
        " res_natural_rel res_comp n_iter n_pivot n_factor n_matvec t_setup_s t_factor_s t_solve_s"
        " certificate"
    ).split():
        assert key in o, key
    assert o["status"] == "ok" and o["verified"] is True and o["n"] == 2
    z = [float(x) for x in (d / "z.mtx").read_text().splitlines()[-2:]]
    assert z == [0.5, 0.0], z


def solve_reports_infeasible(d):
    m = problem(d, m=GOOD_M.replace("1 1 2\n2 2 3", "1 1 -1\n2 2 1"))
    o = json.loads(run("solve", m, "--solver", "lemke", code=3).stdout)
    assert o["status"] in ("infeasible", "ray") and o["verified"] is False


def simulate_prints_one_object(d):
    o = run_json(
        "simulate",
        "slide:speed=1",
        "--formulation",
        "velocity",
        "--solver",
        "lemke",
        "--trajectory",
        d / "t.csv",
    )
    for key in (
        "scene parameters formulation solver step_s steps status observables predictions"
        " lcp_dim_max n_contact_max n_solves n_pivot n_iter res_natural_max res_ncp_max"
        " penetration_max_m approach_max_m energy_defect_J effects_declared effects_seen"
        " t_assemble_s t_solve_s t_total_s"
    ).split():
        assert key in o, key
    assert o["status"] == "ok" and o["predictions"] and all(p["ok"] for p in o["predictions"])
    for key in "quantity time_s value predicted error tolerance ok source".split():
        assert key in o["predictions"][0], key
    lines = (d / "t.csv").read_text().splitlines()
    assert (
        lines[0].startswith("t_s,kind,name,")
        and sum(",body,block," in line for line in lines) == o["steps"] + 1
    )


def dimensions_of_the_three_formulations(d):
    """The 3D block with four contacts: p(nd + 2) unknowns against p."""
    for form, dim in (("velocity:facets=8", 40), ("velocity:facets=4", 24), ("regularized", 4)):
        o = run_json(
            "simulate",
            "incline:theta_deg=17.1887,mu=0.5",
            "--formulation",
            form,
            "--solver",
            "lemke",
        )
        assert o["lcp_dim_max"] == dim, (form, o["lcp_dim_max"])
        assert all(p["ok"] for p in o["predictions"]) and o["predictions"]


def certificates_are_written(d):
    o = run_json("solve", "random_spd:n=6", "--solver", "lemke", "--certificate", d / "c.txt")
    text = (d / "c.txt").read_text()
    assert o["certificate"] == "basis" and text.startswith(
        "lcpbench certificate 1\nkind basis\nn 6\n"
    ), text[:60]


def an_answer_without_a_proof_is_told(d):
    """As usual, and one line on stderr that there is no certificate: exit code 3. Of a solver that
    never proves, and of one that does not apply."""
    for solver, n, status in (
        ("newton", 6, "ok"),
        ("pgs", 6, "ok"),
        ("pgs:max_iter=1", 6, "max_iter"),
    ):
        files = ("--z", d / "z.mtx", "--certificate", d / "c.txt")
        done = run("solve", f"random_spd:n={n}", "--solver", solver, *files, code=3)
        o = json.loads(done.stdout)
        assert o["status"] == status and o["certificate"] is None, o
        assert len((d / "z.mtx").read_text().split()) == n + 7 and not (d / "c.txt").exists()
        name = solver.split(":")[0]
        assert (
            done.stderr
            == f"lcpbench: --certificate {d / 'c.txt'}: {name} proved nothing, no file\n"
        )
        (d / "z.mtx").unlink()


def export_reads_back(d):
    run("export", "random_spd:n=9", "--format", "mtx", "--out", d / "p")
    a = run_json("solve", "random_spd:n=9", "--solver", "lemke")
    b = run_json("solve", d / "p.M.mtx", "--solver", "lemke")
    assert a["n"] == b["n"] == 9 and a["n_pivot"] == b["n_pivot"] and b["status"] == "ok"
    run("export", d / "p.M.mtx", "--format", "mtx", "--out", d / "again")
    for part in ("M", "q"):
        assert (d / f"again.{part}.mtx").read_text() == (d / f"p.{part}.mtx").read_text()
    seeds = pathlib.Path(__file__).resolve().parents[1] / "fuzz" / "seeds"
    for seed in (
        "fc2d_dense",
        "fc2d_blocks",
        "fc2d_csparse",
        "global",
        "rolling",
        "rolling_global",
    ):
        run("export", seeds / f"{seed}.dat", "--format", "siconos", "--out", d / "a.dat")
        if seed != "rolling":  # FCLIB has no local rolling problems
            run("export", d / "a.dat", "--format", "fclib", "--out", d / "b.hdf5")
            run("export", d / "b.hdf5", "--format", "siconos", "--out", d / "b.dat")
            assert (d / "a.dat").read_text() == (d / "b.dat").read_text(), seed
        hashes = {
            run_json("solve", path, "--solver", "nsgs")["solution_hash"]
            for path in (seeds / f"{seed}.dat", d / "a.dat")
        }
        assert len(hashes) == 1, seed
    one_line_error(
        "export", "random_spd:n=9", "--format", "papyrus", "--out", d / "p", names=["papyrus"]
    )
    one_line_error("export", "random_spd:n=9", "--format", "mtx", names=["--out"])
    name = TESTS / "data/friction/FrictionContactProblem00031.dat"
    for kind, ending in (("fclib", "hdf5"), ("siconos", "dat")):
        run("export", name, "--format", kind, "--out", d / f"f.{ending}")
        o = run_json("solve", d / f"f.{ending}", "--solver", "nsgs")
        same = run_json("solve", name, "--solver", "nsgs")
        assert o["status"] == "ok" and o["solution_hash"] == same["solution_hash"], kind
    one_line_error(
        "export",
        name,
        "--format",
        "siconos",
        "--out",
        d / "x",
        "--q",
        d / "p.q.mtx",
        names=["--q", name.name],
    )
    mixed = TESTS / "data/mlcp/RLCD_mlcp.dat"
    for problem_text in (
        "random_spd:n=9",
        f"{name}:facets=4",
        mixed,
    ):  # LCPs and mixed LCPs as text
        run("export", problem_text, "--format", "siconos", "--out", d / "l.dat")
        hashes = {
            run_json("solve", path, "--solver", "lemke")["solution_hash"]
            for path in (problem_text, d / "l.dat")
        }
        assert len(hashes) == 1, problem_text
    one_line_error("export", mixed, "--format", "mtx", "--out", d / "x", names=[d / "x"])
    one_line_error("export", mixed, "--format", "fclib", "--out", d / "x", names=[mixed.name])


def friction_stays_physical(d):
    """A friction problem on facets is judged on the true cone too: more facets, less error; rolling
    included."""
    seeds = pathlib.Path(__file__).resolve().parents[1] / "fuzz" / "seeds"
    for seed in ("rolling", "fc2d_dense", "global"):
        exact = run_json("solve", seeds / f"{seed}.dat", "--solver", "nsgs:tol=1e-12")
        assert exact["res_ncp"] < 1e-10, exact
        for facets in (4, 8, 16):
            o = run_json("solve", f"{seeds / seed}.dat:facets={facets}", "--solver", "lemke")
            assert (
                o["status"] == "ok"
                and o["n"] == {"rolling": 2 * facets + 3}.get(seed, 4)
                and o["res_ncp"] is not None
            ), o
    # friction that points between the facets: 4 facets leave it out, 16 hardly
    (d / "oblique.dat").write_text("3 1 0 3 3 3 3 1 0 0 0 1 0 0 0 1 -1 2 1 0.5")
    error = [
        run_json("solve", f"{d}/oblique.dat:facets={n}", "--solver", "lemke")["res_ncp"]
        for n in (4, 8, 16)
    ]
    assert (
        error[0] > 0.05 and error[0] > error[1] > error[2] > 1e-4 and error[2] < 0.2 * error[0]
    ), error
    for bad in (":facets=1", ":facets=x", ":facets=", ":nosuch=3"):
        one_line_error("solve", f"{d}/oblique.dat{bad}", "--solver", "lemke", names=["oblique.dat"])
    one_line_error(
        "solve", f"{d}/oblique.dat:facets=4", "--facets", "8", "--solver", "lemke", names=["twice"]
    )
    (d / "c.yaml").write_text(
        f"name: c\nparts:\n  - name: p\n    problems: ['{d}/*.dat:facets={{4,8}}', '{d}/*.dat']\n  "
        "  solvers: [lemke, nsgs]\nsampling: {processes: 1, samples: 1, max_samples: 1}\n"
    )
    run("run", d / "c.yaml", "--out", d / "out")
    rows = list(csv.DictReader((d / "out" / "results.csv").read_text().splitlines()))
    judged = {
        (r["problem"][-8:], r["solver"]): float(r["res_ncp"]) for r in rows if r["status"] == "ok"
    }
    assert (
        abs(judged["facets=4", "lemke"] - error[0]) < 1e-12
        and abs(judged["facets=8", "lemke"] - error[1]) < 1e-12
    ), judged
    assert judged["ique.dat", "nsgs"] < 1e-6 and len({r["problem_sha256"] for r in rows}) == 3, (
        judged
    )


def steps_are_dumped(d):
    """Problems of chosen steps: consecutive, read back with the same answer, bit for bit; cones
    too. The answer that is dumped is the solver's where no other is chosen."""
    scene = (
        "simulate",
        "stack:n=2",
        "--formulation",
        "velocity:facets=4,distribution=extreme",
        "--solver",
        "lemke",
    )
    run(*scene, "--dump-steps", "2:4", "--out", d / "seq")
    index = [line.split(",") for line in (d / "seq" / "index.csv").read_text().splitlines()]
    assert index[0] == "step,solve,n,nnz,status,problem,answer".split(",") and [
        row[0] for row in index[1:]
    ] == ["2", "3", "4"], index
    for row in index[1:]:
        o = run_json("solve", d / "seq" / row[5], "--solver", "lemke", "--z", d / "z.mtx")
        assert o["status"] == row[4] == "ok" and o["n"] == int(row[2]), o
        assert (d / "z.mtx").read_text() == (d / "seq" / row[6]).read_text(), row
    run(
        "simulate",
        "stack:n=2",
        "--formulation",
        "coulomb:distribution=extreme",
        "--solver",
        "nsgs",
        "--dump-step",
        "3",
        "--out",
        d / "cone",
    )
    assert sorted(p.name for p in (d / "cone").iterdir()) == [
        "index.csv",
        "step_000003_01.dat",
        "step_000003_01.z.mtx",
    ]
    o = run_json("solve", d / "cone" / "step_000003_01.dat", "--solver", "nsgs", "--z", d / "z.mtx")
    assert (
        o["status"] == "ok"
        and (d / "z.mtx").read_text() == (d / "cone" / "step_000003_01.z.mtx").read_text()
    )
    one_line_error(*scene, "--dump-step", "0", "--out", d / "x", names=["0", "A:B"])
    one_line_error(*scene, "--dump-steps", "3:2", "--out", d / "x", names=["3:2"])
    one_line_error(*scene, "--dump-step", "2", names=["--out"])
    done = run(*scene, "--dump-step", "5000", "--out", d / "x", code=2)
    assert "no problem was posed" in done.stderr
    boxed = ("simulate", "slide", "--formulation", "boxed:distribution=extreme", "--solver", "ppm")
    run(*boxed, "--dump-step", "2", "--out", d / "boxes")
    index = [line.split(",") for line in (d / "boxes" / "index.csv").read_text().splitlines()]
    assert len(index) > 1 and all(row[5].endswith(".npz") for row in index[1:]), index
    for row in index[1:]:
        o = run_json("solve", d / "boxes" / row[5], "--solver", "ppm", "--z", d / "z.mtx")
        assert o["status"] == row[4] == "ok", o
        assert (d / "z.mtx").read_text() == (d / "boxes" / row[6]).read_text(), row


def trajectories_quote_names(d):
    """Whatever a body, a half-space or a scene is called: every row has every column, the name is
    itself."""
    names = ["a,b", 'say "so"', "two\nlines", "#7"]
    floor = {"name": 'floor, "the"', "normal": [0, 1], "offset": 0}
    disc = {"type": "disc", "r": 0.1}
    bodies = [
        {"name": name, "shape": disc, "mass": 1.0, "pos": [i, 0.1]} for i, name in enumerate(names)
    ]
    scene = {"id": "s,t", "dim": 2, "T": 0.02, "gravity": [0, -9.81], "bodies": bodies}
    (d / "s.json").write_text(json.dumps(dict(scene, static=[floor])))
    way = ("--formulation", "velocity", "--solver", "lemke", "--trajectory", d / "t.csv")
    run("simulate", d / "s.json", *way)
    with open(d / "t.csv", newline="", encoding="utf-8") as f:
        head, *rows = csv.reader(f)
    assert {len(row) for row in rows} == {len(head)} == {20}, rows
    got = {kind: [row[2] for row in rows if row[1] == kind] for kind in {row[1] for row in rows}}
    assert got["scene"] == ["s,t"] and got["plane"] == [floor["name"]], got
    assert got["shape"] == names and got["body"] == names * 3, got
    assert set(got["contact"]) == {f"{name}|{floor['name']}" for name in names}, got


def end_begins_a_scene(d: pathlib.Path) -> None:
    """A run, or its first half and another one from the scene that --write-end leaves: joints,
    springs, driven bodies and turned ones end at the same place. What grows with the time since
    the beginning cannot begin anew, and says so."""
    way = ("--formulation", "velocity", "--solver", "lemke")

    def end(*more: object) -> dict[str, list[float]]:
        run("simulate", *more, *way, "--trajectory", d / "t.csv", code=None)
        rows = list(csv.reader((d / "t.csv").open()))
        return {
            r[2]: [float(x) for x in r[4:17]]
            for r in rows
            if r[1] == "body" and r[0] == rows[-1][0]
        }

    for scene in (
        "chain",
        "oscillator",
        "gripper",
        "tablecloth",
        "belt",
        "spin",
        "euler_disc",
        "wall",
    ):
        whole = end(scene, "--step", "0.004", "--duration", "0.08")
        end(scene, "--step", "0.004", "--duration", "0.04", "--write-end", d / "end.json")
        half = end(d / "end.json", "--step", "0.004", "--duration", "0.04")
        assert whole.keys() == half.keys(), scene
        for body, state in whole.items():
            worst = max(abs(x - y) for x, y in zip(state, half[body], strict=True))
            assert worst < 1e-12, (scene, body, worst)
    one_line_error(
        *("simulate", "push", *way, "--write-end", d / "x.json"),
        names=["push", "grows with the time"],
    )
    assert not (d / "x.json").exists()


def parts_of_a_run_have_verdicts(d: pathlib.Path) -> None:
    """A budget of sweeps, then a solver with a tolerance: the run is not verified, its second part
    is."""
    o = run_json(
        *("simulate", "stack:n=3", "--duration", "0.2", "--start", "previous"),
        *("--formulation", "coulomb", "--solver", "nsgs:budget=5/12:cone_newton"),
        code=3,
    )
    first, second = o["combinations"]
    assert (first["status"], first["verified"], first["steps"]) == ("budget", False, 12), first
    assert (second["status"], second["verified"], second["steps"]) == ("ok", True, 8), second
    assert o["status"] == "budget" and not o["verified"]
    for count in ("n_solves", "n_iter", "n_factor", "n_pivot", "n_unsolved", "steps"):
        assert first[count] + second[count] == o[count], count
    assert max(first["rho_max"], second["rho_max"]) == o["rho_max"] > second["rho_max"]


def moments_are_refused_where_they_are_not_simulated(d: pathlib.Path) -> None:
    """A formulation without rolling and torsion says so: a ball that never stops is no answer."""
    for formulation in ("event", "penalty", "acceleration"):
        ball = ("simulate", "billiard", "--formulation", formulation, "--solver", "lemke")
        o = run_json(*ball, code=3)
        assert o["status"] == "unsupported", o["note"]
        assert o["claimed"] == "unsupported" and o["verified"] is False, o
        assert "does not simulate rolling torsion" in o["note"], o["note"]
        said = run(*ball, code=3).stderr
        assert said.count("\n") == 1 and o["note"] in said, said
        free = (*ball, "--duration", "0.01", "--effects=-rolling,-torsion")
        o = run_json(*free, code=None)  # asked for: the ball without them
        assert o["status"] == "ok", o["note"]


def mechanisms_are_simulated(d: pathlib.Path) -> None:
    """Joints hold in every formulation: a pendulum that falls freely is no answer."""
    for formulation in ("velocity", "event", "penalty", "acceleration"):
        chain = ("simulate", "chain", "--formulation", formulation, "--solver", "lemke")
        o = run_json(*chain, "--duration", "0.01", code=None)
        assert o["status"] == "ok", o["note"]


def generalised_coordinates_are_refused_where_bodies_are_needed(d: pathlib.Path) -> None:
    """These formulations read the state of bodies, which such a scene has not: it ended in a
    crash."""
    for formulation in ("event", "penalty", "acceleration"):
        for scene in ("woodpecker", "slider_crank"):
            arguments = ("--formulation", formulation, "--solver", "lemke", "--duration", "0.01")
            o = run_json("simulate", scene, *arguments, code=3)
            assert o["status"] == "unsupported" and "needs bodies" in o["note"], o["note"]


def what_is_not_computed_is_empty(d):
    """A compliant or event-driven step is not held against the cone of a time step: no number, and
    no 0."""
    cone = ("res_ncp_max", "res_ncp_rel_max", "res_cone_rel_max", "dissipation_gap_max_J")
    scene = ("simulate", "drop", "--solver", "lemke", "--formulation")
    o = run_json(*scene, "penalty", code=None)
    assert all(o[name] is None for name in (*cone, "rho_max", "res_natural_max")), o
    o = run_json(*scene, "event", code=None)
    assert all(o[name] is None for name in cone) and o["rho_max"] is not None, o
    o = run_json(*scene, "velocity", code=None)
    assert all(o[name] is not None for name in (*cone, "rho_max", "res_natural_max")), o


def environment_gives_options(d):
    way = ("simulate", "slide", "--formulation", "velocity", "--solver", "lemke")
    for name in ("LCPBENCH_TIME_LIMIT", "LCPBENCH_WORK"):  # of commands that ask for an error
        run(*way, code=0, **{name: "1"})
        run(*way, "--error", "1%", code=3, **{name: "1e-9" if "TIME" in name else "1"})
    o = run_json("solve", problem(d), LCPBENCH_SOLVER="lemke")
    assert o["solver"] == "lemke"
    plan = ("run", "families", "--dry-run", "--out", d / "o")
    whole, quick = (run(*plan, *more).stdout for more in ((), ("--quick",)))
    assert (
        whole != quick
        and run(*plan, LCPBENCH_QUICK="1").stdout == quick
        and run(*plan, LCPBENCH_QUICK="0").stdout == whole
    )
    for name, value in (
        ("LCPBENCH_QUICK", "maybe"),
        ("LCPBENCH_REPS", "many"),
        ("LCPBENCH_TIME_LIMIT", "soon"),
    ):
        done = run(*plan, code=2, **{name: value})
        assert name in done.stderr and value in done.stderr and done.stderr.count("\n") == 1, (
            done.stderr
        )


tap(
    [
        usage_errors,
        nearest_names_are_proposed,
        steps_longer_than_the_run_are_refused,
        options_out_of_range_are_refused,
        options_without_a_meaning_are_refused,
        output_that_does_not_arrive_is_no_success,
        problem_errors,
        scene_errors,
        check_errors,
        check_skips_no_case_for_want_of_anything,
        check_fails_what_it_cannot_run,
        forms_that_nobody_goes_by_are_refused,
        an_id_has_one_scene,
        truths_that_do_not_hold_are_refused,
        a_check_that_names_a_formulation_judges_it,
        lists_are_bare_names,
        scenes_are_described_in_full,
        solve_prints_one_object,
        solve_reports_infeasible,
        simulate_prints_one_object,
        dimensions_of_the_three_formulations,
        moments_are_refused_where_they_are_not_simulated,
        mechanisms_are_simulated,
        what_is_not_computed_is_empty,
        generalised_coordinates_are_refused_where_bodies_are_needed,
        environment_gives_options,
        certificates_are_written,
        an_answer_without_a_proof_is_told,
        export_reads_back,
        friction_stays_physical,
        steps_are_dumped,
        trajectories_quote_names,
        end_begins_a_scene,
        parts_of_a_run_have_verdicts,
    ]
)

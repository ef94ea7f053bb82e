"""Files under any name, and names that are no files: the command of a row reruns through a shell
whatever the path is made of, pipes and folders are refused at once, a byte-order mark is no
content, and no message moves a cursor."""

import json
import os
import pathlib
import subprocess

from support import LCPBENCH, campaign, one_line_error, rows, run, run_json, tap

M = "%%MatrixMarket matrix coordinate real general\n2 2 2\n1 1 2\n2 2 3\n"
Q = "%%MatrixMarket matrix array real general\n2 1\n-1\n1\n"
DAT = "2\n0\n2\n2\n2 2\n2 0\n0 3\n-1 1\n"
DISC = {"name": "b", "shape": {"type": "disc", "r": 0.1}, "mass": 1.0, "pos": [0, 1], "vel": [0, 1]}
SCENE = {
    "id": "s",
    "dim": 2,
    "T": 0.02,
    "bodies": [DISC],
    "checks": [{"type": "state", "var": "b.y", "t": 0.02, "value": 1.02, "tol": {"abs": 1e-9}}],
}
NAMES = (
    "new\nline",
    "it's",
    "two  words",
    "--dash",
    "-",
    "tab\t",
    "$(touch pwned)",
    "`touch pwned`",
    'dou"ble',
    "back\\slash",
    "\x1b[31mred",
    "100%s",
    "a;b&c",
    "#hash",
    "*",
    "[1]",
    "caf\u00e9",
    "~",
    "\n",
    "'\n'",
    "%\n\\n",
)
SIM = ("--formulation", "velocity", "--solver", "lemke")


def problems(folder: pathlib.Path) -> None:
    for i, name in enumerate(NAMES):  # a cell is known by its content: each another
        (folder / f"{name}.M.mtx").write_text(M.replace("2 2 3\n", f"2 2 {3 + i}\n"))
        (folder / f"{name}.q.mtx").write_text(Q)


def shell(command: str, cwd: pathlib.Path) -> dict:
    """The command of a row as a user would paste it, with lcpbench on the path."""
    bin_dir = cwd / "bin"
    bin_dir.mkdir(exist_ok=True)
    if not (bin_dir / "lcpbench").exists():
        (bin_dir / "lcpbench").symlink_to(LCPBENCH)
    env = dict(os.environ, PATH=f"{bin_dir}:{os.environ['PATH']}")
    done = subprocess.run(
        ["sh", "-c", command],
        cwd=cwd,
        env=env,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 0 and done.stderr == "", (command, done.returncode, done.stderr)
    return json.loads(done.stdout)


def lcpbench_in(cwd: pathlib.Path, *words: str) -> subprocess.CompletedProcess:
    done = subprocess.run(
        [LCPBENCH, *map(str, words)],
        cwd=cwd,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, (words, done.returncode, done.stdout, done.stderr)
    return done


def commands_rerun_whatever_the_path(d):
    """Relative paths, so that those that begin with a dash or a ~ reach the shell as they are."""
    problems(d)
    scenes = [f"{n}.json" for n in NAMES]
    for i, name in enumerate(scenes):
        (d / name).write_text(json.dumps(dict(SCENE, id=f"s{i}")))
    text = (
        "name: odd\nsampling: {processes: 1, samples: 1, max_samples: 1, inner: 0.0001s}\nparts:\n"
        "  - {name: a, problems: ['*.M.mtx'], solvers: [lemke]}\n"
        "  - {name: b, problems: ['./*.json'], formulations: [velocity], solvers: [lemke]}\n"
    )
    campaign(d, text)
    lcpbench_in(d, "run", "t.yaml", "--out", "out", "--quiet")
    got = rows(d / "out")
    assert len(got) == 2 * len(NAMES) and {r["status"] for r in got} == {"ok"}, len(got)
    assert (d / "out/results.csv").read_text(encoding="utf-8").count("\n") == len(got) + 1
    for r in got:
        o = shell(r["command"], d)
        assert o["status"] == "ok" and o["solution_hash"] == r["solution_hash"], r["command"]
    for again in ((), ("--rerun",)):
        told = lcpbench_in(d, "verify", "out", *again).stdout
        assert f"{len(got)} cells verified" in told and " 0 differ" in told, told
    # the plan prints the same commands, a line each
    plan = lcpbench_in(d, "run", "t.yaml", "--out", "new", "--dry-run").stdout.splitlines()
    assert len([line for line in plan if line.startswith("todo ")]) == len(got), plan
    assert not (d / "pwned").exists()


def commands_of_calibrate_rerun_too(d):
    for i, name in enumerate(("it's new\nline.json", "two words.json")):
        scene = dict(SCENE, id=f"s{i}")
        (d / name).write_text(json.dumps(scene))
        found = json.loads(
            lcpbench_in(
                d, "calibrate", name, "--error", "1", "--step", "0.01", "--evaluations", "1"
            ).stdout
        )
        assert shell(found["best"]["command"], d)["scene"] == scene["id"]


def names_that_no_line_holds_are_refused(d):
    deep = "\n" * 200 + "/" + "\n" * 80 + ".M.mtx"
    for name, word in (("end\n.M.mtx", ""), ("x.json\n", "line break"), (deep, "longer")):
        (d / name).parent.mkdir(exist_ok=True)
        (d / name).write_text(M if "mtx" in name else json.dumps(SCENE))
        (d / name.replace(".M.", ".q.")).write_text(Q)
        forms = "" if "mtx" in name else "formulations: [velocity], "
        text = "name: n\nparts: [{name: a, problems: [%s], %ssolvers: [lemke]}]\n"
        campaign(d, text % (json.dumps(str(d / name)), forms))
        if word:
            one_line_error("run", d / "t.yaml", "--dry-run", names=[word])
        else:
            run("run", d / "t.yaml", "--dry-run")


def options_end_at_two_dashes(d):
    problems(d)
    done = lcpbench_in(d, "solve", "--solver", "lemke", "--", "--dash.M.mtx")
    assert json.loads(done.stdout)["status"] == "ok"
    one_line_error("solve", "--solver", "lemke", "--dash.M.mtx", names=["--dash.M.mtx"])
    (d / "a#b.json").write_text(json.dumps(SCENE))
    (d / "a.json").write_text(json.dumps([SCENE, dict(SCENE, id="other")]))
    assert run_json("simulate", d / "a#b.json", *SIM)["scene"] == "s"
    assert run_json("simulate", f"{d}/a.json#other", *SIM)["scene"] == "other"


def inputs(path: object, beside: pathlib.Path) -> list[tuple]:
    """Commands that read `path`, one for every reader; its name must end as the reader wants it."""
    path = str(path)
    by_end = {
        ".M.mtx": [("solve", path, "--solver", "lemke")],
        ".mtx": [("solve", beside / "g.M.mtx", "--q", path, "--solver", "lemke")],
        ".dat": [
            ("solve", path, "--solver", "lemke"),
            ("export", path, "--format", "siconos", "--out", beside / "o"),
        ],
        ".hdf5": [("solve", path, "--solver", "nsgs")],
        ".json": [("check", path), ("simulate", path, *SIM), ("calibrate", path, "--error", "1")],
        ".yaml": [
            ("check", path),
            ("simulate", path, *SIM),
            ("run", path, "--dry-run"),
            ("submit", path, "--engine", "parallel", "--dry-run", "--out", beside / "s"),
        ],
        ".txt": [("verify", beside / "g.M.mtx", "--certificate", path)],
    }
    return next(words for end, words in by_end.items() if path.endswith(end))


ENDS = ("x.M.mtx", "x.mtx", "x.dat", "x.hdf5", "x.json", "x.yaml", "x.txt")


def pipes_and_folders_are_no_input(d):
    """A FIFO without a writer used to be waited for."""
    (d / "g.M.mtx").write_text(M)
    (d / "g.q.mtx").write_text(Q)
    for end in ENDS:
        for kind in ("pipe", "folder"):
            path = d / f"{kind}.{end}"
            os.mkfifo(path) if kind == "pipe" else path.mkdir()
            for words in inputs(path, d):
                one_line_error(*words, names=[path, f"is a {kind}", "need a regular file"])
    for words in inputs("/dev/zero.M.mtx", d):
        one_line_error(*words, names=["/dev/zero.M.mtx", "No such file"])
    (d / "null.json").symlink_to("/dev/zero")
    one_line_error("check", d / "null.json", names=["null.json", "is a device"])
    os.mkfifo(d / "results.csv")
    for verb in ("status", "verify"):
        one_line_error(verb, d, names=["results.csv", "is a pipe"])
    one_line_error("compare", d, d, names=["results.csv", "is a pipe"])
    one_line_error("run", "smoke", "--out", d, names=["results.csv", "is a pipe"])


def byte_order_marks_are_no_content(d):
    mark = b"\xef\xbb\xbf"
    texts = {
        "g.M.mtx": M,
        "g.q.mtx": Q,
        "l.dat": DAT,
        "s.json": json.dumps(SCENE),
        "s.yaml": json.dumps(SCENE),
        "c.txt": "lcpbench certificate 1\nkind basis\nn 2\n0 1 0.5\n1 0 0\n",
        "t.yaml": (
            "name: t\nsampling: {processes: 1, samples: 1, max_samples: 1}\n"
            "parts: [{name: a, problems: ['%s/g.M.mtx'], solvers: [lemke]}]\n" % d
        ),
    }
    for name, text in texts.items():
        (d / name).write_bytes(mark + text.encode())
    assert run_json("solve", d / "g.M.mtx", "--solver", "lemke")["status"] == "ok"
    assert run_json("solve", d / "l.dat", "--solver", "lemke")["status"] == "ok"
    for name in ("s.json", "s.yaml"):
        assert run_json("simulate", d / name, *SIM)["status"] == "ok"
        run("check", d / name, *SIM)
    assert run_json("verify", d / "g.M.mtx", "--certificate", d / "c.txt")["holds"]
    run("run", d / "t.yaml", "--out", d / "o", "--quiet")
    for name in ("o/results.csv", "o/manifest.json"):
        (d / name).write_bytes(mark + (d / name).read_bytes())
    assert "1 rows of 1 cells" in run("status", d / "o").stdout
    assert " 0 differ" in run("verify", d / "o").stdout
    run("merge", d / "o", "--out", d / "m")
    for name in ("s.json", "g.M.mtx", "l.dat"):
        (d / f"wide.{name}").write_text(texts[name], encoding="utf-16")
        for words in inputs(d / f"wide.{name}", d):
            one_line_error(*words, names=["UTF-16"])


def messages_are_one_plain_line(d):
    """Whatever was typed, or stands in a file, no message holds a control character."""
    evil = "\x1b[2J\x07\n\r\x9b1m\x7f\u009b"
    (d / "bad.json").write_text(json.dumps(dict(SCENE, **{evil: 1})))
    (d / "bad.yaml").write_text(
        'name: x\nparts: [{name: a, problems: ["\\e[2J"], solvers: ["\\e[31m"]}]\n'
    )
    (d / "bad.M.mtx").write_text(M.replace("1 1 2", "1 1 \x1b[2J"))
    (d / "bad.q.mtx").write_text(Q)
    cases = (
        (evil,),
        ("list", evil),
        ("solve", evil, "--solver", "lemke"),
        ("solve", "murty", "--solver", evil),
        ("solve", "murty:" + evil + "=1", "--solver", "lemke"),
        ("solve", "murty", "--solver", "lemke", "--" + evil),
        ("solve", "murty", "--solver", "lemke", "--tol", evil),
        ("solve", f"{d}/{evil}.dat", "--solver", "lemke"),
        ("solve", "murty", "--solver", "lemke", "--z", f"{d}/none/{evil}"),
        ("simulate", evil, *SIM),
        ("simulate", "incline", "--formulation", evil, "--solver", "lemke"),
        ("simulate", "incline", *SIM, "--effects", evil),
        ("simulate", "incline", *SIM, "--step", evil),
        ("simulate", d / "bad.json", *SIM),
        ("solve", d / "bad.M.mtx", "--solver", "lemke"),
        ("check", f"{d}/{evil}.json"),
        ("run", evil),
        ("run", d / "bad.yaml", "--dry-run"),
        ("run", "smoke", "--dry-run", "--filter", evil),
        ("status", f"{d}/{evil}"),
        ("verify", f"{d}/{evil}"),
        ("compare", evil, evil),
        ("compare", d, d, "--column", evil),
        ("merge", evil, "--out", d / "m"),
        ("export", "murty", "--format", evil, "--out", d / "x"),
        ("submit", "smoke", "--engine", evil),
        ("doctor", "--out", f"/proc/{evil}", "--seconds", "0.01"),
        ("calibrate", evil, "--error", "1"),
    )
    for words in cases:
        done = subprocess.run(
            [LCPBENCH, *map(str, words)], capture_output=True, check=False, timeout=60
        )
        text = done.stderr.decode("utf-8")  # and it is UTF-8
        assert done.returncode == 2 and text.endswith("\n"), (words, done.returncode, text)
        assert not [c for c in text[:-1] if ord(c) < 32 or 127 <= ord(c) < 160], (words, text)


def names_that_are_not_utf8_are_told(d):
    path = os.fsencode(d) + b"/caf\xe9.dat"
    with open(path, "w", encoding="utf-8") as f:
        f.write(DAT)
    done = subprocess.run(
        [LCPBENCH, "solve", path, "--solver", "lemke"], capture_output=True, check=True
    )
    assert json.loads(done.stdout)["problem"].endswith("caf\\xe9.dat")


tap(
    [
        commands_rerun_whatever_the_path,
        commands_of_calibrate_rerun_too,
        names_that_no_line_holds_are_refused,
        options_end_at_two_dashes,
        pipes_and_folders_are_no_input,
        byte_order_marks_are_no_content,
        messages_are_one_plain_line,
        names_that_are_not_utf8_are_told,
    ]
)

"""Files that the program writes: whole or not at all where they are files, untouched in kind where
they are devices, pipes and links; `-` is standard output; what does not fit is told in one line."""

import json
import os
import pathlib
import signal
import stat
import subprocess
import threading
import time

from support import LCPBENCH, Skip, limited, one_line_error, run, run_json, tap

SCENE = (
    "simulate",
    "slide",
    "--formulation",
    "velocity",
    "--solver",
    "lemke",
    "--duration",
    "0.05",
)
SOLVE = ("solve", "murty:n=4", "--solver", "lemke")
# every option that writes a file, with the command that it belongs to and how the file begins
OUTPUTS = (
    (SCENE, "--trajectory", "t_s,kind,"),
    (SCENE, "--trace", "solve,iteration,"),
    (SOLVE, "--trace", "solve,iteration,"),
    (SOLVE, "--certificate", "lcpbench certificate 1"),
    (SOLVE, "--z", "%%MatrixMarket"),
)


def friction(d: pathlib.Path) -> pathlib.Path:
    """One contact with W = I."""
    path = d / "one.dat"
    path.write_text("3\n1\n0\n3\n3\n3 3\n1 0 0\n0 1 0\n0 0 1\n-1 0 0\n0.5\n")
    return path


def all_outputs(d: pathlib.Path):
    yield from OUTPUTS
    yield ("export", friction(d), "--format", "siconos"), "--out", "3\n"


def left_behind(d: pathlib.Path) -> list[str]:
    return [p.name for p in d.iterdir() if ".tmp" in p.name]


def files_are_replaced_whole(d):
    for i, (words, option, head) in enumerate(all_outputs(d)):
        path = d / f"out{i}"
        path.write_text("old")
        path.chmod(0o640)
        before = path.stat().st_ino
        run(*words, option, path)
        assert path.read_text().startswith(head), (option, path.read_text()[:80])
        assert stat.S_IMODE(path.stat().st_mode) == 0o640 and path.stat().st_ino != before, option
    assert not left_behind(d), left_behind(d)


def links_stay_and_their_target_is_written(d):
    (d / "sub").mkdir()
    for i, (words, option, head) in enumerate(all_outputs(d)):
        for target in (d / "sub" / f"there{i}", d / "sub" / f"new{i}"):
            if target.name.startswith("there"):
                target.write_text("old")
            link, chain = d / f"link.{target.name}", d / f"chain.{target.name}"
            link.symlink_to(pathlib.Path("sub") / target.name)  # relative to the link's own folder
            chain.symlink_to(link)
            run(*words, option, chain)
            assert chain.is_symlink() and link.is_symlink() and not target.is_symlink(), option
            assert target.read_text().startswith(head), (option, target)
    one_line_error(*SOLVE, "--z", loop(d), names=["loop", "symbolic links"])


def loop(d: pathlib.Path) -> pathlib.Path:
    (d / "loop").symlink_to(d / "loop2")
    (d / "loop2").symlink_to(d / "loop")
    return d / "loop"


def devices(d: pathlib.Path) -> tuple[pathlib.Path, pathlib.Path]:
    """null and full; for root copies of them, so that a fault of the program spoils no machine."""
    null, full = pathlib.Path("/dev/null"), pathlib.Path("/dev/full")
    if os.geteuid() == 0:
        try:
            for name, minor in (("null", 3), ("full", 7)):
                os.mknod(d / name, 0o666 | stat.S_IFCHR, os.makedev(1, minor))
            null, full = d / "null", d / "full"
            null.write_text("x")
        except OSError as why:
            raise Skip(f"root, and no device to try it on: {why}") from why
    return null, full


def device(path: pathlib.Path) -> tuple[int, int]:
    return stat.S_IFMT(path.stat().st_mode), path.stat().st_rdev


def devices_are_written_to_and_stay_devices(d):
    """As root the program used to put a file in the place of /dev/full."""
    null, full = devices(d)
    before = device(null), device(full)
    for words, option, _ in all_outputs(d):
        run(*words, option, null)
        one_line_error(*words, option, full, names=[full, "No space left on device"])
    assert (device(null), device(full)) == before
    one_line_error(
        "export", friction(d), "--format", "fclib", "--out", null, names=[null, "regular"]
    )
    one_line_error(
        "export", "murty:n=4", "--format", "mtx", "--out", null, names=[null, "two files"]
    )
    for words in (
        ("run", "smoke", "--out", null),
        (*SCENE, "--dump-step", "1", "--out", null),
        ("doctor", "--seconds", "0.1", "--out", null),
    ):
        one_line_error(*words, names=[null, "not a folder"])
    assert (device(null), device(full)) == before


def pipes_are_written_to(d):
    for i, (words, option, head) in enumerate(all_outputs(d)):
        fifo = d / f"fifo{i}"
        os.mkfifo(fifo)
        got = []
        reader = threading.Thread(target=lambda path=fifo, to=got: to.append(path.read_text()))
        reader.start()
        run(*words, option, fifo)
        reader.join(30)
        assert got and got[0].startswith(head) and stat.S_ISFIFO(fifo.stat().st_mode), (option, got)
    lonely = d / "lonely"
    os.mkfifo(lonely)
    one_line_error(*SOLVE, "--z", lonely, names=["lonely", "nobody reads"])
    # what a shell puts in the place of >(command)
    shell = f"exec {LCPBENCH} {' '.join(SOLVE)} --z >(cat > {d}/copy; echo done > {d}/flag)"
    subprocess.run(["bash", "-c", shell], check=True, stdout=subprocess.DEVNULL, timeout=60)
    for _ in range(200):
        if (d / "flag").exists():
            break
        threading.Event().wait(0.05)
    assert (d / "copy").read_text().startswith("%%MatrixMarket")


def descriptors_are_appended_to(d):
    """/dev/fd/N is the open file, not a name to be replaced."""
    log = d / "log"
    log.write_text("first\n")
    with open(log, "a", encoding="utf-8") as f:
        words = [LCPBENCH, *SOLVE, "--z", f"/dev/fd/{f.fileno()}"]
        subprocess.run(
            words, check=True, stdout=subprocess.DEVNULL, pass_fds=[f.fileno()], timeout=60
        )
        f.write("last\n")
    lines = log.read_text().splitlines()
    assert lines[0] == "first" and lines[1].startswith("%%MatrixMarket") and lines[-1] == "last", (
        lines
    )


def dash_is_standard_output(d):
    """The file stands on stdout, alone; the JSON object goes to stderr."""
    for words, option, head in OUTPUTS:
        for name in ("-", "/dev/stdout"):
            done = run(*words, option, name)
            assert done.stdout.startswith(head) and "\n{" not in done.stdout, (
                option,
                done.stdout[:80],
            )
            assert "status" in json.loads(done.stderr), (option, done.stderr[:80])
    exported = run("export", friction(d), "--format", "siconos", "--out", "-")
    assert exported.stdout.startswith("3\n") and exported.stderr == ""
    assert not list(pathlib.Path(".").glob("-")) and not pathlib.Path("-").exists()
    one_line_error(*SCENE, "--trajectory", "-", "--trace", "-", names=["--trajectory", "--trace"])
    one_line_error(
        *SCENE, "--trajectory", "-", "--trace", "/dev/stdout", names=["--trajectory", "--trace"]
    )
    one_line_error(
        *SCENE, "--trajectory", d / "x", "--trace", d / "x", names=["--trajectory", "--trace"]
    )
    one_line_error(
        "export", "murty:n=4", "--format", "mtx", "--out", "-", names=["--out -", "two files"]
    )
    one_line_error("export", friction(d), "--format", "fclib", "--out", "-", names=["regular"])
    for words in (
        ("run", "smoke", "--out", "-"),
        (*SCENE, "--dump-step", "1", "--out", "-"),
        ("submit", "smoke", "--engine", "slurm", "--out", "-"),
    ):
        one_line_error(*words, names=["-", "folder"])
    # a file that is called so
    done = subprocess.run([LCPBENCH, *SOLVE, "--z", "./-"], cwd=d, capture_output=True, check=True)
    assert (d / "-").read_text().startswith("%%MatrixMarket") and json.loads(done.stdout)
    # the file that stdout is sent to cannot be replaced under it
    with open(d / "both", "w", encoding="utf-8") as both:
        words = [LCPBENCH, *map(str, SOLVE), "--z", str(d / "both")]
        done = subprocess.run(words, stdout=both, stderr=subprocess.PIPE, text=True, check=False)
    assert (
        done.returncode == 2 and "standard output" in done.stderr and done.stderr.count("\n") == 1
    )


def places_that_cannot_be_written_are_named(d):
    (d / "folder").mkdir()
    for words, option, _ in all_outputs(d):
        one_line_error(*words, option, d / "folder", names=["folder", "is a folder"])
        one_line_error(*words, option, f"{d}/folder/", names=["folder"])
        one_line_error(*words, option, d / "none" / "x", names=["none/x", "No such file"])
        one_line_error(*words, option, "", names=["name of a file"])
        one_line_error(*words, option, d / ("x" * 2000), names=["1099 characters"])
    if os.geteuid() != 0:
        (d / "sealed").write_text("kept")
        (d / "sealed").chmod(0o444)
        one_line_error(*SOLVE, "--z", d / "sealed", names=["sealed", "Permission denied"])
    assert not left_behind(d)


def files_that_may_not_grow_are_told(d):
    for words, option, _ in all_outputs(d):
        path = d / "big"
        path.write_text("old")
        line = limited((*words, option, path), 4)
        assert "big" in line and "File too large" in line, line
        assert path.read_text() == "old" and not left_behind(d), (option, left_behind(d))


def a_reader_that_leaves_ends_the_program_silently(_):
    shell = f"{LCPBENCH} list scenes --format json | head -1; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", shell], capture_output=True, text=True, check=False)
    assert done.stdout == "[\n" and done.stderr == "" and done.returncode in (0, 141), done


def dumps_follow_links_too(d):
    (d / "real").mkdir()
    (d / "elsewhere").write_text("old")
    (d / "real" / "index.csv").symlink_to(d / "elsewhere")
    (d / "link").symlink_to(d / "real")
    run_json(*SCENE, "--dump-step", "1", "--out", d / "link")
    assert (d / "real" / "index.csv").is_symlink()
    assert (d / "elsewhere").read_text().startswith("step,solve,")
    run_json(*SCENE, "--dump-step", "1", "--out", d / "new" / "deeper")
    assert (d / "new" / "deeper" / "index.csv").exists()


def written_now(p: subprocess.Popen) -> bool:
    """Has p opened a file that is not whole yet?"""
    try:
        links = [os.readlink(fd) for fd in pathlib.Path(f"/proc/{p.pid}/fd").iterdir()]
    except FileNotFoundError:  # one was closed meanwhile
        return False
    assert p.poll() is None, "it ended before it was killed"
    return any("(deleted)" in link or link.endswith(".tmp") for link in links)


def a_killed_program_leaves_nothing(d):
    """The file has no name until it is whole: SIGKILL leaves no part of it. The other signals end
    the run, and the file has the steps up to there."""
    scene = [w if w != "slide" else "stack:n=30" for w in SCENE]
    for sent in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
        out = d / f"t{sent}.csv"
        p = subprocess.Popen(
            [LCPBENCH, *scene, "--step", "0.00001", "--trajectory", out],
            stdout=subprocess.DEVNULL,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        )
        while not written_now(p):
            time.sleep(0.001)
        p.send_signal(sent)
        code = {signal.SIGINT: 130, signal.SIGTERM: 4}.get(sent, -sent)
        assert p.wait() == code, (sent, p.returncode)
        if sent != signal.SIGKILL:
            lines = out.read_text().splitlines()
            assert len(lines) > 31 and lines[-1].count(",") == lines[0].count(","), lines[-1]
            out.unlink()
        assert not list(d.iterdir()), (sent, list(d.iterdir()))


tap(
    [
        files_are_replaced_whole,
        links_stay_and_their_target_is_written,
        devices_are_written_to_and_stay_devices,
        pipes_are_written_to,
        descriptors_are_appended_to,
        dash_is_standard_output,
        places_that_cannot_be_written_are_named,
        files_that_may_not_grow_are_told,
        a_reader_that_leaves_ends_the_program_silently,
        dumps_follow_links_too,
        a_killed_program_leaves_nothing,
    ]
)

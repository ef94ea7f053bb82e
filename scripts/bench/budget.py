"""budget BINARY TIME RUNS [CAMPAIGN ...] - measures the full form of campaigns until TIME is spent.

One campaign after the other: those named, in their order; without names those whose full form is
not whole, the one of which least is left first, by the rows of results/reference. First each as far
as it tells what the quick form tells, then each to its end. Rows go to
RUNS/cut/CAMPAIGN, in an order that may be cut anywhere (lcpbench run --budget), and take the place
of RUNS/CAMPAIGN once they tell at least what the quick form tells. What is not there yet is taken
from results/reference: its rows stand in for what is not measured now, and a full form that was
begun is gone on with.
"""

import lzma
import pathlib
import re
import shutil
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from bench import cut, rows, say  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
UNITS = {"": 1, "s": 1, "m": 60, "h": 3600}
CUT = 4  # lcpbench run: cells are left
# what other scripts measured beside the rows, without asking them (scripts/calibrate, bisect)
BESIDE = ("calibration.jsonl", "limits.csv")


class Failed(Exception):
    pass


def seconds(text: str) -> float:
    """As lcpbench reads a time: 90, 90s, 40m, 4h."""
    found = re.fullmatch(r"(\d+(?:\.\d+)?)([smh]?)", text)
    if not found or not float(found[1]) > 0:
        raise ValueError(text)
    return float(found[1]) * UNITS[found[2]]


def unpack(source: pathlib.Path, target: pathlib.Path) -> None:
    """A folder of packed rows as one that a run goes on with: whole or not at all."""
    part = target.with_name(target.name + ".part")
    shutil.rmtree(part, ignore_errors=True)
    shutil.copytree(source, part)
    packed = part / "results.csv.xz"
    (part / "results.csv").write_bytes(lzma.decompress(packed.read_bytes()))
    packed.unlink()
    part.rename(target)


def adopt(reference: pathlib.Path, runs: pathlib.Path) -> None:
    """Campaigns of the reference that are not in RUNS: full ones as they are, quick ones beside
    those of the quick runs, with a link; begun ones in cut/."""
    for packed in sorted(reference.glob("*/results.csv.xz")):
        name = packed.parent.name
        full = rows.manifest(packed.parent).get("campaign", {}).get("quick") is False
        quick = runs.parent / "runs" / name
        if (runs / name).exists():
            continue
        if full:
            unpack(packed.parent, runs / name)
            continue
        if not quick.exists():
            unpack(packed.parent, quick)
        (runs / name).symlink_to(pathlib.Path("..") / "runs" / name)
    for packed in sorted(reference.glob("cut/*/results.csv.xz")):
        name = packed.parent.name
        if not (runs / "cut" / name).exists() and (runs / name).is_symlink():
            unpack(packed.parent, runs / "cut" / name)


def whole(folder: pathlib.Path) -> bool:
    """Was the full form measured to its end, by whatever build?"""
    found = rows.manifest(folder)
    return found.get("campaign", {}).get("quick") is False and not found.get("cut")


def standing(runs: pathlib.Path, name: str) -> pathlib.Path:
    """Where the rows of the full form are: those that wait, or those that stand already."""
    work, done = runs / "cut" / name, runs / name
    return done if not work.exists() and done.exists() and not done.is_symlink() else work


def prepare(runs: pathlib.Path, name: str) -> pathlib.Path:
    """The folder where the campaign is measured. What stands is copied: a build that measures all
    of it anew does not leave less than there was."""
    work, found = runs / "cut" / name, standing(runs, name)
    if found != work:
        part = work.with_name(name + ".part")
        shutil.rmtree(part, ignore_errors=True)
        shutil.copytree(found, part)
        part.rename(work)
    return work


def promote(runs: pathlib.Path, name: str) -> bool:
    """cut/CAMPAIGN in the place of CAMPAIGN, where it tells as much as the quick form."""
    work, old = runs / "cut" / name, runs / name
    if not cut.stands(rows.manifest(work)):
        return False
    for found in BESIDE:
        if (old / found).exists() and not (work / found).exists():
            shutil.copyfile(old / found, work / found)
    if old.is_symlink():
        old.unlink()
    elif old.exists():
        shutil.rmtree(old)
    work.rename(old)
    return True


def asked(binary: str, name: str, work: pathlib.Path, reference: pathlib.Path) -> list[str]:
    like = reference / name
    told = ["--like", str(like)] if like.exists() else []
    return [binary, "run", name, "--out", str(work), *told]


def left(binary: str, name: str, work: pathlib.Path, reference: pathlib.Path) -> float:
    """Foretold of what is left of a campaign [s]; 0 where nothing is."""
    done = subprocess.run(
        [*asked(binary, name, work, reference), "--dry-run"],
        capture_output=True,
        text=True,
        check=False,
    )
    found = re.search(r" (\d+) to do; about (\d+) s", done.stdout)
    if done.returncode or not found:
        raise Failed(f"{name}: {done.stderr.strip()}")
    return max(float(found[2]), 0.5) if int(found[1]) else 0.0  # it is told in whole seconds


def waits(runs: pathlib.Path, name: str) -> bool:
    return (runs / "cut" / name).exists()


def measure(
    binary: str, budget: float, runs: pathlib.Path, names: list[str], reference: pathlib.Path
) -> None:
    begun = time.monotonic()
    spent = False  # not before one call: whoever asks again and again comes to the end
    todo = [(name, True) for name in names] + [(name, False) for name in names]
    for name, short in todo:
        if short and cut.stands(rows.manifest(standing(runs, name))):
            continue
        if not left(binary, name, standing(runs, name), reference) and not waits(runs, name):
            print(f"{name}: nothing is left")
            continue
        remains = budget - (time.monotonic() - begun)
        if remains <= 0 and spent:
            break
        spent = True
        work = prepare(runs, name)
        command = [*asked(binary, name, work, reference), "--budget", f"{max(remains, 0.001):.3f}s"]
        command += ["--stage", cut.STAGES[-1]] if short else []
        done = subprocess.run(command, stdin=subprocess.DEVNULL, check=False)
        if done.returncode not in (0, CUT):
            raise Failed(f"{name}: {' '.join(command)}: exit {done.returncode}")
        stands = promote(runs, name)
        found = rows.manifest(runs / name if stands else work)
        print(
            f"{name}: {cut.form(found)}"
            + ("" if stands else f"; waits in {work} until it tells what the quick form tells")
        )


def main() -> int:
    parser = say.Arguments(prog="scripts/reproduce --full --budget", description=__doc__)
    parser.add_argument("binary", metavar="BINARY")
    parser.add_argument("time", metavar="TIME", type=seconds, help="such as 40m or 4h")
    parser.add_argument("runs", metavar="RUNS", type=pathlib.Path)
    parser.add_argument("campaigns", metavar="CAMPAIGN", nargs="*")
    parser.add_argument("--all", metavar="NAMES", required=True, help="the campaigns there are")
    parser.add_argument("--reference", type=pathlib.Path, default=ROOT / "results" / "reference")
    args = parser.parse_args()
    for folder in (args.runs / "cut", args.runs.parent / "runs"):
        folder.mkdir(parents=True, exist_ok=True)
    try:
        adopt(args.reference, args.runs)
        names = args.campaigns
        if not names:
            every = {
                n: left(args.binary, n, standing(args.runs, n), args.reference)
                for n in args.all.split()
                if not whole(args.runs / n)
            }
            names = sorted(every, key=lambda n: every[n])
        measure(args.binary, args.time, args.runs, names, args.reference)
    except Failed as error:
        say.complain(f"scripts/reproduce: {error}")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""scripts/engines [--quick] [--engines LIST] [--scenes LIST] [--settings LIST] [--steps LIST]
[--out DIR] - scenes of the suite in other engines and in our own formulations, judged alike: error,
penetration, creep, energy and Coulomb residual against time a step. Scenes, settings and steps are
those of [engines] in scripts/experiments.toml. Lists have commas between their names."""

from __future__ import annotations

import argparse
import dataclasses
import datetime
import importlib
import os
import pathlib
import shlex
import statistics
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from bench import engine_rows as rows  # noqa: E402
from bench import experiments, say  # noqa: E402
from engine_room import isolate, judge, motion, ours, scene  # noqa: E402

REPEATS = 3  # timed runs
TIMED = 4.0  # none is begun after so many seconds of stepping, warming up among them [s]
OWN = "lcpbench"


@dataclasses.dataclass
class Job:
    """One row to be: a scene (or why there is none) in an engine at a setting and a step."""

    row: rows.Row
    scene: scene.Scene | None
    options: dict
    step: float
    rests: float | None


def wanted(text: str | None, known: list[str], what: str) -> list[str]:
    """The names of a list; SystemExit with the rule where one is not known."""
    if not text:
        return known
    asked = text.split(",")
    for name in asked:
        if name not in known:
            say.complain(f"engines: no {what} '{name}': there are {', '.join(known)}")
            raise SystemExit(2)
    return asked


def processor() -> str:
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return ""


def pinned() -> None:
    """One thread on one processor, for everything that is started from here."""
    for name in ("OPENBLAS", "OMP", "MKL"):
        os.environ[f"{name}_NUM_THREADS"] = "1"
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


# ---- an engine --------------------------------------------------------------------------------


def stepped(
    make: object, scene_: scene.Scene, options: dict, step: float, record: bool
) -> tuple[motion.Motion | None, float]:
    """(motion, seconds a step) of one run; a run that is not recorded is timed as a whole."""
    simulation = make(scene_, options, step)
    count = round(scene_.duration / step)
    if not record:
        began = time.perf_counter()
        for _ in range(count):
            simulation.step()
        return None, (time.perf_counter() - began) / count
    recorder, spent = motion.Recorder(scene_), 0.0
    for k in range(count):
        began = time.perf_counter()
        simulation.step()
        spent += time.perf_counter() - began
        recorder.add((k + 1) * step, simulation.states(), simulation.contacts())
    return recorder.motion(), spent / count


def measured(module: object, job: Job, laws: list[str]) -> rows.Row:
    """The row of a job, in a process of its own."""
    make = module.Simulation
    found, first = stepped(make, job.scene, job.options, job.step, True)
    times, spent = [], first * (len(found.t) - 1)
    while len(times) < REPEATS and spent < TIMED:
        _, each = stepped(make, job.scene, job.options, job.step, False)
        times.append(each)
        spent += each * (len(found.t) - 1)
    row = judged(job, found, times or [first], laws, "ok")
    return dataclasses.replace(row, repeats=str(len(times)))


def judged(
    job: Job, found: motion.Motion, times: list[float], laws: list[str], status: str
) -> rows.Row:
    verdict = judge.judge(job.scene, found, motion.in_world(job.scene, found), laws, job.rests)
    return dataclasses.replace(
        job.row,
        steps=str(len(found.t) - 1),
        status=status if verdict.finite else "diverged",
        error=rows.number(verdict.error),
        quantity=verdict.error_quantity,
        penetration_m=rows.number(verdict.penetration),
        creep_m_s=rows.number(verdict.creep),
        energy_gain_J=rows.number(verdict.energy_gain),
        coulomb=rows.number(verdict.coulomb),
        n_contact=rows.number(verdict.n_contact),
        t_step_s=rows.number(statistics.median(times)),
        t_step_low_s=rows.number(min(times)),
        t_step_high_s=rows.number(max(times)),
        load1=f"{os.getloadavg()[0]:.2f}",
    )


def settled(job: Job, word: str, answer: object) -> rows.Row:
    """The row of a job that came to an end, whatever the end was."""
    if word == "ok":
        return answer
    return dataclasses.replace(job.row, status=word, note=say.plain(answer)[:200])


def show(row: rows.Row) -> None:
    told = row.note or (f"error {row.error or '-'}, {rows.value(row.t_step_s) * 1e3:.3g} ms a step")
    say.complain(f"{row.scene} {row.engine} {row.setting} {row.step_s} s: {row.status}, {told}")


def nursery(engine: str, jobs: list[Job], laws: list[str], limit: float) -> list[rows.Row]:
    """All rows of an engine: it is loaded once, every run has a process of its own."""
    module = importlib.import_module(f"engine_room.engines.{engine}_room")
    version, out = module.version(), []
    for job in jobs:
        job.row = dataclasses.replace(job.row, version=version)
        if job.scene is None:
            out.append(job.row)
        else:
            out.append(settled(job, *isolate.call(lambda j=job: measured(module, j, laws), limit)))
        show(out[-1])
    return out


def engine_rows(engine: str, jobs: list[Job], laws: list[str], limit: float) -> list[rows.Row]:
    """Rows of an engine; one row, `absent`, where it cannot be loaded."""
    word, answer = isolate.call(
        lambda: nursery(engine, jobs, laws, limit), limit * (len(jobs) + 1), quiet=False
    )
    if word == "ok":
        return answer
    gone = dataclasses.replace(
        jobs[0].row,
        scene="",
        problem="",
        setting="",
        options="",
        step_s="",
        command="",
        status="absent",
        note=say.plain(answer)[:200],
    )
    show(gone)
    return [gone]


# ---- our own ----------------------------------------------------------------------------------


def own_row(binary: str, job: Job, laws: list[str], limit: float) -> rows.Row:
    try:
        found, times, count, status, command = ours.run(
            binary, job.row.problem, job.scene, job.options, job.step, limit, REPEATS, TIMED
        )
    except scene.Unsupported as reason:
        return settled(job, "unsupported", reason)
    except TimeoutError as late:
        return settled(job, "timeout", late)
    job.row = dataclasses.replace(job.row, command=f"lcpbench {command}")
    return dataclasses.replace(judged(job, found, times, laws, status), repeats=str(count))


def own_rows(binary: str, jobs: list[Job], laws: list[str], limit: float) -> list[rows.Row]:
    out = []
    for job in jobs:
        out.append(job.row if job.scene is None else own_row(binary, job, laws, limit))
        show(out[-1])
    return out


# ---- the campaign -----------------------------------------------------------------------------


def own_version(binary: str) -> str:
    told = subprocess.run([binary, "--version"], capture_output=True, text=True, check=True)
    at = subprocess.run(
        ["git", "-C", ROOT, "rev-parse", "--short", "HEAD"],
        capture_output=True,
        text=True,
        check=False,
    )
    return " ".join(filter(None, [told.stdout.strip().partition(" ")[2], at.stdout.strip()]))


def called(entry: dict) -> str:
    """A scene is called as the file, or the part before its parameters."""
    return pathlib.Path(entry["scene"].partition(":")[0]).stem


def own(text: str) -> str:
    """A scene of the user's: a file by its whole name, otherwise as lcpbench takes it."""
    path = pathlib.Path(text)
    return str(path.resolve()) if path.exists() else text


def label(way: dict) -> str:
    return f"{way['formulation']} + {way['solver']}"


class Campaign:
    """What is asked for, from the command line and experiments.toml."""

    def __init__(self, args: argparse.Namespace) -> None:
        self.plan = experiments.of("engines")
        self.binary = args.binary
        self.quick = args.quick
        known = [*dict.fromkeys(s["engine"] for s in self.plan["settings"]), OWN]
        self.engines = wanted(args.engines, known, "engine")
        self.given = bool(args.own)
        entries = [{"scene": own(t)} for t in args.own] or self.plan["entries"]
        self.names = wanted(args.scenes, [called(s) for s in entries], "scene")
        self.entries = [s for s in entries if called(s) in self.names]
        settings = [s["name"] for s in self.plan["settings"]]
        self.settings = wanted(args.settings, list(dict.fromkeys(settings)), "setting")
        self.all_settings = not args.settings
        steps = self.plan["quick_steps" if args.quick else "steps"]
        self.steps = [float(s) for s in args.steps.split(",")] if args.steps else steps
        self.limit = self.plan["quick_limit_s" if args.quick else "limit_s"]
        self.laws = self.plan["judged"]["formulations"]
        self.start = rows.Row(
            cpu=processor(),
            started_utc=datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        )
        self.scenes: dict[str, scene.Scene | str] = {}

    def load(self, text: str) -> scene.Scene | str:
        """The scene, or why it cannot be given to any engine."""
        path = text if "/" not in text else str(ROOT / text)
        if text not in self.scenes:
            try:
                self.scenes[text] = scene.load(self.binary, path)
            except scene.Unsupported as reason:
                self.scenes[text] = str(reason)
        return self.scenes[text]

    def job(self, entry: dict, engine: str, setting: dict, step: float) -> Job:
        planar = engine in self.plan["planar"] and "planar" in entry
        text = (entry["planar"] if planar else entry)["scene"]
        loaded = self.load(text)
        options = setting["options"] if engine != OWN else setting
        told = ",".join(f"{k}={v}" for k, v in options.items()) if engine != OWN else ""
        name = setting["name"] if engine != OWN else label(setting)
        chosen = shlex.quote(text) if self.given else f"--scenes {called(entry)}"
        again = (
            f"scripts/engines --engines {engine} --settings {shlex.quote(name)} --steps {step:g}"
            f" {chosen}"
        )
        row = dataclasses.replace(
            self.start,
            scene=called(entry),
            problem=text,
            engine=engine,
            setting=name,
            options=told,
            step_s=f"{step:g}",
            command=again,
        )
        if isinstance(loaded, str):
            row = dataclasses.replace(row, status="unsupported", note=loaded)
            return Job(row, None, options, step, entry.get("rests"))
        return Job(row, loaded, options, step, entry.get("rests"))

    def jobs(self, engine: str) -> list[Job]:
        if engine == OWN:
            ways = self.plan["own"]
        else:
            ways = [
                s
                for s in self.plan["settings"]
                if s["engine"] == engine
                and s["name"] in self.settings
                and (not self.quick or s.get("quick", True) or not self.all_settings)
            ]
        return [self.job(e, engine, w, h) for e in self.entries for w in ways for h in self.steps]

    def run(self) -> list[rows.Row]:
        out = []
        for engine in self.engines:
            jobs = self.jobs(engine)
            if not jobs:
                continue
            if engine == OWN:
                told = own_version(self.binary)
                for job in jobs:
                    job.row = dataclasses.replace(job.row, version=told)
                out += own_rows(self.binary, jobs, self.laws, self.limit)
            else:
                out += engine_rows(engine, jobs, self.laws, self.limit)
        order = {name: i for i, name in enumerate(self.names)}
        return sorted(
            out, key=lambda r: order.get(r.scene, -1)
        )  # stable: engines as they are asked


def arguments() -> argparse.Namespace:
    ask = say.Arguments(prog="scripts/engines", description=__doc__.partition(" - ")[2])
    ask.add_argument("--quick", action="store_true", help="two steps and fewer settings")
    for name, what in (
        ("engines", "engines"),
        ("scenes", "scenes"),
        ("settings", "settings"),
        ("steps", "time steps [s]"),
    ):
        ask.add_argument(f"--{name}", metavar="LIST", help=f"{what}, with commas between them")
    ask.add_argument(
        "own",
        metavar="SCENE",
        nargs="*",
        help="scenes of one's own, as lcpbench takes them, for those of experiments.toml",
    )
    ask.add_argument("--binary", default=str(ROOT / "build" / "lcpbench"), help="lcpbench")
    ask.add_argument(
        "--out",
        metavar="DIR",
        default="engines",
        help="folder of engines.csv, whose rows of the same work are replaced",
    )
    return ask.parse_args()


def main() -> int:
    args = arguments()
    if not os.access(args.binary, os.X_OK):
        say.complain(f"engines: {args.binary}: no program there: build it, or say --binary")
        return 2
    path = pathlib.Path(args.out) / rows.FILE
    try:
        old = rows.read(path) if path.exists() else []
    except ValueError as reason:
        say.complain(reason)
        return 2
    pinned()
    began = time.monotonic()
    found = Campaign(args).run()
    rows.write(rows.merged(old, found), path.parent)
    good = sum(r.status == "ok" for r in found)
    print(f"{path}: {len(found)} rows, {good} ok, in {time.monotonic() - began:.0f} s")
    return 0 if good else 3


if __name__ == "__main__":
    sys.exit(main())

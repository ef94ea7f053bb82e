"""bisect BINARY DIR [--quick] - the hardest rung at which each combination still stands, by
bisection."""

import csv
import dataclasses
import hashlib
import json
import math
import pathlib
import shlex
import subprocess
import sys
from collections.abc import Iterator

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from bench import binary as asked  # noqa: E402
from bench import experiments, registry, say, stability
from bench.section import Cell, Table  # noqa: E402

COLUMNS = [
    "build",
    "quick",
    "stressor",
    "formulation",
    "solver",
    "stands",
    "fails",
    "word",
    "reason",
    "probes",
    "command",
]
CLOSE = 1.1  # bisection ends at this ratio between what stands and what does not


@dataclasses.dataclass
class Stressor:
    name: str
    problem: str  # {} is the value
    start: float  # mild end
    end: float  # where the ladder is given up: "stands to the end"
    step: str = "0.01"
    formulation: str = "{form}"  # {form} or one formulation's options with {}
    whole: bool = False  # integers only

    def only(self) -> str:
        """The formulation whose options it turns up; empty: any."""
        return "" if self.formulation == "{form}" else self.formulation.partition(":")[0]

    def command(self, form: str, solver: str, value: float) -> list[str]:
        text = f"{value:.0f}" if self.whole else f"{value:.4g}"
        put = [
            t.replace("{form}", form).replace("{}", text)
            for t in (self.problem, self.formulation, self.step)
        ]
        return ["simulate", put[0], "--formulation", put[1], "--solver", solver, "--step", put[2]]


def stressors() -> list[Stressor]:
    """The stressors of scripts/experiments.toml."""
    return [
        Stressor(
            s["name"],
            s["scene"],
            s["from"],
            s["to"],
            s.get("step", "0.01"),
            s.get("formulation", "{form}"),
            s.get("whole", False),
        )
        for s in experiments.of("bisect.stressors")
    ]


def as_cell(answer: dict, stressor: Stressor, form: str) -> dict:
    """What stability.word reads, from the JSON object of `simulate`."""
    bad = [p for p in answer["predictions"] if not p["ok"]]

    def text(p: dict):
        error, tolerance = p["error"], p["tolerance"]
        times = error / tolerance if error is not None and tolerance else math.inf
        return f"{p['quantity']}{' = 0' if p['predicted'] == 0 else ''} {times:.2g}x"

    return {
        "status": answer["status"],
        "verified": answer["verified"],
        "note": answer["note"],
        "part": stressor.name,
        "problem": stressor.problem,
        "formulation": form,
        "n_predictions_missed": len(bad),
        "missed": ", ".join(map(text, bad[:3])),
        "penetration_m": answer["penetration_max_m"] or 0.0,
        "approach_m": answer["approach_max_m"] or 0.0,
    }


class Probe:
    def __init__(
        self, binary: str, stressor: Stressor, form: str, solver: str, limit: float
    ) -> None:
        self.binary, self.stressor, self.form, self.solver, self.limit, self.count = (
            binary,
            stressor,
            form,
            solver,
            limit,
            0,
        )

    def __call__(self, value: float) -> tuple[str, str, str]:
        """(word, reason, command) of one run."""
        self.count += 1
        args = self.stressor.command(self.form, self.solver, value)
        command = "lcpbench " + " ".join(shlex.quote(a) for a in args)
        try:
            done = subprocess.run(
                [self.binary, *args],
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=self.limit,
            )
        except subprocess.TimeoutExpired:
            return "time-out", f"not finished within {self.limit:g} s", command
        if done.returncode < 0:
            return "dies", f"killed by signal {-done.returncode}", command
        if not done.stdout.strip():
            return (
                "not defined" if done.returncode == 2 else "dies",
                done.stderr.strip()[:200] or f"no result, exit code {done.returncode}",
                command,
            )
        return (
            *stability.word(as_cell(json.loads(done.stdout), self.stressor, self.form)),
            command,
        )


def bisect(probe: Probe) -> dict:
    """From the mild end by factors of ten to the first value that does not stand, then by halving
    the exponent."""
    s = probe.stressor
    factor = (2.0 if s.whole else 10.0) ** (1 if s.end > s.start else -1)
    low, value, high = None, s.start, None
    while high is None:
        found = probe(value)
        if found[0] == "not defined" and low is None:
            return {
                "stands": "",
                "fails": "",
                "word": "not defined",
                "reason": found[1],
                "command": found[2],
            }
        if found[0] != "stands":
            high, last = value, found
        elif value == s.end:
            return {
                "stands": value,
                "fails": "",
                "word": "stands",
                "reason": "to the end of the ladder",
                "command": found[2],
            }
        else:
            low, value = value, (min if factor > 1 else max)(value * factor, s.end)
    while (
        low is not None
        and max(low / high, high / low) > CLOSE
        and not (s.whole and abs(high - low) <= 1)
    ):
        mid = math.sqrt(low * high)
        mid = float(min(max(round(mid), low + 1), high - 1)) if s.whole else float(f"{mid:.3g}")
        if mid in (low, high):
            break
        found = probe(mid)
        if found[0] == "stands":
            low = mid
        else:
            high, last = mid, found
    return {
        "stands": "" if low is None else low,
        "fails": high,
        "word": last[0],
        "reason": last[1],
        "command": last[2],
    }


def work(quick: bool) -> Iterator[tuple[Stressor, str, str]]:
    """Every formulation with every solver; one that poses no problem only once."""
    solvers = registry.solvers()
    every = [
        (f, s)
        for f in registry.formulations()
        for s in (solvers if registry.uses_solver(f) else solvers[:1])
    ]
    for form, solver in (
        [experiments.way(e) for e in experiments.of("bisect.quick")] if quick else every
    ):
        for stressor in stressors():
            if stressor.only() in ("", form):
                yield stressor, form, solver


def load(path: pathlib.Path) -> list[dict[str, str]]:
    if not path.exists():
        return []
    with open(path, newline="") as f:
        return list(csv.DictReader(f))


def number(text: str | None, whole: bool = False) -> str:
    return "" if text in ("", None) else f"{float(text):.0f}" if whole else f"{float(text):.2g}"


def table(rows: list[dict[str, str]]) -> Table:
    """Combinations against stressors: the last value that stands, and the word of the first that
    does not."""
    names = list(dict.fromkeys(r["stressor"] for r in rows))
    whole = {s.name for s in stressors() if s.whole}
    only = {s.name: s.only() for s in stressors()}
    body = []
    for form, solver in dict.fromkeys((r["formulation"], r["solver"]) for r in rows):
        line = [
            Cell(form, look=form),
            Cell(solver, look=solver) if registry.uses_solver(form) else "none (integrator)",
        ]
        for name in names:
            found = [
                r
                for r in rows
                if (r["formulation"], r["solver"], r["stressor"]) == (form, solver, name)
            ]
            if not found:
                lacks = only.get(name, "") not in ("", form)
                line.append(Cell("not defined: no such option" if lacks else "not run", "none"))
                continue
            r = found[0]
            if r["word"] == "not defined":
                line.append(Cell("not defined: " + r["reason"], "none"))
            elif r["word"] == "stands":
                line.append(
                    Cell(
                        f"{number(r['stands'], name in whole)}, the end of the ladder",
                        "good",
                        r["command"],
                        float(r["stands"]),
                    )
                )
            else:
                text = (
                    f"{number(r['stands'], name in whole) or 'none'}; at"
                    f" {number(r['fails'], name in whole)} {r['word']}"
                )
                line.append(
                    Cell(
                        text,
                        "" if r["stands"] else "bad",
                        f"{r['reason']}\n{r['command']}",
                        float(r["stands"] or 0),
                    )
                )
        body.append(line)
    return Table(
        "limits",
        f"How far each stressor can be turned up: the last value that stands and, within {CLOSE:g}"
        " times that, the first that does not and what it does (bisection; lcpbench simulate at"
        " each value).",
        ["formulation", "solver"] + names,
        body,
        paper=False,
    )


def main() -> int:
    parser = say.Arguments(prog="scripts/bisect", description=__doc__)
    parser.add_argument("binary", metavar="BINARY", help="the lcpbench that is asked")
    parser.add_argument("folder", metavar="DIR", help="where limits.csv is or will be")
    parser.add_argument("--quick", action="store_true", help="ten combinations, 0.5 s a run")
    args = parser.parse_args()
    binary = pathlib.Path(args.binary)
    if not binary.exists():
        say.complain(f"scripts/bisect: {binary}: no such file")
        return 2
    asked.LCPBENCH = str(binary)  # whose components are tried
    path = pathlib.Path(args.folder) / "limits.csv"
    path.parent.mkdir(parents=True, exist_ok=True)
    build = hashlib.sha256(binary.read_bytes()).hexdigest()[:12]
    mode = "true" if args.quick else "false"
    kept = [r for r in load(path) if r["build"] == build and r["quick"] == mode]
    done = {(r["stressor"], r["formulation"], r["solver"]) for r in kept}
    with open(path, "w", newline="") as to:
        out = csv.DictWriter(to, COLUMNS, lineterminator="\n")
        out.writeheader()
        out.writerows(kept)
        for stressor, form, solver in work(args.quick):
            if (stressor.name, form, solver) in done:
                continue
            probe = Probe(str(binary), stressor, form, solver, 0.5 if args.quick else 20.0)
            row = bisect(probe)
            out.writerow(
                {
                    "build": build,
                    "quick": mode,
                    "stressor": stressor.name,
                    "formulation": form,
                    "solver": solver,
                    "probes": probe.count,
                    **row,
                }
            )
            to.flush()
    print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())

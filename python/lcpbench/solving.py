"""Solving, judging, simulating."""

from __future__ import annotations

import ctypes
import dataclasses
import json
import os
import pathlib
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any  # of JSON

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from lcpbench import _core, _program
from lcpbench.errors import InvalidInput, LcpbenchError, NotSolved, Unsupported
from lcpbench.problems import Cone, Problem, Sparse, _doubles, _vector, read

TOLERANCE = 1e-9  # of the judge, as the exact solvers are held to
ITERATIVE = 1e-6  # as the iterative ones are
Source = Problem | str | os.PathLike | Sparse | ArrayLike


@dataclasses.dataclass(frozen=True)
class Verdict:
    """What the judge finds in z, from the data alone. Residuals are inf where z is not finite."""

    verified: bool
    tolerance: float  # rho that counts as verified [1]
    rho: float  # the residual that decides; no scaling of rows, columns or q changes it [1]
    natural: float  # max |min(M_ii z_i, w_i)|, and its like for other sets [m/s]
    natural_relative: float  # over 1 + max |q| [1]
    min_map: float  # max |min(z_i, w_i)|
    infeasible_z: float  # largest violation of z in K [N s]
    infeasible_w: float  # largest violation of w in K* [m/s]
    complementarity: float  # sum |z_i w_i| [J]

    def __bool__(self) -> bool:
        return self.verified


@dataclasses.dataclass(frozen=True)
class Solution:
    """An answer with the verdict on it."""

    z: np.ndarray
    solver: str
    status: str  # verdict: "ok", "near", "max_iter", "ray", "infeasible", "unverified", ...
    claim: str  # what the solver said
    verdict: Verdict
    iterations: int
    matvecs: int
    factorizations: int
    setup_seconds: float
    solve_seconds: float

    @property
    def verified(self) -> bool:
        return self.verdict.verified


def _verdict(r: _core.Report) -> Verdict:
    names = [f.name for f in dataclasses.fields(Verdict)]
    return Verdict(**{k: getattr(r, k) for k in names} | {"verified": bool(r.verified)})


def _solution(z: np.ndarray, r: _core.Report) -> Solution:
    texts = {k: getattr(r, k).decode() for k in ("solver", "status", "claim")}
    counts = ("iterations", "matvecs", "factorizations", "setup_seconds", "solve_seconds")
    return Solution(z=z, verdict=_verdict(r), **texts, **{k: getattr(r, k) for k in counts})


def _problem(
    M: Source,
    q: ArrayLike | None,
    lo: ArrayLike | None,
    hi: ArrayLike | None,
    cones: Sequence[Cone],
) -> Problem:
    """M is a matrix, a Problem, or the name of a file."""
    whole = isinstance(M, (Problem, str, os.PathLike))
    if not whole:
        if q is None:
            raise InvalidInput("q is missing")
        return Problem(M, q, lo=lo, hi=hi, cones=cones)
    if lo is not None or hi is not None or cones or (q is not None and isinstance(M, Problem)):
        raise InvalidInput("q, lo, hi, cones: a problem or a file has its own")
    return M if isinstance(M, Problem) else read(M, q)  # q: the file of a Matrix Market vector


def solve(
    M: Source,
    q: ArrayLike | None = None,
    solver: str | None = None,
    *,
    lo: ArrayLike | None = None,
    hi: ArrayLike | None = None,
    cones: Sequence[Cone] = (),
    z0: ArrayLike | None = None,
    check: bool = True,
) -> Solution:
    """Solves a problem (Problem has the arguments; M may also be one, or the name of a file).

    solver: "NAME" or "NAME:option=value,..." (solvers() lists them); None takes the first of lemke,
    cone_newton, pgs that can. z0: the start point, for solvers that are warm. NotSolved where there
    is no verified answer; with check=False the Solution comes back whatever its status. Unsupported
    where the solver does not take this kind of problem; InvalidInput for what is no problem.
    """
    p = _problem(M, q, lo, hi, cones)
    start = _vector(z0, p.n, "z0")
    z = np.zeros(p.n) if start is None else start.copy()
    r = _core.Report()
    name = None if solver is None else str(solver).encode()
    code = _core.lib.lcp_solve(p.handle, name, _doubles(z), ctypes.byref(r))
    if code not in (_core.OK, _core.UNSOLVED):
        raise _core.failure(code)
    solution = _solution(z, r)
    if code == _core.UNSOLVED and check:
        raise NotSolved(_core.lib.lcp_last_error().decode(errors="replace"), solution)
    return solution


def judge(
    M: Source,
    q: ArrayLike | None = None,
    z: ArrayLike | None = None,
    *,
    lo: ArrayLike | None = None,
    hi: ArrayLike | None = None,
    cones: Sequence[Cone] = (),
    tolerance: float = TOLERANCE,
) -> Verdict:
    """The verdict on any z, wherever it is from; of a Problem or a file judge(problem, z=z)."""
    p = _problem(M, q, lo, hi, cones)
    if z is None:
        raise InvalidInput("z is missing")
    r = _core.Report()
    code = _core.lib.lcp_verify(
        p.handle, _doubles(_vector(z, p.n, "z")), float(tolerance), ctypes.byref(r)
    )
    if code not in (_core.OK, _core.UNSOLVED):
        raise _core.failure(code)
    return _verdict(r)


def verify(
    M: Source,
    q: ArrayLike | None = None,
    z: ArrayLike | None = None,
    *,
    lo: ArrayLike | None = None,
    hi: ArrayLike | None = None,
    cones: Sequence[Cone] = (),
    tolerance: float = TOLERANCE,
) -> bool:
    """Does z solve the problem? judge() has the arguments, and says how far it is from that."""
    return judge(M, q, z, lo=lo, hi=hi, cones=cones, tolerance=tolerance).verified


Solver = str | Callable[[np.ndarray | Sparse, np.ndarray], ArrayLike]


def _attempt(p: Problem, solver: Solver, tolerance: float) -> dict:
    """One row of a study: the answer of a solver of the library or of Python, judged alike."""
    began = time.perf_counter()
    try:
        if callable(solver):
            z = solver(p.M.copy(), p.q.copy())
        else:
            found = solve(p, solver=solver, check=False)
    except Unsupported as why:
        return {"status": "unsupported", "verified": False, "note": str(why)}
    except Exception as why:
        if not callable(solver):
            raise
        return {"status": "error", "verified": False, "note": f"{type(why).__name__}: {why}"}
    seconds = time.perf_counter() - began
    if not callable(solver):
        status, verdict, iterations = found.status, found.verdict, found.iterations
    else:
        try:
            verdict = judge(p, z=z, tolerance=tolerance)
        except LcpbenchError as why:  # z is no vector of numbers
            return {"status": "error", "verified": False, "note": str(why)}
        status, iterations = "ok" if verdict else "unverified", None
    out = {"status": status, "verified": verdict.verified, "rho": verdict.rho, "time_s": seconds}
    return out | {"iterations": iterations, "note": ""}


def study(
    problems: Mapping[str, Any] | Sequence[Any],
    solvers: Mapping[str, Solver] | Sequence[Solver],
    *,
    tolerance: float = ITERATIVE,
) -> pd.DataFrame:
    """Every solver on every problem: problem, solver, status, verified, rho, time_s, iterations,
    note.

    A solver is a name with options, or a function of (M, q) that returns z: it is judged as all
    others are (tolerance: the rho that it is held to), and what it raises is its row. Times are
    wall times of one call; campaigns (`lcpbench run`) measure."""
    named = problems if isinstance(problems, Mapping) else {str(p): p for p in problems}
    using = (
        solvers
        if isinstance(solvers, Mapping)
        else {s if isinstance(s, str) else s.__name__: s for s in solvers}
    )
    columns = ["problem", "solver", "status", "verified", "rho", "time_s", "iterations", "note"]
    rows = []
    for problem, source in named.items():
        p = source if isinstance(source, Problem) else read(source)
        for name, solver in using.items():
            rows.append({"problem": problem, "solver": name, **_attempt(p, solver, tolerance)})
    frame = pd.DataFrame(rows, columns=columns)
    frame["iterations"] = frame["iterations"].astype("Int64")
    frame.attrs["units"] = {"rho": "1", "time_s": "s", "iterations": "1"}
    return frame


def simulate(
    scene: str | os.PathLike | Mapping[str, Any],
    formulation: str | None = None,
    solver: str | None = None,
    *,
    step: float | None = None,
    duration: float | None = None,
    trajectory: bool = False,
    check: bool = True,
    **options: object,
) -> dict[str, Any]:
    """Runs a scene: a name with parameters ("stack:n=3"), a file, or a dict as of a file
    (docs/FORMATS.md, 2).

    formulation, solver: "NAME:option=value,...". step, duration [s]: the scene's where None.
    options: any other option of `lcpbench simulate` (contact_order="random:3"; error=0.01, which
    alone chooses formulation, solver and steps). Returns its JSON
    object; with trajectory=True also "trajectory", a DataFrame. NotSolved where a step was not
    solved or not verified (check=False: not raised); a prediction that is missed stands in
    "predictions"."""
    stdin, words = "", [scene]
    if isinstance(scene, Mapping):
        try:
            stdin, words = json.dumps(scene), ["-"]
        except (TypeError, ValueError) as why:
            raise InvalidInput(f"scene: no JSON: {why}") from None
    given = {
        "formulation": formulation,
        "solver": solver,
        "step": step,
        "duration": duration,
        **options,
    }
    for name, value in given.items():
        if value is not None:
            words += ["--" + name.replace("_", "-"), value]
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "trajectory.csv"
        if trajectory:
            words += ["--trajectory", file]
        result = json.loads(_program.run("simulate", *words, stdin=stdin))
        if trajectory:
            result["trajectory"] = pd.read_csv(
                file, dtype={"name": str}, keep_default_na=False, na_values={"word": [""]}
            )
    if check and not (result["status"] == "ok" and result["verified"]):
        line = f"{result['scene']}: {result['status']}: {result['note'] or 'not verified'}"
        raise NotSolved(line, result)
    return result

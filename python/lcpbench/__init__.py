"""Complementarity problems of contact, solved and judged; scenes simulated; rows read and drawn.

    find z, w in R^n:   w = M z + q,   z in K,   w in K*,   z _|_ w

Every answer is judged from the data alone, by code that shares no arithmetic with the solvers.

    solve(M, q)         a Solution, or NotSolved with what there is of one
    judge(M, q, z)      a Verdict on any z, wherever it is from
    verify(M, q, z)     the same as a question
    study(problems, solvers)    a table; a solver is a name, or a function of (M, q)
    read(path)          a Problem from .npz, .mtx, or what the program exports
    simulate(scene, formulation, solver)    a run of a scene, a dict or a file
    load(folder)        measured rows as a DataFrame
    profile(folder)     a performance profile as a table; plot.* draws
"""

from lcpbench import figures as plot
from lcpbench._core import api_version, solvers, version
from lcpbench.errors import InvalidInput, LcpbenchError, NotSolved, Unsupported
from lcpbench.problems import Problem, read
from lcpbench.rows import load, profile
from lcpbench.solving import Solution, Verdict, judge, simulate, solve, study, verify

__version__ = version()
__all__ = [
    "InvalidInput",
    "LcpbenchError",
    "NotSolved",
    "Problem",
    "Solution",
    "Unsupported",
    "Verdict",
    "api_version",
    "judge",
    "load",
    "plot",
    "profile",
    "read",
    "simulate",
    "solve",
    "solvers",
    "study",
    "verify",
    "version",
]

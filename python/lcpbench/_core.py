"""The C library by ctypes: include/lcpbench/lcpbench.h, in its order."""

from __future__ import annotations

import ctypes
import pathlib
from ctypes import POINTER, Structure, c_char_p, c_double, c_int, c_long, c_void_p

import pandas as pd

from lcpbench.errors import InvalidInput, LcpbenchError, Unsupported

API = 1  # LCP_API_VERSION that the structs below are those of
OK, INVALID, NO_MEMORY, IO, UNSUPPORTED, EXTERNAL, UNSOLVED = range(7)

_doubles = POINTER(c_double)
_ints = POINTER(c_int)


class Report(Structure):
    _fields_ = [
        ("solver", c_char_p),
        ("status", c_char_p),
        ("claim", c_char_p),
        ("verified", c_int),
        ("tolerance", c_double),
        ("rho", c_double),
        ("natural", c_double),
        ("natural_relative", c_double),
        ("min_map", c_double),
        ("infeasible_z", c_double),
        ("infeasible_w", c_double),
        ("complementarity", c_double),
        ("iterations", c_long),
        ("matvecs", c_long),
        ("factorizations", c_long),
        ("setup_seconds", c_double),
        ("solve_seconds", c_double),
    ]


class SolverInfo(Structure):
    _fields_ = [
        *((name, c_char_p) for name in ("name", "title", "words", "when")),
        *((name, c_int) for name in ("bounds", "free_rows", "cones", "exact", "warm", "n_option")),
    ]


lib = ctypes.CDLL(str(pathlib.Path(__file__).resolve().parent / "_lcpbench.so"))
for _name, _result, *_arguments in (
    ("lcp_version", c_char_p),
    ("lcp_api_version", c_int),
    ("lcp_last_error", c_char_p),
    ("lcp_problem_dense", c_void_p, c_int, _doubles, c_int, _doubles),
    ("lcp_problem_csc", c_void_p, c_int, _ints, _ints, _doubles, _doubles),
    ("lcp_problem_set_bounds", c_int, c_void_p, _doubles, _doubles),
    ("lcp_problem_set_cones", c_int, c_void_p, c_int, _ints, _ints, _doubles),
    ("lcp_problem_declare", c_int, c_void_p, c_char_p),
    ("lcp_problem_free", None, c_void_p),
    ("lcp_solve", c_int, c_void_p, c_char_p, _doubles, POINTER(Report)),
    ("lcp_verify", c_int, c_void_p, _doubles, c_double, POINTER(Report)),
    ("lcp_solver_count", c_int),
    ("lcp_solver_describe", c_int, c_int, POINTER(SolverInfo)),
):
    getattr(lib, _name).restype = _result
    getattr(lib, _name).argtypes = _arguments
if lib.lcp_api_version() != API:
    raise ImportError(f"_lcpbench.so: API version {lib.lcp_api_version()}, need {API}")


def failure(code: int) -> LcpbenchError:
    """The exception of a code, with the library's line."""
    line = lib.lcp_last_error().decode(errors="replace")
    kind = {INVALID: InvalidInput, UNSUPPORTED: Unsupported}.get(code, LcpbenchError)
    return kind(line)


def check(code: int) -> None:
    if code != OK:
        raise failure(code)


def version() -> str:
    """Release of the library, such as "0.1.0"."""
    return lib.lcp_version().decode()


def api_version() -> int:
    """Grows when the C interface changes."""
    return lib.lcp_api_version()


def solvers() -> pd.DataFrame:
    """The solvers, one a row, by name: title, words (what it is), when (to take it), and whether it
    takes bounds, free rows and cones, is exact, and uses a start point."""
    info, rows = SolverInfo(), []
    for i in range(lib.lcp_solver_count()):
        check(lib.lcp_solver_describe(i, ctypes.byref(info)))
        texts = {k: getattr(info, k).decode() for k in ("name", "title", "words", "when")}
        flags = ("bounds", "free_rows", "cones", "exact", "warm")
        rows.append(texts | {k: bool(getattr(info, k)) for k in flags})
    return pd.DataFrame(rows).set_index("name")

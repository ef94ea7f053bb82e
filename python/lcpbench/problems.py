"""Complementarity problems from arrays and files."""

from __future__ import annotations

import ctypes
import os
import pathlib
import tempfile
import weakref
from collections.abc import Sequence

import numpy as np
import scipy.io
import scipy.sparse
from numpy.typing import ArrayLike

from lcpbench import _core, _program
from lcpbench.errors import InvalidInput

Cone = tuple[int, int, float]  # first row, rows (1, 2 or 3), coefficient of friction
Sparse = scipy.sparse.spmatrix | scipy.sparse.sparray


def _doubles(x: np.ndarray | None) -> object:
    return None if x is None else x.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def _ints(x: np.ndarray) -> object:
    return x.ctypes.data_as(ctypes.POINTER(ctypes.c_int))


def _unmasked(x: object, name: str) -> None:
    """An array would have the numbers behind the mask."""
    if np.ma.is_masked(x):
        raise InvalidInput(f"{name}: has {np.ma.count_masked(x)} masked entries, need numbers")


def _integers(x: Sequence[float], name: str) -> np.ndarray:
    """Those of C, not what is left of others."""
    out = np.asarray(x)
    largest = np.iinfo(np.int32).max
    real = out.astype(float) if out.dtype.kind in "iuf" else np.array([np.nan])
    if not (np.abs(real) <= largest).all() or (real != np.floor(real)).any():
        raise InvalidInput(f"{name}: need integers, not {', '.join(map(str, x))}")
    return out.astype(np.int32)


def _vector(x: ArrayLike | None, n: int, name: str) -> np.ndarray | None:
    """n numbers, also of a column or a row."""
    if x is None:
        return None
    _unmasked(x, name)
    try:
        out = np.asarray(x, dtype=float)
    except (TypeError, ValueError) as why:
        raise InvalidInput(f"{name}: need real numbers ({why})") from None
    if out.size != n or max(out.shape, default=1) != out.size:
        raise InvalidInput(f"{name}: has the shape {out.shape}, need a vector of {n}")
    return np.ascontiguousarray(out.reshape(n))


class Problem:
    """find z, w: w = M z + q, z in K, w in K*, z _|_ w.

    M: n x n, an array or any sparse matrix of scipy (kept as csc). q: n. lo, hi: n, bounds of z,
    with infinities where there are none; z >= 0 without. cones: (first row, rows, mu) of each
    friction cone |r_t| <= mu r_n under the exact Coulomb law; lo and hi have no bound there.
    InvalidInput where shapes or numbers are not those of a problem. The arrays are copied.
    """

    def __init__(
        self,
        M: ArrayLike | Sparse,
        q: ArrayLike,
        *,
        lo: ArrayLike | None = None,
        hi: ArrayLike | None = None,
        cones: Sequence[Cone] = (),
    ) -> None:
        sparse = scipy.sparse.issparse(M)
        _unmasked(M, "M")
        try:
            M = M if sparse else np.asarray(M)
        except ValueError as why:  # rows of different lengths
            raise InvalidInput(f"M: {why}") from None
        shape = M.shape
        if len(shape) != 2 or shape[0] != shape[1]:
            raise InvalidInput(f"M: has the shape {tuple(shape)}, need a square matrix")
        if M.dtype.kind not in "fiub" or np.iscomplexobj(q):
            raise InvalidInput(f"M, q: need real numbers, not {M.dtype}")
        self.n = int(shape[0])
        self.q = _vector(q, self.n, "q")
        self.lo, self.hi = _vector(lo, self.n, "lo"), _vector(hi, self.n, "hi")
        self.cones = tuple(cones)
        if sparse:
            handle = self._from_sparse(M)
        else:
            self.M = np.array(M, dtype=float, order="C")
            handle = _core.lib.lcp_problem_dense(self.n, _doubles(self.M), 1, _doubles(self.q))
        if not handle:
            raise _core.failure(_core.INVALID)
        self.handle = handle
        weakref.finalize(self, _core.lib.lcp_problem_free, handle)
        if lo is not None or hi is not None:
            _core.check(
                _core.lib.lcp_problem_set_bounds(handle, _doubles(self.lo), _doubles(self.hi))
            )
        if self.cones:
            self._set_cones()

    def _from_sparse(self, M: Sparse) -> int | None:
        self.M = scipy.sparse.csc_array(M, dtype=float, copy=True)
        self.M.sum_duplicates()  # sorts, too
        if self.M.nnz > np.iinfo(np.int32).max:
            raise InvalidInput(f"M: has {self.M.nnz} entries, need less than 2^31")
        colptr = np.ascontiguousarray(self.M.indptr, dtype=np.int32)
        rowind = np.ascontiguousarray(self.M.indices, dtype=np.int32)
        val = np.ascontiguousarray(self.M.data)
        return _core.lib.lcp_problem_csc(
            self.n, _ints(colptr), _ints(rowind), _doubles(val), _doubles(self.q)
        )

    def _set_cones(self) -> None:
        try:
            start, size, mu = zip(*self.cones, strict=True)
        except (TypeError, ValueError):
            raise InvalidInput("cones: need (first row, rows, mu) of each") from None
        starts, sizes = _integers(start, "cones: first row"), _integers(size, "cones: rows")
        mus = np.array(mu, dtype=float)
        _core.check(
            _core.lib.lcp_problem_set_cones(
                self.handle, len(mus), _ints(starts), _ints(sizes), _doubles(mus)
            )
        )
        for name, bound, free in (("lo", self.lo, -np.inf), ("hi", self.hi, np.inf)):
            for first, rows in zip(starts, sizes, strict=True):
                if bound is not None and (bound[first : first + rows] != free).any():
                    raise InvalidInput(
                        f"{name}: a cone has the rows {first} to {first + rows - 1}, need"
                        f" {free} there, no bound"
                    )

    def declare(self, trait: str) -> None:
        """What the caller knows of M: symmetric, psd, pd, copositive, copositive_plus, p_matrix.
        Some solvers ask for it; no answer is believed for it."""
        _core.check(_core.lib.lcp_problem_declare(self.handle, trait.encode()))

    def __repr__(self) -> str:
        kind = "sparse" if scipy.sparse.issparse(self.M) else "dense"
        return f"Problem(n={self.n}, {kind}, {len(self.cones)} cones)"


def _npz(path: pathlib.Path) -> Problem:
    """docs/FORMATS.md, 9."""
    known = {"q", "lo", "hi", "M", "data", "indices", "indptr", "row", "col", "shape", "format"}
    try:
        with np.load(path, allow_pickle=False) as file:
            a = {name: file[name] for name in file.files}
    except (OSError, ValueError, EOFError) as why:
        raise InvalidInput(f"{path}: {str(why).splitlines()[0]}") from None
    except Exception as why:  # zipfile.BadZipFile, zlib.error
        raise InvalidInput(f"{path}: damaged: {why}") from None
    strange = sorted(set(a) - known)
    if strange:
        what = "need M (or the parts of a sparse matrix), q, lo, hi"
        raise InvalidInput(f"{path}: {strange[0]}: {what}")
    if "q" not in a or ("M" in a) == ("data" in a):
        raise InvalidInput(f"{path}: need q, and M or the parts of a sparse matrix")
    M = a.get("M")
    if M is None:
        try:
            form = str(np.asarray(a["format"]).astype(str))
            shape = tuple(int(n) for n in a["shape"])
            parts = (
                (a["data"], (a["row"], a["col"]))
                if form == "coo"
                else (a["data"], a["indices"], a["indptr"])
            )
            M = {
                "csc": scipy.sparse.csc_array,
                "csr": scipy.sparse.csr_array,
                "coo": scipy.sparse.coo_array,
            }[form](parts, shape=shape)
        except (KeyError, ValueError, TypeError) as why:
            raise InvalidInput(f"{path}: no sparse matrix: {why}") from None
    return Problem(M, a["q"], lo=a.get("lo"), hi=a.get("hi"))


def _mtx(path: pathlib.Path, q: str | os.PathLike | None) -> Problem:
    beside = path.with_name(path.name.removesuffix(".M.mtx") + ".q.mtx")
    if q is None and not path.name.endswith(".M.mtx"):
        raise InvalidInput(f"{path}: a Matrix Market problem needs q, a file")
    try:
        return Problem(scipy.io.mmread(path), scipy.io.mmread(q or beside))
    except (OSError, ValueError, TypeError) as why:
        if isinstance(why, InvalidInput):
            raise
        raise InvalidInput(f"{path}: {why}") from None


def read(source: str | os.PathLike, q: str | os.PathLike | None = None) -> Problem:
    """A problem from a file or a family: NAME.npz (docs/FORMATS.md, 9); NAME.M.mtx with NAME.q.mtx
    beside it, or q; anything else that `lcpbench export --format npz` takes, such as "murty:n=12"
    or the text of Siconos. InvalidInput with a line that names it."""
    path = pathlib.Path(source)
    if path.suffix == ".npz":
        return _npz(path)
    if path.suffix == ".mtx":
        return _mtx(path, q)
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "problem.npz"
        _program.run("export", source, "--format", "npz", "--out", out)
        return _npz(out)

"""Work in a process of its own, with a limit of time: what crashes or hangs costs one row."""

from __future__ import annotations

import os
import pickle
import select
import signal
import sys
import time
import traceback
from collections.abc import Callable


def call(work: Callable[[], object], limit: float, quiet: bool = True) -> tuple[str, object]:
    """("ok", what work returned), ("unsupported" or "error", the exception), ("crash", the signal)
    or ("timeout", the limit [s]). What a quiet child prints goes nowhere."""
    read, write = os.pipe()
    sys.stdout.flush()
    sys.stderr.flush()
    child = os.fork()
    if child == 0:
        os.close(read)
        _child(work, write, quiet)
    os.close(write)
    data, late = _collect(read, time.monotonic() + limit)
    os.close(read)
    if late:
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    if late:
        return "timeout", f"more than {limit:g} s"
    if os.WIFSIGNALED(status):
        return "crash", signal.Signals(os.WTERMSIG(status)).name
    try:
        return pickle.loads(data)
    except (pickle.UnpicklingError, EOFError):
        return "crash", f"ended with exit code {os.waitstatus_to_exitcode(status)} and no answer"


def _child(work: Callable[[], object], write: int, quiet: bool) -> None:
    if quiet:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
    try:
        answer = ("ok", work())
    except MemoryError:
        answer = ("error", "no memory")
    except BaseException as error:  # the row must say whatever it was
        last = traceback.extract_tb(error.__traceback__)[-1]
        name = type(error).__name__
        place = f"{os.path.basename(last.filename)}:{last.lineno}"
        answer = (
            ("unsupported", str(error))
            if name == "Unsupported"
            else ("error", f"{name}: {error} ({place})")
        )
    with os.fdopen(write, "wb") as pipe:
        pickle.dump(answer, pipe)
    os._exit(0)


def _collect(read: int, deadline: float) -> tuple[bytes, bool]:
    data = b""
    while True:
        left = deadline - time.monotonic()
        if left <= 0 or not select.select([read], [], [], left)[0]:
            return data, True
        piece = os.read(read, 1 << 16)
        if not piece:
            return data, False
        data += piece

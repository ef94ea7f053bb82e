"""What goes wrong, each with the one line that the library or the program says."""

from __future__ import annotations


class LcpbenchError(Exception):
    """A call failed; the text is the program's line."""


class InvalidInput(LcpbenchError, ValueError):
    """An argument, an option or a file that is refused."""


class Unsupported(LcpbenchError):
    """The solver does not take this kind of problem."""


class NotSolved(LcpbenchError):
    """An honest failure: not solved, or not verified. `result` is what there is: a Solution, or the
    dict of a simulation."""

    def __init__(self, text: str, result: object) -> None:
        super().__init__(text)
        self.result = result

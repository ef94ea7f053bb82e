"""tests/fuzz/blame.py - whose fault is it that a libFuzzer target ended: a library's, or ours?

A library is to blame only if every stack of the report begins in it, the sanitizer's own frames,
the C library and the allocator left out. Everything that cannot be told, a report without a stack
included, is ours. So is what only the caller can do wrong: memory that jansson or libyaml handed
out and that was never given back, or used after it was (libhdf5 hands out numbers, no memory: what
it loses, it lost itself), and memory of ours that a library was asked to write beyond.
"""

import collections
import re
from typing import NamedTuple

OURS = "ours"
LIBRARIES = {
    "libhdf5": re.compile(r"/libhdf5[\w.+-]*\.so"),
    "jansson": re.compile(r"/libjansson[\w.+-]*\.so"),
    "libyaml": re.compile(r"/libyaml[\w.+-]*\.so"),
}
FRAME = re.compile(r"^ +#(\d+) 0x[0-9a-f]+ +(?:in )?(.*)$")
HEADLINE = re.compile(r"(?:==\d+==)? ?(ERROR: .*)|.*?(runtime error: .*)")
# No frame of a reader: linked into the target without line numbers (sanitizer, libFuzzer), the C
# library, the loader.
RUNTIME = re.compile(
    r"^(fuzzer::|__asan|__lsan|__ubsan|__sanitizer|__interceptor_)|/compiler-rt/|\(\S*/fuzz_\w+\+0x|/(libc|libm|libpthread|ld-linux[\w-]*)\.so|"
    r"sysdeps/|/(libgcc_s|libstdc\+\+)\.so"
)


KINDS = {
    "allocation": "requested allocation|out-of-memory",
    "leak": "LeakSanitizer",
    "time-out": "timeout",
    "abort": "deadly signal|ABRT",
    "recursion": "stack-overflow",
}


class Verdict(NamedTuple):
    """Who failed (`ours` or a library) and how, in the report's own words."""

    owner: str
    what: str

    def kind(self) -> str:
        """One word for it."""
        return next((kind for kind, words in KINDS.items() if re.search(words, self.what)), "crash")


def _stacks(text: str) -> list[list[str]]:
    """Every stack in a report: its frames, from the top."""
    stacks: list[list[str]] = []
    for frame in filter(None, map(FRAME.match, text.splitlines())):
        if frame.group(1) == "0" or not stacks:
            stacks.append([])
        stacks[-1].append(frame.group(2))
    return stacks


def _owner(frame: str) -> str:
    """Whose code a frame is in; empty where it is the sanitizer's or the C library's."""
    for library, pattern in LIBRARIES.items():
        if pattern.search(frame):
            return library
    return "" if RUNTIME.search(frame) else OURS


def _owners(frames: list[str]) -> list[str]:
    return [owner for owner in map(_owner, frames) if owner]


def _first(frames: list[str]) -> str:
    return next(iter(_owners(frames)), OURS)


def blame(report: str) -> Verdict:
    """The verdict on what a target printed before it ended."""
    found = [m for m in map(HEADLINE.match, report.splitlines()) if m]
    what = next((m.group(1) or m.group(2) for m in found), "ended without a report")
    stacks = _stacks(report)
    if (
        not found or not stacks or "runtime error: " in report
    ):  # only our own code is built with these checks
        return Verdict(OURS, what)
    if (
        "out-of-memory (used" in what
    ):  # a list of what is alive, the largest first, libFuzzer's own among it
        stacks = [s for s in stacks if _owners(s)][:1]
    elif "stack-overflow" in what:  # the code that recurses, not the one that happened to be on top
        common = collections.Counter(_owners(stacks[0])).most_common(1)
        return Verdict(common[0][0] if common else OURS, what)
    owners = {_first(frames) for frames in stacks}
    owner = owners.pop() if len(owners) == 1 else OURS
    lent = any(
        word in what for word in ("LeakSanitizer", "use-after-free", "double-free", "bad-free")
    )
    return Verdict(OURS if lent and owner != "libhdf5" else owner, what)

"""What is said to a person: one line that no terminal obeys (as lcp/base/printable.h)."""

import argparse
import sys
from typing import NoReturn

SHORT = {"\n": "\\n", "\t": "\\t", "\r": "\\r"}


def plain(text: object) -> str:
    """Control characters and bytes that are no text, escaped."""
    return "".join(c if c.isprintable() else SHORT.get(c) or escaped(c) for c in str(text))


def escaped(c: str) -> str:
    return "".join(f"\\x{b:02x}" for b in c.encode("utf-8", "surrogateescape"))


def complain(text: object) -> None:
    print(plain(text), file=sys.stderr)


class Arguments(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """One line, and code 2; --help has the usage."""
        self.exit(2, f"{self.prog}: {plain(message)}\n")

"""The program, as `lcpbench` or `python -m lcpbench`; its scripts run in this interpreter."""

import os
import sys
from typing import NoReturn

from lcpbench._program import PROGRAM


def main() -> NoReturn:
    os.environ.setdefault("LCPBENCH_PYTHON", sys.executable)
    os.execv(PROGRAM, [str(PROGRAM), *sys.argv[1:]])


if __name__ == "__main__":
    main()

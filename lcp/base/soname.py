#!/usr/bin/env python3
"""Prints the soname of a library: the name by which a program that is linked with it loads it.

usage: soname.py PKG LIBRARY CC...   PKG: name for pkg-config, tried first; else -lLIBRARY
"""

import os
import re
import subprocess
import sys
import tempfile


def main() -> int:
    package, library, *compiler = sys.argv[1:]
    told = subprocess.run(["pkg-config", "--libs", package], capture_output=True, text=True)
    flags = told.stdout.split() if told.returncode == 0 else [f"-l{library}"]
    with tempfile.TemporaryDirectory() as folder:
        source, out = os.path.join(folder, "a.c"), os.path.join(folder, "a.so")
        with open(source, "w", encoding="utf-8") as f:
            f.write("int lcpbench_nothing;\n")
        words = [*compiler, "-shared", "-fPIC", source, "-Wl,--no-as-needed", *flags, "-o", out]
        subprocess.run(words, check=True)
        listed = subprocess.run(["readelf", "-d", out], capture_output=True, text=True, check=True)
    needed = re.findall(r"\(NEEDED\).*\[(.*)\]", listed.stdout)
    found = [n for n in needed if n.startswith(f"lib{library}")]
    if not found:
        print(f"soname.py: no lib{library} among {needed}", file=sys.stderr)
        return 1
    print(found[0], end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())

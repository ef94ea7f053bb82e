#!/usr/bin/env python3
"""test_summary.py BUILD - counts what `meson test` did in BUILD, `N passed, N failed` last.

Each TAP point of a test program counts once (meson-logs/testlog.junit.xml); a program that failed
without a failed point of its own (crash, time-out, wrong exit code) counts as one failure
(meson-logs/testlog.json). A test that the machine was too busy to decide (suite timing: skipped,
after a line `inconclusive: WHY`) is named with its reason and counted apart.
"""

import json
import pathlib
import re
import sys
import xml.etree.ElementTree as xml
from collections.abc import Iterator

FINE = {"OK", "EXPECTEDFAIL", "SKIP"}
WHY = re.compile(r"^inconclusive: (.*)", re.M)


def points(junit: pathlib.Path) -> Iterator[tuple[str, str, str]]:
    """Yields (program, point, verdict) for every point in the JUnit file."""
    for suite in xml.parse(junit).getroot().findall("testsuite"):
        for case in suite.findall("testcase"):
            verdict = "passed"
            if case.find("failure") is not None or case.find("error") is not None:
                verdict = "failed"
            elif case.find("skipped") is not None:
                verdict = "skipped"
            yield suite.get("name", ""), case.get("name", ""), verdict


def main() -> int:
    logs = pathlib.Path(sys.argv[1]) / "meson-logs"
    if not (logs / "testlog.json").exists() or not (logs / "testlog.junit.xml").exists():
        print("no test was run\n0 passed, 1 failed")
        return 1
    count = {"passed": 0, "failed": 0, "inconclusive": 0, "skipped": 0}
    told = set()
    for program, point, verdict in points(logs / "testlog.junit.xml"):
        count[verdict] += 1
        if verdict == "failed":
            told.update({program.split(".")[-1], point})
            print(f"FAILED {program}: {point}")
    for line in (logs / "testlog.json").read_text().splitlines():
        test = json.loads(line)
        name = test["name"].split(" / ")[-1]
        why = WHY.search(test.get("stdout", "")) if test["result"] == "SKIP" else None
        if why:
            count["skipped"] -= 1
            count["inconclusive"] += 1
            print(f"INCONCLUSIVE {test['name']}: {why.group(1)}")
        if test["result"] not in FINE and name not in told:
            count["failed"] += 1
            print(f"FAILED {test['name']}: {test['result'].lower()}")
    more = "".join(f", {count[k]} {k}" for k in ("inconclusive", "skipped") if count[k])
    print(f"{count['passed']} passed, {count['failed']} failed{more}")
    return 1 if count["failed"] or not count["passed"] else 0


if __name__ == "__main__":
    sys.exit(main())

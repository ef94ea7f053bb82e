"""Who is to blame for a fault that fuzzing found: recorded reports, OWNER.KIND.txt, and what cannot
be told."""

import pathlib
import sys
import unittest

FUZZ = pathlib.Path(__file__).resolve().parents[1] / "fuzz"
sys.path.insert(0, str(FUZZ))
from blame import OURS, blame  # noqa: E402

REPORTS = {
    f.name.removesuffix(".txt"): f.read_text() for f in sorted((FUZZ / "reports").glob("*.txt"))
}


class Recorded(unittest.TestCase):
    def test_every_report_is_blamed_on_the_owner_in_its_name(self) -> None:
        self.assertGreaterEqual(len(REPORTS), 14)
        for name, report in REPORTS.items():
            with self.subTest(name):
                self.assertEqual(blame(report).owner, name.split(".")[0])

    def test_kinds(self) -> None:
        kinds = {
            name: blame(report).kind()
            for name, report in REPORTS.items()
            if not name.startswith("ours")
        }
        self.assertEqual(
            kinds,
            {
                "jansson.crash": "crash",
                "jansson.recursion": "recursion",
                "jansson.time_out": "time-out",
                "libhdf5.allocation": "allocation",
                "libhdf5.leak": "leak",
                "libhdf5.memory_lost": "allocation",
            },
        )

    def test_the_same_report_is_ours_when_the_library_is_not_one_of_the_three(self) -> None:
        for name, report in REPORTS.items():
            with self.subTest(name):
                other = report.replace("libhdf5_serial", "libother").replace(
                    "libjansson", "libother"
                )
                self.assertEqual(blame(other).owner, OURS)


class Doubtful(unittest.TestCase):
    def test_a_leak_of_ours_among_those_of_a_library(self) -> None:
        for first, second in (("libhdf5.leak", "ours.leak"), ("ours.leak", "libhdf5.leak")):
            self.assertEqual(blame(REPORTS[first] + REPORTS[second]).owner, OURS)

    def test_our_frame_above_those_of_a_library(self) -> None:
        called_back = (
            "    #0 0x5555556 in ours /src/build-fuzz/../problems/import/import_fclib.c:9:3\n    #1"
        )
        report = REPORTS["libhdf5.allocation"].replace("    #1", called_back)
        self.assertNotEqual(report, REPORTS["libhdf5.allocation"])
        self.assertEqual(blame(report).owner, OURS)

    def test_our_recursion_that_ends_inside_a_library(self) -> None:
        report = REPORTS["ours.recursion"].replace(
            "    #0 ", "    #0 0x7ffff in json_equal (/lib/libjansson.so.4+0xa172)\n    #1 ", 1
        )
        self.assertEqual(blame(report).owner, OURS)

    def test_no_report_and_no_stack(self) -> None:
        for text in (
            "",
            "Killed\n",
            "==1==ERROR: AddressSanitizer: SEGV on unknown address\n",
            "ERROR: no end after 1500 s\n",
        ):
            self.assertEqual(blame(text).owner, OURS)


if __name__ == "__main__":
    unittest.main()

"""The report on made-up rows: the same bytes twice, self-contained, honest about failures, and
alive in a browser."""

import base64
import contextlib
import csv
import gzip
import io
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

import numpy as np
import pandas as pd

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from bench import (  # noqa: E402
    accuracy,
    asked,
    chart,
    cut,
    effects,
    latex,
    library,
    limits,
    page,
    paper,
    reference,
    report,
    rows,
    section,
    stability,
    style,
)

HEADER = (
    "schema campaign part cell_id rep problem_family problem formulation formulation_options solver"
    " solver_options step_s duration_s start effects tol n_bodies n_dof n_contacts n_active lcp_dim"
    " t_assemble_s t_solve_s t_total_s n_steps status status_claimed verified note rho res_ncp_rel"
    " penetration_m energy_drift_rel err_ref err_worst n_predictions n_predictions_missed"
    " workspace_B command missed err_quantity"
).split()


def cell(campaign, problem, form, opts, solver, step, p, dim, seconds, error, **more):
    base = {
        "schema": 1,
        "campaign": campaign,
        "part": "x",
        "problem_family": problem.split(":")[0],
        "problem": problem,
        "formulation": form,
        "formulation_options": opts,
        "solver": solver,
        "step_s": step,
        "duration_s": 0.1,
        "start": "cold",
        "effects": "gravity contact friction rotation spatial",
        "tol": 1e-9,
        "n_bodies": p,
        "n_dof": 6 * p,
        "n_contacts": p,
        "n_active": p,
        "lcp_dim": dim,
        "t_solve_s": seconds / 2,
        "t_total_s": seconds,
        "n_steps": 10,
        "status": "ok",
        "status_claimed": "ok",
        "verified": "true",
        "rho": 1e-14,
        "res_ncp_rel": 1e-12,
        "err_ref": error,
        "err_worst": 0.5,
        "n_predictions": 1,
        "n_predictions_missed": 0,
        "workspace_B": 8 * dim * dim,
        "cell_id": f"{campaign}|{problem}|{form}|{opts}|{solver}|{step}",
        "command": (
            f"lcpbench simulate '{problem}' --formulation '{form}' --solver '{solver}' --step"
            f" '{step}'"
        ),
    }
    base.update(more)
    return [dict(base, rep=r) for r in range(3)]


def lie(**more):
    return {"status": "unverified", "verified": "false", **more}


def campaign_rows():
    out = []
    for n in (1, 2, 4, 8):
        p = 4 * n
        out += cell("paper", f"stack:n={n}", "regularized", "", "lemke", 0.01, p, p, 1e-5 * p, 1e-6)
        out += cell(
            "paper",
            f"stack:n={n}",
            "velocity",
            "facets=4",
            "lemke",
            0.01,
            p,
            6 * p,
            4e-5 * p**2,
            1e-6,
        )
        out += cell(
            "paper",
            f"stack:n={n}",
            "velocity",
            "facets=4",
            "liar",
            0.01,
            p,
            6 * p,
            1e-9,
            0.0,
            **lie(),
        )
    for h in (0.02, 0.01, 0.005):
        out += cell("paper", "slide:speed=5", "regularized", "", "lemke", h, 4, 4, 1e-4 / h, h)
        out += cell(
            "paper", "slide:speed=5", "velocity", "facets=4", "lemke", h, 4, 24, 3e-4 / h, h / 2
        )
    for n, word in ((1, "ok"), (10, "ok"), (100, "ray")):
        good = word == "ok"
        out += cell(
            "stability",
            f"stack:mass_ratio={n}",
            "velocity",
            "facets=4",
            "lemke",
            0.01,
            4,
            24,
            1e-4,
            1e-9,
            status=word,
            verified="true" if good else "false",
        )
    for k, family in enumerate(("a", "b", "c")):
        for name, seconds in (("lemke", 1e-3 * (k + 1)), ("pgs", 2e-3)):
            out += cell("library", f"{family}:n=4", "", "", name, "", 0, 4, seconds, "", lcp_dim=4)
        out += cell("library", f"{family}:n=4", "", "", "liar", "", 0, 4, 1e-9, "", **lie())
    return out


def write(folder, lines):
    folder.mkdir(parents=True)
    with open(folder / "results.csv", "w", newline="") as to:
        out = csv.DictWriter(to, HEADER, restval="", lineterminator="\n")
        out.writeheader()
        out.writerows(lines)


class Judged(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.tmp = tempfile.TemporaryDirectory()
        folder = pathlib.Path(cls.tmp.name) / "all"
        write(folder, campaign_rows())
        cls.cells = rows.cells(rows.load(folder))

    @classmethod
    def tearDownClass(cls):
        cls.tmp.cleanup()

    def test_a_cell_of_two_campaigns_is_two(self):
        other = [{**row, "campaign": "other"} for row in campaign_rows()]
        folder = pathlib.Path(self.tmp.name) / "two"
        write(folder, campaign_rows() + other)
        two = rows.cells(rows.load(folder))
        self.assertEqual(two["campaign"].value_counts()["other"], self.cells["cell_id"].nunique())

    def test_how_far_processes_are_apart_is_told(self):
        def of(*seconds):
            return [
                {"process": p, "t_total_s": t} for p, times in enumerate(seconds) for t in times
            ]

        self.assertEqual(rows.between(of((1.0, 1.1, 0.9), (2.0, 2.5, 1.9))), 2.0)
        self.assertTrue(np.isnan(rows.between(of((1.0, 1.1)))))
        apart = pd.DataFrame(
            {"campaign": "x", "good": True, "disturbed": "", "between": [1.3] * 30}
        )
        self.assertIn("factor of 1.2: x 100 %", reference.spread_words(apart))
        self.assertEqual(reference.spread_words(apart[:5]), "")
        some = pd.DataFrame(
            {"good": [True] * 4 + [False], "rho": [0.0] * 3 + [None, 0.0]}
            | {"res_ncp_rel": [0.0, 0.0, None, None, 0.0], "err_ref": [0.0] + 4 * [None]}
        )
        told = reference.yardsticks_words(some)
        self.assertIn("Of the 4 solved cells 75% have `rho`, 50% the residual", told)
        self.assertTrue("25% an error" in told and "25% all three" in told)
        self.assertEqual(reference.yardsticks_words(some[4:]), "")

    def test_machines_are_told_where_there_are_several(self):
        some = pd.DataFrame({"campaign": ["x", "y"], "host_class": ["A; B; avx2; 1", "C; D; e; 1"]})
        self.assertIn("(A, B, avx2: x; C, D, e: y;", reference.machines_words(some))
        self.assertEqual(reference.machines_words(some[:1]), "")

    def test_a_new_reference_leaves_what_no_campaign_makes(self):
        target, source = pathlib.Path(self.tmp.name) / "target", pathlib.Path(self.tmp.name) / "new"
        for path in (
            "target/error/table.tsv",
            "target/gone/results.csv.xz",
            "target/cut/gone/results.csv.xz",
            "new/x/results.csv",
            "new/cut/begun/results.csv",
            "new/kept/results.csv.xz",
        ):
            made = pathlib.Path(self.tmp.name) / path
            made.parent.mkdir(parents=True)
            made.write_text("row\n")
        reference.pack(source, target)
        left = sorted(str(f.relative_to(target)) for f in target.rglob("*") if f.is_file())
        rows = [f"{name}/results.csv.xz" for name in ("cut/begun", "kept", "x")]
        self.assertEqual(left, sorted([*rows, "error/table.tsv"]))
        self.assertEqual((target / "kept" / "results.csv.xz").read_text(), "row\n")

    def test_an_error_that_was_asked_for_is_held_against_the_one_got(self):
        names = "problem error chosen sure promised err_estimate err_got t_chosen_s t_best_s"
        rows = (
            "fall 0.01 a+b 1 1 0.005 0.004 2e-3 1e-3 1e-3 4e-3 0.005 1.4e-3",  # promised, kept
            "spin 0.01 a+b 1 1 0.005 0.02 4e-3 1e-3 1e-3 4e-3 0.02 nan",  # promised, not kept
            "ball 0.01 a+b 1 0 0.5 0.5 9e-3 1e-3 1e-3 4e-3 nan 1e-3",  # not promised
        )
        path = pathlib.Path(self.tmp.name) / "table.tsv"
        lines = [f"{names} t_even_s t_hand_s hand_got t_checked_s", *rows]
        path.write_text("\n".join(line.replace(" ", "\t") for line in lines) + "\n")
        made = asked.section(asked.read(path))
        self.assertIn("Of 3 runs 2 promise the error asked for, and 1 of these keep it", made.lead)
        self.assertIn(" 3 times (median)", made.lead)
        self.assertIn("that these keep E, differ by no more than E in 1 of 2.", made.lead)
        self.assertIn("takes 1.5 times as long (median), and 1 of 2 miss E", made.lead)
        self.assertEqual(made.charts[0].panels[0].lines[1].y, [0.004, 0.02])
        told = [getattr(cell, "text", cell) for cell in made.tables[0].rows[0]]
        by_hand = ["0.75", "1 of 2"]
        self.assertEqual(
            told, ["0.01", "2 of 3", "1 of 2", "3", "3", "0 of 3", *by_hand, "spin: 4"]
        )
        self.assertIsNone(asked.section([]))
        path.write_text(path.read_text().replace("err_got", "got"))
        self.assertRaises(ValueError, asked.read, path)

    def test_a_lying_solver_is_never_cheapest(self):
        self.assertEqual(len(self.cells[(self.cells["solver"] == "liar") & self.cells["good"]]), 0)
        stack = accuracy.confirmed(self.cells[self.cells["problem"] == "stack:n=8"])
        self.assertEqual(accuracy.cheapest(stack, 1e-3)["combination"], "regularized + lemke")

    def test_a_lying_solver_solves_nothing_in_the_profile(self):
        cost, _, families, solvers = library.matrix(self.cells[self.cells["formulation"] == ""])
        made = library.profiles("all", cost, families, solvers, 1.05)
        liar = next(line for line in made.panels[0].lines if line.name == "liar")
        self.assertEqual(max(liar.y), 0)
        self.assertEqual({line.name: max(line.y) for line in made.panels[0].lines}["lemke"], 1)

    def test_solvers_are_compared_on_the_problems_that_all_were_given(self):
        some = self.cells[self.cells["formulation"] == ""]
        cones = some[some["solver"] == "pgs"].assign(
            part="cones", solver="nsgs", combination="nsgs"
        )
        found = library.fields(pd.concat([some, cones]))
        self.assertEqual(
            [(name, sorted(set(g["solver"]))) for name, g in found],
            [("x", ["lemke", "liar", "pgs"]), ("cones", ["nsgs"])],
        )
        made = library.section(pd.concat([some, cones]))
        self.assertEqual(
            [c.name for c in made.charts], ["profiles_x"]
        )  # one solver alone wins nothing
        table = made.tables[0]
        self.assertEqual([row[0] for row in table.rows], ["x"] * 3 + ["cones"])
        for row in table.rows:  # every problem ends in exactly one way
            self.assertEqual(
                int(row[2].text.split()[0]) + sum(int(c.text) for c in row[3:9]),
                int(row[2].text.split()[2]),
                row[1],
            )
        self.assertEqual(table.rows[1][table.header.index("false claims")].text, "3")

    def test_a_lying_solver_is_a_cross_in_the_figure(self):
        made = paper.time_and_error(self.cells)
        panel = next(p for p in made.panels if p.title == "liar")
        self.assertEqual([(len(line.x), len(line.bad)) for line in panel.lines], [(0, 4)])

    def test_the_stability_map_names_the_first_failing_rung(self):
        table = stability.section(stability.ladders(self.cells)).tables[1]
        self.assertEqual([c.text for c in table.rows[0][:2]], ["velocity", "lemke"])
        self.assertEqual(table.rows[0][2].text, "fails honestly 2/3")
        self.assertIn("mass_ratio = 100: ray", table.rows[0][2].title)

    def test_a_long_table_is_drawn_in_pieces(self):
        """The first rows stand in the page; every row is packed beside, with its marks."""
        cells = [
            [section.Cell(str(k), "bad" if k == 499 else "", sort=k), f"a {k}"] for k in range(500)
        ]
        cells[498][0] = section.Cell("", "", "not measured", sort=math.nan)
        made = section.table_html(section.Table("long", "caption", ["n", "command"], cells, code=1))
        self.assertEqual(made.count("<tr>"), 1 + section.ROWS)
        text = re.search(r'id="rows-long">([^<]*)<', made).group(1)
        rows_ = json.loads(gzip.decompress(base64.b64decode(text)))
        self.assertEqual((len(rows_), rows_[499]), (500, [["499", "bad", "", 499], "a 499"]))
        self.assertEqual(rows_[498][0], ["", "", "not measured", None])
        self.assertNotIn("NaN", gzip.decompress(base64.b64decode(text)).decode())  # no JSON
        short = section.table_html(section.Table("short", "", ["n"], [["1"]]))
        self.assertNotIn("rows-short", short)

    def test_a_disturbed_run_is_told_and_drawn_hollow(self):
        self.assertEqual(page.band(self.cells), "")
        told = self.cells.assign(disturbed="other work")
        self.assertIn(
            f"{len(told)} of {len(told)} cells were measured on a disturbed", page.band(told)
        )
        self.assertIn("other work", reference.disturbed_words(told))
        line = chart.from_cells(told[told["good"]], told[~told["good"]], "p", "t_total_s", "pgs")
        self.assertTrue(line.hollow and all(line.hollow))
        drawn = chart.plotly(chart.Chart("c", "", [chart.Panel([line])]))
        self.assertIn("-open", drawn)
        quiet = chart.from_cells(
            self.cells[self.cells["good"]], self.cells[:0], "p", "t_total_s", "pgs"
        )
        self.assertFalse(any(quiet.hollow))

    def test_the_form_of_each_campaign_is_told(self):
        def told(**quick):
            return cut.forms({k: {"campaign": {"quick": q}} for k, q in quick.items()})

        self.assertEqual(told(b=True, a=True), "quick form")
        self.assertEqual(told(a=False), "full form")
        self.assertEqual(told(b=True, a=False, c=True), "a in full form and b, c in quick form")
        self.assertEqual(cut.forms({"a": {}}), "")

    def test_a_cut_campaign_tells_what_it_left_out(self):
        def told(stages, **more):
            account = {"cells": 30, "measured": 9, "begun": 1, "stages": stages} | {
                "parts": {"size": [9, 20], "all there": [4, 4], "none": [0, 6]},
                "absent": {"size": {"problems": ["stack:n=100"], "tolerances": [""]}},
            }
            return {"campaign": {"quick": False}, "cut": account} | more

        short = told({"quick": [9, 20], "rest": [0, 10]})
        enough = told({"quick": [5, 5], "values": [4, 4], "rest": [0, 21]})
        words = cut.forms({"b": short, "a": {"campaign": {"quick": True}}})
        self.assertEqual(
            words,
            "b in full form, cut: 9 of 30 cells, in an order that keeps every axis and a in quick"
            " form",
        )
        chosen = {"campaign": {"quick": False}, "filters": ["solver=lemke"]}
        self.assertEqual(cut.form(chosen), "full form of what solver=lemke chose")
        self.assertEqual(
            cut.table({"b": short}).rows,
            [
                ["b", "size", "9", "20", "problems stack:n=100; tolerances its own"],
                ["b", "none", "0", "6", "all"],
            ],
        )
        self.assertIsNone(cut.table({"a": {"campaign": {"quick": False}}}))
        self.assertIn("left_out", [t.name for t in page.method_tables({"b": short})])
        self.assertFalse(cut.stands(short))
        self.assertTrue(cut.stands(enough))
        self.assertFalse(cut.stands({"campaign": {"quick": True}}))
        self.assertFalse(cut.stands(chosen))
        waiting = {"campaign": {"quick": True}, "begun": short["cut"]}
        self.assertIn("quick form (full form begun: 9 of 30 cells", cut.form(waiting))
        self.assertEqual(len(cut.table({"b": waiting}).rows), 2)

    def test_a_map_on_the_screen_tells_its_fields(self):
        made = json.loads(
            chart.plotly_heat(stability.section(stability.ladders(self.cells)).charts[0])
        )
        self.assertEqual({d["type"] for d in made["data"]}, {"heatmap"})
        self.assertIn("0/1 f", made["data"][0]["text"][0])

    def test_who_is_asked_less_does_not_stand_unsaid(self):
        """Two combinations that miss nothing; one was asked a third of what the other was."""
        rungs = self.cells[(self.cells["campaign"] == "stability") & self.cells["good"]]
        easy = rungs.assign(formulation="position", n_predictions=1)
        found = stability.ladders(pd.concat([rungs.assign(n_predictions=3), easy]))
        shares = stability.asked(found)
        self.assertEqual(shares["position", "lemke"], (2, 6))
        self.assertEqual(stability.asked_words(shares["velocity", "lemke"]), "")
        words = stability.fall_words(
            stability.falls(found)["position", "lemke"], shares["position", "lemke"]
        )
        self.assertIn("Passes 1 of 1 stress tests (asked 2 of the 6 predictions).", words)

    def test_every_end_of_a_run_has_its_word(self):
        ok = {
            "status": "ok",
            "verified": True,
            "part": "height",
            "problem": "stack:n=2",
            "formulation": "velocity",
            "n_predictions_missed": 0,
            "missed": "",
            "penetration_m": 0.0,
        }
        ends = {
            "stands": {},
            "gains energy": {
                "n_predictions_missed": 2,
                "missed": "max_drift b.x 3x, energy_nonincrease 2x",
            },
            "creeps": {"n_predictions_missed": 1, "missed": "max_drift b.x 3x"},
            "penetrates": {"penetration_m": 0.02, "approach_m": 0.01},
            "a step deep": {"penetration_m": 0.02, "approach_m": 0.05},
            "misses": {"n_predictions_missed": 1, "missed": "state b.x 3x"},
            "false claim": {"status": "unverified", "verified": False},
            "time-out": {"status": "timeout", "verified": False},
            "fails honestly": {"status": "max_iter", "verified": False},
            "dies": {"status": "crash", "verified": False},
            "not defined": {"status": "unsupported", "verified": False},
        }
        self.assertEqual(
            {w: stability.word({**ok, **change})[0] for w, change in ends.items()},
            {w: w for w in ends},
        )
        self.assertEqual(stability.missed_word("state b.vx = 0 3x"), "creeps")
        vise = {**ok, "problem": "vise:speed=1"}
        self.assertEqual(
            [
                stability.word({**vise, **c})[0]
                for c in ({}, ends["fails honestly"], {**ends["dies"], "status": "oom"})
            ],
            ["misses", "stands", "dies"],
        )

    def test_a_killed_run_stands_at_the_step_that_it_was_asked_for(self):
        with tempfile.TemporaryDirectory() as folder:
            lines = [
                dict(r, part="long step", **more)
                for h, more in (
                    (0.01, {}),
                    (1, {"status": "timeout", "verified": "false", "step_s": "", "t_total_s": ""}),
                    (0.1, {}),
                )
                for r in cell("stability", "drop", "velocity", "", "lemke", h, 1, 6, 1e-3, 1e-6)
            ]
            write(pathlib.Path(folder) / "s", lines)
            ladder = stability.ladders(rows.cells(rows.load(pathlib.Path(folder) / "s")))[
                "velocity", "lemke"
            ]["long step"]
        self.assertEqual([rung[3] for rung in ladder.rungs], ["0.01 s", "0.1 s", "1 s"])
        self.assertEqual(stability.turned_up(ladder), "h: 0.01 s to 1 s")

    def test_a_field_without_rows_gives_its_reason(self):
        some = self.cells[self.cells["campaign"] == "stability"]
        more = some.assign(part="stiffness", formulation="regularized", problem="stack")
        table = stability.section(stability.ladders(pd.concat([some, more]))).tables[1]
        self.assertTrue(all(cell.text for row in table.rows for cell in row[2:]))
        other = next(r for r in table.rows if r[0].text == "velocity")
        self.assertIn("no stiffness", other[3].text + other[2].text)

    def test_a_refusal_is_right_only_where_no_solution_exists(self):
        some = self.cells[self.cells["campaign"] == "stability"]
        bad = some[some["status"] == "ray"]
        self.assertEqual(int(stability.refusals(bad).sum()), 0)
        self.assertEqual(int(stability.refusals(bad.assign(problem="vise:speed=1")).sum()), 1)
        self.assertEqual(
            int(
                stability.refusals(bad.assign(problem="vise:speed=1", formulation="penalty")).sum()
            ),
            0,
        )
        self.assertEqual(
            int(stability.refusals(bad.assign(problem="vise:speed=1", status="crash")).sum()), 0
        )

    def test_a_probe_that_is_killed_or_prints_nothing_dies(self):
        stressor = limits.Stressor("edge", "x={}", 1, 1e9)
        ends = {
            "kill -9 $$": "dies",
            "exit 1": "dies",
            "echo no such scene >&2; exit 2": "not defined",
            "sleep 5": "time-out",
        }
        with tempfile.TemporaryDirectory() as folder:
            for script, word in ends.items():
                binary = pathlib.Path(folder) / "lcpbench"
                binary.write_text(f"#!/bin/sh\n{script}\n")
                binary.chmod(0o755)
                self.assertEqual(
                    limits.Probe(str(binary), stressor, "velocity", "lemke", 0.5)(1.0)[0],
                    word,
                    script,
                )

    def test_a_limit_that_was_not_looked_for_is_not_called_undefined(self):
        row = {
            "word": "stands",
            "stands": "5",
            "fails": "",
            "reason": "",
            "command": "",
            "solver": "lemke",
        }
        table = limits.table(
            [
                {**row, "formulation": "velocity", "stressor": "tallest stack"},
                {**row, "formulation": "regularized", "stressor": "largest stiffness [N/m]"},
            ]
        )
        self.assertEqual(
            [c.text for c in table.rows[0][2:]],
            ["5, the end of the ladder", "not defined: no such option"],
        )
        self.assertEqual(table.rows[1][2].text, "not run")

    def test_bisection_brackets_the_edge(self):
        stressor = limits.Stressor("edge", "x={}", 1, 1e9)

        class Probe:
            count = 0

            def __init__(self):
                self.stressor = stressor

            def __call__(self, value):
                return ("stands" if value <= 4321 else "creeps", "", "")

        found = limits.bisect(Probe())
        self.assertLessEqual(found["stands"], 4321)
        self.assertGreater(found["fails"], 4321)
        self.assertLess(found["fails"] / found["stands"], limits.CLOSE)
        self.assertEqual(found["word"], "creeps")

    def test_declared_is_held_against_everything_on_beyond_the_noise_only(self):
        def pair(problem, declared, everything, more):
            base = dict(
                good=True,
                err_ref=1e-3,
                err_tol=1e-2,
                n_dof=3,
                lcp_dim=4,
                n_contacts=1,
                n_pivot=5,
                n_iter=0,
            )
            return (
                problem,
                "velocity + lemke",
                {
                    "as declared": {**base, "t_total_s": declared},
                    "everything on": {**base, "t_total_s": everything, **more},
                },
            )

        same = [pair(f"s{i}", 1.0, 1.0 + 0.01 * i, {}) for i in range(10)]
        compared = effects.compare(
            same
            + [
                pair("dear", 2.0, 1.0, {"n_dof": 6}),
                pair("wrong", 0.5, 1.0, {"n_dof": 6, "err_ref": 1.0}),
            ]
        )
        noise = effects.noise_of(compared)
        self.assertTrue(0.05 < noise < 0.1)
        self.assertEqual(
            [p for p, _, r, equal_work, _ in compared if not equal_work and r > 1 + noise], ["dear"]
        )
        self.assertEqual([p for p, _, _, _, equal in compared if not equal], ["wrong"])

    def test_the_first_screen_chooses_what_reaches_most(self):
        cards = {a["situation"]: a for a in accuracy.advise(self.cells)}
        self.assertEqual(cards["stack"]["use"], "regularized + lemke")
        self.assertEqual(cards["grasp"]["use"], "")

    def test_who_was_asked_less_does_not_stand_longer(self):
        """Of a form that was cut: rungs that few were asked for do not count, nor do combinations
        that lack one of the others."""
        rungs = [(k, w) for w in ("lemke", "pgs", "ppm") for k in (1, 2, 3)]
        rungs = [r for r in rungs if r != (2, "ppm")] + [(4, "lemke")]
        told = pd.DataFrame(
            {
                "part": "height",
                "problem": [f"stack:n={k}" for k, _ in rungs],
                "step_s": 0.01,
                "start": "cold",
                "formulation": "velocity",
                "solver": [w for _, w in rungs],
            }
        )
        kept = stability.asked_alike(told)
        self.assertEqual(set(kept["solver"]), {"lemke", "pgs"})
        self.assertEqual(set(kept["problem"]), {"stack:n=1", "stack:n=2", "stack:n=3"})

    def test_the_largest_scene_has_an_answer_of_its_own(self):
        """Who wins on small scenes need not win on a large one."""
        at = ("accuracy", "stack:n=50", "velocity")
        rows_ = [
            *cell("accuracy", "stack:n=1", "regularized", "", "lemke", 0.01, 4, 4, 1e-5, 1e-3),
            *cell("accuracy", "stack:n=1", *at[2:], "", "lemke", 0.01, 4, 24, 1e-4, 1e-3),
            *cell(*at, "", "lemke", 0.01, 200, 1200, 1e-2, 9e-3),
            *cell(*at, "", "lemke", 0.001, 200, 1200, 9e-2, 9e-4),
            *cell("accuracy", "stack:n=50", "boxed", "", "ppm", 0.01, 200, 600, 3e-2, 1e-3),
        ]
        folder = pathlib.Path(self.tmp.name) / "large"
        write(folder, rows_)
        cards = {a["situation"]: a for a in accuracy.advise(rows.cells(rows.load(folder)))}
        self.assertEqual(cards["stack"]["use"], "regularized + lemke")  # of the small one alone
        self.assertEqual(accuracy.kind(cards["stack"]), "stack, below 100 contacts")
        answer, behind = accuracy.largest_words(cards["stack"]["large"])
        self.assertEqual(answer, "200 contacts (stack:n=50): velocity + lemke, 1 ms a step")
        self.assertIn("Slower: boxed + ppm (3 times the time).", behind)
        self.assertIn("a tenth of the error takes 9 times as long", behind)
        self.assertEqual(accuracy.largest_words(cards["sliding"].get("large")), ("", ""))
        self.assertEqual(accuracy.kind(cards["sliding"]), "sliding")

    def test_a_panel_of_a_scene_file_has_its_name_for_a_title(self):
        self.assertEqual(accuracy.short("tests/cases/claims/plates6.json"), "plates6")
        self.assertEqual(accuracy.short("slide:angle_deg=22.5,mu=1"), "slide:angle=22.5")

    def test_the_next_one_is_compared_on_the_scenes_that_both_reach(self):
        won = {p: {"cost": c, "noise": 1.05} for p, c in (("a", 1.0), ("b", 1.0), ("c", 100.0))}
        found = accuracy.rival(
            won,
            "velocity + lemke",
            {p: {"cost": c, "noise": 1.05} for p, c in (("a", 2.0), ("b", 2.0), ("d", 1e-3))},
            5,
        )
        self.assertEqual((found["both"], found["reached"]), (2, 3))
        self.assertEqual(
            accuracy.rival_words(found), "velocity + lemke 2 [2, 2] on 2 (reaches 3 of 5)"
        )
        self.assertEqual(accuracy.kind_of_rival({**found, "few": False}), "slower")
        self.assertEqual(accuracy.kind_of_rival({**found, "few": True}), "few")
        close = accuracy.rival(won, "event", {"a": {"cost": 2.0, "noise": 2.1}}, 1)
        self.assertEqual(accuracy.kind_of_rival({**close, "few": False}), "open")
        open_ = {**found, "few": False, "ratio": 1.6, "low": 0.9, "high": 2.6}
        self.assertEqual(accuracy.kind_of_rival(open_), "open")
        # printed as [1, 1.2]: who reads it sees an interval that 1 is in
        self.assertEqual(accuracy.kind_of_rival({**open_, "low": 1.004}), "open")
        self.assertEqual(accuracy.kind_of_rival({**open_, "low": 1.2}), "slower")
        apart = accuracy.rival(won, "event", {"d": {"cost": 1.0, "noise": 1.05}}, 1)
        self.assertEqual(accuracy.rival_words(apart), "event on none of the same (reaches 1 of 1)")
        self.assertEqual(accuracy.kind_of_rival({**apart, "few": False}), "few")

    def test_an_answer_is_of_one_setting_and_one_start(self):
        """The best of many settings, or of a warm start beside a cold one, is no answer; each start
        has its own, and tells where rivals did not run."""

        def one(problem, form, options, seconds, start):
            return cell(
                *("accuracy", problem, form, options, "lemke", 0.01, 4, 4, seconds, 1e-3),
                start=start,
                cell_id=f"{problem}|{form}|{options}|{start}",
            )

        rows_ = []
        for problem in ("slide", "incline", "spin"):
            rows_ += one(problem, "regularized", "", 4e-3, "cold")
            rows_ += one(problem, "regularized", "ratio=10", 1e-3, "cold")
            rows_ += one(problem, "velocity", "facets=8", 2e-3, "cold")
            rows_ += one(problem, "regularized", "", 1e-3, "previous")
            rows_ += one(problem, "velocity", "facets=8", 2e-3, "previous")
        rows_ += one("slide", "coulomb", "", 1e-4, "cold")
        folder = pathlib.Path(self.tmp.name) / "settings"
        write(folder, rows_)
        found = accuracy.advise(rows.cells(rows.load(folder)))
        cold, warm = (a for a in found if a["situation"] == "sliding")
        self.assertEqual(accuracy.kind(cold), "sliding, cold")
        self.assertEqual(accuracy.kind(warm), "sliding, previous step")
        self.assertEqual((cold["use"], warm["use"]), ("velocity + lemke", "regularized + lemke"))
        self.assertEqual(accuracy.all_ran_words(cold), "all 3 ran on 1 of 3")
        self.assertIn(
            "regularized + lemke 2 [2, 2] on 3", accuracy.rivals_words(cold["others"], "slower")
        )
        self.assertEqual(
            accuracy.rivals_words(cold["others"], "few"),
            "coulomb + lemke 0.05 on 1 (reaches 1 of 1)",
        )
        short = [accuracy.rivals_in_short(cold["others"], k) for k in ("slower", "few")]
        self.assertEqual(short, ["regularized + lemke 2", "coulomb + lemke"])
        fields = {r["name"]: reference.factor_words(r) for r in cold["others"]}
        self.assertEqual(fields["regularized + lemke"], "2 [2, 2]")
        self.assertEqual(fields["coulomb + lemke"], "(0.05)")
        apart = {**cold["others"][0], "few": False, "low": 0.9, "reached": 2, "run": 3}
        self.assertEqual(reference.factor_words(apart), "\u2248 2 [0.9, 2], 2 of 3")
        self.assertEqual(reference.factor_words({**apart, "both": 0}), "-")
        table = reference.advice_in_short(rows.cells(rows.load(folder)))
        self.assertIn("| scene, start | use | a step takes | `velocity` | `regularized` |", table)
        self.assertIn("| **1** | 2 [2, 2] | (0.05) |", table)

    def test_unlike_facets_are_told(self):
        at = ("accuracy", "stack:n=50")
        rest = ("lemke", 0.01, 200, 1200)
        rows_ = [
            *cell(*at, "boxed", "", *rest, 1e-3, 1e-3),
            *cell(*at, "position", "facets=4", *rest, 2e-3, 1e-3),
        ]
        for velocity, told in (("facets=8", True), ("facets=4", False)):
            folder = pathlib.Path(self.tmp.name) / velocity
            more = cell(*at, "velocity", velocity, *rest, 4e-3, 1e-3)
            write(folder, rows_ + more)
            cards = {a["situation"]: a for a in accuracy.advise(rows.cells(rows.load(folder)))}
            said = accuracy.largest_words(cards["stack"]["large"])[1]
            self.assertEqual("unlike facets" in said, told)

    def test_a_table_of_too_many_cells_keeps_what_failed_and_the_smallest_steps(self):
        some = self.cells[self.cells["campaign"] != "stability"]
        with mock.patch.object(page, "MOST", 10):
            table = page.cells_table(some)
        slides = [row for row in table.rows if row[1] == "slide"]
        self.assertEqual({row[5] for row in slides}, {"0.005"})
        self.assertEqual(len(some) - len(table.rows), 4)
        self.assertIn("and 4 verified ones at larger steps", table.caption)
        self.assertEqual(
            sum(row[6].text == "unverified" for row in table.rows),
            int((some["status"] == "unverified").sum()),
        )

    def test_a_table_of_the_document_runs_over_pages(self):
        def made(n):
            return section.table_tex(
                section.Table(
                    "t",
                    "c",
                    ["claim", "verdict", "evidence"],
                    [["a claim of some length", "holds when this or that is so", "evidence " * 30]]
                    * n,
                )
            )

        self.assertIn("tabularx", made(8))
        self.assertIn("longtable", made(30))
        self.assertEqual(made(30).count("a claim of some length"), 30)
        self.assertNotIn("all of them in the page", made(30))
        self.assertIn(f"{section.LONGEST} of 90 rows; all of them in the page", made(90))

    def test_missing_rows_are_an_error(self):
        with self.assertRaises(rows.BadRows):
            rows.load_all(self.tmp.name + "/nothing")


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.tmp = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.tmp.name)
        write(cls.folder / "runs" / "all", campaign_rows())
        for name in ("one", "two"):
            subprocess.run(
                [
                    sys.executable,
                    ROOT / "scripts/bench/report.py",
                    cls.folder / "runs",
                    "--out",
                    cls.folder / name,
                ],
                check=True,
                stdout=subprocess.DEVNULL,
            )
        cls.page = (cls.folder / "one/index.html").read_text()

    @classmethod
    def tearDownClass(cls):
        cls.tmp.cleanup()

    def browse(self, where=""):
        """Headless, without a network; the DOM after the scripts ran, and what they complained
        about."""
        return subprocess.run(
            [
                "chromium",
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--virtual-time-budget=60000",
                "--window-size=1200,9000",
                "--proxy-server=127.0.0.1:9",
                f"--user-data-dir={self.folder / 'profile'}",
                "--enable-logging=stderr",
                "--dump-dom",
                (self.folder / "one/index.html").as_uri() + where,
            ],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=120,
        )

    def test_the_same_bytes_twice(self):
        files = sorted(
            p.relative_to(self.folder / "two")
            for p in (self.folder / "two").rglob("*")
            if p.is_file()
        )  # one is also compiled
        self.assertGreater(len(files), 10)
        for f in files:
            self.assertEqual(
                (self.folder / "one" / f).read_bytes(), (self.folder / "two" / f).read_bytes(), f
            )

    def test_the_reference_is_written_between_its_markers(self):
        root = self.folder / "project"
        root.mkdir()
        (root / "results").mkdir()
        documents = [root / "README.md", root / "results" / "README.md"]
        for document in documents:
            document.write_text(f"before\n{reference.BEGIN}stale\n{reference.END}after\n")
        with (
            mock.patch.object(
                sys, "argv", ["reference", str(self.folder / "runs"), "--out", str(root)]
            ),
            contextlib.redirect_stdout(io.StringIO()),
        ):
            self.assertEqual(reference.main(), 0)
        for document in documents:
            text = document.read_text()
            self.assertTrue(
                text.startswith("before\n" + reference.BEGIN)
                and text.endswith(reference.END + "after\n")
            )
            self.assertNotIn("stale", text)
            self.assertIn("`regularized + lemke`", text)
            drawn = re.findall(r"!\[[^]]*\]\(([^)]*)\)", text)
            self.assertTrue(drawn, document)
            for name in drawn:
                self.assertTrue((document.parent / name).exists(), name)
        packed = rows.load(root / "results/reference/all")
        self.assertTrue(packed.equals(rows.load(self.folder / "runs/all")))

    def test_nothing_is_fetched(self):
        text = re.sub(
            r'<script type="text/plain" id="plotly">.*?</script>', "", self.page, flags=re.S
        )
        self.assertEqual(re.findall(r"(?:src|href)=[\"'](?!#|data:)[^\"']*", text), [])
        self.assertLess(len(self.page.encode()), 5_000_000)

    def test_failures_and_commands_are_in_the_page_without_a_script(self):
        self.assertIn("false claims", self.page)
        self.assertIn("<code>lcpbench simulate 'slide:speed=5'", self.page)
        self.assertIn("fails honestly 2/3", self.page)

    @unittest.skipUnless(
        shutil.which("latexmk") and shutil.which("pdflatex"), "no latexmk: scripts/setup latex"
    )
    def test_the_document_compiles(self):
        self.assertEqual(report.build(self.folder / "one/latex"), 0)
        self.assertGreater((self.folder / "one/latex/main.pdf").stat().st_size, 10_000)
        main = (self.folder / "one/latex/main.tex").read_text()
        for name in re.findall(r"\\input\{tables/(\w+)\}", main):
            self.assertIn("\\toprule", (self.folder / f"one/latex/tables/{name}.tex").read_text())

    @unittest.skipUnless(
        shutil.which("latexmk") and shutil.which("pdflatex"), "no latexmk: scripts/setup latex"
    )
    def test_figures_as_pgf_compile(self):
        cells = rows.cells(rows.load(self.folder / "runs/all"))
        folder = self.folder / "pgf"
        lines = [
            chart.Line("pgs_sm", [1e-3, 1e-1], [1, 2], bad=[(1e-2, 1)]),
            chart.Line("not resolved", [1e-4, 1e-3], [2, 2], [1, 1], [2, 2], kind="band"),
        ]
        made = [
            chart.Chart(
                "marks",
                "",
                [chart.Panel(lines, title="stack_n & τ", xlabel="error (reference ± 1e-3), 95 %")],
            ),
            stability.section(stability.ladders(cells)).charts[0],
        ]
        for one in made:
            style.save(chart.draw(one), folder, one.name, pgf=True)
        body = "".join(f"\\input{{{one.name}.pgf}}\n\n" for one in made)
        (folder / "main.tex").write_text(
            "\\documentclass{article}\n"
            + latex.FIGURES
            + "\\begin{document}\n"
            + body
            + "\\end{document}\n"
        )
        with contextlib.redirect_stdout(io.StringIO()):
            self.assertEqual(report.build(folder), 0)
        self.assertGreater((folder / "main.pdf").stat().st_size, 10_000)

    @unittest.skipUnless(shutil.which("chromium"), "no chromium")
    def test_filters_filter(self):
        done = self.browse("#cells:slide;velocity")
        shown = re.search(r"(\d+) of (\d+) cells", done.stdout)
        self.assertEqual(shown.group(1), "3")
        table = re.search(r'<table id="table-cells".*?</table>', done.stdout, re.S).group(0)
        self.assertEqual(len(re.findall(r"<tr>", table)) - 1, 3)
        self.assertEqual(table.partition("<tbody>")[2].count("<tr>"), 3)

    @unittest.skipUnless(shutil.which("chromium"), "no chromium")
    def test_it_lives_in_a_browser(self):
        done = self.browse()
        self.assertNotIn("CONSOLE", done.stderr)
        charts = self.page.count('class="chart" data-chart=')
        self.assertGreater(charts, 3)
        self.assertEqual(done.stdout.count('data-drawn="yes"'), charts)
        self.assertRegex(done.stdout, r"\d+ of \d+ cells")


if __name__ == "__main__":
    unittest.main()

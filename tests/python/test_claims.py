"""Every judge of a claim on planted rows: what it must call right, and what it must refuse."""

import math
import pathlib
import re
import sys
import unittest

import pandas as pd

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from bench import claims, judges, judges_motion, registry, stats  # noqa: E402
from bench import rows as rows_  # noqa: E402
from bench.judges import EXCEPT, FAILS, HOLDS, UNMEASURED  # noqa: E402

MINE, OTHER = claims.SUBJECT, "velocity"
BASE = {
    "campaign": "claims",
    "part": "p",
    "problem": "slide",
    "problem_family": "slide",
    "duration_s": 1.0,
    "tol": 1e-9,
    "solver": "lemke",
    "solver_options": "",
    "formulation_options": "",
    "step_s": 0.01,
    "effects": "gravity contact friction spatial",
    "start": "cold",
    "status": "ok",
    "good": True,
    "p": 4,
    "n_active": 4,
    "n_contacts": 4,
    "lcp_dim": 4,
    "t_total_s": 1.0,
    "cost": 1.0,
    "noise": 1.05,
    "n_steps": 10,
    "n_solves": 10,
    "n_factor": 0,
    "n_fallback": 0,
    "share_1ms": 1.0,
    "share_4ms": 1.0,
    "share_16ms": 1.0,
    "t_step_max_s": 1e-3,
    "n_predictions": 2,
    "n_predictions_missed": 0,
    "n_evaluations": 0,
    "converged": False,
    "err_ref": 1e-6,
    "err_tol": 1e-4,
    "err_worst": 0.5,
    "err_quantity": "x",
    "stiffness_ratio": math.nan,
    "penetration_m": 0.0,
    "end_value": 1.0,
    "end_quantity": "x",
    "energy_drift_rel": 0.0,
    "label": "a",
    "combination": "a",
    "mine": False,
}


def row(formulation=OTHER, **more):
    made = {**BASE, "formulation": formulation, "mine": formulation == MINE, **more}
    if "t_total_s" in more or "good" in more:
        made["cost"] = made["t_total_s"] if made["good"] else math.inf
    return made


def fails(**more):
    return {"good": False, "status": "stalled", **more}


def frame(*rows):
    return pd.DataFrame(rows)


AGAINST = {"against": {"formulation": OTHER}}


class Judge(unittest.TestCase):
    def word(self, judge, rows, ask, word, says=""):
        found = judge(frame(*rows), ask)
        self.assertIsNotNone(found)
        self.assertEqual(found.word, word, found.evidence)
        self.assertIn(says, found.evidence)
        return found.evidence


class Size(Judge):
    def test_dimension(self):
        def two(dim, active=4, other=24):
            return [
                row(MINE, lcp_dim=dim, n_active=active),
                row(lcp_dim=other, formulation_options="facets=4"),
            ]

        self.word(judges.dimension, two(4), AGAINST, HOLDS)
        self.word(judges.dimension, two(8), AGAINST, FAILS)
        more = [{**r, "problem": "stack"} for r in two(5, active=5)]  # it met another contact
        self.word(judges.dimension, two(4) + more, AGAINST, HOLDS, "1 more have other contacts")
        self.assertIsNone(judges.dimension(frame(*more), AGAINST))
        wrong = [{**r, "problem": "stack"} for r in two(8)]
        self.word(judges.dimension, two(4) + wrong, AGAINST, EXCEPT)
        self.assertIsNone(judges.dimension(frame(row(MINE)), AGAINST))
        cones = next(n for n, s in registry.listed("solvers").items() if "cone" in s["sets"])
        posed = [{**r, "solver": cones} for r in two(12)]
        self.word(judges.dimension, two(4) + posed, AGAINST, HOLDS, "1 cells were posed over cones")
        self.assertIsNone(judges.dimension(frame(*posed), AGAINST))


class Time(Judge):
    def two(self, mine, other, **more):
        return [row(MINE, t_total_s=mine, **more), row(t_total_s=other, **more)]

    def test_a_win_inside_the_noise_is_none(self):
        self.word(judges.faster, self.two(1, 2), AGAINST, HOLDS)
        self.word(judges.faster, self.two(1, 1.04), AGAINST, FAILS, "won 0, tied 1")
        self.word(judges.faster, self.two(1, 1.3, noise=1.33), AGAINST, FAILS, "tied 1")
        self.word(judges.faster, self.two(2, 1), AGAINST, FAILS)

    def test_ratios_are_of_one_solver(self):
        """Ten times faster with one solver, twice slower with another: a mean would hold."""
        rows = self.two(1, 98) + self.two(2, 1, solver="pgs")
        told = self.word(judges.faster, rows, AGAINST, EXCEPT)
        self.assertIn("lemke, cold: 98 (1 pair)", told)
        self.assertIn("pgs, cold: 0.5 (1 pair)", told)

    def test_a_start_is_a_question_of_its_own(self):
        rows = self.two(1, 5) + self.two(2, 1, start="previous")
        self.word(judges.faster, rows, AGAINST, EXCEPT, "lemke, previous: 0.5")

    def test_a_failure_is_lost(self):
        rows = [row(MINE, **fails()), row()]
        self.word(judges.faster, rows, AGAINST, FAILS, "lost 1 (lost on slide)")

    def test_each_decade_of_sizes_has_its_word(self):
        """Faster on what is small, slower on what is large: one word would hide it."""
        rows = self.two(1, 5, p=40) + self.two(5, 1, p=4000, problem="pyramid")
        self.assertEqual(
            judges.faster(frame(*rows), AGAINST).sizes,
            "40 contacts: holds; 4000 contacts: does not hold",
        )
        rows += self.two(1, 5, p=4000, solver="pgs", problem="pyramid")
        self.assertIn(
            "4000 contacts: holds with exceptions, not with lemke",
            judges.faster(frame(*rows), AGAINST).sizes,
        )
        self.assertEqual(judges.faster(frame(*self.two(1, 5, p=40)), AGAINST).sizes, "40 contacts")

    def test_deadline(self):
        def large(mine, other):
            rows = []
            for p in (4, 40):
                for form, most in ((MINE, mine), (OTHER, other)):
                    at = {c: float(p <= most) for c in judges.BUDGETS}
                    rows.append(row(form, problem=f"stack:n={p}", p=p, **at))
            return rows

        self.word(judges.deadline, large(40, 4), AGAINST, HOLDS)
        self.word(judges.deadline, large(4, 40), AGAINST, FAILS)
        self.word(judges.deadline, large(40, 40), AGAINST, EXCEPT)
        self.assertIsNone(judges.deadline(frame(row(MINE)), AGAINST))

    def test_simpler(self):
        def work(**mine):
            return [row(MINE, **mine), row(n_solves=20, n_factor=20)]

        self.word(judges.simpler, work(), AGAINST, HOLDS)
        self.word(judges.simpler, work(n_fallback=1), AGAINST, EXCEPT)
        self.word(judges.simpler, work(n_solves=90, n_factor=90), AGAINST, FAILS)

    def test_improves(self):
        ask = {"than": {"solver": "old"}}

        def beside(cost, old=1.0, good=True):
            new = row(solver="new", t_total_s=cost, **({} if good else fails()))
            return [row(solver="old", t_total_s=old), new]

        self.word(judges.improves, beside(0.5), ask, HOLDS)
        self.word(judges.improves, beside(0.98), ask, FAILS)
        self.word(judges.improves, beside(0.1, good=False), ask, FAILS, "solves 0 more and 1 less")


class WorkAgainstError(Judge):
    def test_compliant_contact_is_asked_at_the_tolerance_that_the_error_needs(self):
        soft = registry.with_trait("compliant")[0]
        tight = row(soft, t_total_s=10, formulation_options="stiffness=1e6,rtol=1e-9")
        loose = row(
            soft, t_total_s=0.1, err_ref=5e-2, formulation_options="stiffness=1e6,rtol=1e-3"
        )
        mine = row(MINE, err_ref=5e-2)
        told = self.word(judges.stiff, [mine, tight, loose], {}, FAILS)
        self.assertIn("slide at 0.1: 0.1", told)
        # rows of one tolerance would have said that it is dearer
        self.assertIsNone(judges.stiff(frame(mine, tight), {}))
        dear = {**loose, "t_total_s": 10, "cost": 10}
        self.word(judges.stiff, [mine, tight, dear], {}, HOLDS)

    def test_priced(self):
        soft = registry.with_trait("compliant")[0]

        def ladder(errors, work):
            return [
                row(
                    soft, err_ref=e, n_evaluations=n, formulation_options=f"stiffness={k},rtol=1e-9"
                )
                for k, e, n in zip((1e4, 1e6), errors, work, strict=True)
            ]

        self.word(judges.priced, ladder((1e-2, 1e-3), (10, 100)), {}, HOLDS)
        self.word(judges.priced, ladder((1e-2, 1e-3), (100, 10)), {}, EXCEPT)
        self.word(judges.priced, ladder((1e-3, 1e-2), (100, 10)), {}, FAILS)

    def test_a_plateau_does_not_converge(self):
        """It halves from the first step to the last, which the last three do not carry on."""
        steps = (0.02, 0.01, 0.005, 0.0025, 0.00125)

        def ladder(errors):
            return [row(MINE, step_s=h, err_ref=e) for h, e in zip(steps, errors, strict=True)]

        self.word(judges.converges, ladder((16, 8, 4, 2, 1)), {}, HOLDS, "order 1")
        self.word(judges.converges, ladder((16, 8, 5, 4.8, 4.7)), {}, FAILS, "plateau")
        self.word(judges.converges, ladder((4, 2, 1, 2, 4)), {}, FAILS, "grows")
        self.word(judges.converges, ladder((0, 0, 0, 0, 0)), {}, HOLDS, "exact")
        self.assertEqual(stats.tail_order((1, 2), (1, 2))[0], "short")


class Motion(Judge):
    def test_equal_predictions(self):
        def two(**mine):
            return [row(MINE, **mine), row(n_predictions=9)]

        flat = [row(MINE, n_predictions=9), row(n_predictions=9)]
        self.word(judges_motion.agreement, flat, {}, HOLDS)
        told = self.word(judges_motion.agreement, two(), {}, EXCEPT)
        self.assertIn("asked 2 predictions where the others are asked 9", told)
        self.word(judges_motion.agreement, two(n_predictions_missed=1), {}, FAILS)
        self.word(judges_motion.agreement, two(err_ref=1.0), {}, FAILS)
        self.word(judges_motion.agreement, two(**fails()), {}, FAILS, "not solved 1")

    def test_predictions(self):
        self.word(judges_motion.predictions, [row()], {}, HOLDS)
        self.word(judges_motion.predictions, [row(), row(n_predictions_missed=1)], {}, EXCEPT)
        self.word(judges_motion.predictions, [row(**fails(n_predictions=0))], {}, FAILS)

    def test_solved(self):
        ask = {"by": "solver"}
        self.word(judges_motion.solved, [row()], ask, HOLDS)
        self.word(judges_motion.solved, [row(), row(**fails())], ask, EXCEPT, "not slide (stalled)")
        self.word(judges_motion.solved, [row(**fails())] * 2 + [row()], ask, FAILS)

    def test_always(self):
        """A proof that there is none counts only where a solution ought to be."""
        closing = next(s for s in registry.scenes() if not registry.solvable(s))
        proof = {"good": False, "status": "infeasible"}
        vise = row(problem=closing, problem_family=closing, **proof)
        self.word(judges_motion.always, [row()], {}, HOLDS)
        self.word(judges_motion.always, [row(), row(**fails(solver="b"))], {}, HOLDS)
        self.word(judges_motion.always, [row(), vise], {}, EXCEPT, "1 of 1 cells prove")
        self.word(judges_motion.always, [row(), row(problem="x", **proof)], {}, FAILS)
        self.word(judges_motion.always, [row(), row(problem="x", **fails())], {}, EXCEPT)

    def test_refused(self):
        proof = row(problem="b", good=False, status="infeasible")
        self.word(judges_motion.refused, [row(), proof], {}, HOLDS)
        self.word(judges_motion.refused, [row(), row(problem="b")], {}, FAILS)
        self.word(
            judges_motion.refused, [row(), row(problem="b", **fails())], {}, UNMEASURED, "without"
        )

    def test_spread(self):
        ask = {"own": "pick=own", "beyond": 0.05}

        def ends(own, one):
            return [
                row(solver=s, end_value=e, formulation_options=f"pick={o}")
                for o, pair in (("own", own), ("one", one))
                for s, e in zip("ab", pair, strict=True)
            ]

        self.word(judges_motion.spread, ends((1, 2), (1, 1)), ask, HOLDS)
        self.word(judges_motion.spread, ends((1, 1), (1, 1)), ask, FAILS)
        self.word(judges_motion.spread, ends((1, 2), (1, 2)), ask, EXCEPT)
        self.assertIsNone(judges_motion.spread(frame(row(formulation_options="pick=own")), ask))

    def test_agree(self):
        ask = {"within": 0.01}
        self.word(judges_motion.agree, [row(MINE), row()], ask, HOLDS)
        self.word(judges_motion.agree, [row(MINE, end_value=2), row()], ask, FAILS)
        self.word(judges_motion.agree, [row(MINE, **fails()), row()], ask, FAILS, "1 not solved")
        half = [row(MINE), row(), row(MINE, problem="b", end_value=2), row(problem="b")]
        self.word(judges_motion.agree, half, ask, EXCEPT)

    def test_penetration(self):
        deep, flat = row(penetration_m=1e-3), row(penetration_m=1e-12)
        self.word(judges_motion.penetrates, [deep], {}, HOLDS)
        self.word(judges_motion.penetrates, [flat], {}, FAILS)
        self.word(judges_motion.clear, [flat], {}, HOLDS)
        self.word(judges_motion.clear, [flat, deep], {}, EXCEPT)
        self.word(judges_motion.clear, [deep], {}, FAILS)

    def test_restricted(self):
        ask = {"level": {"formulation": MINE}, **AGAINST}
        self.word(judges_motion.restricted, [row(MINE, err_ref=1.0), row()], ask, HOLDS)
        self.word(judges_motion.restricted, [row(MINE), row()], ask, FAILS)

    def test_power_law(self):
        ask = {"exponents": {"linear": 1.0}, "within": 0.01}
        right = judges_motion.depth_of(1e5, 1.0, 1.0)
        self.assertAlmostEqual(0.5e5 * right**2, 9.81 * (1 + right), places=6)

        def of(depth):
            return [
                row(
                    problem="bounce:height=1",
                    penetration_m=depth,
                    formulation_options="law=linear,stiffness=1e5",
                )
            ]

        self.word(judges_motion.power_law, of(right), ask, HOLDS)
        self.word(judges_motion.power_law, of(1.1 * right), ask, FAILS)
        self.word(judges_motion.power_law, of(right), {**ask, "missing": "of gears"}, EXCEPT)
        self.assertIsNone(judges_motion.power_law(frame(row()), ask))

    def test_realised(self):
        ask = {"within": 0.05}

        def of(e, asked=0.5):
            kept = (0.1 + e * e) / 1.1 - 1
            return row(problem=f"bounce:height=1,restitution={asked}", energy_drift_rel=kept)

        self.assertAlmostEqual(
            judges_motion.restitution_of(1, 0.1, of(0.3)["energy_drift_rel"]), 0.3
        )
        self.word(judges_motion.realised, [of(0.5)], ask, HOLDS, "0.5 at 4.4 m/s: 0.500")
        self.word(judges_motion.realised, [of(0.5), of(0.8)], ask, EXCEPT)
        self.word(judges_motion.realised, [of(0.8)], ask, FAILS)

    def test_stiffness(self):
        def ladder(*rungs):
            return [row(err_ref=1e-5)] + [row(MINE, stiffness_ratio=r, err_ref=e) for r, e in rungs]

        judge = judges_motion.stiffness
        self.word(
            judge,
            ladder((0.1, 5e-3), (30, 1e-5)),
            AGAINST,
            HOLDS,
            "error of x by G/m_t: 0.1: 5.0e-03, 30: 1.0e-05; velocity 1.0e-05",
        )
        self.word(judge, ladder((0.1, 5e-3), (30, 5e-3)), AGAINST, FAILS)  # stiff and wrong
        self.word(judge, ladder((0.1, 1e-5), (30, 1e-5)), AGAINST, FAILS)  # nothing is needed
        self.word(judge, ladder((0.1, 5e-3), (1, 5e-3), (3, 1e-5), (30, 1e-5)), AGAINST, EXCEPT)
        self.assertIsNone(judge(frame(*ladder((30, 1e-5))), AGAINST))


class Whole(unittest.TestCase):
    def test_every_statement_has_its_line(self):
        ids = [r["id"] for r in claims.ASKED["rows"]]
        self.assertEqual(len(set(ids)), 27)
        for ask in claims.ASKED["rows"]:
            self.assertIn(ask["judge"], claims.JUDGES)

    def test_every_part_is_in_its_campaign(self):
        for ask in claims.ASKED["rows"]:
            for part in ask["parts"]:
                campaign, _, name = part.partition("/")
                text = (ROOT / "harness/campaigns" / f"{campaign}.yaml").read_text()
                self.assertRegex(text, rf"(?m)^  - (name: |{{name: ){re.escape(name)}(,| *#| *$)")

    def test_readings_are_judged_apart(self):
        """The paper's reading has rows and a verdict of its own."""
        fast = row(MINE, part="size", t_total_s=0.1)
        slow = row(MINE, part="size", t_total_s=9, formulation_options="paper")
        ask = next(r for r in claims.ASKED["rows"] if r["judge"] == "faster")
        found = claims.judged(frame(fast, slow, row(part="size")), ask)
        self.assertEqual({k: v.word for k, v in found.items()}, {"ours": HOLDS, "paper": FAILS})

    def test_a_tuned_setting_is_not_ours(self):
        tuned = row(MINE, part="size", t_total_s=0.1, formulation_options="ratio=10")
        ask = next(r for r in claims.ASKED["rows"] if r["judge"] == "faster")
        found = claims.judged(frame(tuned, row(part="size")), ask)
        self.assertEqual(found["ours"].word, UNMEASURED)

    def test_another_pose_is_ours_where_the_claim_says_so(self):
        """The same law given to a solver in another form: time may count it, unknowns may not."""
        posed = row(MINE, part="size", t_total_s=0.1, formulation_options="pose=cone", lcp_dim=12)
        found = {}
        for judge in ("faster", "dimension"):
            ask = next(r for r in claims.ASKED["rows"] if r["judge"] == judge)
            found[judge] = claims.judged(frame(posed, row(part="size")), ask)
        self.assertEqual(found["faster"]["ours"].word, HOLDS)
        self.assertEqual(found["faster"]["paper"].word, UNMEASURED)
        self.assertEqual(found["dimension"]["ours"].word, UNMEASURED)

    def test_a_killed_process_is_compared(self):
        """It wrote no duration, tolerance or effects; its command and its neighbours tell them."""
        said = {"command": "lcpbench simulate s --duration '0.03'", "duration_s": 0.03}
        killed = {**said, "duration_s": math.nan, "tol": math.nan, "effects": ""}
        some = frame(row(**said), row(MINE, **fails(status="timeout"), **killed))
        for column, option, by in rows_.SILENT:
            some[column] = rows_.told(some, column, option, by)
        self.assertEqual(list(some["duration_s"]), [0.03, 0.03])
        self.assertEqual(judges.faster(some, AGAINST).word, FAILS)

    def test_without_rows_nothing_is_claimed(self):
        empty = frame(row()).iloc[:0]
        for ask in claims.ASKED["rows"]:
            for found in claims.judged(empty, ask).values():
                self.assertEqual((found.word, found.evidence), (UNMEASURED, claims.NO_ROWS))


class Commands(unittest.TestCase):
    def test_a_claim_names_a_command_for_each_part_it_reads(self):
        """Two filters of one axis match nothing together."""
        ask = {"parts": ["claims/size", "claims/size, large", "scaling/stack"]}
        some = [("claims", "size"), ("claims", "size, large"), ("claims", "steps")]
        cells = pd.DataFrame([{**BASE, "campaign": c, "part": p} for c, p in some])
        size, large = (f"lcpbench run claims --filter 'part={p}'" for p in ("size", "size, large"))
        quick = cells.assign(quick=True)
        self.assertEqual(claims.command(cells, ask).count("--quick"), 2)
        self.assertEqual(claims.command(cells.assign(quick=False), ask), f"{size}; {large}")
        self.assertEqual(claims.command(quick, ask), claims.command(cells, ask))


if __name__ == "__main__":
    unittest.main()

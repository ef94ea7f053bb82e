"""The statements of the paper, one by one, each with a verdict that a judge computed from rows, its
evidence, its range of sizes and the command that measures it again. Which rows and which judge
stands in scripts/experiments.toml; what else a claim speaks of is told by traits."""

import pandas as pd

from bench import experiments, judges, judges_motion, registry
from bench import rows as rows_
from bench.judges import EXCEPT, FAILS, HOLDS, UNMEASURED, Found, Verdict
from bench.section import Cell, Section, Table

ASKED = experiments.of("claims")
SUBJECT = ASKED["formulation"]
MARK = {HOLDS: "good", EXCEPT: "fair", FAILS: "bad", UNMEASURED: "none"}
NO_ROWS = "no rows of these parts"
JUDGES = {
    judge.__name__: judge
    for judge in (
        judges.dimension,
        judges.faster,
        judges.deadline,
        judges.simpler,
        judges.improves,
        judges.stiff,
        judges.priced,
        judges.converges,
        judges_motion.agreement,
        judges_motion.predictions,
        judges_motion.stiffness,
        judges_motion.solved,
        judges_motion.always,
        judges_motion.refused,
        judges_motion.spread,
        judges_motion.agree,
        judges_motion.penetrates,
        judges_motion.clear,
        judges_motion.restricted,
        judges_motion.power_law,
        judges_motion.realised,
    )
}


def of_parts(cells: pd.DataFrame, parts: list[str]) -> pd.DataFrame:
    """Rows of the parts that a claim reads, by 'campaign/part'."""
    return cells[(cells["campaign"] + "/" + cells["part"]).isin(parts)]


def read_as(cells: pd.DataFrame, variant: str, fixed: bool, posed: list[str]) -> pd.DataFrame:
    """Column `mine`: rows of the claims' formulation in one reading. Rows of its other readings are
    left out; so are other settings, but where the claim turns one of them up (`fixed`). Options of
    `posed` give the same law to a solver in another form, and are no other setting."""
    given = cells["formulation_options"].map(rows_.options)
    named = given.map(lambda o: o.get("variant", ""))
    more = given.map(lambda o: any(k not in ("variant", *posed) for k in o))
    subject = cells["formulation"] == SUBJECT
    mine = subject & (named == variant) & (more if fixed else ~more)
    return cells.assign(mine=mine)[mine | ~subject]


def judged(cells: pd.DataFrame, ask: dict) -> dict[str, Verdict]:
    """The verdict by reading of the formulation; of a statement that is not about it one, under
    ''."""
    some = of_parts(cells, ask["parts"])
    if "impacts" in ask:
        some = some[some["problem_family"].map(registry.situation) == ask["impacts"]]
    judge = JUDGES[ask["judge"]]
    if ask.get("own") is not True:
        found = judge(some.assign(mine=False), ask) if len(some) else None
        return {"": found or Verdict(UNMEASURED, NO_ROWS)}
    out = {}
    for reading, variant in ASKED["readings"].items():
        read = read_as(some, variant, ask.get("fixed", False), ask.get("posed", []))
        found: Found = judge(read, ask) if read["mine"].any() else None
        out[reading] = found or Verdict(
            UNMEASURED, NO_ROWS if not read["mine"].any() else "no pair of rows that could tell"
        )
    return out


def command(cells: pd.DataFrame, ask: dict) -> str:
    """What measures the rows of a claim again, in their form: one command for each part, since
    filters of one axis narrow each other; a part that needs no other campaign comes first. Parts
    that these rows do not have are left out, where they have any."""
    here = [part for part in ask["parts"] if len(of_parts(cells, [part]))] or ask["parts"]
    out = []
    for at in here:
        campaign, _, part = at.partition("/")
        whole = "quick" in cells and not cells.loc[cells["campaign"] == campaign, "quick"].all()
        out.append(f"lcpbench run {campaign}{'' if whole else ' --quick'} --filter 'part={part}'")
    return "; ".join(out)


def line(cells: pd.DataFrame, ask: dict) -> list:
    found = judged(cells, ask)
    words = []
    for reading in ("", *ASKED["readings"]):
        if reading in found:
            words.append(Cell(found[reading].word, MARK[found[reading].word]))
    if len(words) == 1:  # not about the formulation: one verdict, in the column of ours
        words.append(Cell("", "none"))
    told = [f"{reading}: {v.evidence}" if reading else v.evidence for reading, v in found.items()]
    sizes = " / ".join(dict.fromkeys(v.sizes for v in found.values() if v.sizes))
    return [ask["id"], ask["says"], *words, "\n".join(told), sizes, command(cells, ask)]


def table(cells: pd.DataFrame) -> list[list]:
    """One line for each statement; experiments with effects or orders are left to their own
    sections."""
    return [line(cells, ask) for ask in ASKED["rows"]]


def section(cells: pd.DataFrame) -> Section:
    mechanical = cells[cells["formulation"] != ""]
    if mechanical.empty:
        return None
    lines = table(mechanical)
    verdicts = [c.text for row in lines for c in row[2:4] if c.text]
    counts = pd.Series(verdicts).value_counts()
    told = ", ".join(f"{word} {int(counts.get(word, 0))}" for word in MARK)
    return Section(
        "claims",
        "The paper, sentence by sentence",
        f"Each verdict is computed from the rows; none is written by hand. {told}. Wins count"
        " beyond the noise of their campaign and size, ratios are of one solver, and a verdict"
        " speaks for the sizes beside it.",
        [],
        [
            Table(
                "claims",
                f"Statements and methods of the paper, for our own setting of {SUBJECT} and for the"
                " paper's reading of it (a statement about something else has one verdict).",
                [
                    "id",
                    "statement",
                    "verdict",
                    "the paper's reading",
                    "evidence",
                    "sizes",
                    "command",
                ],
                lines,
                code=6,
            )
        ],
        {
            "ClaimsHolding": str(int(counts.get(HOLDS, 0))),
            "ClaimsJudged": str(len(verdicts) - int(counts.get(UNMEASURED, 0))),
        },
    )

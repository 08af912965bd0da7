"""Results and decisions of claims as tables, JSON and Markdown; the page of a paper."""

import json
import math
import re
from collections import Counter
from collections.abc import Sequence
from importlib import import_module
from importlib.resources import files
from inspect import getdoc
from string import Template

from rich.console import Group
from rich.text import Text

from baselines.evaluation.tables import markdown, p_value, plain_table
from baselines.papers.claim_types import MARGIN, ClaimResult, shown
from baselines.papers.experiments import Results
from baselines.papers.paper import Paper
from baselines.papers.sequential import ERROR, LOOKS, Decided, Decision

HEADINGS = ("claim", "published", "ours", "95 % interval", "p", "reproduced")
DECISION_HEADINGS = ("claim", "says", "ours", "interval", "n", "30 episodes show", "decision")


def to_json(claim_results: Sequence[ClaimResult]) -> str:
    """Return claim results as a JSON array, one claim per line, without p."""
    rows = ({k: v for k, v in vars(each).items() if k != "p"} for each in claim_results)
    lines = (json.dumps(row, allow_nan=False) for row in rows)
    return "[\n" + ",\n".join(lines) + "\n]"


def decisions_json(decided: Sequence[Decided]) -> str:
    """Return decisions as a JSON array; values that are not finite are null."""
    rows = [
        {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in row.items()}
        for row in map(vars, decided)
    ]
    return json.dumps(rows, indent=1, allow_nan=False)


def claims_table(claim_results: Sequence[ClaimResult]) -> Group:
    """Return the claims table for a terminal."""
    rows: list[list[str | Text]] = []
    for each in claim_results:
        *cells, verdict = _cells(each)
        rows.append([*cells, Text(verdict, "green" if each.reproduced else "red")])
    return Group(plain_table(HEADINGS, rows), Text(score(claim_results), "bold"))


def decided_table(decided: Sequence[Decided]) -> Group:
    """Return the decisions for a terminal."""
    rows = map(_cells_of_decision, decided)
    return Group(plain_table(DECISION_HEADINGS, rows), Text(count(decided), "bold"))


def claims_markdown(claim_results: Sequence[ClaimResult]) -> str:
    """Return the claims table in Markdown."""
    return markdown(HEADINGS, map(_cells, claim_results))


def score(claim_results: Sequence[ClaimResult]) -> str:
    """Return the sentence with the number of reproduced claims."""
    reproduced = sum(each.reproduced for each in claim_results)
    return f"{reproduced} of {len(claim_results)} claims reproduced"


VERBS: dict[Decision, tuple[str, str]] = {  # verbs for several claims, and for one
    "holds": ("hold", "holds"),
    "equivalent": ("are equivalent", "is equivalent"),
    "undecided": ("are undecided", "is undecided"),
    "fails": ("fail", "fails"),
}


def count(decided: Sequence[Decided]) -> str:
    """Return the sentence with the number of claims of each decision."""
    each = Counter(row.decision for row in decided)
    counts = (f"{each[rank]} {verbs[each[rank] == 1]}" for rank, verbs in VERBS.items())
    return f"Of {len(decided)} claims " + ", ".join(counts)


def page(
    paper: Paper,
    claim_results: Sequence[ClaimResult],
    results: Results,
    command: str,
    decided: Sequence[Decided] = (),
) -> str:
    """Return the Markdown page of a paper: its template, filled with the results."""
    figures = "\n\n".join(
        f"![{each.caption}](figures/{each.name}.png)\n\n"
        f"*{f'{each.caption} {each.reading}'.rstrip()}*"
        for each in paper.figures
    )
    missed = [f"- {each.claim}" for each in claim_results if not each.reproduced]
    text = (files("baselines.papers") / "pages" / f"{paper.page}.md").read_text("utf-8")
    return Template(text).substitute(
        command=command,
        score=score(claim_results),
        claims=claims_markdown(claim_results),
        table=paper.table(results),
        decided=_decided(decided),
        missed="\n".join(missed) or "Nothing.",
        figures=figures,
        left_open="\n\n".join(
            f"### {title}\n\n{left_open(place)}" for title, place in paper.left_open.items()
        ),
    )


DECIDED = f"""## Decided by more episodes

Episodes are added to a claim until the interval of its effect decides it, or there are
{LOOKS[-1]}; *undecided* at fewer means that the run was stopped there. A claim holds if the
interval lies where it says, fails if the interval lies outside, and is *equivalent* if two sides,
of which it says that one is above, differ by less than {MARGIN:.0%}. *Ours* is a mean, or the ratio
of two over the same seeds, with Fieller's interval, and the share of episodes in which something
happened has the exact one of Clopper and Pearson; of several it is the least.
*{LOOKS[0]} episodes show* is half of the 95 % interval that {LOOKS[0]} episodes a side give where
seeds are not shared. The probability that a claim is decided wrongly is {ERROR:.0%} at most, by
Bonferroni's bound over {len(LOOKS)} looks
(`baselines.papers.sequential`)."""


def _decided(decided: Sequence[Decided]) -> str:
    if not decided:
        return ""
    table = markdown(DECISION_HEADINGS, map(_cells_of_decision, decided))
    return f"{DECIDED}\n\n{count(decided)}.\n\n{table}\n\n"


def left_open(place: str) -> str:
    """Return the list after "Not in the paper" in the docstring of `module` or `module:name`."""
    module, _, name = place.partition(":")
    home = import_module(module)
    text = getdoc(getattr(home, name) if name else home) or ""
    listed = re.search(r"(?:[^\n]+\n)*[^\n]*Not in the papers?\b.*?(?=\n\n|\Z)", text, re.DOTALL)
    if listed is None:
        raise ValueError(f"{place} does not say what the paper leaves open")
    return re.sub(r":\n-", ":\n\n-", listed[0], count=1)


def _cells(result: ClaimResult) -> tuple[str, ...]:
    published, low, high = result.published, result.low, result.high
    return (
        result.claim,
        published if isinstance(published, str) else shown(published),
        "-" if result.ours is None else shown(result.ours),
        "-" if low is None or high is None else f"{shown(low)} to {shown(high)}",
        "-" if result.p is None else p_value(result.p),
        "yes" if result.reproduced else "no",
    )


def _cells_of_decision(row: Decided) -> tuple[str, ...]:
    ends = f"{shown(row.low)} to {shown(row.high)}" if math.isfinite(row.low) else "-"
    shows = "-" if math.isnan(row.resolved) else f"± {100.0 * row.resolved:.2g} %"
    ours = "-" if math.isnan(row.ours) else shown(row.ours)
    return row.claim, row.range, ours, ends, str(row.n), shows, row.decision

"""The cards for a terminal."""

import textwrap
from collections.abc import Sequence

from rich.console import Group
from rich.table import Table
from rich.text import Text

from training.ladder.algorithms import Algorithm
from training.ladder.rungs import RANDOM, Rung


def tables(rungs: Sequence[Rung], algorithms: Sequence[Algorithm]) -> Group:
    """Every rung with its scores and what is hard, then the algorithms."""
    parts: list[Text | Table] = []
    for rung in rungs:
        card = rung.card
        parts.append(Text(f"{card.rung} {rung.name}", style="bold").append(f"  {card.title}"))
        parts.append(Text(textwrap.fill(card.hard, 78)))
        shown = [name for name in (RANDOM, *rung.references) if name in card.scores]
        scores = ", ".join(f"{name} {card.scores[name].mean:.1f}" for name in shown)
        parts += [Text(scores or "no scores yet: swarm-forage benchmark cards"), Text()]
    table = Table(box=None, padding=(0, 2, 0, 0))
    for heading in ("algorithm", "", "trained by"):
        table.add_column(heading)
    for each in algorithms:
        table.add_row(each.name, each.title, each.trainer)
    return Group(*parts, table)

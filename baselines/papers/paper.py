"""A paper: its claims, its figures, and the cells they need."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from baselines.evaluation.configuration import Configuration
from baselines.evaluation.runner import Plan
from baselines.papers.cells import Cell, Results
from baselines.papers.figures import Picture
from baselines.papers.findings import Claim, Finding
from swarm_forage_env.registry import Registry


@dataclass(frozen=True)
class Paper:
    """What a paper says and shows."""

    name: str
    """On the command line."""

    page: str
    """Name of its page, without ending."""

    claims: tuple[Claim, ...]
    pictures: tuple[Picture, ...]

    replications: int
    """Of each cell, in the paper."""

    left_open: Mapping[str, str]
    """Whose docstring says what the paper leaves open, by heading."""

    table: Callable[[Results], str] = lambda results: ""
    """A table of its page, in Markdown, for a page that has one."""

    @property
    def cells(self) -> tuple[Cell, ...]:
        """Every cell that a claim or a figure needs, once; those with the longest runs first."""
        parts: tuple[Claim | Picture, ...] = (*self.claims, *self.pictures)
        found = dict.fromkeys(cell for part in parts for cell in part.cells)
        return tuple(sorted(found, key=_robot_steps, reverse=True))

    def configurations(
        self, physics: str | None, settings: Sequence[str] = ()
    ) -> list[Configuration]:
        """Of its cells, in their order; settings change numbers of every scenario."""
        return [cell.configuration(physics, settings) for cell in self.cells]

    def results(self, plan: Plan) -> Results:
        """The episodes of a plan that has been carried out, by cell."""
        episodes, n_seeds = plan.results(), len(plan.seeds)
        return {
            cell: episodes[index * n_seeds : (index + 1) * n_seeds]
            for index, cell in enumerate(self.cells)
        }

    def judge(self, results: Results) -> list[Finding]:
        """The claims table."""
        return [claim.judge(results) for claim in self.claims]


PAPERS: Registry[Callable[[], Paper]] = Registry("paper")
"""The papers by name."""


def _robot_steps(cell: Cell) -> int:
    scenario = cell.configuration(None).scenario
    return scenario.n_ticks * scenario.task.n_robots

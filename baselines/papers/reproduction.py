"""A reproduction of a paper: run what is missing, judge the claims, write figures and page."""

import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import baselines.papers.adaptive_boids
import baselines.papers.ants2008
import baselines.papers.boids_foraging
import baselines.papers.social_odometry
from baselines.evaluation.dataset import Dataset
from baselines.evaluation.progress import carry_out
from baselines.evaluation.request import check_count
from baselines.evaluation.runner import Plan
from baselines.papers import report
from baselines.papers.cells import Results
from baselines.papers.duration import expected_seconds, in_words
from baselines.papers.figures import write_figures
from baselines.papers.findings import Finding
from baselines.papers.paper import PAPERS
from swarm_forage_env.physics import ENGINES
from swarm_forage_env.streams import checked_seed

ENTERED = (
    baselines.papers.social_odometry,
    baselines.papers.ants2008,
    baselines.papers.adaptive_boids,
    baselines.papers.boids_foraging,
)
"""Importing a paper's module enters it in the registry."""


@dataclass(frozen=True)
class Wish:
    """What a user asks `reproduce` for."""

    paper: str
    episodes: int | None = None
    """None: as many as in the paper."""
    seed: int = 0
    physics: str | None = None
    """None: the one that each scenario goes with."""
    settings: Sequence[str] = ()
    """Numbers of every scenario to change: `task.duration=600`."""

    @property
    def command(self) -> str:
        """The command that makes the same episodes again."""
        options = [f"--set={each}" for each in self.settings]
        options += [f"--episodes={self.replications}", f"--seed={self.seed}"]
        options += [f"--physics={self.physics}"] if self.physics else []
        return shlex.join(["swarm-forage", "reproduce", self.paper, *options])

    @property
    def replications(self) -> int:
        """Of each cell."""
        return PAPERS[self.paper]().replications if self.episodes is None else self.episodes

    @property
    def seeds(self) -> range:
        """The seeds of the replications."""
        check_count("--episodes", self.replications)
        first = checked_seed(self.seed)
        return range(first, checked_seed(first + self.replications - 1) + 1)


class Reproduction:
    """One paper, its replications, and the folder they are kept in."""

    def __init__(self, wish: Wish, out: Path | None = None) -> None:
        """Check what is asked for, and look for what there is; nothing runs yet."""
        if wish.physics is not None:
            _ = ENGINES[wish.physics]
        self.paper = PAPERS[wish.paper]()
        self.command = wish.command
        self.folder = out or Path("runs") / f"reproduce-{wish.paper}"
        configurations = self.paper.configurations(wish.physics, wish.settings)
        dataset = Dataset(self.folder / "episodes")
        dataset.open()
        self.plan = Plan(configurations, wish.seeds, dataset)

    def carry_out(self, workers: int, say: Callable[[str], None]) -> None:
        """Say how long it will take, and run what is missing."""
        seconds = expected_seconds(self.plan, workers)
        say(f"about {in_words(seconds)} to run, with {workers} at a time")
        carry_out(self.plan, workers, say)

    @cached_property
    def results(self) -> Results:
        """The episodes of every cell; all must have been run."""
        return self.paper.results(self.plan)

    def findings(self) -> list[Finding]:
        """The claims table."""
        return self.paper.judge(self.results)

    def write(self, findings: Sequence[Finding], page: Path | None = None) -> list[Path]:
        """Write claims, figures and page; the files of claims and page."""
        page = page or self.folder / f"{self.paper.page}.md"
        write_figures(self.paper.pictures, self.results, page.parent / "figures", self.command)
        claims = self.folder / "claims.json"
        claims.write_text(report.to_json(findings) + "\n", "utf-8")
        text = report.page(self.paper, findings, self.results, self.command)
        page.write_text(text, "utf-8")
        return [claims, page]

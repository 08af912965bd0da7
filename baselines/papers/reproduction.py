"""Reproduction of a paper: run missing episodes, judge the claims, write figures and page."""

import shlex
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from baselines.evaluation.backends import Backend
from baselines.evaluation.console import say
from baselines.evaluation.dataset import Dataset
from baselines.evaluation.evaluate_options import check_physics, seeds_from
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.runner import Plan, run_with_progress, warm_up, worlds_in_a_block
from baselines.papers import report
from baselines.papers.claim_types import ClaimResult
from baselines.papers.experiments import Experiment, Results
from baselines.papers.figures import write_figures
from baselines.papers.paper import find_paper
from baselines.papers.sequential import Decided, decide_all
from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.loop import Loop

PROBE = 0.3  # computing time of a probe [s]; the same before it lets the robots meet
BEAT = 20  # ticks between two readings of the clock
ADAPTIVE = "adaptive"  # value of --episodes: as many as decide each claim


def expected_seconds(plan: Plan, workers: int) -> float:
    """Return the expected time of the missing episodes [s], by one controller of a kind per
    scenario and engine."""
    speeds: dict[str, float] = {}
    total = 0.0
    for key, configuration in {each.key: each for each in plan.configurations}.items():
        if key in plan.todo:
            scenario, kind = configuration.scenario, type(configuration.controller).__name__
            known = f"{scenario.name} {scenario.task.n_robots} {kind} {configuration.physics}"
            if known not in speeds:
                speeds[known] = seconds_per_tick(configuration)
            total += len(plan.todo[key]) * scenario.n_ticks * speeds[known]
    return total / workers


def seconds_per_tick(configuration: ExperimentConfig) -> float:
    """Return the computing time of one tick of one world in a block of the usual size [s]."""
    warm_up(configuration)
    n_worlds = worlds_in_a_block(configuration)
    scenario, controller = configuration.scenario, configuration.controller
    loop = Loop(scenario, controller, range(n_worlds), configuration.physics)
    for _ in range(2):  # the second counts
        ticks, begin = 0, time.perf_counter()
        while (spent := time.perf_counter() - begin) < PROBE:
            loop.run(BEAT)
            ticks += BEAT
    return spent / ticks / n_worlds


def format_duration(seconds: float) -> str:
    """Format a duration for a reader: 1.5 h, 2 min or 4 s."""
    if seconds >= 3600.0:
        return f"{seconds / 3600.0:.1f} h"
    return f"{seconds / 60.0:.0f} min" if seconds >= 60.0 else f"{seconds:.0f} s"


@dataclass(frozen=True)
class ReproduceOptions:
    """Options of the command `reproduce`."""

    paper: str
    episodes: int | None = None  # None: as in the paper
    adaptive: bool = False  # afterwards as many as decide each claim
    seed: int = 0
    physics: str | None = None  # None: the default of each scenario
    settings: Sequence[str] = ()  # changes of every scenario: `task.duration=600`
    policies: Sequence[str] = ()  # instead of those of the paper

    @property
    def command(self) -> str:
        """Command line that repeats the same episodes."""
        options = [f"--policy={each}" for each in self.policies]
        options += [f"--set={each}" for each in self.settings]
        episodes = ADAPTIVE if self.adaptive else self.replications
        options += [f"--episodes={episodes}", f"--seed={self.seed}"]
        options += [f"--physics={self.physics}"] if self.physics else []
        return shlex.join(["swarm-forage", "reproduce", self.paper, *options])

    @property
    def replications(self) -> int:
        """Number of replications of each experiment."""
        paper = find_paper(self.paper, self.policies)
        return paper.replications if self.episodes is None else self.episodes


def results_of(plan: Plan, experiments: Sequence[Experiment]) -> Results:
    """Return the episodes of a finished plan, by experiment."""
    return dict(zip(experiments, plan.by_configuration(), strict=True))


class Reproduction:
    """Reproduction of a paper: the plan of its episodes and the folder that they are saved in."""

    def __init__(
        self, options: ReproduceOptions, out: Path | None = None, page: Path | None = None
    ) -> None:
        """Check the options and look for saved episodes; no episode runs yet."""
        if options.physics is not None:
            check_physics(options.physics)
        self.paper = find_paper(options.paper, options.policies)
        self.options, self.command = options, options.command
        self.folder = out or Path("runs") / f"reproduce-{options.paper}"
        self.page = page or self.folder / f"{self.paper.page}.md"
        self._dataset = Dataset(self.folder / "episodes")
        self._dataset.open()
        self.plan = self._plan(self.paper.experiments, options.replications)
        self.decided: list[Decided] = []
        self.files: list[Path] = []  # files of the last `write`

    def run_with_progress(self, backend: Backend) -> None:
        """Print the expected time, and run the missing episodes."""
        seconds = expected_seconds(self.plan, backend.workers * backend.threads)
        say(f"about {format_duration(seconds)} to run, {backend.workers} episodes at a time")
        run_with_progress(self.plan, backend)

    def decide(self, backend: Backend) -> None:
        """Run as many episodes as decide each claim, at most 400; write decisions at each look."""

        def run(experiments: Sequence[Experiment], n: int) -> Results:
            plan = self._plan(experiments, n)
            run_with_progress(plan, backend)
            return results_of(plan, experiments)

        for decided in decide_all(self.paper.claims, run):
            self.decided = decided
            self.write()

    def _plan(self, experiments: Sequence[Experiment], n: int) -> Plan:
        of = self.options
        configurations = [each.configuration(of.physics, of.settings) for each in experiments]
        return Plan(configurations, seeds_from(of.seed, n), self._dataset)

    @cached_property
    def results(self) -> Results:
        """Episodes of every experiment; all must have been run."""
        return results_of(self.plan, self.paper.experiments)

    @cached_property
    def claim_results(self) -> list[ClaimResult]:
        """Result of every claim."""
        return self.paper.judge(self.results)

    def write_figures(self, style: str) -> None:
        """Draw the figures next to the page; episodes added for a claim do not change them."""
        folder = self.page.parent / "figures"
        write_figures(self.paper.figures, self.results, folder, self.command, style)

    def write(self) -> None:
        """Write the claims, the page, and the decisions so far."""
        texts = {self.folder / "claims.json": report.to_json(self.claim_results) + "\n"}
        if self.decided:
            texts[self.folder / "decisions.json"] = report.decisions_json(self.decided) + "\n"
        judged = self.claim_results, self.results, self.command, self.decided
        texts[self.page] = report.page(self.paper, *judged)
        for file, text in texts.items():
            write_atomically(file, text.encode())
        self.files = list(texts)

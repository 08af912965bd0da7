"""Papers: the claims and figures of each, and the experiments that they need."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module

from baselines.evaluation.experiment_config import parse_settings
from baselines.papers.claim_types import Claim, ClaimResult
from baselines.papers.commands_reproduce import PAPER_NAMES
from baselines.papers.experiments import Experiment, Results
from baselines.papers.figures import PaperFigure
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.scenarios import find_scenario


@dataclass(frozen=True)
class Paper:
    """Claims, figures and experiments of a paper."""

    name: str
    """Name on the command line."""
    claims: tuple[Claim, ...]
    figures: tuple[PaperFigure, ...]
    replications: int
    """Number of replications of each experiment in the paper."""
    left_open: Mapping[str, str]
    """Modules or classes whose docstrings list what the paper leaves open, by heading."""
    table: Callable[[Results], str] = lambda results: ""
    """Returns the table of the page in Markdown; empty for a page without one."""

    @property
    def page(self) -> str:
        """Name of the page, without ending."""
        return self.name.replace("-", "_")

    @cached_property
    def experiments(self) -> tuple[Experiment, ...]:
        """Every experiment that a claim or figure needs, once; the longest runs first."""
        parts: tuple[Claim | PaperFigure, ...] = (*self.claims, *self.figures)
        needed = dict.fromkeys(experiment for part in parts for experiment in part.experiments)
        return tuple(sorted(needed, key=_robot_steps, reverse=True))

    def judge(self, results: Results) -> list[ClaimResult]:
        """Return the result of every claim."""
        return [claim.judge(results) for claim in self.claims]


def find_paper(name: str, policies: Sequence[str] = ()) -> Paper:
    """Return the paper with a name, `PAPER` of its module; UnknownNameError if there is none.

    `policies` take the place of the bundled ones; ConfigError for a paper that compares none.
    """
    if name not in PAPER_NAMES:
        raise UnknownNameError("paper", name, PAPER_NAMES)
    module = import_module(f"baselines.papers.{name.replace('-', '_')}")
    if policies and not hasattr(module, "paper"):
        raise ConfigError(f"--policy: {name} compares no policies; leave it out, or use transfer")
    paper: Paper = module.paper(policies) if policies else module.PAPER
    return paper


def _robot_steps(experiment: Experiment) -> int:
    scenario = find_scenario(experiment.scenario, parse_settings(experiment.settings))
    return int(scenario.n_ticks * scenario.task.n_robots)

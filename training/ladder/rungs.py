"""Rungs, which are the tasks of the ladder, and algorithms: each a file of keywords."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal, TypeVar

import yaml
from pydantic import Field

from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.parameters import BaseScenario, Count, Parameters, Positive, validated
from swarm_forage_env.scenarios import find_scenario

FOLDER = Path(__file__).parents[1] / "benchmarl_tasks" / "conf" / "task" / "swarm_forage"

Keywords = Mapping[str, Any]
"""Keywords of `parallel_env`."""

NEEDED = {"scenario": "es1", "learn": "motion", "discount": 0.99}
"""Keywords that the file of a rung must have, each with an example."""

ALGORITHMS = Path(__file__).parent / "algorithms"

DEFAULTS = (
    "cleanrl_ppo", "ippo", "mappo", "sb3_dqn", "sb3_ppo", "sb3_ppo_defaults", "sb3_sac",
)  # fmt: skip
"""Algorithms that `benchmark defaults` trains."""

NamedT = TypeVar("NamedT")

RANDOM = "random"
"""Name of the policy of random actions."""

MARK = "  # Written by `swarm-forage benchmark cards`: means of test episodes, 95 % intervals.\n"
"""Line of a rung's file below which everything is generated."""


class Score(Parameters):
    """Mean over test episodes and its 95 % interval, which is None if all are equal."""

    mean: float = 0.0
    low: float | None = None
    high: float | None = None
    episodes: Count = 1


class Card(Parameters):
    """Card of a rung: what the task is, how it is scored, and what others score."""

    rung: Count = Field(1, description="Number of the rung on the ladder")
    title: str = Field("", description="Title of the rung")
    hard: str = Field("", description="Difficulty of the rung, in words")
    robot_steps: Count = Field(1_000_000, description="Training length, over all robots [ticks]")
    controllers: tuple[str, ...] = Field(("nc", "ssgikf"), description="Hand-written controllers")
    also: tuple[str, ...] = Field(
        ("learned-motion", "learned-both", "learned-ppo", "learned-generalist"),
        description="Bundled policies",
    )
    oracle: str = Field("no-error", description="Oracle with a normalised score of 1")
    test: Keywords = Field({}, description="Changed keywords of the test worlds")
    episodes: Count = Field(30, description="Number of test episodes")
    curve_episodes: Count = Field(4, description="Held-back episodes of an evaluation in training")
    scores: Mapping[str, Score] = Field({}, description="Score of each of these")


@dataclass(frozen=True)
class Rung:
    """Task of the ladder."""

    name: str
    file: Path
    keywords: Keywords
    """Keywords of `parallel_env` in training."""
    card: Card

    @property
    def test_keywords(self) -> dict[str, Any]:
        """Keywords of the test worlds, which use the default engine of the scenario.

        Changes of the training scenario do not apply to another test scenario.
        """
        keywords = {name: value for name, value in self.keywords.items() if name != "physics"}
        if "scenario" in self.card.test:
            keywords = {name: value for name, value in keywords.items() if "." not in name}
        return {**keywords, **self.card.test}

    @property
    def test_scenario(self) -> BaseScenario:
        """Scenario of the test worlds."""
        keywords = self.test_keywords
        changes = {name: value for name, value in keywords.items() if "." in name}
        scenario: BaseScenario = find_scenario(keywords["scenario"], changes)
        return scenario

    @property
    def references(self) -> Sequence[str]:
        """Controllers that are scored for comparison, each once."""
        card = self.card
        return list(dict.fromkeys((*card.controllers, *card.also, card.oracle)))

    @property
    def scores(self) -> dict[str, Score]:
        """Scores on the card: of random actions, then of the references."""
        names = (RANDOM, *self.references)
        return {name: self.card.scores[name] for name in names if name in self.card.scores}

    def normalised(self, score: float) -> float:
        """Scale a score to 0 for random actions and 1 for the oracle; ConfigError without these."""
        scores = self.card.scores
        if RANDOM not in scores or self.card.oracle not in scores:
            raise ConfigError(f"rung '{self.name}': no scores; run swarm-forage benchmark cards")
        low, high = scores[RANDOM].mean, scores[self.card.oracle].mean
        return (score - low) / (high - low)


@cache
def read_rungs(folder: Path = FOLDER) -> dict[str, Rung]:
    """Read the rungs of a folder by name, the easiest first, without files that have no card.

    ConfigError for a file whose keywords or card do not do.
    """
    rungs = []
    for file in folder.glob("*.yaml"):
        keywords = yaml.safe_load(file.read_text(encoding="utf-8"))
        card = keywords.pop("card", None)
        if card is not None:
            for name, example in NEEDED.items():
                if name not in keywords:
                    raise ConfigError(f"{file}: has no {name}; add it, as in {name}: {example}")
            rungs.append(Rung(file.stem, file, keywords, validated(Card, card, str(file))))
    return {rung.name: rung for rung in sorted(rungs, key=lambda each: each.card.rung)}


def find_named(kind: str, names: Sequence[str] | None, known: Mapping[str, NamedT]) -> list[NamedT]:
    """Return the entries of these names, or all. UnknownNameError for an unknown name."""
    for name in names or ():
        if name not in known:
            raise UnknownNameError(kind, name, known)
    return [each for name, each in known.items() if not names or name in names]


def write_scores(rung: Rung, scores: Mapping[str, Score]) -> None:
    """Write scores to the end of a rung's file, in place of older ones."""
    text, _, _ = rung.file.read_text(encoding="utf-8").partition(MARK)
    text += f"{MARK}  scores:\n"
    for name, score in scores.items():
        numbers = ", ".join(f"{key}: {_number(value)}" for key, value in score)
        text += f"    {name}: {{{numbers}}}\n"
    write_atomically(rung.file, text.encode())
    read_rungs.cache_clear()


def _number(value: float | None) -> str:
    return "null" if value is None else f"{value:.4g}"


class Algorithm(Parameters):
    """Algorithm of the ladder: its library and settings, which are tuned on no rung."""

    name: str = Field("", description="Name of its file")
    title: str = Field("", description="Title on figures and pages")
    trainer: Literal["sb3", "cleanrl", "benchmarl", "own", "offline"] = Field(
        "sb3", description="Library that trains it"
    )
    algorithm: str = Field("", description="Name in the library; none: PPO")
    worlds: Count = Field(8, description="Number of parallel worlds (not BenchMARL)")
    settings: Keywords = Field(
        {}, description="Keywords of PPO, of BenchMARL's algorithm, or of cloning"
    )
    experiment: Keywords = Field({}, description="Changed settings of BenchMARL's experiment")
    keywords: Keywords = Field({}, description="Changed keywords of `parallel_env`")
    share: Positive = Field(1.0, description="Share of a rung's robot-steps, for a slow algorithm")
    rungs: tuple[str, ...] = Field((), description="Rungs that it is for; none: all")


@cache
def read_algorithms(folder: Path = ALGORITHMS) -> dict[str, Algorithm]:
    """Read the algorithms of a folder by name."""
    algorithms = {}
    for file in sorted(folder.glob("*.yaml")):
        tree = {**yaml.safe_load(file.read_text(encoding="utf-8")), "name": file.stem}
        algorithms[file.stem] = validated(Algorithm, tree, str(file))
    return algorithms


def title_of(algorithm: str) -> str:
    """Return the name of an algorithm on figures and pages."""
    return read_algorithms()[algorithm].title


def find_algorithms(names: Sequence[str] | None) -> list[Algorithm]:
    """Return the algorithms of these names, or all. UnknownNameError for an unknown name."""
    return find_named("algorithm", names, read_algorithms())

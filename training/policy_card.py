"""Policy cards: under which keywords a policy of another trainer was trained.

`SwarmVecEnv` puts a card on its observation space, and so stable-baselines3 keeps it in what
`model.save("model.zip")` writes, as plain JSON. Beside other files it lies as JSON of the same
name: `save_policy_card("policy.pt", "es1", learn="motion", decision_period=5)`.
"""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from gymnasium.spaces import Box
from pydantic import Field, ValidationError, model_validator

from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.envs.config import EnvConfig, PolicyKeywords
from swarm_forage_env.envs.make import EnvParts, checked_parts
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.envs.registration import keywords_of
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import Controller
from swarm_forage_env.parameters import Part
from swarm_forage_env.registry import CONTROLLERS
from training.foreign_file import LARGEST_CARD, read_file, reason
from training.policy_file import TrainingRecord

ON_SPACE = "policy_card"
"""Attribute of an observation space that holds a card as JSON."""

Word = Annotated[str, Field(max_length=1000, pattern=r"^\P{C}*$")]
"""What a message can quote: no line ends, nothing that a terminal obeys."""


class CardKeywords(PolicyKeywords):
    """Keywords of `parallel_env` by which observations are made and actions read.

    There are no others on a card: which file is run and whether it is trusted, a name says alone.
    """

    observation: Word = "layer"


class PolicyCard(Part):
    """What a policy was trained on."""

    format: Literal[2] = 2
    """Version of the card; 1 was of environments of version 1, and another one is refused."""
    scenario: Word
    controller: Word
    """What did the rest, as `ssgiff:weighting.beta=0.01`."""
    keywords: CardKeywords
    observes: tuple[tuple[Word, Word], ...]
    """Name and unit of each number of an observation."""
    training: TrainingRecord | None = None
    """How `swarm-forage train` has trained it."""

    @model_validator(mode="before")
    @classmethod
    def _of_version_1(cls, told: Any) -> Any:  # noqa: ANN401 whatever was read
        """A card of format 1 says what was the default then."""
        if not isinstance(told, dict) or told.get("format") != 1:
            return told
        keywords, scenario = told.get("keywords"), told.get("scenario")
        if not isinstance(keywords, dict) or not isinstance(scenario, str):
            return told
        first = keywords_of(1, scenario)
        if keywords.get("residual") or keywords.get("action") not in (None, "drive"):
            first.pop("action", None)
        return {**told, "format": 2, "keywords": {**keywords, **first}}


def card_of(parts: EnvParts) -> PolicyCard:
    """The card of a policy that is trained under checked keywords of `parallel_env`."""
    config = parts.config
    form = PolicyForm([parts.scenario], config)
    keywords = {name: getattr(config, name) for name in CardKeywords.model_fields}
    return PolicyCard(
        scenario=parts.scenario.name,
        controller=_text(parts.controller),
        keywords=CardKeywords(**{**keywords, "observation": "+".join(_names(config))}),
        observes=form.observes,
    )


def save_policy_card(
    file: str | Path,
    scenario: Any = "es1",  # noqa: ANN401 a name, a file or a scenario of any task
    controller: str | Controller | None = None,
    **options: Any,  # noqa: ANN401 as parallel_env
) -> Path:
    """Write the card of a policy file beside it, under the keywords that it was trained with."""
    card = card_of(checked_parts(scenario, controller, options))
    path = Path(file).with_suffix(".json")
    write_atomically(path, (card.model_dump_json(indent=1) + "\n").encode())
    return path


def read_policy_card(file: str | Path) -> PolicyCard | None:
    """The card beside a policy file; None without one, ConfigError for one that is none."""
    path = Path(file).with_suffix(".json")
    if not os.path.lexists(path):
        return None
    return card_from(read_file(path, "card", LARGEST_CARD), str(path))


def card_from(text: str | bytes, where: str) -> PolicyCard:
    """The card that a text holds; ConfigError if it holds none."""
    try:
        return PolicyCard.model_validate_json(text)
    except ValidationError as error:
        raise ConfigError(
            f"card {where}: {reason(error)}; take it away, and say what the policy was trained"
            " with, as in decision_period=5"
        ) from None


def as_in_a_name(keywords: Mapping[str, object]) -> str:
    """Keywords as the name of a policy says them.

    >>> as_in_a_name({"normalise": True, "discrete": (3, 5), "learn": "motion"})
    'normalise=true, discrete=3x5, learn=motion'
    """
    said = {name: str(value) for name, value in keywords.items()}
    for name, value in keywords.items():
        if isinstance(value, tuple):
            said[name] = "x".join(map(str, value))
        elif isinstance(value, bool):
            said[name] = said[name].lower()
        elif isinstance(value, float):
            said[name] = f"{value:g}"
    return ", ".join(f"{name}={text}" for name, text in said.items())


def with_card(space: Box, card: PolicyCard) -> Box:
    """A copy of an observation space that carries a card along, also through pickle."""
    found = Box(space.low, space.high, dtype=np.float32)
    setattr(found, ON_SPACE, card.model_dump_json())
    return found


def _names(config: EnvConfig) -> Sequence[str]:
    """What is observed, by name; a class of the user's own by its path."""
    given = config.observation
    listed = list(given) if isinstance(given, list | tuple) else [given]
    return [each if isinstance(each, str) else _path(each) for each in listed]


def _path(observation: object) -> str:
    made_by = observation if isinstance(observation, type) else type(observation)
    return f"{made_by.__module__}:{made_by.__qualname__}"


def _text(controller: Controller) -> str:
    """A controller as its name and the parameters that differ from those of that name."""
    name = str(controller.name)
    if name not in CONTROLLERS or not hasattr(controller, "parameters"):
        return name
    usual = CONTROLLERS[name].parameters
    changes = [f"{k}={v}" for k, v in controller.parameters.items() if usual.get(k) != v]
    return f"{name}:{','.join(changes)}" if changes else name

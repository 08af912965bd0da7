"""Policy cards: the keywords under which a policy of another trainer was trained.

Every environment has a card on its observation space, so that stable-baselines3 saves it with
`model.save("model.zip")`, as plain JSON. Beside other files, the card is a JSON file of the same
name: `save_policy_card("policy.pt", "es1", learn="motion", decision_period=5)`.
"""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal, Unpack

from pydantic import Field, ValidationError, model_validator

from swarm_forage_env.controllers import Controllers
from swarm_forage_env.envs.config import PolicyKeywords
from swarm_forage_env.envs.keywords import EnvOptions
from swarm_forage_env.envs.make import EnvParts, checked_parts, made_with
from swarm_forage_env.envs.registration import keywords_of
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.parameters import Parameters, Positive
from swarm_forage_env.scenarios import ScenarioSource
from training.foreign_file import LARGEST_CARD, read_file, reason
from training.policy_file import TrainingRecord, write_card

Word = Annotated[str, Field(max_length=1000, pattern=r"^\P{C}*$")]
"""Text that a message can quote: without line breaks and control characters."""


class CardKeywords(PolicyKeywords):
    """Keywords of `parallel_env` that determine observations and actions.

    A card holds no others: only the name of a policy selects the file that is run and trusted.
    """

    observation: Word = "layer"


class PolicyCard(Parameters):
    """Card of a policy: the scenario, controller and keywords of its training."""

    format: Literal[2] = 2
    """Version of the card; a card of version 1 is converted, any other version is refused."""
    scenario: Word
    controller: Word
    """Controller of the other layers, such as `ssgiff:weighting.beta=0.01`."""
    keywords: CardKeywords
    observes: tuple[tuple[Word, Word], ...]
    """Name and unit of each feature of the observation."""
    sizes: tuple[Positive, ...] = ()
    """Typical size of each feature of a single observation, by which a training with `randomise`
    normalised it; empty: those of the scenario in which the policy runs."""
    training: TrainingRecord | None = None
    """Record of the training by `swarm-forage train`."""

    @model_validator(mode="before")
    @classmethod
    def _of_version_1(cls, card: object) -> object:
        """Add the defaults of version 1 to a card of format 1."""
        if not isinstance(card, dict) or card.get("format") != 1:
            return card
        keywords, scenario = card.get("keywords"), card.get("scenario")
        if not isinstance(keywords, dict) or not isinstance(scenario, str):
            return card
        first = keywords_of(1, scenario)
        if keywords.get("residual") or keywords.get("action") not in (None, "drive"):
            first.pop("action", None)
        return {**card, "format": 2, "keywords": {**keywords, **first}}


def card_of(parts: EnvParts) -> PolicyCard:
    """Return the card of a policy that is trained under checked keywords of `parallel_env`."""
    return PolicyCard.model_validate_json(made_with(parts.form, parts.controller))


def save_policy_card(
    file: str | Path,
    scenario: ScenarioSource = "es1",
    controller: Controllers | None = None,
    **options: Unpack[EnvOptions],
) -> Path:
    """Write the card of a policy file beside it, with the keywords of its training.

    Args:
        file: File of the policy, such as `policy.pt`; the card is `policy.json` beside it.
        scenario: The scenario of the training.
        controller: Controller of the layers that were not learned.
        **options: The other keywords of `parallel_env`.
    """
    card = card_of(checked_parts(scenario, controller, options))
    path = Path(file).with_suffix(".json")
    write_card(path, card)
    return path


def read_policy_card(file: str | Path) -> PolicyCard | None:
    """Read the card beside a policy file; None without one. ConfigError if it is not valid."""
    path = Path(file).with_suffix(".json")
    if not os.path.lexists(path):
        return None
    return card_from(read_file(path, "card", LARGEST_CARD), str(path))


def card_from(text: str | bytes, where: str) -> PolicyCard:
    """Return the card that a text holds. ConfigError if it holds none."""
    try:
        return PolicyCard.model_validate_json(text)
    except ValidationError as error:
        raise ConfigError(
            f"card {where}: {reason(error)}; remove it, and give the keywords of the policy's"
            " training, as in decision_period=5"
        ) from None


def as_keywords(keywords: Mapping[str, object]) -> str:
    """Return keywords as they are written in the name of a policy.

    >>> as_keywords({"normalise": True, "discrete": (3, 5), "learn": "motion"})
    'normalise=true, discrete=3x5, learn=motion'
    """
    return ", ".join(f"{name}={_in_a_name(value)}" for name, value in keywords.items())


def _in_a_name(value: object) -> str:
    if isinstance(value, tuple):
        return "x".join(map(str, value))
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)

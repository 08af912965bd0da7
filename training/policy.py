"""Policies of other trainers: what they are, and the keywords of their training."""

import sys
from collections.abc import Callable
from importlib import import_module
from inspect import getfile
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field, field_validator

from swarm_forage_env.arrays import Array, Float32, Float64, Int64
from swarm_forage_env.envs import (
    actions,
    config,
    decision_kernels,
    extra_observations,
    observations,
    policy_form,
)
from swarm_forage_env.envs.config import EnvConfig, PolicyKeywords
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.parameters import Count, validated
from training.foreign_file import is_file
from training.policy_card import PolicyCard, read_policy_card

SHOWN_BY = tuple(
    Path(getfile(module))
    for module in (
        actions,
        extra_observations,
        config,
        decision_kernels,
        observations,
        policy_form,
    )
)
"""The code of environments between a policy and the world."""

Predict = Callable[[Float32[Array, "robots numbers"]], Any]
"""The actions of the robots of a world, from what each of them observes."""

Draw = Callable[[Float32[Array, "robots numbers"], Float64[Array, "robots draws"]], Any]
"""The same by chance, from draws as well: standard normal, one for each number of an action; or
one that is uniform in [0, 1), where actions are choices."""


def imported(name: str) -> Any:  # noqa: ANN401 whatever goes by that name
    """What `package.module:name` stands for, on Python's path or in the current folder.

    Importing a module runs it. ConfigError where there is no such thing.
    """
    home, _, own = name.partition(":")
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.append(here)
    try:
        return getattr(import_module(home), own)
    except (ImportError, AttributeError, ValueError) as error:
        raise ConfigError(f"'{name}': {error}") from None


def module_file(found: Any) -> Path:  # noqa: ANN401 a class or function
    """The file of the module that a class or function is defined in."""
    return Path(getattr(sys.modules[found.__module__], "__file__", None) or getfile(found))


def _is_class(observation: object) -> bool:
    """An observation is named by module and class."""
    return isinstance(observation, str) and ":" in observation


class ForeignPolicy(PolicyKeywords):
    """A policy, and the keywords of `parallel_env` under which it was trained."""

    discrete: bool | tuple[Count, Count] = Field(
        False, description="Its actions are choices; 3x5: of 3 speeds times 5 turns"
    )
    observation: Any = Field(
        "layer", description="What it observes: layer+previous_action, layer+module:Class"
    )
    chance: bool = Field(
        False, description="It acts by chance, as in training, from a stream of each robot"
    )

    @field_validator("discrete", mode="before")
    @classmethod
    def _grid(cls, discrete: object) -> object:
        if isinstance(discrete, str) and "x" in discrete:
            return tuple(discrete.split("x"))
        return discrete

    @property
    def reads(self) -> tuple[Path, ...]:
        """Files that its output depends on, beside those of its kind: what shows it the world."""
        names = self.observation.split("+") if isinstance(self.observation, str) else ()
        return (*SHOWN_BY, *(module_file(imported(each)) for each in names if _is_class(each)))

    @property
    def source(self) -> str:
        """What a refusal calls it."""
        return type(self).__name__

    def config(self) -> EnvConfig:
        """The keywords, as an environment has them."""
        names = self.observation
        listed = names.split("+") if isinstance(names, str) else names
        shown = [imported(each) if _is_class(each) else each for each in listed]
        given = {name: getattr(self, name) for name in PolicyKeywords.model_fields}
        return validated(EnvConfig, {**given, "observation": shown})

    def card(self) -> PolicyCard | None:
        """What it was trained on, where that is known."""
        return None

    def start(self, form: PolicyForm) -> Predict:
        """The policy, ready to be asked; ConfigError if it does not fit."""
        raise NotImplementedError

    def start_by_chance(self, form: PolicyForm) -> Draw:
        """The same, to act by chance; ConfigError for one that tells no distribution."""
        raise ConfigError(
            f"policy {self.source}: chance=true: tells no distribution of its actions, only the"
            " actions; leave it out"
        )


def drawn_choices(
    probabilities: Float64[Array, "robots choices"], draws: Float64[Array, "robots draws"]
) -> Int64[Array, " robots"]:
    """The choice of each robot: the first below which a share of at least its draw lies."""
    shares = np.cumsum(probabilities, axis=1)
    chosen: Int64[Array, " robots"] = (shares <= draws[:, :1] * shares[:, -1:]).sum(axis=1)
    return chosen


class PolicyFile(ForeignPolicy):
    """A policy that is kept in a file."""

    file: str = Field("", description="The file")

    @property
    def path(self) -> Path:
        """The file; ConfigError if there is none."""
        path = Path(self.file)
        if not self.file:
            raise ConfigError("policy: which file? Name it after the colon, as in sb3:model.zip")
        if not is_file(path):
            raise ConfigError(
                f"policy {self.file[:200]}: there is no such file; name the one that its trainer"
                " has saved"
            )
        return path

    @property
    def reads(self) -> tuple[Path, ...]:
        """The file too."""
        return (*super().reads, self.path)

    @property
    def source(self) -> str:
        """The file's name as it was given."""
        return self.file

    def card(self) -> PolicyCard | None:
        """The card beside the file."""
        return read_policy_card(self.path)


class FunctionPolicy(ForeignPolicy):
    """A function of Python's, from what the robots of a world observe to their actions."""

    function: Any = None

    def start(self, form: PolicyForm) -> Predict:
        """The function itself."""
        predict: Predict = self.function
        return predict

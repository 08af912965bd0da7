"""Policies of other trainers, with the keywords of their training."""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from inspect import getfile
from os.path import isfile
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field, field_validator

from swarm_forage_env import envs
from swarm_forage_env.arrays import Array, Float32, Float64, Int64
from swarm_forage_env.envs.config import EnvConfig, PolicyKeywords
from swarm_forage_env.envs.pilot import Pilot
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.parameters import Count, validated
from training.foreign_file import reason
from training.policy_card import PolicyCard, read_policy_card

OBSERVATION_FILES = tuple(
    Path(envs.__file__).with_name(f"{name}.py")
    for name in (
        "actions", "extra_observations", "config", "decision", "decision_kernels", "observations",
        "policy_form",
    )
)  # fmt: skip
"""Source files of the environments between a policy and the world."""

StateSize = Annotated[int, Field(ge=0, le=10_000)]

Rows = Float32[Array, "robots numbers"]

Act = Callable[[Rows, Float64[Array, "robots draws"] | None, Rows], tuple[object, Rows]]
"""Maps observations, random draws and hidden states (robots, n_state) of the robots of a world to
actions and next states; without draws the actions are deterministic. The draws of a robot are one
standard normal value per component of its action, or one uniform value in [0, 1) if actions are
choices."""


@dataclass(frozen=True)
class Started:
    """Policy that is ready to act."""

    act: Act
    n_state: int = 0
    """Size of the hidden state of a robot, which is zero when an episode starts."""
    has_distribution: bool = False
    """Whether the policy can act stochastically, by draws."""


def imported(name: str) -> object:
    """Import `package.module:name`, from Python's path or the current folder.

    Importing a module runs it. ConfigError if the module or the name does not exist.
    """
    home, _, own = name.partition(":")
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.append(here)
    try:
        return getattr(import_module(home), own)
    except (ImportError, AttributeError, ValueError) as error:
        where = "searched were Python's path and the current folder"
        raise ConfigError(f"'{name}': {error}; {where}") from None


def module_file(part: object) -> Path:
    """Return the file of the module that defines a class or function."""
    home = sys.modules[part.__module__]
    return Path(vars(home).get("__file__") or getfile(home))


class ForeignPolicy(PolicyKeywords):
    """A policy, and the keywords of `parallel_env` under which it was trained."""

    discrete: bool | tuple[Count, Count] = Field(
        False, description="Whether its actions are choices; 3x5: of 3 speeds times 5 turns"
    )
    observation: str | Sequence[object] = Field(
        "layer", description="Observations: layer+previous_action, layer+module:Class"
    )
    chance: bool = Field(
        False, description="Whether it acts stochastically, as in training; a stream for each robot"
    )

    @field_validator("discrete", mode="before")
    @classmethod
    def _grid(cls, discrete: object) -> object:
        if isinstance(discrete, str) and "x" in discrete:
            return tuple(discrete.split("x"))
        return discrete

    @property
    def reads(self) -> tuple[Path, ...]:
        """Files that the output depends on: here, the code that makes its observations."""
        names = self.observation.split("+") if isinstance(self.observation, str) else ()
        return (*OBSERVATION_FILES, *(module_file(imported(each)) for each in names if ":" in each))

    @property
    def source(self) -> str:
        """Name of the policy in error messages."""
        return type(self).__name__

    def config(self) -> EnvConfig:
        """Return the keywords as the configuration of an environment."""
        names = self.observation
        observed = [
            imported(each) if isinstance(each, str) and ":" in each else each
            for each in (names.split("+") if isinstance(names, str) else names)
        ]
        keywords = {name: value for name, value in self if name in PolicyKeywords.model_fields}
        return validated(EnvConfig, {**keywords, "observation": observed})

    def card(self) -> PolicyCard | None:
        """Return the card of the training; None if there is none."""
        return None

    def start(self, form: PolicyForm) -> Started:
        """Start the policy. ConfigError if it does not fit."""
        raise NotImplementedError

    def pilot(self, form: PolicyForm) -> Pilot:
        """Return the policy for compilation with the world. ConfigError if Python must call it."""
        raise ConfigError(
            f"policy {self.source}: runs in Python only; networks that swarm-forage train has"
            " saved (network:FILE), and those of PPO and A2C of stable-baselines3 whose layers"
            " are dense (sb3:FILE), run without Python"
        )


def drawn_choices(
    probabilities: Float64[Array, "robots choices"], draws: Float64[Array, "robots draws"]
) -> Int64[Array, " robots"]:
    """Return each robot's choice: the first whose cumulative probability exceeds the draw."""
    shares = np.cumsum(probabilities, axis=1)
    chosen: Int64[Array, " robots"] = (shares <= draws[:, :1] * shares[:, -1:]).sum(axis=1)
    return chosen


def started_function(function: Callable[..., object], n_state: int, source: str) -> Started:
    """Start a Python function; with `n_state` it must return next states, else ConfigError."""

    def act(observed: Rows, draws: object, states: Rows) -> tuple[object, Rows]:
        if not n_state:
            return function(observed), states
        output = function(observed, states)
        if not isinstance(output, tuple) or len(output) != 2:
            raise ConfigError(
                f"policy {source}: gives a {type(output).__name__}; with n_state={n_state} it must"
                " give actions and the next states, as in `return actions, states`"
            )
        after = as_array(output[1], f"policy {source}: gives no array of states")
        largest = np.finfo(np.float32).max
        is_real = after.dtype.kind in "fiu" and bool((np.abs(after) <= largest).all())
        if after.shape != states.shape or not is_real:
            raise ConfigError(
                f"policy {source}: gives states {after.shape} of {after.dtype}; must be finite"
                f" float32 numbers of shape {states.shape}, robots by n_state"
            )
        return output[0], after

    return Started(act, n_state)


def as_array(output: object, refusal: str) -> Array:
    """Return an output as an array. ConfigError, which begins with `refusal`, if it is none."""
    try:
        return np.asarray(output)
    except (ValueError, TypeError, RuntimeError) as error:  # ragged; a tensor with gradients
        raise ConfigError(f"{refusal} ({reason(error)})") from None


class PolicyFile(ForeignPolicy):
    """Policy in a file."""

    file: str = Field("", description="File of the policy")

    @property
    def path(self) -> Path:
        """Path of the file; ConfigError if there is none."""
        path = Path(self.file)
        if not self.file:
            raise ConfigError("policy: which file? Name it after the colon, as in sb3:model.zip")
        if not isfile(path):
            raise ConfigError(
                f"policy {self.file[:200]}: there is no such file; name the one that its trainer"
                " has saved"
            )
        return path

    @property
    def reads(self) -> tuple[Path, ...]:
        """Files that the output depends on, including this file."""
        return (*super().reads, self.path)

    @property
    def source(self) -> str:
        """Name of the file."""
        return self.file

    def card(self) -> PolicyCard | None:
        """Return the card beside the file; None if there is none."""
        return read_policy_card(self.path)


class FunctionPolicy(ForeignPolicy):
    """A Python function that maps observations of the robots of a world to their actions."""

    function: Callable[..., object] | None = None
    n_state: StateSize = Field(0, description="Size of the hidden state of a robot; 0: none")

    def start(self, form: PolicyForm) -> Started:
        """Start the function."""
        assert self.function is not None
        return started_function(self.function, self.n_state, self.source)

"""Policies of other trainers: what they are, and the keywords of their training."""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from inspect import getfile
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
from training.foreign_file import is_file
from training.policy_card import PolicyCard, read_policy_card

SHOWN_BY = tuple(
    Path(envs.__file__).with_name(f"{name}.py")
    for name in (
        "actions", "extra_observations", "config", "decision_kernels", "observations", "policy_form"
    )
)  # fmt: skip
"""The code of environments between a policy and the world."""

Predict = Callable[[Float32[Array, "robots numbers"]], object]
"""Maps what the robots of a world observe to their actions."""

Draw = Callable[[Float32[Array, "robots numbers"], Float64[Array, "robots draws"]], object]
"""Maps what the robots observe, and random draws, to their actions. A robot has one standard normal
draw for each number of its action; or one that is uniform in [0, 1), if actions are choices."""

StateSize = Annotated[int, Field(ge=0, le=10_000)]


@dataclass(frozen=True)
class Recurrent:
    """A policy with a hidden state of each robot, which is zeros when an episode starts."""

    function: Callable[..., object]
    """Maps the inputs of a `Predict` or `Draw`, and states (robots, n_state) of float32, to actions
    and the next states."""

    n_state: int
    """Numbers in the state of a robot."""


def imported(name: str) -> object:
    """Import `package.module:name`, from Python's path or the current folder.

    Importing a module runs it. ConfigError where there is no such thing.
    """
    home, _, own = name.partition(":")
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.append(here)
    try:
        part: object = getattr(import_module(home), own)
    except (ImportError, AttributeError, ValueError) as error:
        raise ConfigError(f"'{name}': {error}") from None
    return part


def module_file(part: object) -> Path:
    """The file of the module that defines a class or function."""
    home = sys.modules[part.__module__]
    return Path(vars(home).get("__file__") or getfile(home))


class ForeignPolicy(PolicyKeywords):
    """A policy, and the keywords of `parallel_env` under which it was trained."""

    discrete: bool | tuple[Count, Count] = Field(
        False, description="Its actions are choices; 3x5: of 3 speeds times 5 turns"
    )
    observation: str | Sequence[object] = Field(
        "layer", description="What it observes: layer+previous_action, layer+module:Class"
    )
    chance: bool = Field(
        False, description="It acts stochastically, as in training, by a stream of each robot"
    )

    @field_validator("discrete", mode="before")
    @classmethod
    def _grid(cls, discrete: object) -> object:
        if isinstance(discrete, str) and "x" in discrete:
            return tuple(discrete.split("x"))
        return discrete

    @property
    def reads(self) -> tuple[Path, ...]:
        """Files that its output depends on, beside those of its kind: what observes the world."""
        names = self.observation.split("+") if isinstance(self.observation, str) else ()
        return (*SHOWN_BY, *(module_file(imported(each)) for each in names if ":" in each))

    @property
    def source(self) -> str:
        """Its name in error messages."""
        return type(self).__name__

    def config(self) -> EnvConfig:
        """The keywords, as an environment has them."""
        names = self.observation
        observed = [
            imported(each) if isinstance(each, str) and ":" in each else each
            for each in (names.split("+") if isinstance(names, str) else names)
        ]
        own = {name: value for name, value in self if name in PolicyKeywords.model_fields}
        return validated(EnvConfig, {**own, "observation": observed})

    def card(self) -> PolicyCard | None:
        """The card of its training, if it has one."""
        return None

    def start(self, form: PolicyForm) -> Predict | Recurrent:
        """The policy as a function that acts deterministically; ConfigError if it does not fit."""
        raise NotImplementedError

    def pilot(self, form: PolicyForm) -> Pilot:
        """The policy compiled beside the world; ConfigError for one that Python must call."""
        raise ConfigError(
            f"policy {self.source}: Python calls it; what runs without Python are networks that"
            " swarm-forage train has saved (network:FILE), and those of PPO and A2C of"
            " stable-baselines3 whose layers are dense (sb3:FILE)"
        )

    def start_by_chance(self, form: PolicyForm) -> Draw | Recurrent:
        """The policy as a function that acts stochastically; ConfigError without a distribution."""
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
    """A policy in a file."""

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
        """The name of the file."""
        return self.file

    def card(self) -> PolicyCard | None:
        """The card beside the file."""
        return read_policy_card(self.path)


class FunctionPolicy(ForeignPolicy):
    """A Python function that maps what the robots of a world observe to their actions."""

    function: Callable[..., object] | None = None
    n_state: StateSize = Field(0, description="Numbers in the hidden state of a robot; 0: none")

    def start(self, form: PolicyForm) -> Predict | Recurrent:
        """The function itself."""
        assert self.function is not None
        return Recurrent(self.function, self.n_state) if self.n_state else self.function

"""Interface between worlds and controllers: the parts of a layer.

A layer is a set of functions on records, compiled together with those of the other layers, or a
rule written in NumPy, called between `observe` and `decide` on the arrays of a whole block.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.random_streams import NoiseSource
from swarm_forage_env.record import Record, Rows
from swarm_forage_env.record import field as record_field

KEEP, REPLACE, CORRECT, RULE, COURSE = range(5)
"""Effect of an action on a layer: none; a learner replaces it, or corrects its output; a rule in
NumPy replaces it; or a learner gives the speed and the angle off the course."""

Kernel = Callable[..., Any]
KernelNumbers = Mapping[str, Any]


class NoMemory(Record):
    """Memory of a layer that remembers nothing; numba supports no record without a field."""

    nothing: int = record_field(np.int8)


def refuse_falsifying(name: str, scenario: BaseScenario) -> None:
    """Raise ConfigError if faults falsify messages, as this controller supports no such fault."""
    for fault in scenario.falsifying:
        raise ConfigError(
            f"{fault}: scenario '{scenario.name}' falsifies messages, but those of controller"
            f" '{name}' cannot be falsified; use a controller whose messages hold places, such"
            " as ssgikf"
        )


@dataclass(frozen=True)
class WeightingLayer:
    """Layer that weighs a received estimate against the robot's own one."""

    gain: Kernel
    """Computes the weight in [0, 1] of the received estimate."""
    numbers: KernelNumbers = field(default_factory=dict)
    """Parameters by name; each world has its own record of them."""
    heard_p_share: float = 0.0
    """Share of the received p in the merged p: p = (1 - g) p_i + share g p_j."""

    @property
    def all_numbers(self) -> KernelNumbers:
        """Parameters that kernels receive: those of the layer, and the share of the received p."""
        return {**self.numbers, "heard_p_share": self.heard_p_share}


@dataclass(frozen=True)
class EstimatorLayer:
    """Layer that maintains the beliefs of a robot, as a record and functions on it."""

    mind: type[Record]
    """State that the estimator keeps for a robot, with the inputs of the other layers."""
    numbers: KernelNumbers
    """Parameters by name; each world has its own record of them."""
    kernels: Mapping[str, Kernel]
    """Functions bound to free names of the task's templates. In foraging they include `falsify` and
    `repeat` if faults can change the messages."""
    observe: Kernel
    """Row template `observe_world`: the first half of the control, before the cut."""
    shared: tuple[int, ...] | None = None
    """Shape of the state kept for each pair of robots; None if there is none."""
    own_weighting: WeightingLayer | None = None
    """Weighting that the estimator itself defines, used by the rule `filter`."""

    def check_falsifiable(self, name: str, scenario: BaseScenario) -> None:
        """Raise ConfigError if faults falsify messages and this layer cannot falsify its own."""
        if not {"falsify", "repeat"} <= set(self.kernels):
            refuse_falsifying(name, scenario)


@dataclass(frozen=True)
class MotionLayer:
    """Layer that drives a robot."""

    steer: Kernel
    """Writes the command of a robot; of an e-puck it is called as
    `steer(situation, readings, heard, wheels, memory, numbers)`."""
    numbers: KernelNumbers
    """Parameters by name; each world has its own record of them."""
    memory: type[Record] = NoMemory
    """State kept between ticks; a field `stream` is a random stream of each robot."""
    noise: NoiseSource = NoiseSource.WANDER
    """Source of noise that this stream is for."""
    kernels: Mapping[str, Kernel] = field(default_factory=dict)
    """Further functions bound to free names of the task's templates: in foraging `reflex` and
    `walk`, which can stay active when a learner steers."""


@dataclass(frozen=True)
class CompiledLayers:
    """Layers of all robots of a block, as `run_ticks` runs them in one call with the world."""

    functions: Mapping[str, Kernel]
    """Functions bound to the free names of a tick's templates: `observe_world`, `decide_world`, and
    the functions that these call."""
    arrays: tuple[Any, ...]
    """The estimator's state of each robot, the motion's memory of it, the estimator's state of each
    pair, and parameters, in one column for robots that share them; for joined layers, a tuple of
    these for each."""
    firsts: tuple[Array, ...] = ()
    """Initial records of estimator and motion, one of each; empty if only a CPU can reset them."""
    noise: int = 0
    """Source of noise that the stream in the motion's memory is for."""
    has_beliefs: bool = True
    """Whether there is an estimator, whose beliefs can be logged."""


class WeightingRule(Protocol):
    """Weighting written in NumPy."""

    heard_p_share: float

    def __call__(self, exchange: Rows) -> Float32[Array, "rows weights"]:
        """Return the weights of all robots; those of robots without an exchange are ignored."""


class MotionRule(Protocol):
    """Motion written in NumPy, for all robots of a block of worlds.

    It is created from the scenario of the first world only. It may use parameters that are constant
    for the life of a world (the scenario's `fixed`), but none that differ between worlds.
    """

    def __call__(self, situation: Rows, *seen: Rows) -> Float32[Array, "rows 2"]:
        """Return the command of every robot, given copies of the records that `steer` takes.

        In foraging these are situation, readings, heard and wheels, the last command.
        """

    def reset(self, world: int, seed: int) -> None:
        """Reset the state of one world, and draw from this seed from now on."""


class RunningController(Protocol):
    """Layers of all robots of a block of worlds."""

    minds: Array
    """State of each robot: records with the fields `estimator` and `motion`."""

    @property
    def has_rules(self) -> bool:
        """Whether a layer is a rule in NumPy, called once for all worlds."""

    @property
    def compiled(self) -> CompiledLayers:
        """Functions and arrays of all its work between two cuts, for one call with the worlds."""

    def check_on_gpu(self) -> None:
        """Raise ConfigError, with the reason, for layers that run on a CPU only."""

    def call_rules(self) -> None:
        """Call the rules written in NumPy, and write their actions."""

    def reset(self, first: int, last: int, seeds: Sequence[int]) -> None:
        """Reset the worlds first .. last - 1, and seed their random streams with these seeds."""

    def parameters_in(self, world: int, scenario: BaseScenario) -> object:
        """Return a world's layer parameters in another scenario; ConfigError if unsupported."""

    def write_parameters(self, world: int, numbers: Any) -> None:  # noqa: ANN401 as above
        """Use these parameters in one world from now on."""

    def snapshot(self) -> Any:  # noqa: ANN401 of the controller
        """Return copies of all that the next ticks depend on; they can be pickled."""

    def restore(self, snapshot: Any) -> None:  # noqa: ANN401 as above
        """Restore a snapshot; arrays keep their place in memory."""


@runtime_checkable
class Controller(Protocol):
    """A named controller with its parameters, independent of any world."""

    @property
    def name(self) -> str:
        """Name of the controller, without its parameters."""

    def with_parameters(self, values: Mapping[str, Any]) -> "Controller":
        """Return the same controller with some parameters changed."""

    def check_supports(self, scenario: BaseScenario) -> None:
        """Raise ConfigError if the controller does not support a scenario."""


@runtime_checkable
class TeamController(Controller, Protocol):
    """A controller whose robots may share a world with robots of other controllers."""

    def language(self, scenario: BaseScenario) -> object:
        """Return the language of its messages: robots with equal languages form a team."""

    def build_team(
        self,
        world: Any,  # noqa: ANN401 of its task
        seeds: Sequence[int],
        each: Sequence[Sequence[Any]],
    ) -> RunningController:
        """Start a team. `each[world][robot]` is the controller of a robot, or None for robots of
        other teams, which are not controlled."""


@runtime_checkable
class PolicyOverLayers(Controller, Protocol):
    """One or more policies on top of another controller, such as hand-written layers."""

    @property
    def policies(self) -> Mapping[str, object]:
        """The policies."""

    def under(self, scenario: BaseScenario) -> TeamController:
        """Return the controller below the policy."""

    def over(
        self,
        world: Any,  # noqa: ANN401 of its task
        inner: RunningController,
        robots: Sequence[int],
    ) -> RunningController:
        """Start the policy of some robots on top of `inner`; ConfigError if it does not fit."""

    def pilot(self, scenario: BaseScenario) -> Any:  # noqa: ANN401 an `envs.pilot.Pilot`
        """Return the compiled policy; ConfigError if Python must call it."""


def has_talk(controller: object) -> bool:
    """Return whether robots send what a weighting can weigh; true by default."""
    return bool(getattr(controller, "talks", True))


def is_privileged(controller: object) -> bool:
    """Return whether a controller is an oracle, which knows the ground truth."""
    return bool(getattr(controller, "is_privileged", False))


def files_read_by(part: object) -> Sequence[Path]:
    """Return the files that a part of a controller or world reads, such as a policy file."""
    files: Sequence[Path] = getattr(part, "reads", ())
    return files

"""The border between a world and its controllers: what a layer consists of.

A layer is a few functions on records, compiled together with those of the other layers, or a rule
written in NumPy, which is called between `observe` and `decide` on the arrays of a whole block.
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
"""What an action does with a layer: nothing; a learner takes its place, or is added to it; a rule
written in NumPy takes its place; or a learner says the speed, and how far off the course."""

Kernel = Callable[..., Any]
KernelNumbers = Mapping[str, Any]


class NoMemory(Record):
    """The memory of a layer that remembers nothing; numba knows no record without a field."""

    nothing: int = record_field(np.int8)


def refuse_falsifying(name: str, scenario: BaseScenario) -> None:
    """ConfigError if faults of a scenario change messages: those of this controller cannot be."""
    for fault in scenario.falsifying:
        raise ConfigError(
            f"{fault}: scenario '{scenario.name}' falsifies messages, and those of controller"
            f" '{name}' cannot be falsified; take one that tells places, as ssgikf"
        )


@dataclass(frozen=True)
class WeightingLayer:
    """How much of what is heard enters the own estimate."""

    gain: Kernel
    """The weight in [0, 1] of what was heard."""
    numbers: KernelNumbers = field(default_factory=dict)
    """Its parameters, one record a world."""
    heard_p_share: float = 0.0
    """Part that the heard p plays in the merged p: p = (1 - g) p_i + share g p_j."""

    @property
    def all_numbers(self) -> KernelNumbers:
        """The record that kernels are handed: the parameters, and the share of the heard p."""
        return {**self.numbers, "heard_p_share": self.heard_p_share}


@dataclass(frozen=True)
class EstimatorLayer:
    """What a robot believes, as records and functions on them."""

    mind: type[Record]
    """All that the estimator keeps of a robot; among it what the other layers see."""
    numbers: KernelNumbers
    """Its parameters, one record a world."""
    kernels: Mapping[str, Kernel]
    """The functions that the templates of the task name. Of robots that forage they include
    `falsify` and `repeat` if faults can change the messages."""
    observe: Kernel
    """The row template `observe_world`: the first half of the control, before the cut."""
    shared: tuple[int, ...] | None = None
    """Shape of what it keeps for each pair of robots; None: nothing."""
    own_weighting: WeightingLayer | None = None
    """The weighting that the filter itself has, for the rule `filter`."""

    def check_falsifiable(self, name: str, scenario: BaseScenario) -> None:
        """ConfigError if faults of a scenario would change messages that this cannot falsify."""
        if not {"falsify", "repeat"} <= set(self.kernels):
            refuse_falsifying(name, scenario)


@dataclass(frozen=True)
class MotionLayer:
    """Where a robot goes."""

    steer: Kernel
    """Writes the command of a robot."""
    numbers: KernelNumbers
    """Its parameters, one record a world."""
    memory: type[Record] = NoMemory
    """What it remembers between ticks; of a field `stream` every robot has its own."""
    noise: NoiseSource = NoiseSource.WANDER
    """What it draws from that stream for."""
    kernels: Mapping[str, Kernel] = field(default_factory=dict)
    """Further functions that the templates of the task name: of robots that forage `reflex` and
    `walk`, which go on where a learner steers."""


@dataclass(frozen=True)
class CompiledLayers:
    """The layers of all robots of a block as `run_ticks` runs them, in one call with the world."""

    functions: Mapping[str, Kernel]
    """What the templates of a tick have free names for: `observe_world`, `decide_world`, and the
    functions that these name."""
    arrays: tuple[Any, ...]
    """What the estimator keeps of each robot, what the motion remembers of it, what the estimator
    keeps of each pair, and parameters, in one column for robots that share them; of joined layers a
    tuple of these for each."""
    firsts: tuple[Array, ...] = ()
    """One record each of what estimator and motion keep before anything has happened; none where a
    CPU must reset them."""
    noise: int = 0
    """What the motion draws for from the stream in its memory."""
    has_beliefs: bool = True
    """There is an estimator, whose beliefs can be logged."""


class WeightingRule(Protocol):
    """A weighting written in NumPy."""

    heard_p_share: float

    def __call__(self, exchange: Rows) -> Float32[Array, "rows weights"]:
        """The weights of all robots; those of a robot without an exchange do not count."""


class MotionRule(Protocol):
    """A motion written in NumPy, for all robots of a block of worlds.

    It is told the scenario of the first world, once: of a scenario it may use what stays as long
    as a world does (the scenario's `fixed`), and not what differs from world to world.
    """

    def __call__(self, situation: Rows, *seen: Rows) -> Float32[Array, "rows 2"]:
        """What every robot is commanded, by copies of the records that `steer` takes of each.

        Of robots that forage: situation, readings, heard, wheels; the last are the last command.
        """

    def reset(self, world: int, seed: int) -> None:
        """Forget everything about one world, and draw from this seed from now on."""


class RunningController(Protocol):
    """The layers of all robots of a block of worlds."""

    minds: Array
    """What each robot keeps: records with the fields `estimator` and `motion`."""

    @property
    def has_rules(self) -> bool:
        """A layer is a rule in NumPy, which is asked about all worlds at once."""

    @property
    def compiled(self) -> CompiledLayers:
        """All that it does between two cuts, for one call with the worlds."""

    def check_on_gpu(self) -> None:
        """ConfigError for layers that run on a CPU only, with the reason."""

    def consult(self) -> None:
        """Ask the rules written in NumPy, and write their actions."""

    def reset(self, first: int, last: int, seeds: Sequence[int]) -> None:
        """Forget everything about the worlds first .. last - 1, and draw from these seeds."""

    def numbers_in(self, world: int, scenario: BaseScenario) -> object:
        """The numbers of one world's layers in another scenario; ConfigError if one has none."""

    def renumber(self, world: int, numbers: Any) -> None:  # noqa: ANN401 as above
        """Go by these numbers in one world from now on."""

    def snapshot(self) -> Any:  # noqa: ANN401 of the controller
        """All that the next ticks depend on, as copies, picklable."""

    def restore(self, kept: Any) -> None:  # noqa: ANN401 as above
        """Go on as when that snapshot was taken; arrays keep their place in memory."""


@runtime_checkable
class Controller(Protocol):
    """A named controller with its parameters, before it meets a world."""

    @property
    def name(self) -> str:
        """What it is called, without its parameters."""

    def with_parameters(self, values: Mapping[str, Any]) -> "Controller":
        """The same controller with some parameters changed."""

    def check_supports(self, scenario: BaseScenario) -> None:
        """ConfigError if it is not made for such a world."""


@runtime_checkable
class TeamController(Controller, Protocol):
    """A controller of robots, which may live among robots of other controllers."""

    def language(self, scenario: BaseScenario) -> object:
        """What its robots understand: those of equal languages are a team."""

    def build_team(
        self,
        world: Any,  # noqa: ANN401 of its task
        seeds: Sequence[int],
        each: Sequence[Sequence[Any]],
    ) -> RunningController:
        """The running controller of a team: of each world what drives each of its robots, None
        for a robot of another team, which is to be left alone."""


@runtime_checkable
class PolicyOverLayers(Controller, Protocol):
    """A controller that is a policy over something else, as over hand-written layers."""

    policy: object

    def under(self, scenario: BaseScenario) -> TeamController:
        """What does the rest."""

    def over(
        self,
        world: Any,  # noqa: ANN401 of its task
        inner: RunningController,
        robots: Sequence[int],
    ) -> RunningController:
        """The policy of some robots, over what does the rest; ConfigError if it does not fit."""

    def pilot(self, scenario: BaseScenario) -> Any:  # noqa: ANN401 an `envs.pilot.Pilot`
        """The policy, compiled; ConfigError for one that Python must call."""


def has_talk(controller: object) -> bool:
    """Whether robots of a controller tell each other what a weighting can weigh; by default yes."""
    return bool(getattr(controller, "talks", True))


def is_privileged(controller: object) -> bool:
    """Whether a controller is an oracle, which knows the ground truth."""
    return bool(getattr(controller, "is_privileged", False))


def files_read_by(part: object) -> Sequence[Path]:
    """The files that a part of a controller or world reads, as that of a policy."""
    files: Sequence[Path] = getattr(part, "reads", ())
    return files

"""Control of robots without layers, for policies that replace all layers."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import CompiledLayers, Kernel, NoMemory, refuse_falsifying
from swarm_forage_env.observed_fields import Sizes
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.record import Record, field
from swarm_forage_env.templates import row_template
from swarm_forage_env.ticks import Arrays, Errors, nothing

lane: Kernel
lanes: Kernel
apply_action: Kernel
hear_words: Kernel
"""Free names of the templates: lanes, and functions of the task."""


@row_template
def apply_actions(
    world_arrays: Arrays, layer_arrays: Arrays, errors: Errors, w: int, n_robots: int
) -> None:
    """Apply the actions of the policy to its robots in a world."""
    robots, minds, settings = world_arrays[0], layer_arrays[0], layer_arrays[3]
    for i in range(lane(), n_robots, lanes()):
        if settings[w, i].is_member:
            apply_action(robots[w, i], minds[w, i])


class Membership(Record):
    """Record that marks the robots of the policy."""

    is_member: bool = field(np.bool_)


@row_template
def hear_world(world_arrays: Arrays, layer_arrays: Arrays, w: int, n_robots: int) -> None:
    """Write the received messages of the policy's robots in a world."""
    minds, settings = layer_arrays[0], layer_arrays[3]
    for i in range(lane(), n_robots, lanes()):
        if settings[w, i].is_member:
            hear_words(world_arrays, minds, w, i)


def has_estimators(minds: Array) -> bool:
    """Return whether any robot has an estimator; false if all policies replace all layers."""
    return "estimator" in (minds.dtype.names or ())


def estimators_of(minds: Array) -> Array:
    """Return the records of the robots' estimators; ConfigError if no robot has one."""
    if not has_estimators(minds):
        raise ConfigError(
            "exchange, situation: no robot here has an estimator, because the policy replaces"
            " everything; use learn='weighting', 'motion' or 'both'"
        )
    estimators: Array = minds["estimator"]
    return estimators


@dataclass(frozen=True)
class RawControl:
    """Controller of robots whose policy replaces all layers: nothing in it is hand-written."""

    messages: type[Record]
    """Record of the messages that the policy sends and receives."""
    apply_action: Kernel
    """Writes the command of a robot; arguments: the robot and its messages."""
    hear_words: Kernel
    """Writes the received messages of a robot; arguments: arrays of the world, messages of all
    robots, world and robot."""
    sizes: Callable[..., Sizes]
    """Returns the sizes of the named axes of the messages in a scenario."""
    name: str = "policy"

    def check_supports(self, scenario: BaseScenario) -> None:
        """Raise ConfigError if faults falsify messages."""
        refuse_falsifying(self.name, scenario)

    def language(self, scenario: BaseScenario) -> object:
        """Return the controller itself, as only this policy can interpret its messages."""
        return self

    def build_team(
        self,
        world: Any,  # noqa: ANN401 of its task
        seeds: Sequence[int],
        each: Sequence[Sequence[object]],
    ) -> "RunningPolicy":
        """Start the policy of some robots; `each[world][robot]` is None for all others."""
        for scenario in world.scenarios:
            self.check_supports(scenario)
        robots = [robot for robot, controller in enumerate(each[0]) if controller is not None]
        return RunningPolicy(self, world, robots)

    def with_parameters(self, values: Mapping[str, object]) -> "RawControl":
        """Return the controller itself, which has no parameters."""
        return self


class RunningPolicy:
    """Applies the actions of a policy that replaces all layers, and delivers its messages."""

    has_rules = False

    def __init__(
        self,
        policy: RawControl,
        world: Any,  # noqa: ANN401 of its task
        robots: Sequence[int],
    ) -> None:
        self._policy, self._world = policy, world
        shape = world.n_worlds, world.n_robots
        self.minds: Array = self._messages(shape)
        self._nothing = NoMemory.array(shape), np.zeros((*shape, 0)), Membership.array(shape)
        self._nothing[2]["is_member"] = np.isin(range(world.n_robots), robots)

    @property
    def compiled(self) -> CompiledLayers:
        """Kernels and arrays of commands and messages, for one call with the worlds."""
        functions: dict[str, Kernel] = {
            "apply_action": self._policy.apply_action,
            "hear_words": self._policy.hear_words,
            "decide_world": apply_actions,
            "observe_world": hear_world,
            "set_stream": nothing,
        }
        firsts = self._messages((1,)), NoMemory.array((1,))
        arrays = self.minds, *self._nothing
        return CompiledLayers(functions, arrays, firsts, has_beliefs=False)

    def call_rules(self) -> None:
        """Do nothing: there are no rules."""

    def check_on_gpu(self) -> None:
        """Do nothing: a GPU can run it."""

    def write_parameters(self, world: int, numbers: None) -> None:
        """Do nothing: there are no parameters."""

    def parameters_in(self, world: int, scenario: BaseScenario) -> None:
        """Return no parameters; ConfigError if faults falsify messages."""
        refuse_falsifying("policy", scenario)

    def reset(self, first: int, last: int, seeds: Sequence[int]) -> None:
        """Clear the messages of the worlds first .. last - 1."""
        self._policy.messages.restart(self.minds[first:last])

    def snapshot(self) -> Array:
        """Return a copy of the messages."""
        return self.minds.copy()

    def restore(self, snapshot: Array) -> None:
        """Restore a snapshot."""
        self.minds[...] = snapshot

    def _messages(self, shape: tuple[int, ...]) -> Array:
        return self._policy.messages.array(shape, **self._policy.sizes(self._world.scenario))

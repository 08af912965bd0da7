"""Robots without layers: what runs where a policy is everything."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Bool
from swarm_forage_env.compiler import bind
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import GridLayers, Kernel, LayerTemplates, refuse_falsifying
from swarm_forage_env.observed_fields import Sizes
from swarm_forage_env.record import Record

carry_out: Kernel
hear_words: Kernel
"""Free names of the templates: functions of the task."""


def carry_out_all(
    robots: Array, minds: Array, is_member: Bool[Array, " robots"], first: int, last: int
) -> None:
    """Command what the policies of the members say, in the worlds first .. last - 1.

    Free name: carry_out.
    """
    for w in range(first, last):
        for i in range(robots.shape[1]):
            if is_member[i]:
                carry_out(robots[w, i], minds[w, i])


def hear_all(
    records: Any,  # noqa: ANN401 an array, or a tuple of arrays
    minds: Array,
    is_member: Bool[Array, " robots"],
    first: int,
    last: int,
) -> None:
    """Write what the members are told, in the worlds first .. last - 1. Free name: hear_words."""
    for w in range(first, last):
        for i in range(minds.shape[1]):
            if is_member[i]:
                hear_words(records, minds, w, i)


def has_estimators(minds: Array) -> bool:
    """Whether robots of these minds have an estimator: not where all policies are everything."""
    return "estimator" in (minds.dtype.names or ())


def estimators_of(minds: Array) -> Array:
    """What the estimators of robots keep; ConfigError where no robot has one."""
    if not has_estimators(minds):
        raise ConfigError(
            "exchange, situation: no robot here has layers to be shown them, as the policy of"
            " all is everything; take one that learns the weighting, the motion or both"
        )
    estimators: Array = minds["estimator"]
    return estimators


@dataclass(frozen=True)
class NoLayers:
    """The controller of robots whose policy is everything: no estimator, nothing hand-written."""

    said: type[Record]
    """What the policy says beside what it commands, and what it is told."""

    carry_out: Kernel
    """Commands what the action says; of one robot and what it said."""

    hear_words: Kernel
    """Writes what a robot is told; of the world's records, what all said, world and robot."""

    sizes: Callable[[Any], Sizes]
    """Sizes of the named axes of what is said in a scenario."""

    on_grid: LayerTemplates | None = None
    """How a GPU runs it; None: a CPU runs it only."""

    name: str = "policy"

    def build(self, world: Any, seeds: Sequence[int], each: Sequence[Any]) -> "RunningPolicy":  # noqa: ANN401 of its task
        """The running policy of a block of worlds; ConfigError where faults falsify messages."""
        for scenario in world.scenarios:
            refuse_falsifying(self.name, scenario)
        return RunningPolicy(self, world, range(world.n_robots))

    def language(self, scenario: Any) -> Any:  # noqa: ANN401 of any task
        """What is said is words, whose meaning is the policy's."""
        return self

    def build_team(
        self,
        world: Any,  # noqa: ANN401 of its task
        seeds: Sequence[int],
        each: Sequence[Sequence[Any]],
    ) -> "RunningPolicy":
        """The running policy of some robots, worlds by robots; None for one of another's."""
        for scenario in world.scenarios:
            refuse_falsifying(self.name, scenario)
        robots = [robot for robot, own in enumerate(each[0]) if own is not None]
        return RunningPolicy(self, world, robots)

    def with_parameters(self, values: Mapping[str, Any]) -> "NoLayers":
        """There are no parameters."""
        return self


class RunningPolicy:
    """Carries out what a learner of everything does."""

    def __init__(
        self,
        policy: NoLayers,
        world: Any,  # noqa: ANN401 of its task
        robots: Sequence[int],
    ) -> None:
        """Nobody has said anything yet; these robots have the policy."""
        self._policy, self._world = policy, world
        self._is_member = np.isin(range(world.n_robots), robots)
        self._carry_out = bind(carry_out_all, {"carry_out": policy.carry_out})
        self._hear = bind(hear_all, {"hear_words": policy.hear_words})
        self.minds: Array = self._said((world.n_worlds, world.n_robots))

    @property
    def has_rules(self) -> bool:
        """There are none."""
        return False

    def observe(self, first: int, last: int) -> None:
        """Write what the robots of the worlds first .. last - 1 are told."""
        self._hear(self._world.records, self.minds, self._is_member, first, last)

    def consult(self) -> None:
        """There are no rules."""

    def decide(self, first: int, last: int) -> None:
        """Command what the action says, in the worlds first .. last - 1."""
        self._carry_out(self._world.robots, self.minds, self._is_member, first, last)

    def numbers_in(self, world: int, scenario: Any) -> None:  # noqa: ANN401 of its task
        """There are no numbers; ConfigError where faults falsify messages."""
        refuse_falsifying("policy", scenario)

    def renumber(self, world: int, numbers: None) -> None:
        """There are no numbers."""

    def reset(self, world: int, seed: int) -> None:
        """Forget what was said."""
        self._policy.said.restart(self.minds[world])

    def snapshot(self) -> Array:
        """What was said."""
        return self.minds.copy()

    def restore(self, kept: Array) -> None:
        """Go on from what was said then."""
        self.minds[...] = kept

    def grid_layers(self) -> GridLayers:
        """What a GPU runs; ConfigError where the task says nothing of it."""
        if self._policy.on_grid is None:
            raise ConfigError(
                "device='cuda': policies that are everything run on a CPU only in this task"
            )
        nothing = np.zeros((*self.minds.shape, 1), np.int8)
        first, functions = self._said((1,)), {"hear_words": self._policy.hear_words}
        return GridLayers(
            functions, self.minds, nothing, nothing, nothing, nothing, first, nothing[0, 0], 0,
            self._policy.on_grid,
        )  # fmt: skip

    def _said(self, shape: tuple[int, ...]) -> Array:
        """Records of what is said, with room for all that a robot may be told."""
        return self._policy.said.array(shape, **self._policy.sizes(self._world.scenario))

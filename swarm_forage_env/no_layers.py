"""Robots without layers: what runs where a policy is everything."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from swarm_forage_env.arrays import Array
from swarm_forage_env.interface import refuse_falsifying
from swarm_forage_env.record import Record


@dataclass(frozen=True)
class NoLayers:
    """The controller of robots whose policy is everything: no estimator, nothing hand-written."""

    said: type[Record]
    """What the policy says beside what it commands. Writer: the environment."""

    carry_out: Callable[[Array, Array], None]
    """Commands what the actions say; of the robots of some worlds and what they said."""

    name: str = "policy"

    def build(self, world: Any, seeds: Sequence[int], each: Sequence[Any]) -> "RunningPolicy":  # noqa: ANN401 of its task
        """The running policy of a block of worlds; ConfigError where faults falsify messages."""
        for scenario in world.scenarios:
            refuse_falsifying(self.name, scenario)
        return RunningPolicy(world, self.said, self.carry_out, range(world.n_robots))

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
        return RunningPolicy(world, self.said, self.carry_out, robots)

    def with_parameters(self, values: Mapping[str, Any]) -> "NoLayers":
        """There are no parameters."""
        return self


class RunningPolicy:
    """Carries out what a learner of everything does."""

    def __init__(
        self,
        world: Any,  # noqa: ANN401 of its task
        said: type[Record],
        carry_out: Callable[[Array, Array], None],
        robots: Sequence[int],
    ) -> None:
        """Nobody has said anything yet; these robots have the policy."""
        self._world, self._said, self._carry_out = world, said, carry_out
        self._parts = _slices(robots)
        self.minds: Array = said.array((world.n_worlds, world.n_robots))

    @property
    def has_rules(self) -> bool:
        """There are none."""
        return False

    def observe(self, first: int, last: int) -> None:
        """There is no estimator."""

    def consult(self) -> None:
        """There are no rules."""

    def decide(self, first: int, last: int) -> None:
        """Command what the action says, in the worlds first .. last - 1."""
        robots = self._world.robots
        for part in self._parts:
            self._carry_out(robots[first:last, part], self.minds[first:last, part])

    def numbers_in(self, world: int, scenario: Any) -> None:  # noqa: ANN401 of its task
        """There are no numbers; ConfigError where faults falsify messages."""
        refuse_falsifying("policy", scenario)

    def renumber(self, world: int, numbers: None) -> None:
        """There are no numbers."""

    def reset(self, world: int, seed: int) -> None:
        """Forget what was said."""
        self._said.restart(self.minds[world])

    def snapshot(self) -> Array:
        """What was said."""
        return self.minds.copy()

    def restore(self, kept: Array) -> None:
        """Go on from what was said then."""
        self.minds[...] = kept


def _slices(numbers: Sequence[int]) -> list[slice]:
    """Numbers in rising order as slices, one for each run without a gap.

    >>> _slices([0, 1, 2, 5])
    [slice(0, 3, None), slice(5, 6, None)]
    """
    found: list[slice] = []
    for number in numbers:
        if found and found[-1].stop == number:
            found[-1] = slice(found[-1].start, number + 1)
        else:
            found.append(slice(number, number + 1))
    return found

"""What is reported of a block of worlds: global state for critics, logs, and trajectories."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from gymnasium.spaces import Box

from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.interface import Kernel, RunningController
from swarm_forage_env.raw_control import has_estimators
from swarm_forage_env.spaces import Feature, Layout


class GlobalState(ABC):
    """What is true in a block of worlds, flat: each robot, then the world and the time."""

    infos: tuple[str, ...]
    """What is logged of each robot, by name."""
    logs: tuple[Kernel, Kernel]
    """What writes it: of a robot, what its estimator keeps or what a policy says, its world, and
    the row of numbers, which are 0 before; without beliefs, and with."""
    counts: frozenset[str] = frozenset()
    """Those of which several robots have the sum; of everything else they have the mean."""

    def __init__(
        self,
        world: Any,  # noqa: ANN401 of its task
        controller: RunningController,
        agents: Sequence[str],
        scenario: Any,  # noqa: ANN401 of its task
    ) -> None:
        self._world, self._controller, self._scenario = world, controller, scenario
        self._has_beliefs = has_estimators(controller.minds)
        own = self.robot_features()
        features = [replace(f, name=f"{agent}.{f.name}") for agent in agents for f in own]
        share = Feature("share_gone", "of the episode", 0.0, 1.0)
        self.layout = Layout([*features, *self.world_features(), share])
        self.space: Box = self.layout.box()

    def state(self, share_gone: Float64[Array, " worlds"]) -> Float32[Array, "worlds numbers"]:
        """One row for each world, as the layout says."""
        shape = self._world.robots.shape
        robots = np.concatenate([each.reshape(*shape, -1) for each in self.of_robots()], axis=2)
        rows = [each.reshape(len(robots), -1) for each in (robots, *self.of_world())]
        return np.concatenate([*rows, np.minimum(share_gone, 1.0)[:, None]], 1, dtype=np.float32)

    @abstractmethod
    def robot_features(self) -> Sequence[Feature]:
        """The features of one robot."""

    @abstractmethod
    def of_robots(self) -> Sequence[Array]:
        """The numbers of the robots, in the order of their features: worlds, robots, any axes."""

    def world_features(self) -> Sequence[Feature]:
        """The features of the world beside its robots: none."""
        return ()

    def of_world(self) -> Sequence[Array]:
        """The numbers of the worlds, in the order of their features: worlds, any axes."""
        return ()


@dataclass(frozen=True, slots=True)
class TrajectoryColumn:
    """One column: what a table calls it, its type, and what it is for a reader."""

    name: str
    kind: str
    """NumPy type: of the numbers, or of the codes of words."""
    text: str
    """What the column holds, with its unit."""
    words: tuple[str, ...] = ()
    """The word of each code, where the column holds words."""

    @property
    def is_nullable(self) -> bool:
        """The column may be empty: a float that is NaN, a code that is -1."""
        return bool(self.words) or self.kind.startswith("f")


@dataclass(frozen=True, slots=True)
class TrajectoryKind:
    """What the robots of a task leave behind in a tick."""

    columns: tuple[TrajectoryColumn, ...]
    take: Callable[[Any, Array], Mapping[str, Array]]
    """The columns as they stand now, each (worlds, robots), from a block and the minds of its
    robots. NaN and -1 stand for what there is not."""

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the columns."""
        return tuple(each.name for each in self.columns)

"""Reports on a block of worlds: global state for critics, logs and trajectories."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.interface import Kernel, RunningController
from swarm_forage_env.raw_control import has_estimators
from swarm_forage_env.spaces import Feature, Layout


class GlobalState(ABC):
    """Flat true state of a block of worlds: each robot, then the world and the time."""

    infos: tuple[str, ...]
    """Names of the values that are logged for each robot."""
    logs: tuple[Kernel, Kernel]
    """Functions that write these values, without and with beliefs; arguments: robot, its mind (the
    record of its estimator or its policy), its world, and the output row, which is 0 before."""
    counts: frozenset[str] = frozenset()
    """Infos that are summed over several robots; all others are averaged."""

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

    def state(self, share_gone: Float64[Array, " worlds"]) -> Float32[Array, "worlds numbers"]:
        """Return one row for each world, in the order of `layout`."""
        shape = self._world.robots.shape
        robots = np.concatenate([each.reshape(*shape, -1) for each in self.of_robots()], axis=2)
        rows = [each.reshape(len(robots), -1) for each in (robots, *self.of_world())]
        return np.concatenate([*rows, share_gone[:, None]], 1, dtype=np.float32)

    @abstractmethod
    def robot_features(self) -> Sequence[Feature]:
        """Return the features of one robot."""

    @abstractmethod
    def of_robots(self) -> Sequence[Array]:
        """Return the robots' features in order, each of shape (worlds, robots, ...)."""

    def world_features(self) -> Sequence[Feature]:
        """Return the features of the world without its robots; by default none."""
        return ()

    def of_world(self) -> Sequence[Array]:
        """Return the worlds' features in order, each of shape (worlds, ...)."""
        return ()


@dataclass(frozen=True, slots=True)
class TrajectoryColumn:
    """One column of a trajectory: its name, type and description."""

    name: str
    kind: str
    """NumPy type of the values, or of the codes of words."""
    text: str
    """Description of the column, with its unit."""
    words: tuple[str, ...] = ()
    """Word of each code, if the column holds words."""

    @property
    def is_nullable(self) -> bool:
        """Whether values may be missing: NaN in floats, -1 in codes."""
        return bool(self.words) or self.kind.startswith("f")


@dataclass(frozen=True, slots=True)
class TrajectoryKind:
    """Columns recorded of the robots of a task in every tick."""

    columns: tuple[TrajectoryColumn, ...]
    take: Callable[[Any, Array], Mapping[str, Array]]
    """Returns the current columns, each of shape (worlds, robots), of a block and the minds of its
    robots; missing values are NaN or -1."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(each.name for each in self.columns)

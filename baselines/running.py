"""The running controller: the layers of all robots of a block of worlds, compiled together.

Robots whose estimators have the same functions are a team: they understand each other's messages.
Members of a team whose weighting and motion have the same functions too are a group: one kernel
decides for them. All robots of one controller are a team of one group.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import replace
from typing import Any

import numpy as np

from baselines.composition import (
    LAYERS,
    Layers,
    Members,
    Row,
    check_alike,
    groups_of,
    layers_by_robot,
    set_stream,
    settings_of,
)
from swarm_forage_env.arrays import Array
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.foraging.control import observe_world
from swarm_forage_env.interface import (
    CORRECT,
    KEEP,
    RULE,
    CompiledLayers,
    EstimatorLayer,
    Kernel,
    MotionRule,
    WeightingRule,
)
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.random_streams import streams
from swarm_forage_env.record import Rows, copied_rows, offset_of, record_dtype
from swarm_forage_env.task import World, task_of
from swarm_forage_env.templates import is_row_template, parts_of
from swarm_forage_env.ticks import joined, nothing


def _by_robot(rule: Callable[..., object], inputs: Iterable[Rows], like: Array) -> Array:
    """Call a rule in NumPy and reshape its result like `like`; ConfigError if it does not fit."""
    result, rows = np.asarray(rule(*inputs), np.float32), like.shape[0] * like.shape[1]
    if result.shape[:1] != (rows,) or result.size != like.size:
        raise ConfigError(
            f"{type(rule).__name__}: gave shape {result.shape}, must be"
            f" {(rows, like.size // rows)}, a row for each robot of all worlds"
        )
    return result.reshape(like.shape)


class CompositionGroup:
    """Group of robots whose layers have the same functions."""

    def __init__(
        self, running: "RunningLayers", own: Layers, members: Members, seeds: Sequence[int]
    ) -> None:
        """Bind the functions of the group; `own` are the layers of one of its members."""
        world, motion = running.world, own.motion
        self.members, self.motion = members, motion
        minds, memory = running.minds, motion.memory.dtype(robots=len(members))
        place = offset_of(minds.dtype, "motion")
        self.memories: Array = np.ndarray(minds.shape, memory, minds, place, minds.strides)
        """Memory of the motion of each robot: a view, as other groups may need larger records."""
        self.functions: Mapping[str, Kernel] = {
            **running.estimator.kernels,
            **motion.kernels,
            "gain": own.weighting.gain,
            "steer": motion.steer,
            "observe_world": running.estimator.observe,
            "decide_world": task_of(world.scenario).decide,
            "set_stream": set_stream if "stream" in motion.memory.fields else nothing,
        }
        self._check_names(*running.estimator.kernels, *motion.kernels)
        self.steer: MotionRule | None = None  # the motion, if written in NumPy
        if own.motion_rule is not None:
            self.steer = own.motion_rule.start(world.scenario, seeds)
        self.weigh: WeightingRule | None = own.weighting_rule
        """Weighting of the group if it is written in NumPy, else None."""
        if hasattr(self.weigh, "start_knowing"):  # it reads the beliefs and the ground truth
            self.weigh = self.weigh.start_knowing(running, world)

    def _check_names(self, *names: str) -> None:
        """Raise UnknownNameError for a function of a layer that no template calls by its name.

        An estimator with a template of its own may also keep functions of the usual one.
        """
        own = self.functions["observe_world"], self.functions["decide_world"]
        templates = [each for each in (observe_world, *own) if is_row_template(each)]
        called = {name for each in templates for name, _ in parts_of(each, self.functions)}
        for name in names:
            if name not in called:
                raise UnknownNameError("function that the tick calls", name, called)

    def reset(self, first: int, last: int, seeds: Sequence[int]) -> None:
        """Reset the motion in worlds first .. last - 1, with these seeds."""
        shape = last - first, len(self.members)
        memory = np.zeros(shape, self.memories.dtype)
        self.motion.memory.restart(memory)
        if "stream" in self.motion.memory.fields:
            words = streams(seeds, len(self.members), self.motion.noise)
            memory["stream"][:, :, 0] = words.reshape(shape)
        self.memories[first:last, self.members] = memory[:, self.members]
        if self.steer is not None:
            for world, seed in zip(range(first, last), seeds, strict=True):
                self.steer.reset(world, seed)

    def act(self, action: Array, layer: str, name: str, values: Array) -> None:
        """Write the values of a rule as actions of the robots of the group without a policy."""
        mask = self.members & ((action[layer] == KEEP) | (action[layer] == RULE))
        action[layer][mask] = RULE
        action[name][mask] = values[mask]


class RunningLayers:
    """Running layers of a team in a block of worlds; parameters may differ by robot and world.

    Weight and wheel speeds of a tick both depend on the beliefs after messages were received.
    Estimates are merged afterwards and affect the motion from the next tick on. Thus one
    observation holds the inputs of either layer, or of both.
    """

    minds: Array

    def __init__(self, world: World, seeds: Sequence[int], controllers: Sequence[Row]) -> None:
        """Compile the layers. `controllers[world][robot]` is None for robots of other teams.

        Between worlds, the controllers of a robot may differ only in their parameters.
        """
        self.world, self._task = world, task_of(world.scenario)
        self.controllers = controllers
        robot_layers = layers_by_robot(controllers, world.scenarios)
        check_alike(robot_layers)
        self._first_layers, groups = robot_layers[0], groups_of(robot_layers[0])
        leaders = [self._first_layers[int(np.argmax(members))] for members in groups]
        self.estimator: EstimatorLayer = leaders[0].estimator
        self._allocate(self._first_layers)
        self._groups = [
            CompositionGroup(self, own, members, seeds)
            for own, members in zip(leaders, groups, strict=True)
        ]
        self._settings = self._settings_of(robot_layers)

    @property
    def has_rules(self) -> bool:
        """Whether a layer is a rule in NumPy, which is called once for all worlds."""
        return any(group.steer is not None or group.weigh is not None for group in self._groups)

    @property
    def compiled(self) -> CompiledLayers:
        """Compiled layers for the ticks of the block; the groups decide one after the other."""
        n_robots = self.world.n_robots
        groups = [
            CompiledLayers(
                group.functions,
                (self._estimators, group.memories, self.shared, settings),
                (
                    self.estimator.mind.array((1,), robots=n_robots),
                    group.motion.memory.array((1,), robots=n_robots),
                ),
                int(group.motion.noise),
            )
            for group, settings in zip(self._groups, self._settings[1:], strict=True)
        ]
        if len(groups) == 1:
            return groups[0]
        deciding = [
            replace(each, functions={**each.functions, "observe_world": nothing}) for each in groups
        ]
        first = groups[0]
        observing = CompiledLayers(
            {**first.functions, "decide_world": nothing}, (*first.arrays[:3], self._settings[0])
        )
        return joined([*deciding, observing])

    def call_rules(self) -> None:
        """Call the rules written in NumPy. A policy takes precedence; its corrections are added."""
        robots, commanded = self.world.robots, self._task.commanded
        action, command = robots["action"], robots["command"][commanded]
        for group in self._groups:
            if group.steer is not None:
                wheels = _by_robot(group.steer, self._motion_inputs(), command)
                group.act(action, "motion", commanded, wheels)
                corrected = group.members & (action["motion"] == CORRECT)
                command[corrected] = wheels[corrected]
            if group.weigh is not None:
                exchange = copied_rows(self._estimators, ("exchange",))
                if exchange.is_valid.any():
                    weights = _by_robot(group.weigh, (exchange,), action["weight"])
                    group.act(action, "weighting", "weight", weights)

    def reset(self, first: int, last: int, seeds: Sequence[int]) -> None:
        """Reset the layers in worlds first .. last - 1, with these seeds."""
        self.estimator.mind.restart(self._estimators[first:last])
        self.shared[first:last] = 0.0
        for group in self._groups:
            group.reset(first, last, seeds)

    def parameters_in(self, world: int, scenario: BaseScenario) -> list[Array]:
        """Return the parameters of the robots of a world in another scenario: of team and groups.

        ConfigError if a layer does not support the scenario.
        """
        robot_layers = layers_by_robot([self.controllers[world]], [scenario])
        check_alike([self._first_layers, robot_layers[0]])
        return self._settings_of(robot_layers)

    def write_parameters(self, world: int, numbers: Sequence[Array]) -> None:
        """Write parameters returned by `parameters_in` for one world."""
        for settings, parameters in zip(self._settings, numbers, strict=True):
            settings[world] = parameters[0]

    def snapshot(self) -> dict[str, Any]:
        """Return copies of all minds, of the parameters of all worlds, and of motions in NumPy."""
        return {
            "minds": self.minds.copy(),
            "shared": self.shared.copy(),
            "settings": [settings.copy() for settings in self._settings],
            "motions": deepcopy([group.steer for group in self._groups]),
        }

    def restore(self, snapshot: Mapping[str, Any]) -> None:
        """Restore a snapshot in place: the arrays keep their addresses."""
        self.minds[...], self.shared[...] = snapshot["minds"], snapshot["shared"]
        for settings, values in zip(self._settings, snapshot["settings"], strict=True):
            settings[...] = values
        for group, motion in zip(self._groups, deepcopy(snapshot["motions"]), strict=True):
            group.steer = motion

    def check_on_gpu(self) -> None:
        """Raise ConfigError, with the reason, if the layers run on a CPU only."""
        own = self.estimator
        reasons = {
            "one of its layers is a rule in NumPy": self.has_rules,
            "its robots have several compositions": len(self._groups) > 1,
            "its estimator stores data of each pair of robots": own.shared is not None,
            "its estimator receives messages by a template of its own": own.observe
            not in (observe_world, nothing),
        }
        for reason, holds in reasons.items():
            if holds:
                raise ConfigError(
                    f"device='cuda': controller '{self.controllers[0][0].name}' runs on a CPU"
                    f" only, because {reason}; use another one, such as ssgikf, or device='cpu'"
                )

    def _motion_inputs(self) -> Iterator[Rows]:
        """Yield copies of the inputs of the motion layer, in the order of `steer`."""
        yield copied_rows(self._estimators, ("situation",))
        for path in (*self._task.steered_by, f"robots.command.{self._task.commanded}"):
            yield copied_rows(self.world.robots, path.split(".")[1:])

    def _settings_of(self, robot_layers: Sequence[Row]) -> list[Array]:
        """Return the parameters of each robot of each world, for the team and for each group."""
        by_group = [
            settings_of(robot_layers, LAYERS, each.members, is_last=each is self._groups[-1])
            for each in self._groups
        ]
        team = np.any([each.members for each in self._groups], axis=0)
        return [settings_of(robot_layers, ("estimator",), team), *by_group]

    def _allocate(self, row: Row) -> None:
        n_worlds, n_robots = self.world.n_worlds, self.world.n_robots
        memories = [layers.motion.memory.dtype(robots=n_robots) for layers in row if layers]
        mind = [
            ("estimator", self.estimator.mind.dtype(robots=n_robots)),
            ("motion", max(memories, key=lambda memory: memory.itemsize)),
        ]
        self.minds = np.zeros((n_worlds, n_robots), record_dtype(mind))
        pairs = (0,) if self.estimator.shared is None else (n_robots, *self.estimator.shared)
        self.shared: Array = np.zeros((n_worlds, n_robots, *pairs))
        self._estimators = self.minds["estimator"]

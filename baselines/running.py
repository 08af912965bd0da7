"""The running controller: the layers of all robots of a block of worlds, compiled together."""

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import bind, kernel
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import KEEP, RULE, EstimatorLayer, MotionLayer, WeightingLayer
from swarm_forage_env.random_streams import streams
from swarm_forage_env.record import numbers_record, record_dtype
from swarm_forage_env.task import task_of


class RunningLayers:
    """Three layers, run on a block of worlds; each world has its own numbers.

    Both the weight and the wheels of a tick are decided from what the robot knows after
    listening; what was heard is merged afterwards, and steers from the next tick on. So one
    observation holds all that either layer, or both, are shown.
    """

    def __init__(
        self,
        world: Any,  # noqa: ANN401 of any task
        seeds: Sequence[int],
        controllers: Sequence[Any],
    ) -> None:
        """Put the layers of every world together; they differ in their numbers only."""
        self._world, self._task = world, task_of(world.scenario)
        self._controllers = tuple(controllers)
        each = [
            _layers(controller, scenario)
            for controller, scenario in zip(controllers, world.scenarios, strict=True)
        ]
        _check_alike(controllers, each)
        self.estimator, self.weighting, self.motion = each[0]
        self._allocate()
        self._layers = _numbers(each)
        self._numbers = np.ascontiguousarray(self._layers["estimator"])
        self._bind()
        self._weigh = _rule(controllers[0].weighting, self, world)
        self._steer = None
        if _is_numpy_motion(self.motion):
            self._steer = controllers[0].motion.start(world.scenario, seeds)

    @property
    def has_rules(self) -> bool:
        """A layer is a rule in NumPy, which is asked about all worlds at once."""
        return self._steer is not None or self._weigh is not None

    def observe(self, first: int, last: int) -> None:
        """Take in what the worlds first .. last - 1 gave back."""
        self._observe(
            self._world.records, self._estimators, self.shared, self._numbers, first, last
        )

    def consult(self) -> None:
        """Ask the rules written in NumPy; where a learner acts already they are not heard."""
        action = self._world.robots["action"]
        if self._steer is not None:
            situation = self._task.situation(self._world, self.minds)
            _act(action, "motion", self._task.commanded, self._steer(situation))
        if self._weigh is not None:
            exchange = self._task.exchange(self._world, self.minds)
            if exchange.valid.any():
                _act(action, "weighting", "weight", self._weigh(exchange))

    def decide(self, first: int, last: int) -> None:
        """Write the next commands of the worlds first .. last - 1, and merge what was heard."""
        self._decide(self._world.records, self.minds, self.shared, self._layers, first, last)

    def reset(self, world: int, seed: int) -> None:
        """Forget everything about one world, and draw from this seed from now on."""
        self.estimator.mind.restart(self._estimators[world])
        memory = self.minds["motion"][world]
        self.motion.memory.restart(memory)
        self.shared[world] = 0.0
        if "stream" in self.motion.memory.fields:
            n_robots = self._world.n_robots
            memory["stream"][:, 0] = streams([seed], n_robots, self.motion.noise)
        if self._steer is not None:
            self._steer.reset(world, seed)

    def numbers_in(self, world: int, scenario: Any) -> Array:  # noqa: ANN401 of its task
        """The numbers of one world's layers in another scenario: one record.

        ConfigError if a layer is not made for it.
        """
        controller = self._controllers[world]
        layers = _layers(controller, scenario)
        own = self.estimator, self.weighting, self.motion
        _check_alike((self._controllers[0], controller), (own, layers))
        return _numbers([layers])

    def renumber(self, world: int, numbers: Array) -> None:
        """Go by these numbers in one world from now on."""
        self._layers[world] = numbers[0]
        self._numbers[world] = numbers["estimator"][0]

    def _allocate(self) -> None:
        """Make the records of every robot."""
        n_worlds, n_robots = self._world.n_worlds, self._world.n_robots
        mind = [
            ("estimator", self.estimator.mind.dtype(robots=n_robots)),
            ("motion", self.motion.memory.dtype(robots=n_robots)),
        ]
        self.minds: Array = np.zeros((n_worlds, n_robots), record_dtype(mind))
        pairs = (0,) if self.estimator.shared is None else (n_robots, *self.estimator.shared)
        self.shared: Array = np.zeros((n_worlds, n_robots, *pairs))
        self._estimators = self.minds["estimator"]

    def _bind(self) -> None:
        """Compile both halves of a tick with the functions of the layers."""
        functions = {
            **self.estimator.kernels, "gain": self.weighting.gain, "steer": self.motion.steer,
        }  # fmt: skip
        self._observe = bind(self.estimator.observe, functions)
        self._decide = bind(self._task.decide, functions)


LAYERS = ("estimator", "weighting", "motion")


def _check_alike(controllers: Sequence[Any], each: Sequence[Any]) -> None:
    """ConfigError if the controllers of a block differ in more than their numbers."""
    for controller, layers in zip(controllers, each, strict=True):
        for name, first, layer in zip(LAYERS, each[0], layers, strict=True):
            in_numpy = not hasattr(getattr(controller, name), "layer") or _is_numpy_motion(layer)
            is_same = getattr(controller, name) is getattr(controllers[0], name)
            if (in_numpy and not is_same) or _functions(layer) != _functions(first):
                raise ConfigError(
                    f"controllers '{controllers[0].name}' and '{controller.name}' have another"
                    f" {name}: those of one block may differ in their numbers only"
                )


def _is_numpy_motion(layer: Any) -> bool:  # noqa: ANN401 any of the three
    """Whether a layer leaves the motion to a rule in NumPy."""
    return getattr(layer, "steer", None) is no_motion


def _functions(layer: Any) -> list[Any]:  # noqa: ANN401 any of the three
    """What a layer consists of, but for its numbers."""
    numbers = ("numbers", "heard_p_share", "own_weighting")
    kept = [getattr(layer, each.name) for each in fields(layer) if each.name not in numbers]
    return [*kept, sorted(layer.numbers)]


def _numbers(each: Sequence[tuple[EstimatorLayer, WeightingLayer, MotionLayer]]) -> Array:
    """One record a world with the numbers of each layer."""
    worlds = [
        {
            "estimator": estimator.numbers,
            "weighting": weighting.all_numbers,
            "motion": motion.numbers,
        }
        for estimator, weighting, motion in each
    ]
    kinds = [(layer, numbers_record(**numbers)) for layer, numbers in worlds[0].items()]
    found = np.zeros(len(worlds), record_dtype(kinds))
    for w, layers in enumerate(worlds):
        for layer, numbers in layers.items():
            for name, value in numbers.items():
                found[layer][name][w] = value
    return found


@kernel
def no_gain(*seen: Any) -> float:  # noqa: ANN401 of any task
    """Nothing is taken over: the weight of a rule written in NumPy comes as an action."""
    return 0.0


@kernel
def no_motion(*seen: Any) -> None:  # noqa: ANN401 of any task
    """The command stays as it is: that of a rule written in NumPy comes as an action."""


def _layers(
    controller: Any, scenario: Any  # noqa: ANN401 of any task
) -> tuple[EstimatorLayer, WeightingLayer, MotionLayer]:  # fmt: skip
    """The three layers of a controller in a scenario."""
    estimator = controller.estimator.layer(scenario)
    weighting = _weighting_layer(controller.weighting, scenario, estimator)
    return estimator, weighting, _motion_layer(controller.motion, scenario)


def _weighting_layer(part: Any, scenario: Any, estimator: EstimatorLayer) -> WeightingLayer:  # noqa: ANN401 compiled or not
    if not hasattr(part, "layer"):
        return WeightingLayer(no_gain, heard_p_share=part.heard_p_share)
    layer: WeightingLayer | None = part.layer(scenario) or estimator.own_weighting
    if layer is None:
        raise ConfigError("weighting 'filter': this estimator has no gain of its own; name a rule")
    return layer


def _motion_layer(part: Any, scenario: Any) -> MotionLayer:  # noqa: ANN401 compiled or not
    layer: MotionLayer | None = part.layer(scenario) if hasattr(part, "layer") else None
    return layer or MotionLayer(no_motion, {})


def _rule(part: Any, running: RunningLayers, world: Any) -> Any:  # noqa: ANN401 as above
    """A weighting written in NumPy; None for a compiled one."""
    if hasattr(part, "layer"):
        return None
    return part.start_knowing(running, world) if hasattr(part, "start_knowing") else part


def _act(action: Array, layer: str, name: str, given: Float32[Array, "rows numbers"]) -> None:
    """Write what a rule gives, where no learner acts."""
    own = (action[layer] == KEEP) | (action[layer] == RULE)
    action[layer][own] = RULE
    numbers = given.reshape(action[name].shape)
    action[name][own] = numbers[own]

"""Actions on a GPU: numbers or choices of the learners, checked and handed to their layers."""

from typing import Any, Protocol

import numpy as np
from gymnasium.spaces import Box

from swarm_forage_env.compiler import bind_grid
from swarm_forage_env.device_loop import DeviceLoop
from swarm_forage_env.envs import grid
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.errors import ConfigError


class DeviceActions(Protocol):
    """Actions of one form."""

    raw: Any
    """What the layers of the learners took last; worlds, learners, numbers."""

    def taken(self, actions: Any) -> Any:  # noqa: ANN401 a tensor of any library
        """The actions as they lie on the GPU; ConfigError for what has another shape or type."""
        ...

    def check(self, given: Any) -> None:  # noqa: ANN401 an array of the GPU
        """Note what is out of bounds."""
        ...

    def take(self, given: Any) -> None:  # noqa: ANN401 an array of the GPU
        """Write the actions."""
        ...


class DeviceNumbers:
    """Actions that are numbers, float32."""

    def __init__(self, host: ArrayEnv, loop: DeviceLoop) -> None:
        """In the place of the learners of an environment."""
        assert isinstance(host.action_space, Box)
        self._form, self._turn = host.actions.form, host.config.sharpest_turn
        self._loop, self._learners = loop, loop.memory.to_device(host.learner_numbers)
        low, high = host.action_space.low, host.action_space.high
        self._bounds = loop.memory.to_device(low), loop.memory.to_device(high)
        self.raw, self._fields = _raw(host, loop), loop.fields(host.policy.action)
        command = {"command": grid.as_given, **self._form.steering_kernel}
        self._check = bind_grid(grid.check_actions, {})
        self._take = bind_grid(grid.take_actions, command)

    def taken(self, actions: Any) -> Any:  # noqa: ANN401 a tensor of any library
        """The actions as they lie on the GPU; ConfigError for what has another shape or type."""
        given = self._loop.memory.taken(actions)
        return _checked(given, self.raw.shape, given.dtype == np.float32, "float32")

    def check(self, given: Any) -> None:  # noqa: ANN401 an array of the GPU
        """Note what is out of bounds."""
        self._check[self._loop.launch](given, *self._bounds, self._loop.trouble)

    def take(self, given: Any) -> None:  # noqa: ANN401 an array of the GPU
        """Write the actions."""
        form, turn = self._form, self._turn
        self._take[self._loop.launch](
            *self._fields, self._learners, given, self.raw, form.n_symmetric, form.steers_at, turn
        )


class DeviceChoices:
    """Actions that are choices, whole numbers of any type."""

    def __init__(self, host: ArrayEnv, loop: DeviceLoop) -> None:
        """In the place of the learners of an environment."""
        form = host.actions.form
        self._n = len(form.choices)
        self._choices = loop.memory.to_device(form.raw_of(np.arange(self._n)))
        self._loop, self._learners = loop, loop.memory.to_device(host.learner_numbers)
        self.raw, self._fields = _raw(host, loop), loop.fields(host.policy.action)
        self._check = bind_grid(grid.check_choices, {})
        self._take = bind_grid(grid.take_choices, {})

    def taken(self, actions: Any) -> Any:  # noqa: ANN401 a tensor of any library
        """The actions as they lie on the GPU; ConfigError for what has another shape or type."""
        given = self._loop.memory.taken(actions)
        is_whole = given.dtype.kind in "iu"
        return _checked(given, self.raw.shape[:2], is_whole, "whole numbers, as int64,")

    def check(self, given: Any) -> None:  # noqa: ANN401 an array of the GPU
        """Note what is no choice."""
        self._check[self._loop.launch](given, self._n, self._loop.trouble)

    def take(self, given: Any) -> None:  # noqa: ANN401 an array of the GPU
        """Write the actions."""
        self._take[self._loop.launch](*self._fields, self._learners, given, self._choices, self.raw)


def _raw(host: ArrayEnv, loop: DeviceLoop) -> Any:  # noqa: ANN401 an array of the GPU
    """Room for the actions as the layers take them; zeros before the first."""
    shape = host.n_worlds, len(host.learners), len(host.policy.action)
    return loop.memory.to_device(np.zeros(shape, np.float32))


def _checked(given: Any, shape: tuple[int, ...], fits: bool, kind: str) -> Any:  # noqa: ANN401 as above
    if given.shape == shape and fits:
        return given
    raise ConfigError(
        f"actions of shape {given.shape} and type {given.dtype}: must be {kind} of shape {shape}"
    )

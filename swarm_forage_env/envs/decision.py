"""What becomes of the actions of the learners of worlds, and what they observe and are given."""

from collections.abc import Callable
from typing import Any

import numpy as np
from gymnasium.spaces import Box

from swarm_forage_env.arrays import Array, Float64, Int64
from swarm_forage_env.device_loop import DeviceLoop
from swarm_forage_env.envs import decision_kernels as kernels
from swarm_forage_env.envs.decision_kernels import Terms
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.envs.stepping import Worlds
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.ticks import RUNS
from swarm_forage_env.worlds_on_cpu import PlacedArray

Snapshot = tuple[Array, tuple[Array, Array]]
"""Actions, and of observations frames and streams."""


class Decisions:
    """The decisions of the learners of a block of worlds, where these run."""

    def __init__(
        self, worlds: Worlds, form: PolicyForm, learners: Int64[Array, " learners"]
    ) -> None:
        self._worlds, self._form, config, memory = worlds, form, form.config, worlds.memory
        self._terms: Terms = config.discount, config.shaping, config.reward == "team"
        self._earned = worlds.arrays["earned"]
        shape: tuple[int, int] = self._earned.shape
        self._rows = shape[0], len(learners)
        raw = np.zeros((*self._rows, len(form.policy.action)), np.float32)
        self.raw = memory.to_device(raw)
        """What the layers of the learners took last; worlds, learners, numbers."""
        self._learners = memory.to_device(learners)
        table, *rest = form.action.conversion
        self._conversion = memory.to_device(table), *rest
        self._fields = worlds.fields(form.policy.action)
        self._write_actions = worlds.kernel(kernels.write_actions, form.action.functions)
        self._allowed = kernels.check_choices if form.action.is_discrete else kernels.check_numbers
        self._check = worlds.kernel(kernels.check, {"check_actions": self._allowed})
        space = form.action.space
        self._limits: Any = 0
        """The bounds of the numbers of an action, or how many choices there are."""
        if isinstance(space, Box):
            self._limits = memory.to_device(space.low), memory.to_device(space.high)
        else:
            self._limits = len(form.action.choices)
        self._credit = worlds.kernel(kernels.credit, {})
        phi = form.task.potential
        self._note = None
        if config.shaping > 0.0 and phi is not None:
            self._note = worlds.kernel(kernels.write_potentials, {"potential": phi.of})
        self._potentials = memory.to_device(
            np.zeros((2, *shape) if config.shaping > 0.0 else (2, 0, 0))
        )
        self.observing = form.observing(worlds, learners.tolist())
        self._run = memory.to_device(np.full(shape[0], RUNS, np.int8))

    def placed(self, actions: object) -> PlacedArray:
        """Actions as they lie on a GPU; ConfigError for another shape or type."""
        assert isinstance(self._worlds, DeviceLoop)
        array = self._worlds.memory.as_device_array(actions)
        is_discrete = self._form.action.is_discrete
        fits = array.dtype.kind in "iu" if is_discrete else array.dtype == np.float32
        kind = "whole numbers, as int64," if is_discrete else "float32"
        shape = *self._rows, *self._form.action.shape
        if array.shape != shape or not fits:
            raise ConfigError(
                f"actions of shape {array.shape} and type {array.dtype}: must be {kind} of shape"
                f" {shape}"
            )
        return array

    def check(self, actions: PlacedArray) -> None:
        """ConfigError for actions on a GPU that are out of bounds: waits for it."""
        assert isinstance(self._worlds, DeviceLoop)
        self._check(actions, self._limits, self._worlds.trouble)
        self._worlds.check()

    def write_actions(self, actions: PlacedArray) -> None:
        """Hand checked actions to the layers of the learners."""
        self._write_actions(
            self._fields, self._learners, actions, self._conversion, self.raw, self._earned
        )
        self._note_potential(0)

    def rewards(self) -> tuple[PlacedArray, PlacedArray]:
        """The rewards of every learner since it acted: without shaping, and with it."""
        self._note_potential(1)
        out = self._worlds.memory.empty((2, *self._rows), np.float64)
        self._credit(self._learners, self._earned, self._potentials, self._terms, out)
        return out[0], out[1]

    def observe(
        self, time_left: Callable[[], Float64[Array, " worlds"]], modes: PlacedArray | None = None
    ) -> Any:  # noqa: ANN401 an array of NumPy, or of a GPU
        """What every learner observes after its action, or where worlds begin as `modes` say."""
        return self.observing(self.raw, self._run if modes is None else modes, time_left)

    def snapshot(self) -> Snapshot:
        """The last actions, and what observations go on from."""
        return np.array(self._worlds.memory.read(self.raw)), self.observing.snapshot()

    def check_fits(self, snapshot: Snapshot) -> None:
        """ConfigError if a snapshot is of an environment of other options."""
        raw, frames = snapshot
        if raw.shape != self.raw.shape or not self.observing.fits(frames):
            raise ConfigError("restore(): the snapshot is of an environment of other options")

    def restore(self, snapshot: Snapshot) -> None:
        """Go on as when a snapshot that fits was taken."""
        raw, frames = snapshot
        self._worlds.memory.write(self.raw, raw)
        self.observing.restore(frames)

    def _note_potential(self, when: int) -> None:
        if self._note is not None:
            at = self._worlds.arrays
            self._note(at["robots"], at["worlds"], self._potentials[when])

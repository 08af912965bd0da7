"""Decisions of learners: from actions to layer inputs, and back to observations and rewards."""

from collections.abc import Mapping
from typing import Any, cast

import numpy as np
from gymnasium.spaces import Box

from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int64, read_only
from swarm_forage_env.device_loop import DeviceLoop
from swarm_forage_env.envs import decision_kernels as kernels
from swarm_forage_env.envs.decision_kernels import Terms
from swarm_forage_env.envs.episodes import Episodes
from swarm_forage_env.envs.extra_observations import Observation, ObservationContext, RowObservation
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import Kernel
from swarm_forage_env.loop import Loop
from swarm_forage_env.random_streams import hash_of
from swarm_forage_env.spaces import Layout
from swarm_forage_env.ticks import RUN, SKIP, START, Modes
from swarm_forage_env.worlds_on_cpu import Memory, PlacedArray, WorldsOnCpu

Worlds = Loop | DeviceLoop

Snapshot = tuple[Array, tuple[Array, Array]]
"""Last actions; stacked observations and random streams."""


class Observing:
    """Observations of the learners, computed where the worlds run, in a new array for each call."""

    def __init__(
        self, form: PolicyForm, place: WorldsOnCpu | DeviceLoop, robots: Int64[Array, " learners"]
    ) -> None:
        self._place, memory = place, place.memory
        self._shape = place.arrays["robots"].shape
        rows, n, stack = (self._shape[0], len(robots)), len(form.observed), form.config.stack
        self._robots, self._learners = robots, memory.to_device(robots)
        self._single_shape, self._stacked_shape = (*rows, n), (*rows, stack * n)
        *where, bound, squashes = form.scaling
        self._scaling = *where, memory.to_device(bound), memory.to_device(squashes)
        self._fields = place.fields(form.shown)
        additions = [
            (part.kind, first)
            for part, first, _ in form.additions
            if isinstance(part, RowObservation)
        ]
        self._additions = memory.to_device(np.array(additions, np.int64).reshape(-1, 2))
        self._numpy: list[tuple[Observation, int, Layout]] = [
            (part, first, features)
            for part, first, features in form.additions
            if not isinstance(part, RowObservation)
        ]
        # a user-defined observation is not repeated in a world that is not observed: it is kept
        n_frames = stack if stack > 1 or self._numpy else 0
        self._stacks = memory.to_device(np.zeros((*rows, n_frames, n), np.float32))
        self._streams = np.zeros(self._shape if self._numpy else (0, 0), np.uint64)
        self._observe = place.kernel(kernels.observe, {})

    def __call__(
        self, raw: PlacedArray, modes: PlacedArray, time_left: Float64[Array, " worlds"]
    ) -> Any:  # noqa: ANN401 a NumPy or GPU array
        """Return the observations of every learner after the layer inputs `raw`.

        In mode START, `raw` is set to zero and the stack is filled with the observation; mode RUN
        appends one. `time_left` is the remaining share of each episode.
        """
        single, out = self.output_arrays()
        if self._numpy:
            self._add_all(time_left, cast(Array, raw), cast(Array, modes), cast(Array, single))
        extras = self._additions, self._place.memory.to_device(time_left), raw
        rows = single, self._stacks, out
        self._observe(self._fields, self._learners, self._scaling, extras, modes, rows)
        return out

    def output_arrays(self, *axes: int) -> tuple[PlacedArray, PlacedArray]:
        """Return new arrays for single and stacked observations; without a stack, one for both."""
        empty, n_frames = self._place.memory.empty, self._stacks.shape[2]
        single = empty((*axes, *self._single_shape), np.float32)
        return single, empty((*axes, *self._stacked_shape), np.float32) if n_frames else single

    @property
    def arguments(self) -> tuple[Any, ...]:
        """Arguments of `decide_at_once`: observed fields, scaling, additions and stacks."""
        return self._fields, self._scaling, self._additions, self._stacks

    def snapshot(self) -> tuple[Array, Array]:
        """Return copies of the stacks and of the random streams, for `restore`."""
        return np.array(self._place.memory.read(self._stacks)), self._streams.copy()

    def restore(self, snapshot: tuple[Array, Array]) -> None:
        """Continue from a snapshot."""
        frames, self._streams[...] = snapshot
        self._place.memory.write(self._stacks, frames)

    def _add_all(
        self,
        time_left: Float64[Array, " worlds"],
        raw: Float32[Array, "worlds learners numbers"],
        modes: Modes,
        observed: Float32[Array, "worlds learners numbers"],
    ) -> None:
        """Write the user-defined observations; ConfigError for a value out of bounds."""
        at, begins = self._place.arrays, modes == START
        # a new episode derives its streams from those of the robots, which depend on the seed
        self._streams[begins] = at["robots"]["streams"][begins, :, 0] ^ hash_of("observation")
        raw[begins] = 0.0
        actions = np.zeros((*self._shape, raw.shape[2]), np.float32)
        actions[:, self._robots] = raw
        minds = cast("Array | None", self._place.estimators)
        context = ObservationContext(
            robots=read_only(at["robots"]),
            worlds=read_only(at["worlds"]),
            minds=None if minds is None else read_only(minds),
            time_left=time_left,
            last_action=actions,
            streams=self._streams,
            is_observed=modes != SKIP,
        )
        for part, first, features in self._numpy:
            out = np.zeros((*self._shape, len(features)), np.float32)
            returned = cast(Any, part).write(context, out)
            if returned is not None and returned is not out:
                raise ConfigError(
                    f"observation {type(part).__name__}: `write` returned a value, must write"
                    " features into `out`, as in out[:, :, 0] = ...; a feature that it does not"
                    " write is zero"
                )
            observed[:, :, first : first + len(features)] = values = out[:, self._robots]
            _check_numbers(values, features, context.is_observed)


def _check_numbers(
    numbers: Float32[Array, "worlds learners numbers"],
    features: Layout,
    is_observed: Bool[Array, " worlds"],
) -> None:
    """Raise ConfigError if a value of a user-defined observation is NaN or out of bounds."""
    box = features.box()
    is_right = (box.low <= numbers) & (numbers <= box.high) & np.isfinite(numbers)
    is_right |= ~is_observed[:, None, None]
    if not is_right.all():
        world, robot, k = map(int, np.argwhere(~is_right)[0])
        low, high = features[k].low, features[k].high
        raise ConfigError(
            f"observation {features[k].name}: is {numbers[world, robot, k]} for learner {robot}"
            f" of world {world}, must be a finite number from {low:g} to {high:g}; correct"
            " `write`, or the bounds of the feature"
        )


class Decisions:
    """Decisions of the learners of a block of worlds, computed where the worlds run."""

    def __init__(
        self,
        worlds: Worlds,
        form: PolicyForm,
        learners: Int64[Array, " learners"],
        episodes: Episodes,
    ) -> None:
        self._worlds, self._form, config, memory = worlds, form, form.config, worlds.memory
        self._episodes, self._zero_time_left = episodes, np.zeros(len(episodes.steps))
        at = worlds.arrays
        self._state = at["robots"], at["worlds"], worlds.errors
        terms: Terms = config.discount, config.shaping, config.reward == "team"
        rewards = at["rewards"]
        shape: tuple[int, int] = rewards.shape
        self._rows = shape[0], len(learners)
        raw = np.zeros((*self._rows, len(form.policy.action)), np.float32)
        self.raw = memory.to_device(raw)
        """Last inputs of the learners' layers, shape (worlds, learners, features)."""
        self._learners = memory.to_device(learners)
        table, *rest = form.action.conversion
        self._conversion = memory.to_device(table), *rest
        self._fields = worlds.fields(form.policy.action)
        space, phi = form.action.space, form.task.potential
        self._limits: Any = (
            (memory.to_device(space.low), memory.to_device(space.high))
            if isinstance(space, Box)
            else len(form.action.choices)
        )
        """Bounds of a continuous action, or the number of choices of a discrete one."""
        self._functions: dict[str, Kernel] = {
            **form.action.functions,
            "check_actions": kernels.check_choices
            if form.action.is_discrete
            else kernels.check_numbers,
            "potential": phi.of if phi and config.shaping > 0.0 else kernels.no_potential,
        }
        self._act = worlds.kernel(kernels.act, self._functions)
        self._settle = worlds.kernel(kernels.settle, self._functions)
        potentials = np.zeros(shape if config.shaping > 0.0 else (0, 0))
        self._reward_arrays = memory.to_device(potentials), terms, rewards
        self.observing = Observing(form, worlds, learners)
        self._run = memory.to_device(np.full(shape[0], RUN, np.int8))

    def placed(self, actions: object) -> PlacedArray:
        """Return the actions as a GPU array; ConfigError for another shape or type."""
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

    def act(self, actions: PlacedArray) -> None:
        """Write actions to the layers of the learners; a refused action is noted in its world."""
        self._act(self._state, self._action_arrays(actions), self._reward_arrays)

    def rewards(self) -> tuple[PlacedArray, PlacedArray]:
        """Return the rewards of every learner since its action: without and with shaping."""
        out = self._worlds.memory.empty((2, *self._rows), np.float64)
        self._settle(self._state, self._reward_arrays, self._learners, out)
        return out[0], out[1]

    def _action_arrays(self, actions: PlacedArray) -> tuple[Any, ...]:
        return self._fields, self._learners, actions, self._conversion, self.raw, self._limits

    def observe(self, modes: PlacedArray | None = None) -> Any:  # noqa: ANN401 a NumPy or GPU array
        """Return the observations of every learner; by default in mode RUN."""
        time_left = self._episodes.share_left if self._form.additions else self._zero_time_left
        return self.observing(self.raw, self._run if modes is None else modes, time_left)

    def snapshot(self) -> Snapshot:
        """Return copies of the last actions, of the stacks and of the random streams."""
        return np.array(self._worlds.memory.read(self.raw)), self.observing.snapshot()

    def check_fits(self, snapshot: Snapshot) -> None:
        """Raise ConfigError if a snapshot is from an environment with other options."""
        (raw, frames), (own_raw, own_frames) = snapshot, self.snapshot()
        there, here = (raw, *frames), (own_raw, *own_frames)
        if [each.shape for each in there] != [each.shape for each in here]:
            raise ConfigError("restore(): the snapshot is of an environment with other options")

    def restore(self, snapshot: Snapshot) -> None:
        """Continue from a snapshot that fits."""
        raw, frames = snapshot
        self._worlds.memory.write(self.raw, raw)
        self.observing.restore(frames)


CHECK_INTERVAL = 16
"""Number of ticks between two checks whether a world still runs; each waits for the GPU."""


class Exchanges:
    """Steps that run each world to the end of the next exchange of one of its learners.

    A world also stops at the end of its episode. A stopped world waits for all others. The length
    of an episode counts ticks.
    """

    def __init__(
        self, worlds: Worlds, episodes: Episodes, learners: Int64[Array, " learners"]
    ) -> None:
        if isinstance(worlds, Loop) and worlds.controller.has_rules:
            raise ConfigError(
                "step_on='exchange': each world runs separately, but a layer of this controller"
                " is a Python rule that acts on all worlds at once, as learned layers do; use a"
                " controller whose layers are compiled"
            )
        self._worlds, self._episodes = worlds, episodes
        memory: Memory = worlds.memory
        self._learners = memory.to_device(learners)
        self._shape = len(episodes.steps), len(learners)
        self._modes: Any = memory.to_device(np.zeros(self._shape[0], np.int8))
        self._ticks = memory.to_device(np.zeros(self._shape[0], np.int64))
        self._stop = worlds.kernel(kernels.stop_at_exchanges, {})
        self._acts = worlds.kernel(kernels.write_acts, {})

    def run(self) -> int:
        """Run one step and count the ticks of each world; return their total."""
        worlds, episodes, modes = self._worlds, self._episodes, self._modes
        at: Mapping[str, Any] = worlds.arrays
        memory: Memory = worlds.memory
        ends = memory.to_device(episodes.ends)
        memory.write(modes, np.full(self._shape[0], RUN, np.int8))
        for tick in range(1, int((episodes.ends - episodes.steps).max()) + 1):
            worlds.run(1, modes)
            self._stop(at["worlds"], at["minds"], self._learners, ends, modes, self._ticks)
            if tick % CHECK_INTERVAL == 0 and not memory.read(modes).any():
                break
        after = memory.read(self._ticks)
        n_ticks = int((after - episodes.steps).sum())
        episodes.steps[:] = after
        return n_ticks

    def acts(self) -> PlacedArray:
        """Return 1 for each learner that has just ended an exchange and acts next, else 0."""
        out = self._worlds.memory.empty(self._shape, np.float64)
        self._acts(self._worlds.arrays["minds"], self._learners, out)
        return out

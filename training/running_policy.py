"""The running policy of another trainer, which acts between `observe` and `decide`."""

from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from typing import Any

import numpy as np
from gymnasium.spaces import Box

from swarm_forage_env.arrays import Array, Bool, Float32, UInt64
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import KEEP, RULE, CompiledLayers, RunningController
from swarm_forage_env.observed_fields import write_rows
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.random_streams import NoiseSource, streams
from swarm_forage_env.task import World
from swarm_forage_env.ticks import BEGINS, RUNS, STANDS
from swarm_forage_env.worlds_on_cpu import WorldsOnCpu
from training.foreign_file import reason

Rows = Float32[Array, "robots numbers"]
Streams = UInt64[Array, " robots"]
Steer = Callable[[Rows, Streams], Rows]
"""Maps what each robot of a world observes, and its stream, to the actions of the layers."""


class RunningForeignPolicy:
    """A policy of some robots and the controller of the other layers, on a block of worlds.

    It acts where no learner does, so that its robots can be the team-mates of learners.
    """

    has_rules = True  # the policy acts in all worlds at once

    def __init__(
        self,
        world: World,
        inner: RunningController,
        form: PolicyForm,
        steer: Steer,
        robots: Sequence[int],
    ) -> None:
        """Prepare the policy; it has not acted yet."""
        self._world, self._inner, self._form, self._steer = world, inner, form, steer
        self._robots = np.array(robots)
        self.minds = inner.minds
        place = WorldsOnCpu(world, inner.minds)
        self._observing = form.observing(place, robots)
        self._write, self._fields = place.kernel(write_rows, {}), place.fields(form.policy.action)
        shape = world.n_worlds, len(robots), len(form.policy.action)
        self._held = np.zeros(shape, np.float32)
        self._streams = np.zeros(shape[:2], np.uint64)
        self._own: dict[str, Bool[Array, "worlds robots"]] | None = None

    @property
    def compiled(self) -> CompiledLayers:
        """What does the rest, for one call a tick: the policy is asked before."""
        return self._inner.compiled

    def check_on_gpu(self) -> None:
        """ConfigError: the policy runs on a CPU."""
        raise ConfigError(
            "device='cuda': policies of other trainers run on a CPU only; take device='cpu'"
        )

    def consult(self) -> None:
        """Let the policy act in worlds where a decision is due, then the rules in NumPy."""
        if self._own is None:
            self._own = self._take_over()
        ticks, period = self._world.worlds["ticks"], self._form.config.period
        due = np.flatnonzero(ticks % period == 0)
        if len(due):
            seen = self._seen(ticks // period, due)
            for world in due:
                self._held[world] = self._steer(seen[world], self._streams[world])
            self._act(self._own)
        self._inner.consult()

    def reset(self, world: int, seed: int) -> None:
        """Forget everything about one world; the policy does at its first tick."""
        own = streams([seed], self._world.n_robots, NoiseSource.POLICY)
        self._streams[world] = own[self._robots]
        self._inner.reset(world, seed)

    def numbers_in(self, world: int, scenario: BaseScenario) -> object:
        """The parameters of one world's layers in another scenario."""
        return self._inner.numbers_in(world, scenario)

    def renumber(self, world: int, numbers: object) -> None:
        """Set the parameters of one world's layers."""
        self._inner.renumber(world, numbers)

    def snapshot(self) -> dict[str, object]:
        """Copy all that the next ticks depend on."""
        return {
            "frames": self._observing.snapshot(),
            "held": self._held.copy(),
            "streams": self._streams.copy(),
            "own": deepcopy(self._own),
            "rest": self._inner.snapshot(),
        }

    def restore(self, kept: Mapping[str, Any]) -> None:
        """Restore a snapshot."""
        self._observing.restore(kept["frames"])
        self._held[...] = kept["held"]
        self._streams[...] = kept["streams"]
        self._own = deepcopy(kept["own"])
        self._inner.restore(kept["rest"])

    def _take_over(self) -> dict[str, Bool[Array, "worlds robots"]]:
        """Mark as the policy's what no learner has; returns the robots of each layer."""
        action, own = self._world.robots["action"], {}
        mine = np.zeros(action.shape, np.bool_)
        mine[:, self._robots] = True
        for layer in self._form.policy.replaces:
            own[layer] = mine & ((action[layer] == KEEP) | (action[layer] == RULE))
        self._form.hand_over(action, own)
        return own

    def _seen(self, decisions: Array, due: Array) -> Float32[Array, "worlds robots numbers"]:
        """Observations of the policy's robots; valid in the worlds where a decision is due."""
        modes = np.full(self._world.n_worlds, STANDS, np.int8)
        modes[due] = np.where(decisions[due] == 0, BEGINS, RUNS)
        seen: Float32[Array, "worlds robots numbers"] = self._observing(
            self._held, modes, lambda: 1.0 - np.minimum(decisions / self._form.max_cycles, 1.0)
        )
        return seen

    def _act(self, own: Mapping[str, Bool[Array, "worlds robots"]]) -> None:
        """Write the actions, and leave those of learners as they were."""
        action, robots = self._world.robots["action"], self._robots
        has_learners = not all(mask[:, robots].all() for mask in own.values())
        before = action.copy() if has_learners else action
        self._write(self._held, self._fields, robots)
        if has_learners:
            fields = {"weighting": "weight", "motion": self._form.task.commanded}
            for layer, mask in own.items():
                action[fields[layer]][~mask] = before[fields[layer]][~mask]


def usable_rows(
    form: PolicyForm, robots: Sequence[int], source: str
) -> Callable[[object], Float32[Array, "robots n"]]:
    """A function from a policy's actions to those of the layers, clipped to their bounds.

    It raises ConfigError for NaN and infinity, and for all else that the action space lacks.
    """
    actions, space = form.actions(robots), form.action_space

    def rows(output: object) -> Float32[Array, "robots n"]:
        try:
            array = np.asarray(output)
        except (ValueError, TypeError, RuntimeError) as error:  # ragged; a tensor with gradients
            why = reason(error)
            raise ConfigError(f"policy {source}: gives no array of actions ({why})") from None
        is_finite = array.dtype.kind == "f" and bool(np.isfinite(array).all())
        if isinstance(space, Box) and array.shape[1:] == space.shape and is_finite:
            array = np.clip(array, space.low, space.high)
        try:
            return form.action.to_raw(actions.rows(array))
        except ConfigError as error:
            raise ConfigError(f"policy {source}: {error}") from None

    return rows

"""The running policy of another trainer: asked between `observe` and `decide`, as a learner is."""

from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from typing import Any

import numpy as np
from gymnasium.spaces import Box

from swarm_forage_env.arrays import Array, Bool, Float32, UInt64
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import (
    KEEP,
    RULE,
    CompiledLayers,
    RunningController,
)
from swarm_forage_env.observed_fields import write_rows
from swarm_forage_env.random_streams import NoiseSource, streams
from swarm_forage_env.task import World
from swarm_forage_env.ticks import BEGINS, RUNS, STANDS
from swarm_forage_env.worlds_on_cpu import WorldsOnCpu
from training.foreign_file import reason

Rows = Float32[Array, "robots numbers"]
Streams = UInt64[Array, " robots"]
Steer = Callable[[Rows, Streams], Rows]
"""What the layers of some robots of a world take, from what each observes, and its stream."""


class RunningForeignPolicy:
    """A policy of some robots and what does the rest, on a block of worlds.

    It acts where no learner does, so that its robots can be the team-mates of some.
    """

    has_rules = True
    """The policy is asked about all worlds at once."""

    def __init__(
        self,
        world: World,
        inner: RunningController,
        form: PolicyForm,
        steer: Steer,
        robots: Sequence[int],
    ) -> None:
        """The policy has not been asked yet."""
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
        """ConfigError: the policy is asked by a CPU."""
        raise ConfigError(
            "device='cuda': policies of other trainers run on a CPU only; take device='cpu'"
        )

    def consult(self) -> None:
        """Ask the policy in worlds where a decision is due, then the rules written in NumPy."""
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

    def numbers_in(self, world: int, scenario: Any) -> Any:  # noqa: ANN401 of any task
        """The numbers of one world's layers in another scenario."""
        return self._inner.numbers_in(world, scenario)

    def renumber(self, world: int, numbers: Any) -> None:  # noqa: ANN401 as above
        """Go by these numbers in one world from now on."""
        self._inner.renumber(world, numbers)

    def snapshot(self) -> dict[str, object]:
        """What was observed and is being done, whose robots are the policy's, and all the rest."""
        return {
            "frames": self._observing.snapshot(),
            "held": self._held.copy(),
            "streams": self._streams.copy(),
            "own": deepcopy(self._own),
            "rest": self._inner.snapshot(),
        }

    def restore(self, kept: Mapping[str, Any]) -> None:
        """Go on as when that snapshot was taken."""
        self._observing.restore(kept["frames"])
        self._held[...] = kept["held"]
        self._streams[...] = kept["streams"]
        self._own = deepcopy(kept["own"])
        self._inner.restore(kept["rest"])

    def _take_over(self) -> dict[str, Bool[Array, "worlds robots"]]:
        """Mark as the policy's what no learner has; which robots, for each layer."""
        action, own = self._world.robots["action"], {}
        for layer in self._form.policy.replaces:
            mine = np.zeros(action.shape, np.bool_)
            mine[:, self._robots] = True
            own[layer] = mine & ((action[layer] == KEEP) | (action[layer] == RULE))
        self._form.hand_over(action, own)
        return own

    def _seen(self, decisions: Array, due: Array) -> Float32[Array, "worlds robots numbers"]:
        """What every robot of the policy observes; right in the worlds where a decision is due."""
        modes = np.full(self._world.n_worlds, STANDS, np.int8)
        modes[due] = np.where(decisions[due] == 0, BEGINS, RUNS)
        seen: Float32[Array, "worlds robots numbers"] = self._observing(
            self._held, modes, lambda: 1.0 - np.minimum(decisions / self._form.max_cycles, 1.0)
        )
        return seen

    def _act(self, own: Mapping[str, Bool[Array, "worlds robots"]]) -> None:
        """Write the actions, and leave those of learners as they were."""
        action, robots = self._world.robots["action"], self._robots
        before = None if all(mask[:, robots].all() for mask in own.values()) else action.copy()
        self._write(self._held, self._fields, robots)
        if before is None:
            return
        fields = {"weighting": "weight", "motion": self._form.task.commanded}
        for layer, mask in own.items():
            field = fields[layer]
            action[field][~mask] = before[field][~mask]


def usable_rows(
    form: PolicyForm, robots: Sequence[int], source: str
) -> Callable[[object], Float32[Array, "robots n"]]:
    """What turns the actions of some robots into what the layers take, clipped to their bounds.

    ConfigError for NaN and infinity, and for what else the action space does not hold.
    """
    actions, space = form.actions(robots), form.action_space

    def rows(given: object) -> Float32[Array, "robots n"]:
        try:
            found = np.asarray(given)
        except (ValueError, TypeError, RuntimeError) as error:  # ragged; a tensor with gradients
            raise ConfigError(
                f"policy {source}: gives no array of actions ({reason(error)})"
            ) from None
        is_finite = found.dtype.kind == "f" and bool(np.isfinite(found).all())
        if isinstance(space, Box) and found.shape[1:] == space.shape and is_finite:
            found = np.clip(found, space.low, space.high)
        try:
            return form.action.to_raw(actions.rows(found))
        except ConfigError as error:
            raise ConfigError(f"policy {source}: {error}") from None

    return rows

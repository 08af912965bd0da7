"""Running policy of another trainer, which acts between `observe` and `decide`."""

import hashlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Box

from swarm_forage_env.arrays import Array, Bool, UInt64
from swarm_forage_env.envs.actions import Actions
from swarm_forage_env.envs.decision import Observing
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import KEEP, RULE, CompiledLayers, RunningController
from swarm_forage_env.observed_fields import write_rows
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.random_streams import NoiseSource, draw_rows, streams
from swarm_forage_env.raw_control import estimators_of
from swarm_forage_env.task import World
from swarm_forage_env.ticks import RUN, SKIP, START
from swarm_forage_env.worlds_on_cpu import WorldsOnCpu
from training.policy import OBSERVATION_FILES, ForeignPolicy, Rows, as_array

Streams = UInt64[Array, " robots"]


class PolicyActor:
    """Maps the observation of each robot of a world to the actions of the layers.

    The random stream and the hidden state of each robot advance in place.
    """

    def __init__(
        self,
        policy: ForeignPolicy,
        form: PolicyForm,
        robots: Sequence[int],
        noise: NoiseSource = NoiseSource.POLICY,
    ) -> None:
        """Start the policy of some robots, and run it once; ConfigError if it does not fit."""
        self.noise = noise
        started, n = policy.start(form), len(robots)
        self._act, self.n_state = started.act, started.n_state
        self._source, self._chance = policy.source, policy.chance
        own = (each for each in policy.reads[len(OBSERVATION_FILES) :] if each.is_file())
        self.files = [hashlib.sha256(each.read_bytes()).hexdigest() for each in own]
        """Hashes of the files that its actions depend on."""
        if self._chance and not started.has_distribution:
            raise ConfigError(
                f"policy {self._source}: chance=true: the policy gives actions only, and no"
                " distribution of them; leave it out"
            )
        self._action, self._space = form.action, form.action_space
        self._actions = Actions([form.agents[robot] for robot in robots], form.action)
        observed, states = (np.zeros((n, k), np.float32) for k in (len(form.layout), self.n_state))
        self(observed, np.zeros(n, np.uint64), states)

    def __call__(self, observed: Rows, streams: Streams, states: Rows) -> Rows:
        """Return the clipped actions of one decision; ConfigError for NaN and what does not fit."""
        draws = None
        if self._chance:
            is_discrete = self._action.is_discrete
            draws = np.empty((len(observed), 1 if is_discrete else len(self._action.layout)))
            draw_rows(streams, draws, not is_discrete)
        output, states[...] = self._act(observed, draws, states.copy())
        array = as_array(output, f"policy {self._source}: gives no array of actions")
        space, is_finite = self._space, array.dtype.kind == "f" and np.isfinite(array).all()
        if isinstance(space, Box) and array.shape[1:] == space.shape and is_finite:
            array = np.clip(array, space.low, space.high)
        try:
            return self._action.to_raw(self._actions.rows(array))
        except ConfigError as error:
            raise ConfigError(f"policy {self._source}: {error}") from None


class RunningForeignPolicy:
    """Policy of some robots and the controller of the other layers, on a block of worlds.

    It acts only where no learner does, so that its robots can be team-mates of learners.
    """

    has_rules = True  # the policy acts in all worlds at once

    def __init__(
        self,
        world: World,
        inner: RunningController,
        form: PolicyForm,
        actor: PolicyActor,
        robots: Sequence[int],
    ) -> None:
        self._world, self._inner, self._form, self._actor = world, inner, form, actor
        self._robots = np.array(robots)
        self.minds = inner.minds
        place = WorldsOnCpu(world, inner.minds)
        self._observing = Observing(form, place, self._robots)
        self._write, self._fields = place.kernel(write_rows, {}), place.fields(form.policy.action)
        shape = world.n_worlds, len(robots), len(form.policy.action)
        self._held = np.zeros(shape, np.float32)
        self._streams = np.zeros(shape[:2], np.uint64)
        self._states = np.zeros((*shape[:2], actor.n_state), np.float32)
        self._claimed: dict[str, Bool[Array, "worlds robots"]] | None = None

    @property
    def compiled(self) -> CompiledLayers:
        """Compiled other layers, which run once per tick, after the policy."""
        return self._inner.compiled

    def check_on_gpu(self) -> None:
        """Raise ConfigError: the policy runs on a CPU only."""
        raise ConfigError(
            "device='cuda': policies of other trainers run on a CPU only; use device='cpu'"
        )

    def call_rules(self) -> None:
        """Call the policy in worlds where a decision is due, then the rules in NumPy."""
        if self._claimed is None:
            self._claimed = self._claim()
        ticks, period = self._world.worlds["ticks"], self._form.config.period
        is_due = ticks % period == 0
        if self._form.config.step_on == "exchange":
            exchanges = estimators_of(self.minds)["exchange"]["is_valid"][:, self._robots]
            is_due = (ticks == 0) | exchanges.any(axis=1)
        due = np.flatnonzero(is_due)
        if len(due):
            decisions, modes = ticks // period, np.full(self._world.n_worlds, SKIP, np.int8)
            modes[due] = np.where(decisions[due] == 0, START, RUN)
            time_left = 1.0 - np.minimum(decisions / self._form.max_cycles, 1.0)
            observed = self._observing(self._held, modes, time_left)  # valid where it is due
            for world in due:
                self._held[world] = self._actor(
                    observed[world], self._streams[world], self._states[world]
                )
            self._act(self._claimed)
        self._inner.call_rules()

    def reset(self, first: int, last: int, seeds: Sequence[int]) -> None:
        """Reset worlds first .. last - 1; their past observations are dropped at the first tick."""
        started = streams(seeds, self._world.n_robots, self._actor.noise)
        self._streams[first:last] = started.reshape(last - first, -1)[:, self._robots]
        self._states[first:last] = 0.0
        self._inner.reset(first, last, seeds)

    def parameters_in(self, world: int, scenario: BaseScenario) -> object:
        """Return the parameters of one world's layers in another scenario."""
        return self._inner.parameters_in(world, scenario)

    def write_parameters(self, world: int, numbers: object) -> None:
        """Set the parameters of one world's layers."""
        self._inner.write_parameters(world, numbers)

    def snapshot(self) -> dict[str, object]:
        """Copy the state that later ticks depend on."""
        return {
            "files": self._actor.files,
            "frames": self._observing.snapshot(),
            "held": self._held.copy(),
            "streams": self._streams.copy(),
            "states": self._states.copy(),
            "own": self._claimed,
            "rest": self._inner.snapshot(),
        }

    def restore(self, snapshot: Mapping[str, Any]) -> None:
        """Restore a snapshot; ValueError if it was made under another policy."""
        if snapshot["files"] != self._actor.files:
            raise ValueError("a snapshot under another policy")
        self._observing.restore(snapshot["frames"])
        self._held[...] = snapshot["held"]
        self._streams[...] = snapshot["streams"]
        self._states[...] = snapshot["states"]
        self._claimed = snapshot["own"]
        self._inner.restore(snapshot["rest"])

    def _claim(self) -> dict[str, Bool[Array, "worlds robots"]]:
        """Claim the robots' actions that no learner has; return the robots of each layer."""
        action, claimed = self._world.robots["action"], {}
        mine = np.zeros(action.shape, np.bool_)
        mine[:, self._robots] = True
        for layer in self._form.policy.replaces:
            claimed[layer] = mine & ((action[layer] == KEEP) | (action[layer] == RULE))
        self._form.mark_replaced_layers(action, claimed)
        return claimed

    def _act(self, claimed: Mapping[str, Bool[Array, "worlds robots"]]) -> None:
        """Write the actions of the policy, without changing those of learners."""
        action = self._world.robots["action"]
        before = action.copy()
        self._write(self._held, self._fields, self._robots)
        fields = {"weighting": "weight", "motion": self._form.task.commanded}
        for layer, mask in claimed.items():
            action[fields[layer]][~mask] = before[fields[layer]][~mask]

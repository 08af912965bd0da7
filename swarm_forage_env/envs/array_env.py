"""ArrayEnv, the batch API: W worlds of N robots as arrays. Every API in this folder wraps it."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple, Self, Unpack

import numpy as np
from gymnasium.spaces import Box

from swarm_forage_env.arrays import Array, Bool, Float32, Int64
from swarm_forage_env.controllers import Controllers
from swarm_forage_env.device_loop import DeviceLoop, placed
from swarm_forage_env.envs.actions import Actions, as_array
from swarm_forage_env.envs.config import EnvConfig, chosen_robots
from swarm_forage_env.envs.decision import Decisions, Exchanges, Worlds
from swarm_forage_env.envs.decision_kernels import write_log
from swarm_forage_env.envs.episodes import Episodes, Seeds, checked_options, parts_of
from swarm_forage_env.envs.extra_observations import RowObservation
from swarm_forage_env.envs.keywords import EnvOptions
from swarm_forage_env.envs.make import ON_SPACE, checked_parts, made_with, name_and_changes
from swarm_forage_env.envs.notebook import html_of
from swarm_forage_env.envs.observations import normalise_rows, normalised, typical_sizes
from swarm_forage_env.envs.policy_form import PolicyForm, check_within
from swarm_forage_env.envs.rewards import OwnReward
from swarm_forage_env.envs.whole_decision import WholeDecision
from swarm_forage_env.errors import ConfigError, checked_count
from swarm_forage_env.loop import Loop
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.scenarios import ScenarioSource
from swarm_forage_env.spaces import Layout, widest
from swarm_forage_env.task import World
from swarm_forage_env.ticks import SKIP, START
from swarm_forage_env.worlds_on_cpu import Device, Memory, PlacedArray, checked_device

Infos = dict[str, Any]
"""Values that are not observed, by name: arrays of shape (worlds, learners) or (worlds,)."""

Step = tuple[Any, Any, Any, Any, Infos]
"""Observations (worlds, learners, features), rewards (worlds, learners), terminated and truncated
(worlds,), and infos, as NumPy or GPU arrays."""


class Transition(NamedTuple):
    """A step of all worlds, followed by a reset of the worlds whose episodes have ended."""

    final: Any
    """Observations after the step, before the reset."""
    observations: Any
    """Observations for the next actions; after a reset, those of the new episode."""
    rewards: Any
    is_over: Bool[Array, " worlds"]
    """Whether the episode of each world has ended, in CPU memory."""
    acts: Any
    """1 for learners whose next action takes effect, else 0; None if all do."""
    outputs: tuple[PlacedArray, ...] | None
    """GPU arrays that a step writes, for reuse in a later call."""


class ArrayEnv:
    """W worlds in parallel, in each of which some or all robots learn: arrays in, arrays out.

        env = ArrayEnv("es1", n_worlds=64, threads=2)
        observations, infos = env.reset(seed=0)              # (64, 10, features)
        observations, rewards, terminated, truncated, infos = env.step(actions)
        observations, infos = env.reset(worlds=truncated)    # resets those

    The first axis is the world, the second the learner, in the order of `learners`. A world equals
    the same world run alone, bit for bit, with any number of threads. `terminated` is always False;
    a world is truncated after `max_cycles` steps and must then be reset, by a mask or by indices of
    worlds. The other worlds continue.

    With a decision period of k ticks an action is held for k ticks, and the rewards of these ticks
    are summed. A weight g applies to every exchange that ends in these ticks, while the
    observation shows the last tick only: for `learn="weighting"`, k = 1 matches the hand-written
    rules. With `step_on="exchange"` the step of a world ends when an exchange of one of its
    learners ends; `infos["acts"]` is 1 for the learners whose next action takes effect.

    With `device="cuda"` the worlds run on a GPU; in Numba's GPU simulator, bit for bit as on a CPU:

        env = ArrayEnv("es1", n_worlds=4096, device="cuda", physics="kinematic")
        observations, infos = env.reset(seed=0)
        actions = policy(torch.as_tensor(observations, device="cuda"))
        observations, rewards, terminated, truncated, infos = env.step(actions)

    Results are then GPU arrays with `__cuda_array_interface__`, new ones in each step; actions may
    come from any library with that interface. Neither is copied. One CUDA stream, `stream`, orders
    all work; by default it is CUDA's default stream, which PyTorch uses too. A step is one launch
    that reads nothing back: a world with a refused action stops until `check`, a reset or a
    download raises the error. User-defined rewards and observations run on a CPU only.
    """

    def __init__(
        self,
        scenario: ScenarioSource = "es1",
        n_worlds: int = 1,
        controller: Controllers | None = None,
        stagger: bool = False,
        device: Device = "cpu",
        **options: Unpack[EnvOptions],
    ) -> None:
        """Make the worlds from the keywords of `parallel_env`; `reset` starts their episodes.

        Raises ConfigError for options that do not run on the device.

        Args:
            scenario: A name, a TOML file or a `Scenario`.
            n_worlds: Number of worlds.
            controller: Controller of the layers that are not learned, as in `parallel_env`.
            stagger: The ends of the episodes that begin at a reset of all worlds are spread evenly
                over the length of an episode, so that a batch shows all its phases at once.
            device: `cpu` or `cuda`.
            **options: The fields of `EnvConfig`, and parameters of the scenario.
        """
        self.device = checked_device(device)
        self.base_controller = controller
        """Controller of the layers that are not learned, as given to the constructor."""
        self.n_worlds = checked_count("n_worlds", n_worlds)
        parts = checked_parts(scenario, controller, options)
        form, config = parts.form, parts.form.config
        # the scenario itself: a copy reads no file again, which may have changed since
        self._arguments = form.scenario, n_worlds, controller, stagger, device, options
        self.config, self.task, self._is_staggered = config, form.task, stagger
        if device == "cuda":
            _check_on_gpu(config, form)
        self.policy, self.max_cycles, self.agents = form.policy, form.max_cycles, form.agents
        self._controller_name = name_and_changes(parts.controller)
        made_of = parts.controller, range(self.n_worlds), config.physics, config.threads
        self.loop = Loop(form.scenario, *made_of, is_blank=True)
        robots = chosen_robots(config.learners, self.agents)
        self.learners = [self.agents[robot] for robot in robots]
        self.learner_numbers: Int64[Array, " learners"] = np.array(robots, np.int64)
        """Indices of the robots that learn."""
        is_all = len(robots) == len(self.agents)
        learns = slice(None) if is_all else self.learner_numbers
        masks = dict.fromkeys(self.policy.replaces, (slice(None), learns))
        copied = slice(None if device == "cpu" else 1)  # on a GPU, all worlds copy the first
        form.mark_replaced_layers(self.world.robots["action"][copied], masks)
        self._worlds: Worlds = placed(self.loop, device)
        self.episodes = Episodes(self._worlds, parts.randomisation, self._check_scenario)
        self._prepare(form)
        self._describe_state(parts.randomisation.extremes)
        self.card = made_with(form, parts.controller)
        setattr(self.observation_space, ON_SPACE, self.card)

    def __repr__(self) -> str:
        return self.described(type(self).__name__)

    def described(self, kind: str) -> str:
        """Return a one-line description of the environment, under this class name."""
        worlds = f"{self.n_worlds} worlds" if self.n_worlds > 1 else "1 world"
        return (
            f"<{kind} {self.world.scenario.name}: learn={self.config.learn!r},"
            f" controller={self._controller_name!r}, {worlds}, {len(self.learners)} of"
            f" {self.world.n_robots} robots learn, physics={self.loop.physics!r}>"
        )

    @property
    def world(self) -> World:
        """Worlds of the robots; their records hold the ground truth."""
        return self.loop.world

    @property
    def infos(self) -> tuple[str, ...]:
        """Names of the values that `log` returns for each learner."""
        return self.truth.infos

    @property
    def robot_steps(self) -> int:
        """Number of ticks of all learners of all worlds since the environment was made."""
        return self._ticks * len(self.learners)

    @property
    def is_over(self) -> Bool[Array, " worlds"]:
        """Whether the episode of each world has ended, so that it must be reset."""
        return self.episodes.is_over

    def reset(
        self, seed: Seeds = None, worlds: object = None, options: Mapping[str, object] | None = None
    ) -> tuple[Any, Infos]:
        """Reset all worlds, or those of a mask or of indices; return observations and infos of all.

        A seed fixes an episode and all later ones that are started without a seed. Give one for
        each world to be reset, or a single one: these worlds then take seed, seed + 1 and so on.
        `options` are scenario parameters for these episodes, by dotted name.
        """
        self.check()
        fresh = self.episodes.begin(seed, worlds, checked_options(options), self.max_cycles)
        modes = np.full(self.n_worlds, SKIP, np.int8)
        modes[fresh] = START
        if self._is_staggered and (modes == START).all():
            self.episodes.stagger()
        memory = self.memory
        observed = self._decisions.observe(memory.to_device(modes))
        self.episodes.is_interrupted[fresh] = False
        no_rewards = np.zeros((self.n_worlds, len(self.learners)))
        return observed, self._infos(memory.to_device(no_rewards))

    def step(self, actions: object) -> Step:
        """Run one decision; return observations, rewards, terminated, truncated and infos.

        `actions` have the shape (worlds, learners, features), or (worlds, learners) if they are
        discrete; on a GPU, their type is float32 or an integer type. A refused action leaves all
        worlds unchanged; on a GPU, its own world.
        """
        self.episodes.check_running()
        if self.device == "cuda":
            return self._decided(self._decisions.placed(actions))
        array, rows = as_array(actions), (self.n_worlds, len(self.learners))
        if array.shape[:2] != rows:
            raise ConfigError(
                f"actions of shape {array.shape}: must be {(*rows, *self.action_shape)}"
            )
        return self.advance(self.actions.rows(array.reshape(-1, *array.shape[2:])))

    def advance(self, rows: Array) -> Step:
        """Run `step` with rows that `actions` has checked, one for each learner of each world."""
        self.episodes.check_running()
        shape = self.n_worlds, len(self.learners), *self.action_shape
        return self._decided(self.memory.to_device(rows.reshape(shape)))

    def step_and_reset(
        self, actions: object, out: tuple[PlacedArray, ...] | None = None
    ) -> "Transition":
        """Run `step`, then `reset` the worlds whose episodes have ended.

        On a GPU both are one launch if episodes differ in their seeds only. The results then are
        views of `out` if it is given: the `outputs` of an earlier call, which is overwritten.
        """
        if not self.is_one_launch:
            final, rewards, _, _, infos = self.step(actions)
            over, observed = self.is_over, final
            if over.any():
                observed, infos = self.reset(worlds=over)
            return Transition(final, observed, rewards, over, infos.get("acts"), out)
        placed, outputs = self._decisions.placed(actions), out or self.output_arrays()
        over = self.count_step()
        self.launch(placed, outputs)
        rewards, _, observed, _ = outputs
        return Transition(observed[0], observed[1], rewards[1], over, None, outputs)

    @property
    def is_one_launch(self) -> bool:
        """Whether `step_and_reset` is one GPU launch: `count_step`, then `launch` on fixed arrays,
        which a CUDA graph can repeat."""
        return self._whole_decision is not None and self.episodes.are_alike

    def output_arrays(self) -> tuple[PlacedArray, ...]:
        """Return new arrays for the results of a launch, as `whole_decision.Outputs`."""
        assert self._whole_decision is not None
        return self._whole_decision.output_arrays()

    def count_step(self) -> Bool[Array, " worlds"]:
        """Count a step on the CPU, as `launch` does on the GPU; return where episodes end."""
        assert self._whole_decision is not None
        self.episodes.check_running()
        self._whole_decision.upload_counts()
        self._count()
        return self.episodes.follow_on(self.max_cycles)

    def launch(self, actions: PlacedArray, outputs: tuple[PlacedArray, ...]) -> None:
        """Launch `step_and_reset` on the GPU, with actions in GPU memory."""
        assert self._whole_decision is not None
        self._whole_decision(actions, self.config.period, self.max_cycles, outputs)

    def check_keeps_step(self, instead: str) -> None:
        """Raise ConfigError, with this advice, if episodes can end at different times."""
        why = "stagger=True" if self._is_staggered else f"step_on='{self.config.step_on}'"
        if self.n_worlds > 1 and why != "step_on='tick'":
            raise ConfigError(
                f"{why}: worlds end at different times, but are reset together here; {instead}"
            )

    def check(self) -> None:
        """Wait for the GPU, and raise errors since the last check, such as a refused action."""
        self._worlds.check()

    def _count(self) -> None:
        self.episodes.steps += 1
        self._ticks += self.config.period * self.n_worlds

    def _decided(self, actions: PlacedArray) -> Step:
        if self._whole_decision is not None:
            rewards, _, observed, over = outputs = self.output_arrays()
            self._whole_decision.upload_counts()
            self._count()
            self._whole_decision(actions, self.config.period, 0, outputs)
            never = self.memory.lend(self._terminated)
            return observed[0], rewards[1], never, over, self._infos(rewards[0])
        self._decisions.act(actions)
        self.check()
        self.episodes.is_interrupted[:] = True
        self._run()
        unshaped, rewards = self._decisions.rewards()
        observed = self._decisions.observe()
        self.episodes.is_interrupted[:] = False
        truncated, never = self.memory.to_device(self.is_over), self.memory.lend(self._terminated)
        return observed, rewards, never, truncated, self._infos(unshaped)

    def _run(self) -> None:
        """Run the ticks of a decision; `world.rewards` sums those of each robot."""
        if self._exchanges is not None:
            self._ticks += self._exchanges.run()
            return
        if self._own_reward is not None:
            self._own_reward.run(self.config.period)
        else:
            self._worlds.run(self.config.period)
        self._count()

    @cached_property
    def actions(self) -> Actions:
        """Checker of the actions of all learners on a CPU."""
        names = self.learners
        if self.n_worlds > 1:
            names = [f"{name} of world {w}" for w in range(self.n_worlds) for name in names]
        return Actions(names, self._form.action)

    def state(self) -> Float32[Array, "worlds numbers"]:
        """Return the global state of every world, as in `state_layout`, on the CPU: for critics."""
        self.download()
        state = self.truth.state(self.episodes.share_gone)
        if self.config.normalise:
            normalise_rows(state, *self._state_sizes)
        return state

    def log(self) -> Any:  # noqa: ANN401 a NumPy or GPU array
        """Return the logged values, shape (worlds, learners, infos), in the order of `infos`."""
        out = self.memory.empty((self.n_worlds, len(self.learners), len(self.infos)), np.float64)
        at = self._worlds.arrays
        self._write_log(at["robots"], at["minds"], at["worlds"], self._learners, out)
        return out

    def download(self) -> Self:
        """Copy the records of a GPU to `loop` and `world`; on a CPU, do nothing.

        Changes to these copies do not affect later steps on the GPU.
        """
        self.check()
        self._worlds.download()
        return self

    @property
    def memory(self) -> Memory:
        """Memory of the arrays that `reset` and `step` return, with methods to copy them."""
        return self._worlds.memory

    @property
    def stream(self) -> int:
        """Address of the CUDA stream that orders the work of a GPU; 0: the default stream.

        To work in another stream, set it before a reset or a step, as the wrappers for PyTorch do:
        `env.stream = torch.cuda.current_stream().cuda_stream`. It waits for the previous stream.
        """
        return int(self.memory.stream)

    @stream.setter
    def stream(self, address: int) -> None:
        self.memory.change_stream(address)

    def snapshot(self) -> object:
        """Return the full state, which can be pickled and restored any number of times."""
        self.download()
        state = self.episodes.snapshot(), self._decisions.snapshot(), self._fixed_options
        return self.loop.snapshot(), state

    def restore(self, snapshot: object) -> None:
        """Continue from a snapshot, bit for bit; ConfigError if it does not fit."""
        loop, rest = parts_of(snapshot, 2)
        episodes, decisions, options = parts_of(rest, 3)
        self._decisions.check_fits(parts_of(decisions, 2))
        for name, value in self._fixed_options.items():
            if options[name] != value:
                raise ConfigError(
                    f"restore(): the snapshot is of an environment with other options: {name} is"
                    f" {options[name]!r} there and {value!r} here; make an environment with the"
                    " same options"
                )
        self.loop.restore(loop)
        self._decisions.restore(decisions)
        self.episodes.restore(episodes)
        if isinstance(self._worlds, DeviceLoop):
            self._worlds.upload(range(self.n_worlds))

    @property
    def _fixed_options(self) -> dict[str, object]:
        """Options that say what a snapshot counts, draws, keeps frames of and lets learners do."""
        config = self.config
        kept = "learn", "action", "reflexes", "residual", "walk", "step_on"
        return {
            **{name: getattr(config, name) for name in kept},
            "learners": self.learners,
            "decision_period": config.period,
            "max_cycles": self.max_cycles,
            "randomise": [*self.episodes.drawn],
            "normalise": config.stack > 1 and config.normalise,
        }

    def _repr_html_(self) -> str:
        return html_of(self, type(self).__name__)

    def __getstate__(self) -> dict[str, object]:
        own = {"made_by": self._arguments, "snapshot": self.snapshot()}
        return {**own, "is_unseeded": self.episodes.is_unseeded}

    def __setstate__(self, state: dict[str, Any]) -> None:
        *made_by, options = state["made_by"]
        ArrayEnv.__init__(self, *made_by, **options)
        self.restore(state["snapshot"])
        self.episodes.seed_anew(state["is_unseeded"])

    def _prepare(self, form: PolicyForm) -> None:
        """Make the spaces and the parts of a decision."""
        config, worlds, learners = self.config, self._worlds, self.learner_numbers
        self._whole_decision = None
        if isinstance(worlds, DeviceLoop) and config.step_on != "exchange":
            self._whole_decision = WholeDecision(worlds, form, learners, self.episodes)
        self._decisions = self._whole_decision or Decisions(worlds, form, learners, self.episodes)
        self._exchanges: Exchanges | None = None
        self._own_reward: OwnReward | None = None
        self._ticks = 0
        if config.step_on == "exchange":
            self._exchanges = Exchanges(worlds, self.episodes, learners)
        elif not isinstance(config.reward, str):
            self._own_reward = OwnReward(self.loop, config.reward)
        self._learners = self.memory.to_device(learners)
        self._terminated = self.memory.to_device(np.zeros(self.n_worlds, np.bool_))
        self.observation_layout, self.observation_space = form.layout, form.observation_space
        self.action_layout, self.action_space = form.action.layout, form.action_space
        self.action_shape, self._form = form.action.shape, form

    def _describe_state(self, scenarios: Sequence[BaseScenario]) -> None:
        """Make the global state, with the size of the largest among these scenarios."""
        truths = [
            self.task.global_state(self.world, self.loop.controller, self.agents, each)
            for each in scenarios
        ]
        self.truth = max(truths, key=lambda each: len(each.layout))
        self.state_layout = self._state_bounds = Layout(widest([each.layout for each in truths]))
        if self.config.normalise:
            self._state_sizes = typical_sizes(self.state_layout)
            self.state_layout = normalised(self.state_layout)
        self.state_space: Box = self.state_layout.box()
        log = self.truth.logs[self._worlds.estimators is not None]
        self._write_log = self._worlds.kernel(write_log, {"log": log})

    def _check_scenario(self, scenario: BaseScenario) -> None:
        """Raise ConfigError if the controller or the spaces do not fit this scenario."""
        self.loop.controller.parameters_in(0, scenario)
        self._form.check_bounds(scenario)
        truth = self.task.global_state(self.world, self.loop.controller, self.agents, scenario)
        check_within(self._state_bounds, truth.layout, "state")

    def _infos(self, unshaped: PlacedArray) -> Infos:
        """Return unshaped rewards, `acts` if steps end at exchanges, and drawn parameters."""
        acting = {} if self._exchanges is None else {"acts": self._exchanges.acts()}
        drawn = self.episodes.drawn.items()
        lent = {name: self.memory.lend(self.memory.to_device(each)) for name, each in drawn}
        return {"unshaped_reward": unshaped, **acting, **lent}


array_env = ArrayEnv
"""Alias of `ArrayEnv`, named like `parallel_env`."""


def _check_on_gpu(config: EnvConfig, form: PolicyForm) -> None:
    refused = "runs on a CPU only; leave it out, or use device='cpu'"
    if not isinstance(config.reward, str):
        raise ConfigError(f"reward={config.reward!r}: {refused}")
    for part, *_ in form.additions:
        if not isinstance(part, RowObservation):
            raise ConfigError(
                f"observation: {type(part).__name__} is written in NumPy, which {refused}"
            )

"""Environment for TorchRL: `SwarmTorchEnv`, a block of worlds as one `EnvBase`."""

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Unpack
from unittest.mock import patch

import numpy as np
import torch
from gymnasium.spaces import Box, Discrete, Space
from tensordict import TensorDict, TensorDictBase
from tensordict.nn import TensorDictModuleBase
from torch import Tensor
from torchrl.data import Bounded, Categorical, Composite, OneHot, TensorSpec, Unbounded
from torchrl.envs import EnvBase
from torchrl.envs.utils import ExplorationType, set_exploration_type
from torchrl.modules.distributions import continuous
from torchrl.modules.distributions import utils as distribution_utils

from swarm_forage_env.arrays import Array
from swarm_forage_env.controllers import Controllers
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.envs.episodes import Seeds, checked_seeds
from swarm_forage_env.envs.keywords import EnvOptions
from swarm_forage_env.envs.notebook import title_of
from swarm_forage_env.envs.render import Frame
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.rendering.viewer import Viewer, check_render_mode
from swarm_forage_env.scenarios import ScenarioSource
from swarm_forage_env.task import stage_of
from training.policy_card import card_from
from training.tensor_vec_env import array_for, follow_stream, tensor_of, torch_device, worlds_on
from training.torchscript import save_torchscript

TRACEABLE = {
    "safetanh_noeps": distribution_utils._SafeTanhNoEps.forward,
    "safeatanh_noeps": distribution_utils._SafeaTanhNoEps.forward,
}
"""The tanh of TorchRL's distributions without its own gradient, which torch.jit can trace."""


def save_policy(policy: TensorDictModuleBase, env: "SwarmTorchEnv", file: str | Path) -> Path:
    """Save a policy without its noise as TorchScript, with a card beside it.

        save_policy(actor, env, "policy.pt")    # swarm-forage evaluate es1 torchscript:policy.pt

    `env` is that of the training. ConfigError unless the policy is the same for every robot and
    uses its observation alone, without a memory and without parameters of each robot.
    """
    group, fixed = env.group, copy.deepcopy(policy).to("cpu").requires_grad_(False)

    def act(observed: Tensor) -> Tensor:
        seen = TensorDict({"observation": observed[None]}, [1, len(observed)])
        with set_exploration_type(ExplorationType.DETERMINISTIC):
            action: Tensor = fixed(TensorDict({group: seen}, [1]))[group, "action"][0]
        return action

    card = card_from(env.array_env.card, "of the environment")
    with patch.multiple(continuous, **TRACEABLE):
        return save_torchscript(act, len(env.array_env.learners), card, file)


ENDS = ("done", "terminated", "truncated")
"""Keys of the end of an episode."""


class SwarmTorchEnv(EnvBase):  # type: ignore[misc]
    """W worlds of N robots as one TorchRL environment of batch size (W,).

        env = SwarmTorchEnv("es1", n_worlds=16, shaping=1.0, threads=2)
        env.rollout(100)["epuck", "observation"]              # (16, 100, 10, features)

    The keywords are those of `parallel_env`, and the keys those of `PettingZooWrapper`: all
    learners are one group, named after the robots ("epuck", "create"), with "observation",
    "action", "reward", and the infos of `parallel_env` under "info". "state" is the true state of
    a world, for centralised critics; `return_state=False` saves its time.

    Each world has "done", "terminated" and "truncated"; so has each robot, for the losses of
    TorchRL. Collectors reset the worlds whose episodes are over, each to the next seed of its
    sequence; with `stagger` episodes end at different times. Shorten episodes by `max_cycles`: in
    TorchRL 0.11, `StepCounter(max_steps=...)` and a collector's `max_frames_per_traj` fail on the
    ends of robots in batches or, with as many worlds as robots, assign them to the wrong ones.
    Choices (`discrete`) are integers, or one-hot with `categorical_actions=False`.

    With `device="cuda"` the worlds run on a GPU, and only the mask of the worlds to reset leaves
    its memory. This needs `physics="kinematic"` and, as a CPU writes the "state",
    `return_state=False`.
    """

    def __init__(  # noqa: PLR0913 keywords of the public API
        self,
        scenario: ScenarioSource = "es1",
        n_worlds: int = 1,
        controller: Controllers | None = None,
        seed: int | None = None,
        stagger: bool = False,
        return_state: bool = True,
        categorical_actions: bool = True,
        device: torch.device | str = "cpu",
        **options: Unpack[EnvOptions],
    ) -> None:
        """Make the worlds; `seed` is that of `set_seed`.

        Args:
            scenario: A name, a TOML file or a `Scenario`.
            n_worlds: Number of worlds in the batch.
            controller: Controller of the layers that are not learned.
            seed: Seed of the first episodes.
            stagger: The first episodes end at different times.
            return_state: Include the true state, for centralised critics.
            categorical_actions: Discrete actions are integers; false: one-hot.
            device: `cpu` or `cuda`.
            **options: The fields of `EnvConfig`, and parameters of the scenario.
        """
        where = worlds_on(device)
        if where == "cuda" and return_state:
            raise ConfigError(
                "return_state=True: the state is written on a CPU only; use return_state=False,"
                " or device='cpu'"
            )
        self.array_env = env = ArrayEnv(scenario, n_worlds, controller, stagger, where, **options)
        on = torch_device(where) if where == "cuda" else device
        super().__init__(device=on, batch_size=[n_worlds])
        self.return_state, self.categorical_actions = return_state, categorical_actions
        self.group = env.learners[0].rpartition("_")[0]
        self.group_map = {self.group: list(env.learners)}
        self.max_cycles = env.max_cycles
        self._view: Viewer | None = None
        self._seeds: list[int | None] = [None] * n_worlds
        self._per_robot = torch.Size((n_worlds, len(env.learners)))
        self._make_specs()
        if seed is not None:
            self.set_seed(seed)

    def __repr__(self) -> str:
        return self.array_env.described(type(self).__name__)

    @property
    def has_render(self) -> bool:
        """Whether the worlds can be drawn."""
        return self.array_env.task.scene is not None

    def episodes(self, seen: TensorDictBase) -> dict[str, Tensor]:
        """Return the logged metrics of the episodes that ended in a rollout, by name.

        Counts, such as `round_trips`, are summed over a world's robots; others are averaged.
        """
        info = seen["next", self.group, "info"][seen["next", "done"].squeeze(-1)]
        counts = self.array_env.truth.counts
        return {
            name: info[name].sum(-1) if name in counts else info[name].mean(-1)
            for name in self.array_env.infos
        }

    def render(self, mode: str = "rgb_array", width: int | None = None) -> Frame | str | None:
        """Draw the first world; return its frame, (height, width, RGB), or None if in a window."""
        if self._view is None:
            check_render_mode(mode)
            stage = stage_of(self.array_env.world.scenario, title_of(self.array_env))
            self._view = Viewer(stage, mode, width)
        return self._view.draw(self.array_env.download().loop.scene())

    def close(self, *, raise_if_closed: bool = True) -> None:
        """Close the window, if there is one."""
        if self._view is not None:
            self._view.close()
        super().close(raise_if_closed=raise_if_closed)

    def _set_seed(self, seed: int | None) -> None:
        """Give the next episode of world w the seed + w; the seeds of later episodes are drawn."""
        self._seeds = list(checked_seeds(seed, self.array_env.n_worlds))

    def _reset(
        self,
        tensordict: TensorDictBase | None = None,
        seed: Seeds = None,
        options: Mapping[str, object] | None = None,
    ) -> TensorDict:
        """Reset the worlds in "_reset", or all without it; the rest is as in `ArrayEnv.reset`."""
        follow_stream(self.array_env)
        chosen = np.arange(self.array_env.n_worlds)
        if tensordict is not None and "_reset" in tensordict.keys():  # noqa: SIM118 no iterator
            chosen = np.flatnonzero(tensordict.get("_reset").numpy(force=True))
        seeds = [self._seeds[world] for world in chosen] if seed is None else seed
        observations, infos = self.array_env.reset(seeds, chosen, options)
        for world in chosen:
            self._seeds[world] = None
        return self._tensors(observations, infos)

    def _step(self, tensordict: TensorDictBase) -> TensorDict:
        follow_stream(self.array_env)
        action = tensordict.get((self.group, "action"))
        if self.array_env.config.discrete and not self.categorical_actions:
            action = action.to(torch.uint8).argmax(-1)
        array = array_for(self.array_env, action)
        observations, rewards, _, _, infos = self.array_env.step(array)
        return self._tensors(observations, infos, rewards)

    def _tensors(
        self, observations: Array, infos: Mapping[str, Array], rewards: Array | None = None
    ) -> TensorDict:
        """Return the tensors of a reset or, with rewards, of a step."""
        env, per_robot, device = self.array_env, self._per_robot, self.device
        done = torch.from_numpy(env.is_over)[:, None]
        never = torch.zeros_like(done)
        info = dict(zip(self.array_env.infos, _float(env.log()).unbind(-1), strict=True))
        for name, numbers in infos.items():
            tensor = _float(numbers)
            info[name] = tensor if tensor.ndim > 1 else tensor[:, None].expand(per_robot)
        group = {
            "observation": tensor_of(observations),
            "info": TensorDict(info, per_robot, device=device),
            **_ends(done[:, None].expand(*per_robot, 1), never[:, None].expand(*per_robot, 1)),
        }
        if rewards is not None:
            group["reward"] = _float(rewards)[..., None]
        tensors = {self.group: TensorDict(group, per_robot, device=device), **_ends(done, never)}
        if self.return_state:
            tensors["state"] = torch.from_numpy(env.state())
        return TensorDict(tensors, self.batch_size, device=device)

    def _make_specs(self) -> None:
        env, worlds, per_robot = self.array_env, self.batch_size, self._per_robot
        one, acts = Unbounded(shape=per_robot), ("acts",) * (env.config.step_on == "exchange")
        of_step = "unshaped_reward", *acts, *env.episodes.drawn
        info = {name: one.clone() for name in (*env.infos, *of_step)}
        seen = _spec(env.observation_space, per_robot)
        observed = {"observation": seen, "info": Composite(info, shape=per_robot)}
        observations: dict[str, TensorSpec] = {self.group: Composite(observed, shape=per_robot)}
        if self.return_state:
            observations["state"] = _spec(env.state_space, worlds)
        flag = Categorical(2, shape=(1,), dtype=torch.bool)
        actions = _spec(env.action_space, per_robot, self.categorical_actions)
        self.observation_spec = Composite(observations, shape=worlds).to(self.device)
        self.action_spec = self._of_group({"action": actions})
        self.reward_spec = self._of_group({"reward": Unbounded(shape=(*per_robot, 1))})
        ends = {name: flag.expand(*per_robot, 1) for name in ENDS}
        of_worlds = {name: flag.expand(*worlds, 1) for name in ENDS}
        self.done_spec = self._of_group(ends).update(of_worlds)

    def _of_group(self, specs: dict[str, TensorSpec]) -> Composite:
        group = Composite(specs, shape=self._per_robot)
        return Composite({self.group: group}, shape=self.batch_size).to(self.device)


def _ends(done: Tensor, never: Tensor) -> dict[str, Tensor]:
    """Return the flags of episode ends, which are due to the time limit only."""
    return dict(zip(ENDS, (done, never, done.clone()), strict=True))


def _spec(space: Space[Any], batch: tuple[int, ...], is_categorical: bool = True) -> TensorSpec:
    """Return the spec of a batch of values, with bounds if they have any, or of choices."""
    if isinstance(space, Discrete):
        spec = Categorical(int(space.n)) if is_categorical else OneHot(int(space.n))
    else:
        assert isinstance(space, Box)
        is_bounded = np.isfinite(space.low).all() and np.isfinite(space.high).all()
        bounds = torch.from_numpy(space.low), torch.from_numpy(space.high)
        spec = Bounded(*bounds, shape=space.shape) if is_bounded else Unbounded(shape=space.shape)
    return spec.expand(*batch, *spec.shape)


def _float(array: Array) -> Tensor:
    """Return an array as a tensor in single precision."""
    return tensor_of(array).float()

"""Environment for RLlib, with all worlds of an env runner in one block.

    config = (
        PPOConfig()
        .environment(SwarmMultiAgentEnv, env_config={"scenario": "es1", "shaping": 1.0})
        .env_runners(env_runner_cls=SwarmEnvRunner, num_envs_per_env_runner=8)
        .multi_agent(policies={"robot"}, policy_mapping_fn=lambda agent, *_, **__: "robot")
    )

RLlib makes `num_envs_per_env_runner` environments and steps one after the other. `SwarmEnvRunner`
replaces them by a block of worlds. Without it the same environment works world by world.

`.callbacks(SavesPolicies)` saves each module and its card in the folder of the experiment or of a
trial of Tune (`algorithm.logdir`): `swarm-forage evaluate es1 torchscript:robot.pt` runs it.
`save_policies(algorithm, folder)` saves the modules to another folder.
"""

import copy
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import torch
from gymnasium.spaces import Dict as DictSpace
from gymnasium.spaces import Discrete, Space
from ray.rllib.algorithms.algorithm import Algorithm
from ray.rllib.algorithms.algorithm_config import AlgorithmConfig
from ray.rllib.callbacks.callbacks import RLlibCallback
from ray.rllib.core.columns import Columns
from ray.rllib.core.rl_module.rl_module import RLModule
from ray.rllib.env.multi_agent_env import MultiAgentEnv
from ray.rllib.env.multi_agent_env_runner import MultiAgentEnvRunner
from ray.rllib.env.vector.vector_multi_agent_env import VectorMultiAgentEnv
from torch import Tensor

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.envs.episodes import Seeds
from swarm_forage_env.envs.keywords import SingleEnvOptions
from swarm_forage_env.envs.make import ON_SPACE, refuse_keywords_of_blocks
from swarm_forage_env.errors import ConfigError
from training.policy_card import PolicyCard, card_from
from training.torchscript import save_torchscript

OfAgents = dict[str, Any]
"""A value for each agent of a world; under `__all__`, for all."""

Step = tuple[list[OfAgents], list[OfAgents], list[OfAgents], list[OfAgents], list[OfAgents]]
"""Observations, rewards, terminations, truncations and infos of a step, world by world."""

ALL = "__all__"

ROWS = 10
"""Rows of observations with which a saved module is called at once."""


class SwarmMultiAgentEnv(MultiAgentEnv):  # type: ignore[misc]
    """One world; `env_config` has the keywords of `parallel_env`, without `render_mode`."""

    def __init__(self, env_config: SingleEnvOptions | None = None) -> None:
        super().__init__()
        self.options = dict(env_config or {})
        self._block = SwarmVectorEnv(self.options, 1)
        self.possible_agents = self._block.env.learners
        self.agents = list(self.possible_agents)
        self.observation_spaces = self._block.single_observation_spaces
        self.action_spaces = self._block.single_action_spaces

    def __repr__(self) -> str:
        return self._block.env.described(type(self).__name__)

    def reset(
        self, *, seed: int | None = None, options: dict[str, object] | None = None
    ) -> tuple[OfAgents, OfAgents]:
        """Start an episode; a seed determines it and all later ones without a seed.

        `options` are parameters of the scenario for this episode, by dotted name.
        """
        (observations,), (infos,) = self._block.reset(seed=seed, options=options)
        return observations, infos

    def step(
        self, action_dict: OfAgents
    ) -> tuple[OfAgents, OfAgents, OfAgents, OfAgents, OfAgents]:
        """Run one decision period."""
        (seen,), (rewards,), (ended,), (cut,), (infos,) = self._block.advance([action_dict])
        return seen, rewards, ended, cut, infos


class SwarmVectorEnv(VectorMultiAgentEnv):  # type: ignore[misc]
    """Worlds in one block, whose episodes end together; the next step resets them."""

    stride = 1
    """World w has seed + w stride, as RLlib gives its env runners consecutive seeds."""

    def __init__(self, options: Mapping[str, Any], num_envs: int, envs: Sequence[Any] = ()) -> None:
        """Make `num_envs` worlds; `envs` give RLlib the spaces of each."""
        super().__init__()
        refuse_keywords_of_blocks(options)
        self.env = env = ArrayEnv(**options, n_worlds=num_envs)
        env.check_keeps_step("leave SwarmEnvRunner out, or use num_envs_per_env_runner=1")
        self.num_envs, self.envs = num_envs, list(envs)
        self.single_observation_spaces = dict.fromkeys(env.learners, env.observation_space)
        self.single_action_spaces = dict.fromkeys(env.learners, env.action_space)
        self.single_observation_space: Space[Any] = DictSpace({**self.single_observation_spaces})
        self.single_action_space: Space[Any] = DictSpace({**self.single_action_spaces})
        self._over = False

    def __repr__(self) -> str:
        return self.env.described(type(self).__name__)

    def reset(
        self, *, seed: Seeds = None, options: dict[str, object] | None = None
    ) -> tuple[list[OfAgents], list[OfAgents]]:
        """Reset every world; seeds and options are those of `ArrayEnv`."""
        if isinstance(seed, int) and self.stride > 1:
            seed = range(seed, seed + self.num_envs * self.stride, self.stride)
        observations, _ = self.env.reset(seed=seed, options=options)
        self._over = False
        return self._by_agent(observations), self._silence()

    def step(self, actions: Sequence[OfAgents]) -> Step:
        """Run one decision period; after the end of the episodes, reset and ignore the actions."""
        if not self._over:
            return self.advance(actions)
        observations, infos = self.reset()
        rewards = [dict.fromkeys(self.env.learners, 0.0) for _ in range(self.num_envs)]
        return observations, rewards, self._all(False), self._all(False), infos

    def advance(self, actions: Sequence[OfAgents]) -> Step:
        """Run one decision period; the last infos hold the metrics that `parallel_env` logs."""
        agents = self.env.learners
        observations, rewards, _, truncated, _ = self.env.advance(self._rows(actions))
        self._over = bool(truncated.all())
        return (
            self._by_agent(observations),
            [dict(zip(agents, row, strict=True)) for row in rewards.tolist()],
            self._all(False),
            self._all(self._over),
            self._log() if self._over else self._silence(),
        )

    def _rows(self, actions: Sequence[OfAgents]) -> Array:
        """Return a row for each agent of each world; errors are those of `parallel_env`."""
        if self.num_envs == 1:
            return self.env.actions.matrix(actions[0])
        of_all = [(agent, w) for w, each in enumerate(actions) for agent in each]
        by_agent = {f"{agent} of world {w}": actions[w][agent] for agent, w in of_all}
        return self.env.actions.matrix(by_agent)

    def _by_agent(self, observations: Float32[Array, "worlds learners numbers"]) -> list[OfAgents]:
        return [dict(zip(self.env.learners, world, strict=True)) for world in observations]

    def _all(self, value: bool) -> list[OfAgents]:
        """Return one flag for all agents: RLlib takes a truncation of each for a termination."""
        return [{ALL: value} for _ in range(self.num_envs)]

    def _silence(self) -> list[OfAgents]:
        return [{agent: {} for agent in self.env.learners} for _ in range(self.num_envs)]

    def _log(self) -> list[OfAgents]:
        names, drawn_in = self.env.infos, self.env.episodes.drawn_in
        return [
            {
                agent: {**dict(zip(names, row, strict=True)), **drawn_in(world)}
                for agent, row in zip(self.env.learners, rows, strict=True)
            }
            for world, rows in enumerate(self.env.log().tolist())
        ]


class SwarmEnvRunner(MultiAgentEnvRunner):  # type: ignore[misc]
    """Env runner that steps all its worlds at once."""

    def make_env(self) -> None:
        """Make the environments as RLlib does, and replace them by one block."""
        super().make_env()
        worlds: list[Any] = self.env.envs
        self.env: Any = SwarmVectorEnv(worlds[0].unwrapped.options, self.num_envs, worlds)
        self.env.stride = max(1, self.config.num_env_runners)


class SavesPolicies(RLlibCallback):  # type: ignore[misc]
    """Callback that saves the modules and their cards in the experiment's folder."""

    def on_train_result(self, *, algorithm: Algorithm, **_: object) -> None:
        """Save the modules after an iteration."""
        save_policies(algorithm, algorithm.logdir)


def save_policies(algorithm: Algorithm, folder: str | Path) -> list[Path]:
    """Save each module without its noise as TorchScript, such as `robot.pt`, with a card beside it.

    The environment is one of this project, also behind RLlib's `ParallelPettingZooEnv`. ConfigError
    for a module with a memory, and for observations that a connector or a wrapper changes first.
    """
    config = algorithm.config
    if config._env_to_module_connector is not None:
        raise ConfigError(
            "env_to_module_connector: changes what a module observes, which its file cannot"
            " record; leave it out: observations lie in [-1, 1] as they are"
        )
    modules = {name: algorithm.get_module(name) for name in sorted(config.policies)}
    cards = {name: _card_of(name, module) for name, module in modules.items()}
    return [
        save_torchscript(_acting(module, config), ROWS, cards[name], Path(folder) / f"{name}.pt")
        for name, module in modules.items()
    ]


def _card_of(name: str, module: RLModule) -> PolicyCard:
    """Return the card on the observation space of a module. ConfigError without one."""
    text = getattr(module.observation_space, ON_SPACE, None)
    if text is None:
        raise ConfigError(
            f"module '{name}': its observation space has no card, so it is not that of a robot;"
            " train without wrappers and Joint forms, which make a space of their own"
        )
    return card_from(text, f"of the module '{name}'")


def _acting(module: RLModule, config: AlgorithmConfig) -> Callable[[Tensor], Tensor]:
    """Return a module's map from observations of robots to actions, without noise."""
    fixed = copy.deepcopy(module).to("cpu").requires_grad_(False)
    distribution, space = fixed.get_inference_action_dist_cls(), fixed.action_space

    def act(observed: Tensor) -> Tensor:
        outputs = fixed.forward_inference({Columns.OBS: observed})
        if Columns.ACTIONS in outputs:  # of DQN
            chosen: Tensor = outputs[Columns.ACTIONS]
            return chosen
        drawn_from = distribution.from_logits(outputs[Columns.ACTION_DIST_INPUTS])
        action: Tensor = drawn_from.to_deterministic().sample()
        if isinstance(space, Discrete) or not config.normalize_actions:
            return action
        low, high = map(torch.from_numpy, (space.low, space.high))
        scaled: Tensor = low + 0.5 * (action + 1.0) * (high - low)
        return scaled

    return act

"""Training with the PPO of `examples/cleanrl_ppo.py`, with an annealed learning rate as in CleanRL.

Unlike in CleanRL, observations and rewards are not normalised, as observations are in [-1, 1]
already, and the value at the time limit of an episode is bootstrapped.
"""

import copy
from dataclasses import replace

import torch

from swarm_forage_env.arrays import Array, Bool
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.errors import ConfigError
from training.ladder.play import Act, Watch
from training.ladder.rungs import Algorithm, Rung

try:
    from examples.cleanrl_ppo import Agent, Options, collect, rows_of, update
except ModuleNotFoundError as error:
    if (error.name or "").partition(".")[0] != "examples":
        raise
    raise ConfigError(
        "trainer 'cleanrl': needs examples/cleanrl_ppo.py, which is not in the wheel; run it in"
        " a checkout"
    ) from None

MINIBATCHES = 32  # minibatches of a rollout


def train(rung: Rung, algorithm: Algorithm, seed: int, watch: Watch) -> None:
    """Train from scratch, for the number of robot-steps of the watch."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    keywords = {**rung.keywords, **algorithm.keywords}
    worlds, settings = algorithm.worlds, algorithm.settings
    options = Options(seed=seed, worlds=worlds, discount=keywords["discount"], **settings)
    env = ArrayEnv(n_worlds=worlds, stagger=True, **keywords)
    agent = Agent(len(env.observation_layout), len(env.action_layout))
    optimiser = torch.optim.Adam(agent.parameters(), lr=options.learning_rate, eps=1e-5)
    now = rows_of(env.reset(seed=seed)[0])
    options = replace(options, batch=len(now) * options.steps // MINIBATCHES)
    while env.robot_steps < watch.robot_steps:
        left = 1.0 - env.robot_steps / watch.robot_steps
        optimiser.param_groups[0]["lr"] = left * options.learning_rate
        seen, now, _ = collect(agent, env, now, options)
        update(agent, optimiser, seen, options)
        if watch.due(env.robot_steps):
            watch.evaluate(env.robot_steps, _acting(agent), lambda: _acting(copy.deepcopy(agent)))


def _acting(agent: Agent) -> Act:
    @torch.no_grad()
    def act(observations: Array, begins: Bool[Array, " worlds"], stochastic: bool) -> Array:
        choice = agent.act(rows_of(observations))
        actions = (choice.sample() if stochastic else choice.mean).clamp(-1.0, 1.0)
        chosen: Array = actions.reshape(*observations.shape[:2], -1).numpy()
        return chosen

    return act

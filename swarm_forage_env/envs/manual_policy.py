"""ManualPolicy: the user drives a robot in the window, as in PettingZoo's environments."""

from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.errors import ConfigError, UnknownNameError

DRIVEN = ("drive.speed", "drive.strength")
"""First feature of actions that arrow keys can give: of foraging and of waypoint robots."""


class ManualPolicy:
    """Policy that drives one robot with the arrow keys: up drives ahead, left and right turn.

        env = swarm_forage_v2.env("es1", render_mode="human", decision_period=1)
        env.reset(seed=0)
        manual_policy = swarm_forage_v2.ManualPolicy(env)
        for agent in env.agent_iter():
            observation, reward, termination, truncation, info = env.last()
            if termination or truncation:
                action = None
            elif agent == manual_policy.agent:
                action = manual_policy(observation, agent)
            else:
                action = env.action_space(agent).sample()
            env.step(action)

    An arrow key takes effect while it is held; the other keys of the window keep their functions.
    """

    def __init__(self, env: Any, agent_id: int = 0) -> None:  # noqa: ANN401 of either API, wrapped
        bare = env.unwrapped
        if bare.window is None:
            raise ConfigError("manual control: make the environment with render_mode='human'")
        names = bare.action_layout.names
        if names[0] not in DRIVEN or bare.array_env.config.discrete:
            raise ConfigError(
                f"manual control of {', '.join(names)}: the arrow keys drive learn='motion' with"
                " action='drive' and discrete=False only"
            )
        learners = bare.possible_agents
        if not 0 <= agent_id < len(learners):
            raise ConfigError(f"agent_id={agent_id}: must be 0 to {len(learners) - 1}")
        self.env, self.agent_id, self.agent = env, agent_id, learners[agent_id]
        self._window, self._names = bare.window, names
        self._window.drive(int(self.agent.rpartition("_")[2]))

    def __call__(self, observation: object, agent: str) -> Float32[Array, "2"]:
        """Return the action of the keys held now; UnknownNameError for another agent."""
        if agent != self.agent:
            raise UnknownNameError("agent driven by hand", agent, [self.agent])
        return action_of(self._window.arrows, self._names)

    @property
    def available_agents(self) -> dict[str, int]:
        """Index of each agent that can be driven."""
        return {agent: k for k, agent in enumerate(self.env.unwrapped.possible_agents)}


def action_of(arrows: tuple[bool, bool, bool], names: tuple[str, ...]) -> Float32[Array, "2"]:
    """Return the action of the arrow keys (up, left, right) for these action features.

    A foraging robot turns on the spot without up, and stops without any key. A waypoint robot
    never stops: it drives straight without any key, and speeds up when it turns.
    """
    ahead, left, right = arrows
    turn = float(left) - float(right)
    if names[0] == "drive.strength":
        return np.array([1.0 if ahead or turn else -1.0, turn], np.float32)
    return np.array([1.0 if ahead else -1.0, turn], np.float32)

"""What a policy is shown and what it gives in a scenario, under the keywords of its training."""

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Discrete

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.envs.actions import ActionForm, Actions
from swarm_forage_env.envs.config import EnvConfig, n_steps
from swarm_forage_env.envs.observations import Observer, stacked
from swarm_forage_env.errors import UnknownNameError
from swarm_forage_env.task import task_of

BOUND = re.compile(r"of [-+.e0-9]+ ")
"""Start of the unit of a number that is divided by its bound, which goes by the scenario."""


class PolicyForm:
    """The observation and the action of a robot, as an environment of these keywords has them."""

    def __init__(self, scenario: Any, config: EnvConfig, message_path: float) -> None:  # noqa: ANN401 of any task
        """ConfigError or UnknownNameError for keywords that the scenario's task does not have."""
        self.task = task_of(scenario)
        if config.learn not in self.task.policies:
            raise UnknownNameError("layer to learn", config.learn, self.task.policies)
        self.policy = self.task.policies[config.learn]
        self.period = config.decision_period or min(self.policy.decision_period, scenario.n_ticks)
        self.config = config = config.model_copy(update={"decision_period": self.period})
        self.max_cycles = n_steps(scenario, config)
        ticks = max(scenario.n_ticks, self.max_cycles * self.period)
        shown = self.policy.layout(self.task.bounds(scenario, ticks, message_path))
        agents = self.task.agents(scenario.task.n_robots)
        self.observe = Observer(
            self.policy, config.observation, shown, scenario, agents, config.normalise
        )
        self.layout = stacked(self.observe.layout, config.stack)
        self.observation_space: Box = self.layout.box()
        self._action = ActionForm(self.task, self.policy, config)
        self.action_space: Box | Discrete[Any] = self._action.space
        self._agents = agents

    @property
    def observes(self) -> tuple[tuple[str, str], ...]:
        """Name and unit of each number of an observation, the same under other bounds."""
        return tuple((each.name, BOUND.sub("of its bound, in ", each.unit)) for each in self.layout)

    def actions(self, robots: Sequence[int]) -> Actions:
        """What turns the actions of these robots of a world into what the layers take."""
        return Actions([self._agents[robot] for robot in robots], self._action)

    def dummy(self, robots: Sequence[int]) -> Float32[Array, "robots numbers"]:
        """An observation of each of these robots, all zeros."""
        return np.zeros((len(robots), len(self.layout)), np.float32)

    @property
    def everybody(self) -> Sequence[int]:
        """The numbers of all robots."""
        return range(len(self._agents))

"""Version 0 of the environment, which ends with the next release: commands, in SI units."""

from typing import Any

from pettingzoo import AECEnv

from swarm_forage_env.envs import pettingzoo_env
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.task import task_of

__all__ = ["env", "parallel_env", "raw_env"]


def parallel_env(scenario: Any = "es1", **options: Any) -> pettingzoo_env.parallel_env:  # noqa: ANN401 as its class
    """As the newest `parallel_env`, under the defaults of version 0."""
    return pettingzoo_env.parallel_env(scenario, **{**_defaults(scenario), **options})


def raw_env(scenario: Any = "es1", **options: Any) -> AECEnv:  # noqa: ANN401
    """As the newest `raw_env`, under the defaults of version 0."""
    return pettingzoo_env.raw_env(scenario, **{**_defaults(scenario), **options})


def env(scenario: Any = "es1", **options: Any) -> AECEnv:  # noqa: ANN401
    """As the newest `env`, under the defaults of version 0."""
    return pettingzoo_env.env(scenario, **{**_defaults(scenario), **options})


def _defaults(scenario: Any) -> dict[str, Any]:  # noqa: ANN401 of any task
    """Commands as the motion gives them, in each tick, and SI units."""
    *_, command = task_of(find_scenario(scenario)).steerings or (None,)
    return {"action": command, "normalise": False, "decision_period": 1}

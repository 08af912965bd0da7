"""Version 1 of the environment, which ends with the next release: half speed at 0, no walk."""

from typing import Any

from pettingzoo import AECEnv

from swarm_forage_env.envs import pettingzoo_env
from swarm_forage_env.envs.registration import keywords_of
from swarm_forage_env.scenarios import find_scenario

__all__ = ["env", "parallel_env", "raw_env"]


def parallel_env(scenario: Any = "es1", **options: Any) -> pettingzoo_env.parallel_env:  # noqa: ANN401 as its class
    """As the newest `parallel_env`, under the defaults of version 1."""
    return pettingzoo_env.parallel_env(scenario, **{**_defaults(scenario), **options})


def raw_env(scenario: Any = "es1", **options: Any) -> AECEnv:  # noqa: ANN401
    """As the newest `raw_env`, under the defaults of version 1."""
    return pettingzoo_env.raw_env(scenario, **{**_defaults(scenario), **options})


def env(scenario: Any = "es1", **options: Any) -> AECEnv:  # noqa: ANN401
    """As the newest `env`, under the defaults of version 1."""
    return pettingzoo_env.env(scenario, **{**_defaults(scenario), **options})


def _defaults(scenario: Any) -> dict[str, Any]:  # noqa: ANN401 of any task
    """Those of the environments with ids of version 1."""
    return keywords_of(1, find_scenario(scenario).name)

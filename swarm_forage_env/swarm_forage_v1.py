"""Version 1 of the environment, to be removed in the next release: half speed at 0, no walk."""

from typing import Any

from pettingzoo import AECEnv

from swarm_forage_env.envs import pettingzoo_env
from swarm_forage_env.envs.registration import keywords_of
from swarm_forage_env.scenarios import ScenarioSource, find_scenario

__all__ = ["env", "parallel_env", "raw_env"]


def _options(scenario: ScenarioSource, options: dict[str, Any]) -> dict[str, Any]:
    return {**keywords_of(1, find_scenario(scenario).name), **options}


def parallel_env(
    scenario: ScenarioSource = "es1",
    **options: Any,  # noqa: ANN401 as its class
) -> pettingzoo_env.parallel_env:
    """Return the newest `parallel_env` with the defaults of version 1."""
    return pettingzoo_env.parallel_env(scenario, **_options(scenario, options))


def raw_env(scenario: ScenarioSource = "es1", **options: Any) -> AECEnv:  # noqa: ANN401
    """Return the newest `raw_env` with the defaults of version 1."""
    return pettingzoo_env.raw_env(scenario, **_options(scenario, options))


def env(scenario: ScenarioSource = "es1", **options: Any) -> AECEnv:  # noqa: ANN401
    """Return the newest `env` with the defaults of version 1."""
    return pettingzoo_env.env(scenario, **_options(scenario, options))

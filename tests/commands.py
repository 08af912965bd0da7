"""Environments whose policies give the commands of the motion, in each tick, and see SI units."""

from typing import Any

import gymnasium

from swarm_forage_env.envs import pettingzoo_env
from swarm_forage_env.envs.registration import NAMES
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.task import task_of

COMMANDS = {"normalise": False, "decision_period": 1, "walk": False}


def parallel_env(scenario: Any = "es1", **options: Any) -> pettingzoo_env.parallel_env:
    """As the newest `parallel_env`."""
    return pettingzoo_env.parallel_env(scenario, **{**commands_of(scenario), **options})


def env(scenario: Any = "es1", **options: Any) -> Any:
    """As the newest `env`."""
    return pettingzoo_env.env(scenario, **{**commands_of(scenario), **options})


def commands_of(scenario: Any) -> dict[str, Any]:
    """The keywords."""
    forms = task_of(find_scenario(scenario)).steerings
    action = next((form for form in ("wheels", "pull") if form in forms), None)
    return {"action": action, **COMMANDS}


def register_ids() -> None:
    """Enter `Commands/<Name>-v0`, -Joint and -Tuple, with these keywords, in Gymnasium."""
    for scenario, name in NAMES.items():
        for kind in ("", "-Joint", "-Tuple"):
            newest = gymnasium.spec(f"SwarmForage/{name}{kind}-v2")
            few = {"discrete": (3, 3)} if kind == "-Tuple" else {}
            gymnasium.register(
                f"Commands/{name}{kind}-v0",
                newest.entry_point,
                vector_entry_point=newest.vector_entry_point,
                disable_env_checker=newest.disable_env_checker,
                kwargs={"scenario": scenario, **commands_of(scenario), **few},
            )


register_ids()

"""A multi-robot foraging world: e-pucks, drifting odometry, a short-range lossy radio.

>>> from swarm_forage_env import parallel_env
>>> env = parallel_env("es1", learn="weighting")
>>> observations, infos = env.reset(seed=0)
"""

from typing import TYPE_CHECKING

from swarm_forage_env.envs.registration import register_with_gymnasium, register_with_pettingzoo

if TYPE_CHECKING:
    from swarm_forage_env.envs.array_env import ArrayEnv, array_env
    from swarm_forage_env.envs.pettingzoo_env import env, parallel_env, raw_env
    from swarm_forage_env.errors import ConfigError, UnknownNameError
    from swarm_forage_env.foraging.world import ForagingWorld
    from swarm_forage_env.scenarios import find_scenario

__all__ = [
    "ArrayEnv",
    "ConfigError",
    "ForagingWorld",
    "UnknownNameError",
    "array_env",
    "env",
    "find_scenario",
    "parallel_env",
    "raw_env",
]

_WHERE = {
    "ArrayEnv": "swarm_forage_env.envs.array_env",
    "array_env": "swarm_forage_env.envs.array_env",
    "ConfigError": "swarm_forage_env.errors",
    "UnknownNameError": "swarm_forage_env.errors",
    "ForagingWorld": "swarm_forage_env.foraging.world",
    "env": "swarm_forage_env.envs.pettingzoo_env",
    "find_scenario": "swarm_forage_env.scenarios",
    "parallel_env": "swarm_forage_env.envs.pettingzoo_env",
    "raw_env": "swarm_forage_env.envs.pettingzoo_env",
}


def __getattr__(name: str) -> object:
    """Import a public name at its first use, so that importing the package is quick."""
    from importlib import import_module

    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_WHERE[name]), name)


register_with_gymnasium()
register_with_pettingzoo()

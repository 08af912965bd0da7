"""A multi-robot foraging world: e-pucks, drifting odometry, a short-range lossy radio.

>>> from swarm_forage_env import parallel_env
>>> env = parallel_env("es1", learn="weighting")
>>> observations, infos = env.reset(seed=0)
"""

from importlib import import_module
from typing import TYPE_CHECKING

from swarm_forage_env.envs.registration import register_with_gymnasium, register_with_pettingzoo

if TYPE_CHECKING:
    from swarm_forage_env.envs.array_env import ArrayEnv, array_env
    from swarm_forage_env.envs.keywords import OwnName
    from swarm_forage_env.envs.pettingzoo_env import env, parallel_env, raw_env
    from swarm_forage_env.errors import ConfigError, UnknownNameError
    from swarm_forage_env.foraging.world import ForagingWorld
    from swarm_forage_env.scenarios import find_scenario

__all__ = [
    "ArrayEnv", "ConfigError", "ForagingWorld", "OwnName", "UnknownNameError", "array_env", "env",
    "find_scenario", "parallel_env", "raw_env",
]  # fmt: skip

_NAMES = {
    "envs.array_env": ("ArrayEnv", "array_env"),
    "envs.keywords": ("OwnName",),
    "envs.pettingzoo_env": ("env", "parallel_env", "raw_env"),
    "errors": ("ConfigError", "UnknownNameError"),
    "foraging.world": ("ForagingWorld",),
    "scenarios": ("find_scenario",),
}


def __getattr__(name: str) -> object:
    """Import a public name at its first use, so that importing the package is quick."""
    for module, names in _NAMES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{module}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


register_with_gymnasium()
register_with_pettingzoo()

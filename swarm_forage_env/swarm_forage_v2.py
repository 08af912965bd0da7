"""The environment as PettingZoo's modules: `env`, `parallel_env`, `raw_env`, `ManualPolicy`."""

from swarm_forage_env.envs.manual_policy import ManualPolicy
from swarm_forage_env.envs.pettingzoo_env import env, parallel_env, raw_env

__all__ = ["ManualPolicy", "env", "parallel_env", "raw_env"]

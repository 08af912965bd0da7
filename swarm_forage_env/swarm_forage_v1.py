"""The environment as PettingZoo's modules are laid out: `env`, `parallel_env` and `raw_env`."""

from swarm_forage_env.envs.pettingzoo_env import env, parallel_env, raw_env

__all__ = ["env", "parallel_env", "raw_env"]

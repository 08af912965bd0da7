"""The environment as PettingZoo's modules are laid out: `env`, `parallel_env`, `raw_env`.

`ManualPolicy` drives a robot by the arrow keys.
"""

from swarm_forage_env.envs.manual_policy import ManualPolicy
from swarm_forage_env.envs.pettingzoo_env import env, parallel_env, raw_env

__all__ = ["ManualPolicy", "env", "parallel_env", "raw_env"]

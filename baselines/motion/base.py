"""The registry of motion rules; what one consists of is in `swarm_forage_env.interface`."""

from typing import Any

from swarm_forage_env.registry import Registry

MOTIONS: Registry[Any] = Registry("motion")
"""Parameters by name; each is a `Part`. A compiled motion has a method `layer(scenario)`, which
returns a `MotionLayer`; of a motion in NumPy `start(scenario, seeds)` gives a function of the
records that `steer` takes, a row for each robot."""

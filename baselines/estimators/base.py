"""The registry of estimators; their protocol is `swarm_forage_env.interface.Estimator`."""

from typing import Any

from swarm_forage_env.registry import Registry

ESTIMATORS: Registry[Any] = Registry("estimator")
"""Parameters by name; each is a `Part` with a method `start(scenario, n_worlds)`."""

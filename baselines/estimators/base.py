"""Registry of estimators; `swarm_forage_env.interface` defines the parts of an estimator."""

from swarm_forage_env.parameters import Parameters
from swarm_forage_env.registry import Registry

ESTIMATORS: Registry[type[Parameters]] = Registry("estimator")
"""Parameter classes by name; the method `layer(scenario)` returns an `EstimatorLayer`."""

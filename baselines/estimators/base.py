"""The registry of estimators; what one consists of is in `swarm_forage_env.interface`."""

from swarm_forage_env.parameters import Parameters
from swarm_forage_env.registry import Registry

ESTIMATORS: Registry[type[Parameters]] = Registry("estimator")
"""Parameters by name; the method `layer(scenario)` of each returns an `EstimatorLayer`."""

"""The registry of estimators; what one consists of is in `swarm_forage_env.interface`."""

from typing import Any

from swarm_forage_env.registry import Registry

ESTIMATORS: Registry[Any] = Registry("estimator")
"""Parameters by name; each is a `Part` with a method `layer(scenario)`, which returns an
`EstimatorLayer`."""

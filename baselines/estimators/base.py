"""The registry of estimators: parts with an `EstimatorLayer`."""

from typing import Any

from swarm_forage_env.registry import Registry

ESTIMATORS: Registry[Any] = Registry("estimator")
"""Estimators by name; each is a `Part` whose fields are its parameters, with a method
`layer(scenario)`."""

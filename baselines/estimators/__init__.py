"""Estimators: where a robot believes the areas are."""

from baselines.estimators.base import ESTIMATORS
from swarm_forage_env.registry import load_folder

__all__ = ["ESTIMATORS"]

load_folder(__name__, __path__)

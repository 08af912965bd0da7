"""Weighting rules: the weight of a received estimate relative to that of the robot itself."""

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.registry import load_folder

__all__ = ["WEIGHTING_RULES"]

load_folder(__name__, __path__)

"""Weighting rules: weight g of a received estimate, from 0 (keep the own) to 1 (adopt it)."""

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.registry import load_folder

__all__ = ["WEIGHTING_RULES"]

load_folder(__name__, __path__)

"""Confidence-weighting rules: how much of a heard estimate enters the own one."""

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.registry import load_folder

__all__ = ["WEIGHTING_RULES"]

load_folder(__name__, __path__)

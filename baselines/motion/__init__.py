"""Motions: rules that map the situation of a robot to its command."""

from baselines.motion.base import MOTIONS
from swarm_forage_env.registry import load_folder

__all__ = ["MOTIONS"]

load_folder(__name__, __path__)

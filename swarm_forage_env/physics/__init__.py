"""Physics engines, which move the robots, with a common interface."""

from swarm_forage_env.physics.base import ENGINES, Physics
from swarm_forage_env.registry import load_folder

__all__ = ["ENGINES", "Physics"]

load_folder(__name__, __path__)

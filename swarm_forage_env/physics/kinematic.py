"""The engine `kinematic`: wheels integrated exactly, no forces.

Robots in contact keep driving and are moved apart along the line between their centres; they do
not push, slide or turn each other.
"""

from swarm_forage_env.physics.base import ENGINES, Physics


@ENGINES.register("kinematic")
class Kinematic(Physics):
    """Wheels are integrated exactly, without forces; overlapping robots are separated."""

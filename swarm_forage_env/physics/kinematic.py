"""The engine `kinematic`: wheels integrated exactly, no forces.

In a contact robots keep turning their wheels and are moved apart along the line between their
centres; they do not push, slide or turn each other.
"""

from swarm_forage_env.physics.base import ENGINES, Physics


@ENGINES.register("kinematic")
class Kinematic(Physics):
    """Robots go where their wheels take them, without forces; where two overlap, they part."""

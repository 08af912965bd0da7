"""How fast an episode is shown."""

from swarm_forage_env.errors import ConfigError

SPEEDS = (0.1, 256.0)
"""Slowest and fastest multiple of real time."""


def checked_speed(speed: float) -> float:
    """A multiple of real time; ConfigError for one out of bounds."""
    slowest, fastest = SPEEDS
    if not slowest <= speed <= fastest:
        raise ConfigError(f"speed={speed:g}: must be {slowest:g} to {fastest:g} times real time")
    return speed

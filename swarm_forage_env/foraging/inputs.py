"""Helpers for the inputs of layers in records: goals and exchanges."""

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.foraging.records import Exchange


@kernel
def goal_of(goal: Float32[Array, "3"]) -> int:
    """Return the area that a robot is heading for: 0 nest, 1 prey, -1 none."""
    if goal[0] > 0.0:
        return 0
    return 1 if goal[1] > 0.0 else -1


@kernel
def write_goal(area: int, goal: Float32[Array, "3"]) -> None:
    """Write the area that a robot is heading for, -1 for none, in one-hot form."""
    for k in range(3):
        goal[k] = 0.0
    goal[area] = 1.0  # -1 is the last element


@kernel
def clear_exchange(exchange: Exchange) -> None:
    """Clear the inputs of an exchange when it is over, and keep its weights."""
    exchange.is_valid = exchange.range = exchange.n_averaged = 0.0
    exchange.right = exchange.wrong = 0.0
    write_goal(-1, exchange.goal)
    for area in range(2):
        exchange.own_p[area] = exchange.heard_p[area] = exchange.disagreement[area] = 0.0
        exchange.own_known[area] = exchange.heard_known[area] = exchange.own_visited[area] = 0.0
        exchange.own_distance[area] = exchange.heard_distance[area] = 0.0
        exchange.support[area] = exchange.suspicion[area] = exchange.dissent[area] = 0.0

"""Inputs of layers as they lie in records: where a robot is heading, exchanges, and messages."""

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.foraging.records import Exchange, Heard


@kernel
def goal_of(goal: Float32[Array, "3"]) -> int:
    """The area that a robot is heading for: 0 nest, 1 prey, -1 none."""
    if goal[0] > 0.0:
        return 0
    return 1 if goal[1] > 0.0 else -1


@kernel
def write_goal(area: int, goal: Float32[Array, "3"]) -> None:
    """Write the area that a robot is heading for, -1 for none, as one of three."""
    goal[0], goal[1], goal[2] = area == 0, area == 1, area < 0


@kernel
def clear_exchange(exchange: Exchange) -> None:
    """Clear what was seen of an exchange when it is over; the weights stay."""
    exchange.is_valid = exchange.range = exchange.n_averaged = 0.0
    exchange.right = exchange.wrong = 0.0
    write_goal(-1, exchange.goal)
    for area in range(2):
        exchange.own_p[area] = exchange.heard_p[area] = exchange.disagreement[area] = 0.0
        exchange.own_known[area] = exchange.heard_known[area] = exchange.own_visited[area] = 0.0
        exchange.own_distance[area] = exchange.heard_distance[area] = 0.0
        exchange.support[area] = exchange.suspicion[area] = exchange.dissent[area] = 0.0


@kernel
def mark_messages(heard: Heard, n: int) -> None:
    """Set how many messages were heard; flags follow, and slots that were used before are zeros."""
    for slot in range(heard.n, n):
        heard.is_valid[slot] = 1.0
    for slot in range(n, heard.n):
        heard.is_valid[slot] = heard.n_averaged[slot] = 0.0
        for k in range(3):
            heard.range_bearing[slot, k] = 0.0
    heard.n = n

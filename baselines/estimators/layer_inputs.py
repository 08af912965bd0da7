"""Layer inputs of social odometry: what the weighting and the motion are shown of the beliefs."""

from baselines.estimators.belief import NOBODY, NOWHERE, Belief, SocialMind
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import cos_sin, hypot
from swarm_forage_env.equations.geometry import to_body
from swarm_forage_env.foraging.inputs import write_goal
from swarm_forage_env.foraging.records import Exchange, Report, Situation


@kernel
def describe_situation(belief: Belief, situation: Situation) -> None:
    """Areas and target in the body frame; zeros for what is unknown.

    At the place where the area should be, the target is the rest of the way straight on.
    """
    c = s = 0.0
    if belief.known[0] or belief.known[1]:
        c, s = cos_sin(belief.pose[2])
    for area in range(2):
        ahead = left = p = 0.0
        if belief.known[area]:
            dx = belief.location[area, 0] - belief.pose[0]
            dy = belief.location[area, 1] - belief.pose[1]
            ahead, left = to_body(dx, dy, c, s)
            p = belief.p[area]
        situation.areas[area, 0], situation.areas[area, 1] = ahead, left
        situation.p[area] = p
        situation.known[area] = belief.known[area]
    write_goal(belief.goal, situation.goal)
    situation.is_talking = belief.partner != NOBODY
    situation.target[0] = situation.target[1] = 0.0
    if belief.goal != NOWHERE:
        situation.target[0] = situation.areas[belief.goal, 0]
        situation.target[1] = situation.areas[belief.goal, 1]
        if belief.search_path_left >= 0.0:
            situation.target[0], situation.target[1] = belief.search_path_left, 0.0


@kernel
def describe_own_side(belief: Belief, area: int, exchange: Exchange) -> None:
    """What the robot itself knows of an area; zeros for what is unknown."""
    p = distance = 0.0
    if belief.known[area]:
        dx = belief.location[area, 0] - belief.pose[0]
        dy = belief.location[area, 1] - belief.pose[1]
        p, distance = belief.p[area], hypot(dx, dy)
    exchange.own_known[area] = belief.known[area]
    exchange.own_p[area], exchange.own_distance[area] = p, distance


@kernel
def describe_heard_side(belief: Belief, area: int, exchange: Exchange) -> None:
    """What the partner told of an area, and how far apart both place it; zeros if nothing."""
    p = distance = apart = 0.0
    is_told = belief.heard_weight[area] > 0.0
    if is_told:
        x = belief.heard_sum[area, 0] / belief.heard_weight[area]
        y = belief.heard_sum[area, 1] / belief.heard_weight[area]
        p, distance = belief.heard_p[area], hypot(x - belief.pose[0], y - belief.pose[1])
        if belief.known[area]:
            apart = hypot(x - belief.location[area, 0], y - belief.location[area, 1])
    exchange.heard_known[area] = is_told
    exchange.heard_p[area], exchange.heard_distance[area] = p, distance
    exchange.disagreement[area] = apart


@kernel
def describe_exchange(belief: Belief, exchange: Exchange) -> None:
    """The exchange that just ended, before it is merged."""
    for area in range(2):
        describe_own_side(belief, area, exchange)
        describe_heard_side(belief, area, exchange)
    exchange.range = belief.range_sum / belief.n_averaged
    exchange.n_averaged = belief.n_averaged
    write_goal(belief.goal, exchange.goal)


@kernel
def describe(mind: SocialMind, report: Report) -> None:
    """Fill the inputs of both layers, and the report; of an exchange only if one ended."""
    belief = mind.belief
    if mind.exchange.is_valid:
        describe_exchange(belief, mind.exchange)
    describe_situation(belief, mind.situation)
    report.is_lost = belief.is_lost
    report.known[0], report.known[1] = belief.known[0], belief.known[1]

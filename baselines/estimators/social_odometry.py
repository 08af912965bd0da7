"""Social odometry: each robot keeps its own estimate of both areas, and imitates better ones.

Gutierrez et al. 2009 (TR), Sections 4 and 5; Gutierrez et al. 2008 (ANTS), Section 4.2.

Not in the paper, and chosen here:
- an exchange lasts the radio's exchange time and averages what the partner says in it, each
  message weighted by its frames; one partner at a time, drawn by the radio's random slots;
- an exchange is of one robot: its partner may be in a pause, talk to another one or drive on, and
  then keeps its own estimate. Both end with the same one, as TR, Eq. 17, has it, if both begin in
  the same tick; of 1,175 exchanges of DSGIKF in six worlds of es1, 84 % were of one robot alone
  (10 minutes under `kinematic`, a probe whose script is not kept);
- the p that is merged is that of the last message, after an exchange of the partner if that ended
  first;
- after an exchange a robot ignores all robots for `pause`, and the same partner for `refractory`:
  if p shrinks at each of many exchanges, a crowd becomes confident of a wrong place;
- a robot does not stop for a message that holds nothing of use to it;
- on its way a single filter sends only the estimate of the area it comes from. TR 6.1 says which
  one a robot corrects; TR 6.1.2 that robots "only communicate their estimate about the goal they
  are aiming at", and then why telling of that goal harms;
- a turn counts as path, too (Gutierrez2010), on a curve in addition to the way;
- a robot recognises an area by two of its three ground sensors;
- the point stored on entering an area is its centre, if the robot was heading there;
- the distance from the believed centre that counts as "there", and the path of the search that
  follows before the robot is lost;
- a robot that just got lost ignores messages for `deaf_when_lost`;
- optionally, a message costs precision (`message_path`), a robot on its way does not report an area
  whose p is large (`tells_within`), which ends rumours, and does not stop for an area whose p is
  small (`listens_above`); the papers have none of these;
- a robot that received an area before it visited any heads for the nearer one.
"""

import math
from collections.abc import Mapping
from typing import ClassVar, Literal

from pydantic import Field

from baselines.estimators.area_memory import displacement_to, update_belief
from baselines.estimators.base import ESTIMATORS
from baselines.estimators.belief import NOBODY, NOWHERE, Belief, SocialMind
from baselines.estimators.falsified_messages import falsify, repeat
from baselines.estimators.message_exchange import (
    compose,
    has_something_to_say,
    heard_place,
    is_listening,
    merge,
    update_exchange,
)
from baselines.weighting.covariance import Covariance
from baselines.weighting.sgikf import SGIKF
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import cos_sin, hypot
from swarm_forage_env.equations.geometry import to_body
from swarm_forage_env.foraging.control import observe_world
from swarm_forage_env.foraging.inputs import write_goal
from swarm_forage_env.foraging.records import Exchange, Report, Situation
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import EstimatorLayer, Kernel
from swarm_forage_env.parameters import MAX_TICKS, NotNegative, Parameters, Positive
from swarm_forage_env.record import Record


@kernel
def describe_situation(belief: Belief, situation: Situation) -> None:
    """Write areas and target in the body frame; zeros for unknown ones.

    During the search at the believed location, the target is the end of the straight search path.
    """
    c = s = 0.0
    if belief.known[0] or belief.known[1]:
        c, s = cos_sin(belief.pose[2])
    for area in range(2):
        ahead = left = p = 0.0
        if belief.known[area]:
            dx, dy = displacement_to(belief, area)
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
def describe_exchange(belief: Belief, exchange: Exchange) -> None:
    """Describe the exchange that just ended, before it is merged; zeros for unknown values."""
    for area in range(2):
        own_p = own_distance = heard_p = heard_distance = apart = 0.0
        is_heard = belief.heard_weight[area] > 0.0
        if belief.known[area]:
            dx, dy = displacement_to(belief, area)
            own_p, own_distance = belief.p[area], hypot(dx, dy)
        if is_heard:
            x, y = heard_place(belief, area)
            heard_p = belief.heard_p[area]
            heard_distance = hypot(x - belief.pose[0], y - belief.pose[1])
            if belief.known[area]:
                apart = hypot(x - belief.location[area, 0], y - belief.location[area, 1])
        exchange.own_known[area], exchange.heard_known[area] = belief.known[area], is_heard
        exchange.own_p[area], exchange.own_distance[area] = own_p, own_distance
        exchange.heard_p[area], exchange.heard_distance[area] = heard_p, heard_distance
        exchange.disagreement[area] = apart
    exchange.range = belief.range_sum / belief.n_averaged
    exchange.n_averaged = belief.n_averaged
    write_goal(belief.goal, exchange.goal)


@kernel
def describe(mind: SocialMind, report: Report) -> None:
    """Write the inputs of the weighting (if an exchange ended) and the motion, and the report."""
    belief = mind.belief
    if mind.exchange.is_valid:
        describe_exchange(belief, mind.exchange)
    describe_situation(belief, mind.situation)
    report.is_lost = belief.is_lost
    report.known[0], report.known[1] = belief.known[0], belief.known[1]


N_STEPS = {"float32": 0.0, "int16": 2.0**16, "int8": 2.0**8}
"""Number of values of a word of each payload; 0: not rounded."""

KERNELS: Mapping[str, Kernel] = {
    "is_listening": is_listening,
    "compose": compose,
    "repeat": repeat,
    "falsify": falsify,
    "update_belief": update_belief,
    "update_exchange": update_exchange,
    "describe": describe,
    "merge": merge,
    "has_something_to_say": has_something_to_say,
}
"""Functions of social odometry bound to the free names of the tick."""


@ESTIMATORS.register("social_odometry")
class SocialOdometryParameters(Parameters):
    """Social odometry: robots exchange their estimates of the areas.

    A subclass replaces records or functions.
    """

    mind: ClassVar[type[Record]] = SocialMind
    kernels: ClassVar[Mapping[str, Kernel]] = KERNELS
    own_rule: ClassVar[SGIKF | Covariance] = SGIKF()

    speaks: bool = Field(True, description="Whether robots broadcast; false: no communication")
    double: bool = Field(
        False,
        description="Whether both areas are exchanged; false: a robot corrects the one that it"
        " heads for (TR 6.1), and reports the one that it comes from (TR 6.1.2; derived)",
    )
    first_hand: bool = Field(
        True,
        description="Whether a robot reports an area only if it has stood on it since it was"
        " last lost; false: it passes on received estimates, too. TR 4.1 (published)",
    )
    message_path: NotNegative = Field(
        0.0,
        description="Path added to that of a received estimate, because a message costs"
        " precision, too [m]. 0: TR 4.3 (published)",
    )
    tells_within: NotNegative = Field(
        0.0,
        description="Largest own p at which a robot that knows both areas reports one [m]; 0: it"
        " always does, as in TR 5.2 (published)",
    )
    listens_above: NotNegative = Field(
        0.0,
        description="Smallest own p at which a robot stops for estimates of an area that it"
        " knows [m]; 0: it always does, as in TR 5.2 (published)",
    )
    payload: Literal["float32", "int16", "int8"] = Field(
        "float32",
        description="Type of the words that hold distance, direction and p in a message, rounded"
        " as on a board. Not in the papers (chosen)",
    )
    refractory: NotNegative = Field(
        20.0, description="Time before a robot talks to the same partner again [s] (derived)"
    )
    pause: NotNegative = Field(
        15.0, description="Time after an exchange in which a robot listens to nobody [s] (derived)"
    )
    deaf_when_lost: NotNegative = Field(
        5.0, description="Time for which a robot that got lost ignores messages [s] (derived)"
    )
    lost_within: Positive = Field(
        0.05, description="Distance from the believed centre that counts as there [m] (derived)"
    )
    overshoot: NotNegative = Field(
        0.18, le=1.0, description="Path to search straight ahead, once there [m] (derived)"
    )

    def layer(self, scenario: Scenario) -> EstimatorLayer:
        """Return the records and functions of the estimator, with its parameters in a scenario."""
        numbers, own = self.numbers(scenario), self.own_rule.layer(scenario)
        return EstimatorLayer(self.mind, numbers, self.kernels, observe_world, own_weighting=own)

    def numbers(self, scenario: Scenario) -> dict[str, float]:
        """Return the parameters of the kernels, those of subclasses included; times in ticks."""

        def in_ticks(time: float) -> int:
            return min(round(time / scenario.tick), MAX_TICKS)  # beliefs count in 32 bits

        times = "refractory", "pause", "deaf_when_lost"
        own = {name: each for name, each in self if isinstance(each, int | float)}
        return {name: each for name, each in own.items() if name not in times} | {
            "tells_within": self.tells_within or math.inf,
            "talk_ticks": max(1, in_ticks(scenario.radio.exchange_time)),
            "refractory_ticks": in_ticks(self.refractory),
            "pause_ticks": in_ticks(self.pause),
            "deaf_ticks": in_ticks(self.deaf_when_lost),
            "n_steps": N_STEPS[self.payload],
            "axle": scenario.robot.axle,
            "to_centre": scenario.sensors.ground_ahead + scenario.task.area_radius,
        }

"""Global communication: every robot adopts the mean of the estimates of the whole group.

Gutierrez et al. 2008 (ANTS), Section 5: "each robot updates its estimates by averaging the
knowledge of the whole group". It is a reference, since no robot can hear the whole group.

Not in the paper, and chosen here:
- the group uses the radio of local communication with unlimited range: beams have the noise of
  one frame, as robots do not stop for them, and the group averages once in the time of an exchange
  and its pause. Only for these two reasons does local communication perform better, so that this
  choice decides the claim of the paper (decision 0022): with `through_radio=false`, exact beams in
  every exchange time, global communication performs better;
- no message is lost;
- messages hold the known areas of their sender; the mean is over all senders and the robot itself,
  with equal weights; p becomes the mean of their p;
- a robot that knows no area copies the mean, and so is recruited at once; a robot that just got
  lost first ignores messages for `deaf_when_lost`;
- estimates of robots on an area have the same weight.
"""

from dataclasses import replace

import numpy as np
from pydantic import Field

from baselines.estimators.area_memory import update_belief
from baselines.estimators.belief import Belief, SocialMind
from baselines.estimators.message_exchange import heard_location, heard_place, write_estimate
from baselines.estimators.social_odometry import KERNELS, SocialOdometryParameters, describe
from swarm_forage_env.arrays import Array, UInt64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.records import RADIO
from swarm_forage_env.equations.elementary import atan2, cos_sin
from swarm_forage_env.equations.geometry import range_and_bearing, to_outer, wrap
from swarm_forage_env.equations.radio import board_range
from swarm_forage_env.equations.random_draws import symmetric
from swarm_forage_env.foraging.records import RobotState
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import EstimatorLayer, Kernel
from swarm_forage_env.record import Numbers, field
from swarm_forage_env.templates import row_template
from swarm_forage_env.ticks import Arrays


class GroupBelief(Belief):
    """Belief of a robot under global communication."""

    ticks: int = field(np.int64, unit="ticks")
    """Ticks since reset; the group averages at multiples of the period."""
    streams: UInt64[Array, "1"] = field(np.uint64, 1)
    """Copy of the random stream of the radio, which is unused as no robot broadcasts."""


class GroupMind(SocialMind):
    """Record of the estimator for one robot under global communication."""

    belief: GroupBelief = field(GroupBelief)


@kernel
def measured_beam(
    here: RobotState, there: RobotState, streams: UInt64[Array, "1"], numbers: Numbers
) -> tuple[float, float, float]:
    """Measure range [m], bearing and bearing back [rad] at any distance, with one frame."""
    dx, dy = there.pose[0] - here.pose[0], there.pose[1] - here.pose[1]
    d, bearing = range_and_bearing(dx, dy, here.pose[2])
    back = atan2(-dy, -dx) - there.pose[2]
    if numbers.is_board > 0.0:
        body = 2.0 * numbers.radius
        d = body + board_range(max(d - body, 0.0), streams, 0)
    else:
        d = max(d + numbers.range_noise * symmetric(streams, 0), 0.0)
    bearing += numbers.bearing_noise * symmetric(streams, 0)
    back += numbers.bearing_noise * symmetric(streams, 0)
    return d, wrap(bearing), wrap(back)


@kernel
def tell(mind: GroupMind) -> None:
    """Write the message: distance, direction and p of each known area."""
    for area in range(2):
        mind.message.has_estimate[area] = mind.belief.known[area]
        write_estimate(mind.belief, area, mind.message)


@kernel
def add_own(belief: GroupBelief) -> None:
    """Initialise the sums of a robot with its own estimates."""
    for area in range(2):
        known = float(belief.known[area])
        belief.heard_weight[area] = known
        belief.heard_p[area] = known * belief.p[area]
        for axis in range(2):
            belief.heard_sum[area, axis] = known * belief.location[area, axis]


@kernel
def add_heard(swarm: Array, minds: Array, i: int, j: int, numbers: Numbers) -> None:
    """Add the message of robot j to the sums of robot i, in the frame of i."""
    belief, message = minds[i].belief, minds[j].message
    if not (message.has_estimate[0] or message.has_estimate[1]):
        return
    beam = measured_beam(swarm[i], swarm[j], belief.streams, numbers)
    c, s = cos_sin(belief.pose[2])
    for area in range(2):
        if message.has_estimate[area]:
            d_j, phi_j = message.distance[area], message.direction[area]
            ahead, left = heard_location(beam[0], beam[1], beam[2], d_j, phi_j)
            dx, dy = to_outer(ahead, left, c, s)
            belief.heard_sum[area, 0] += belief.pose[0] + dx
            belief.heard_sum[area, 1] += belief.pose[1] + dy
            belief.heard_p[area] += message.p[area]
            belief.heard_weight[area] += 1.0


@kernel
def move_to_mean(belief: GroupBelief) -> None:
    """Replace the estimates of a robot by the mean over the group."""
    for area in range(2):
        if belief.heard_weight[area] > 0.0:
            belief.location[area, 0], belief.location[area, 1] = heard_place(belief, area)
            belief.p[area] = belief.heard_p[area] / belief.heard_weight[area]
            belief.known[area] = True


@kernel
def average_robot(swarm: Array, minds: Array, i: int, numbers: Numbers) -> None:
    """Replace the estimates of robot i by the mean over itself and the messages of the others."""
    add_own(minds[i].belief)
    for j in range(minds.shape[0]):
        if j != i:
            add_heard(swarm, minds, i, j, numbers)
    move_to_mean(minds[i].belief)


@kernel
def average(swarm: Array, minds: Array, numbers: Numbers) -> None:
    """Average the estimates in one world, once per period."""
    for i in range(minds.shape[0]):
        minds[i].belief.ticks += 1
    if minds[0].belief.ticks == 1:
        for i in range(minds.shape[0]):
            minds[i].belief.streams[0] = swarm[i].streams[RADIO]
    if minds[0].belief.ticks % int(numbers.period_ticks) != 0:
        return
    for i in range(minds.shape[0]):
        tell(minds[i])
    for i in range(minds.shape[0]):
        if minds[i].belief.ignore_ticks == 0:
            average_robot(swarm, minds, i, numbers)


@row_template
def observe_group(world_arrays: Arrays, layer_arrays: Arrays, w: int, n_robots: int) -> None:
    """Update beliefs by the readings, then average over the group; there are no pairwise exchanges.

    Free names: update_belief, average, describe.
    """
    swarm = world_arrays[0][w]
    all_minds, _, shared, settings = layer_arrays
    minds, last = all_minds[w], settings.shape[1] - 1
    for i in range(n_robots):
        update_belief(
            minds[i], shared[w, i], swarm[i].readings, settings[w, min(i, last)].estimator
        )
    if n_robots > 0:
        average(swarm, minds, settings[w, 0].estimator)
    for i in range(n_robots):
        describe(minds[i], swarm[i].report)


class GlobalAverage(SocialOdometryParameters):
    """Social odometry without broadcasts: all robots share one mean of their estimates."""

    mind = GroupMind

    through_radio: bool = Field(
        True,
        description="Whether beams have the noise of one frame, and all robots average once in"
        " the time of an exchange and its pause; false: beams are exact, and all average in"
        " every exchange time. ANTS 5 has one radio for all (derived)",
    )

    def layer(self, scenario: Scenario) -> EstimatorLayer:
        """Return the records and functions of the estimator, with its parameters in a scenario."""
        kernels: dict[str, Kernel] = {**KERNELS, "average": average}
        del kernels["falsify"], kernels["repeat"]  # no message that a fault could change
        return replace(super().layer(scenario), kernels=kernels, observe=observe_group)

    def numbers(self, scenario: Scenario) -> dict[str, float]:
        """Return the parameters for kernels, and the noise of one frame."""
        own, radio = super().numbers(scenario), scenario.radio
        return {
            **own,
            "range_noise": self.through_radio * radio.range_noise,
            "bearing_noise": self.through_radio * radio.bearing_noise,
            "is_board": self.through_radio and radio.is_board,
            "radius": scenario.robot.radius,
            "period_ticks": own["talk_ticks"] + self.through_radio * own["pause_ticks"],
        }

"""No odometry error: social odometry with the true motion as odometry.

Gutierrez et al. 2008 (ANTS), Section 5: "robots communicate and are not affected by odometry
errors".

Not in the paper, and chosen here:
- robots that "know accurately" also measure each other exactly (`exact_beam`);
- all else is unchanged: messages are lost, and the weighting rule blends received estimates,
  although the own estimate has hardly any error;
- the weighting is that of local communication in ANTS: the Fermi filter with beta = 1e-3;
- pushed and blocked robots count their true motion, also in p;
- the frame of a robot is the world frame: this does not affect any layer.
"""

from dataclasses import replace

import numpy as np
from pydantic import Field

from baselines.estimators.area_memory import choose_goal, find_areas, notice_loss
from baselines.estimators.belief import Belief, SocialMind
from baselines.estimators.message_exchange import (
    accumulate_message,
    end_in_time,
    has_partner,
    slot_of,
)
from baselines.estimators.social_odometry import KERNELS, SocialOdometryParameters
from swarm_forage_env.arrays import NEST, PREY, Array, Float32, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.records import Heard, Readings
from swarm_forage_env.equations.differential_drive import path_length
from swarm_forage_env.equations.elementary import atan2, cos_sin, hypot
from swarm_forage_env.equations.geometry import range_and_bearing, wrap
from swarm_forage_env.foraging.control import observe_world as observe_all
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import EstimatorLayer, Kernel
from swarm_forage_env.record import Numbers, field
from swarm_forage_env.templates import row_template
from swarm_forage_env.ticks import Arrays


class ExactBelief(Belief):
    """Belief of a robot that knows its true pose."""

    true_pose: Float64[Array, "3"] = field(np.float64, 3, unit="m, m, rad")
    """True x, y [m] and heading [rad] in the world frame. Writer: `observe_truth`."""
    is_placed: bool = field(np.bool_)
    """Whether the estimated pose has been set to the true one, at the start."""
    beam: Float32[Array, "3"] = field(np.float32, 3, unit="m, rad, rad")
    """True range of the partner [m], its bearing and bearing back [rad]."""
    moved: Float32[Array, "2"] = field(np.float32, 2, unit="m, rad")
    """True motion of the last tick: distance, negative if backwards [m], and turn [rad]."""


class ExactMind(SocialMind):
    """Record of the estimator for one robot with perfect odometry."""

    belief: ExactBelief = field(ExactBelief)


@kernel
def follow(belief: ExactBelief, axle: float) -> None:
    """Move the estimated pose to the true one, and increase p by the path between them [m]."""
    pose, true_pose = belief.pose, belief.true_pose
    dx, dy = true_pose[0] - pose[0], true_pose[1] - pose[1]
    dtheta = wrap(true_pose[2] - pose[2])
    middle = pose[2] + 0.5 * dtheta
    drho = hypot(dx, dy)
    c, s = cos_sin(middle)
    if dx * c + dy * s < 0.0:
        drho = -drho
    belief.moved[0], belief.moved[1] = drho, dtheta
    belief.pose = true_pose
    dd = path_length(drho, dtheta, axle)
    belief.p[NEST] += dd
    belief.p[PREY] += dd


@kernel
def update_belief(mind: ExactMind, shared: Array, readings: Readings, numbers: Numbers) -> None:
    """Update a belief as social odometry does, with the true motion as odometry."""
    belief = mind.belief
    if not belief.is_placed:
        belief.pose = belief.true_pose
        belief.is_placed = True
    follow(belief, numbers.axle)
    find_areas(belief, readings.ground, numbers.to_centre)
    notice_loss(belief, belief.moved, numbers)
    choose_goal(belief)


@kernel
def update_exchange(minds: Array, i: int, heard: Heard, numbers: Numbers) -> bool:
    """Update an exchange as social odometry does, with the true beam."""
    if not has_partner(minds, i, heard, numbers):
        return False
    belief = minds[i].belief
    slot = slot_of(heard, belief.partner)
    if slot < heard.n:
        partner = minds[belief.partner]
        here, there = belief.true_pose, partner.belief.true_pose
        dx, dy = there[0] - here[0], there[1] - here[1]
        belief.beam[0], belief.beam[1] = range_and_bearing(dx, dy, here[2])
        belief.beam[2] = wrap(atan2(-dy, -dx) - there[2])
        weight = float(heard.n_averaged[slot])
        accumulate_message(belief, partner.message, belief.beam, weight, numbers.message_path)
    return end_in_time(belief, numbers)


@row_template
def observe_truth(world_arrays: Arrays, layer_arrays: Arrays, w: int, n_robots: int) -> None:
    """Write the true poses to the beliefs, then update these by readings and messages.

    Free names: those of observe_world.
    """
    robots, minds = world_arrays[0], layer_arrays[0]
    for i in range(n_robots):
        minds[w, i].belief.true_pose = robots[w, i].pose
    observe_all(world_arrays, layer_arrays, w, n_robots)


class PerfectOdometry(SocialOdometryParameters):
    """Social odometry of robots that know their poses: the odometry is exact."""

    mind = ExactMind

    exact_beam: bool = Field(
        True,
        description='Whether robots measure each other exactly, as they "know accurately"; false:'
        " with the radio's noise. ANTS 5 (derived)",
    )

    def layer(self, scenario: Scenario) -> EstimatorLayer:
        """Return the records and functions of the estimator, with its parameters in a scenario."""
        kernels: dict[str, Kernel] = {**KERNELS, "update_belief": update_belief}
        if self.exact_beam:
            kernels["update_exchange"] = update_exchange
        return replace(super().layer(scenario), kernels=kernels, observe=observe_truth)

"""Localisation: parameters common to all estimators of a pose.

Smith et al. 2021 (BOIDS), Section II.1. `setting` chooses between two readings of the paper:

- `authors`: the code behind its figures. Process noise and measurement noise are diagonals of
  standard deviations; home resets the estimate; the filter corrects only one of two robots, within
  limits; flocks align on positions.
- `corrected`: textbook noise, propagated by the Jacobians; home is a private measurement update;
  both robots are corrected; flocks align on velocities; the covariance stimulus has a scale that
  fits such covariances.

Not in the paper, and chosen here:
- the corrected filters treat a device's constant error as a part of its noise (the variances add
  up), as they have no measurement of it;
- what a neighbour estimates of a robot (x_i^j and P_i^j of Eq. 1 and 2) is the neighbour's estimate
  moved by range and bearing, with a heading from the bearings at which both see each other;
- the decentralised EKF uses range and body bearing (g of Eq. 16), both sightings of a pair one
  after the other, in the order of the robots; a cross-covariance too large for a covariance is
  shrunk (`bound_correlation`);
- dead reckoning (e of Eq. 30) is corrected at home as the filters are.
"""

from collections.abc import Mapping
from typing import ClassVar, Literal

from pydantic import Field

from baselines.estimators.pose_prediction import PoseMind
from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import cos_sin, hypot
from swarm_forage_env.equations.geometry import to_body
from swarm_forage_env.equations.steering import seek
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import EstimatorLayer, Kernel, WeightingLayer
from swarm_forage_env.parameters import Parameters, numbers_named
from swarm_forage_env.record import Numbers, Record
from swarm_forage_env.waypoints.control import observe_world
from swarm_forage_env.waypoints.records import Exchange, Readings
from swarm_forage_env.waypoints.scenario import WaypointsScenario

COVARIANCE_NORM_MAX = {"authors": 5.0, "corrected": 0.05}
"""Largest covariance norm allowed: 5 (published), or a hundredth for textbook noise (chosen)."""

OFFSET_MAX = 1.0  # largest distance allowed between the estimate and dead reckoning [m] (published)


@kernel
def describe_correction(minds: Array, i: int, sightings: Array, exchange: Exchange) -> None:
    """Describe the next correction of robot i, by the robots that it sees or that see it.

    `disagreement` is the distance from its estimate to the mean position that the latter measure.
    """
    n_robots, n, n_back, heard, x, y = minds.shape[0], 0, 0, 0.0, 0.0, 0.0
    for j in range(n_robots):
        back = sightings[j, i]
        if sightings[i, j].seen or back.seen:
            n += 1
            heard += minds[j].covariance_norm
        if back.seen:
            n_back += 1
            pose = minds[j].belief.pose
            direction = float(back.bearing) + pose[2]
            c, s = cos_sin(direction)
            x += pose[0] + float(back.range) * c
            y += pose[1] + float(back.range) * s
    exchange.is_valid = n > 0
    exchange.neighbours = n / n_robots
    exchange.own_covariance_norm = minds[i].covariance_norm
    exchange.heard_covariance_norm = heard / n if n > 0 else 0.0
    exchange.disagreement = 0.0
    if n_back > 0:
        own = minds[i].belief.pose
        exchange.disagreement = hypot(x / n_back - own[0], y / n_back - own[1])


@kernel
def away_from_one_by_one(
    minds: Array, i: int, sightings: Array, numbers: Numbers
) -> tuple[float, float]:
    """Return the separation as in the authors' code, which steers after each neighbour.

    After each neighbour, the sum is divided by their number so far and replaced by five times
    the unit vector of `seek`, so that the last neighbours have the largest weights.

    Source: BOIDS, authors' code.
    """
    own, x, y, dx, dy, n = minds[i].belief, 0.0, 0.0, 0.0, 0.0, 0
    for j in range(minds.shape[0]):
        if not sightings[i, j].seen:
            continue
        pose = minds[j].belief.pose
        ax, ay = own.pose[0] - pose[0], own.pose[1] - pose[1]
        d = hypot(ax, ay)
        if 0.0 < d < numbers.reach:
            n += 1
            x += ax / (d * d)
            y += ay / (d * d)
        if n > 0:
            dx, dy = x / n, y / n
            sx, sy = seek(dx, dy, own.velocity[0], own.velocity[1], numbers.max_speed)
            x, y = 5.0 * sx, 5.0 * sy
    return dx, dy


@kernel
def sum_neighbours(minds: Array, i: int, sightings: Array, reach: float) -> tuple[int, int]:
    """Write the means over the robots seen that are believed in reach; zeros if there are none.

    Returns the number of robots seen, and of those believed in reach.

    Source: BOIDS, Eq. 21 to 23.
    """
    own, means, n_seen, n = minds[i].belief.pose, minds[i].neighbours, 0, 0
    for k in range(2):
        means.position[k] = means.velocity[k] = means.away[k] = 0.0
    for j in range(minds.shape[0]):
        if not sightings[i, j].seen:
            continue
        n_seen += 1
        other = minds[j].belief
        if 0.0 < hypot(own[0] - other.pose[0], own[1] - other.pose[1]) < reach:
            n += 1
            for k in range(2):
                means.position[k] += other.pose[k]
                means.velocity[k] += other.velocity[k]
                means.away[k] += own[k] - other.pose[k]
    if n > 0:
        for k in range(2):
            means.position[k] /= n
            means.velocity[k] /= n
    return n_seen, n


@kernel
def turn_to_body(x: float, y: float, compass: float, out: Float32[Array, "2"]) -> None:
    """Rotate a vector from the world frame to the body frame."""
    out[0], out[1] = to_body(x, y, *cos_sin(compass))


@kernel
def describe_flock(minds: Array, i: int, sightings: Array, numbers: Numbers) -> None:
    """Write the vectors to the flock (centre, separation, alignment) and the density, rho.

    The alignment is the neighbours' mean velocity, the separation the sum of the displacements from
    them; in the authors' code, these are their mean position, and `away_from_one_by_one`.
    """
    mind, situation = minds[i], minds[i].situation
    n_seen, n = sum_neighbours(minds, i, sightings, numbers.reach)
    means, pose, compass = mind.neighbours, mind.belief.pose, mind.compass
    x, y = means.away[0], means.away[1]
    towards = means.velocity
    if numbers.authors > 0.0:
        x, y = away_from_one_by_one(minds, i, sightings, numbers)
        towards = means.position
    turn_to_body(x, y, compass, situation.separation)
    turn_to_body(towards[0], towards[1], compass, situation.alignment)
    x = y = 0.0
    if n > 0:
        x, y = means.position[0] - pose[0], means.position[1] - pose[1]
    turn_to_body(x, y, compass, situation.centre)
    situation.density = n_seen / minds.shape[0]


@kernel
def describe_self(mind: PoseMind, readings: Readings, numbers: Numbers) -> None:
    """Write the vectors to goal and home, the velocity, both stimuli, and whether it has arrived.

    Source: BOIDS, Eq. 29 and 30, for the stimuli.
    """
    situation, pose, goal = mind.situation, mind.belief.pose, readings.goal
    dx, dy, velocity = goal[0] - pose[0], goal[1] - pose[1], mind.belief.velocity
    turn_to_body(dx, dy, mind.compass, situation.goal)
    turn_to_body(-pose[0], -pose[1], mind.compass, situation.home)
    turn_to_body(velocity[0], velocity[1], mind.compass, situation.velocity)
    reckoned = mind.reckoned.pose
    offset = hypot(pose[0] - reckoned[0], pose[1] - reckoned[1])
    situation.covariance_norm = mind.covariance_norm / numbers.covariance_norm_max
    situation.dead_reckoning_offset = offset / numbers.offset_max
    situation.has_arrived = hypot(dx, dy) < numbers.tolerance


@kernel
def describe(minds: Array, i: int, sightings: Array, readings: Readings, numbers: Numbers) -> None:
    """Write the inputs of weighting and motion of one robot, from the present beliefs of all."""
    describe_correction(minds, i, sightings, minds[i].exchange)
    describe_flock(minds, i, sightings, numbers)
    describe_self(minds[i], readings, numbers)


@kernel
def full_correction(exchange: Exchange, area: int, numbers: Numbers) -> float:
    """Return the gain g = 1: every correction is made as the filter computes it.

    Source: BOIDS, Section II.1.
    """
    return 1.0


def waypoints_kernels(update_belief: Kernel, merge: Kernel) -> Mapping[str, Kernel]:
    """Return the functions bound to the free names of the waypoint tick."""
    return {"update_belief": update_belief, "describe": describe, "merge": merge}


class Localisation(Parameters):
    """Parameters of an estimator of a pose; a subclass is an estimator.

    Among e-pucks: Smith et al. 2021 (BOIDS), Section II.1, over Gutierrez et al. 2009 (TR),
    Section 5.

    Not in the papers, and chosen here:
    - an e-puck has neither compass nor map: it estimates the places of nest and prey area in its
      own frame, each with an error ellipse, and the area under it is its landmark;
    - neighbours exchange and merge estimates as in social odometry, one partner at a time;
    - with dead reckoning robots do not communicate;
    - covariance intersection merges two ellipses with the weight of the fast form for circles,
      p_i^2 / (p_i^2 + p_j^2);
    - the decentralised EKF keeps the cross-covariance of its own estimate and each partner's since
      their last exchange, in its own frame, and includes it in the gain. An exchange may end for
      one robot and break off for the other, so that each robot corrects only itself, without
      knowing the partner's own corrections in between.
    """

    tasks: ClassVar[tuple[str, ...]] = ("foraging", "waypoints")
    mind: ClassVar[type[Record]] = PoseMind
    kernels: ClassVar[Mapping[str, Kernel]]
    setting: Literal["authors", "corrected"] = Field(
        "corrected",
        description="Filters: those of the paper's figures (waypoints only), or of textbooks"
        " (chosen)",
    )

    def layer(self, scenario: Scenario | WaypointsScenario) -> EstimatorLayer:
        """Return the records and functions of the estimator, with its parameters in a scenario.

        Raises ConfigError for the authors' setting in a foraging scenario.
        """
        if isinstance(scenario, WaypointsScenario):
            return self.waypoints_layer(scenario)
        if self.setting != "corrected":
            raise ConfigError(
                f"setting='{self.setting}': is for robots that visit waypoints, not for"
                f" {scenario.name}; leave it out"
            )
        return self.foraging_layer(scenario)

    def waypoints_layer(self, scenario: WaypointsScenario) -> EstimatorLayer:
        """Return the layer for a waypoint scenario."""
        numbers, own = self.numbers(scenario), WeightingLayer(full_correction)
        return EstimatorLayer(self.mind, numbers, self.kernels, observe_world, own_weighting=own)

    def foraging_layer(self, scenario: Scenario) -> EstimatorLayer:
        """Return the layer for a foraging scenario."""
        raise NotImplementedError

    def numbers(self, scenario: WaypointsScenario) -> dict[str, float]:
        """Return the noise and limits of the scenario as parameters of the kernels."""
        sensors = scenario.sensors
        names = "speed_noise turn_noise range_noise bearing_noise reach max_speed tolerance"
        return {
            **numbers_named(scenario, names.split()),
            "authors": self.setting == "authors",
            "dt": scenario.tick,
            "var_speed": sensors.speed_noise**2 + sensors.speed_bias**2,
            "var_turn": sensors.turn_noise**2 + sensors.turn_bias**2,
            "home_variance": sensors.home_noise**2,
            "covariance_norm_max": COVARIANCE_NORM_MAX[self.setting],
            "offset_max": OFFSET_MAX,
        }

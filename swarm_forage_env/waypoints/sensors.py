"""Sensors of the waypoints world: wheels and gyro, the fix at home, and the LiDAR."""

from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.equations.geometry import range_and_bearing, wrap
from swarm_forage_env.equations.random_draws import normal
from swarm_forage_env.waypoints.records import ENCODER, LANDMARK, LIDAR, RobotState, WorldState


@kernel
def measure_motion(robot: RobotState) -> None:
    """What wheels and gyro say: truth, a constant error of the robot's own, and noise."""
    for k in range(2):
        noise = robot.deviation[k] * normal(robot.streams, ENCODER)
        robot.readings.motion[k] = robot.motion[k] + robot.bias[k] + noise


@kernel
def fix_at_home(robot: RobotState, world: WorldState) -> None:
    """Measure the pose, of robots within reach of home, the origin; zeros for others."""
    readings, pose = robot.readings, robot.pose
    readings.at_home = hypot(pose[0], pose[1]) < world.reach
    for k in range(3):
        readings.home_fix[k] = 0.0
        if readings.at_home:
            readings.home_fix[k] = pose[k] + world.home_noise * normal(robot.streams, LANDMARK)


@kernel
def read_goal(robot: RobotState) -> None:
    """The compass, and where to go next."""
    robot.readings.compass = robot.pose[2]
    for k in range(2):
        robot.readings.goal[k] = robot.goal[k]


@kernel
def see_each_other(swarm: Array, sightings: Array, world: WorldState) -> None:
    """Range and bearing from every robot to those that it measures within reach.

    Nobody beyond the reach by eight standard deviations of the range is measured at all.
    """
    farthest = world.reach + 8.0 * world.range_noise
    for i in range(swarm.shape[0]):
        pose, streams = swarm[i].pose, swarm[i].streams
        for j in range(swarm.shape[0]):
            sighting = sightings[i, j]
            sighting.seen, sighting.range, sighting.bearing = False, 0.0, 0.0
            dx, dy = swarm[j].pose[0] - pose[0], swarm[j].pose[1] - pose[1]
            if j == i or hypot(dx, dy) >= farthest:
                continue
            far, bearing = range_and_bearing(dx, dy, pose[2])
            far += world.range_noise * normal(streams, LIDAR)
            bearing = wrap(bearing + world.bearing_noise * normal(streams, LIDAR))
            if 0.0 < far < world.reach:
                sighting.seen, sighting.range, sighting.bearing = True, far, bearing

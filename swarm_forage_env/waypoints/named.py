"""The world of adaptive boids (Smith et al. 2021): waypoints-05, -10, -25, -50, each twice.

`waypoints-25` has the parameters stated in the paper; `waypoints-25-authors` has those behind its
figures: another gyro, another bearing noise, another tolerance.
"""

import math

from swarm_forage_env.registry import ORIGINS, SCENARIOS
from swarm_forage_env.waypoints.scenario import WaypointSensors, WaypointsScenario, WaypointTask

N_ROBOTS = (5, 10, 25, 50)
"""Swarm sizes: 0.05, 0.1, 0.25 and 0.5 robots per square metre (published)."""

AUTHORS_SENSORS = WaypointSensors(turn_noise=0.01, turn_bias=0.001, bearing_noise=math.radians(1.0))
"""Sensors with a better gyro than in Table 2, and a bearing noise of one degree (code)."""

AUTHORS_TOLERANCE = 0.15
"""Tolerance in all runs behind the figures but three: adaptive gains, 50 robots, 0.2 m (code)."""

AUTHORS_EXTRA_TICKS = 2
"""Extra ticks of the averages over time: sums over 200 ticks are divided by 202 (code)."""

for size in N_ROBOTS:
    stated = WaypointsScenario(name=f"waypoints-{size:02d}", task=WaypointTask(n_robots=size))
    ran = WaypointsScenario(
        name=f"waypoints-{size:02d}-authors",
        sensors=AUTHORS_SENSORS,
        task=WaypointTask(
            n_robots=size, tolerance=AUTHORS_TOLERANCE, extra_ticks=AUTHORS_EXTRA_TICKS
        ),
    )
    sensors = (f"sensors.{name}" for name in sorted(AUTHORS_SENSORS.model_fields_set))
    changed = *sensors, "task.tolerance", "task.extra_ticks"
    ORIGINS[ran.name] = dict.fromkeys(changed, "Runs behind the figures (code)")
    abouts = "parameters of the paper of 2021", "parameters of the authors' code"
    for scenario, how in zip((stated, ran), abouts, strict=True):
        SCENARIOS.register(scenario.name, f"robots visit goals; {how}")(scenario)

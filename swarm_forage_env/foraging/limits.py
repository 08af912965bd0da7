"""Limits of what the sensors of a scenario can read."""

from swarm_forage_env.foraging.scenario import Scenario

SLACK = 1.01
"""Room for the rounding to float32."""


def max_brightness(scenario: Scenario) -> float:
    """Reading of a ground sensor over white floor."""
    return SLACK * (1.0 + scenario.sensors.ground_noise)


def max_step(scenario: Scenario) -> float:
    """Path of a wheel in a tick, as its encoder reads it [m]; a worn encoder reads more."""
    robot, noise = scenario.robot, scenario.sensors.wheel_noise
    speed, worn = robot.max_speed, scenario.faults.worn
    if worn.is_any:
        speed, noise = speed * (1.0 + worn.bias), noise * max(worn.noise_factor, 1.0)
    return SLACK * (speed + noise * robot.cruise_speed) * scenario.tick


def max_turn(scenario: Scenario) -> float:
    """Turn in a tick, as the encoders read it [rad]."""
    return 2.0 * max_step(scenario) / scenario.robot.axle

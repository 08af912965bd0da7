"""Limits and noise of what the sensors of a scenario read."""

from swarm_forage_env.epuck.scenario import EpuckScenario

SLACK = 1.01
"""Room for the rounding to float32."""


def max_brightness(scenario: EpuckScenario) -> float:
    """Reading of a ground sensor over white floor."""
    return SLACK * (1.0 + scenario.sensors.ground_noise)


def max_step(scenario: EpuckScenario) -> float:
    """Path of a wheel in a tick, as its encoder reads it [m]; a worn encoder reads more."""
    robot, noise = scenario.robot, scenario.sensors.wheel_noise
    speed, worn = robot.max_speed, scenario.faults.worn
    if worn.is_any:
        speed, noise = speed * (1.0 + worn.bias), noise * max(worn.noise_factor, 1.0)
    return SLACK * (speed + noise * robot.cruise_speed) * scenario.tick


def max_turn(scenario: EpuckScenario) -> float:
    """Turn in a tick, as the encoders read it [rad]."""
    return 2.0 * max_step(scenario) / scenario.robot.axle


def odometry_noise(scenario: EpuckScenario) -> tuple[str, str]:
    """Error of distance and turn, in words."""
    robot = scenario.robot
    error = scenario.sensors.wheel_noise * robot.cruise_speed * scenario.tick
    return f"+- {error:.3g} m", f"+- {2.0 * error / robot.axle:.3g} rad"


def proximity_noise(scenario: EpuckScenario) -> str:
    """Error of a proximity sensor, in words."""
    return f"x (1 +- {scenario.sensors.proximity_noise:g})"


def ground_noise(scenario: EpuckScenario) -> str:
    """Error of a ground sensor, in words."""
    return f"x (1 +- {scenario.sensors.ground_noise:g})"


def range_noise(scenario: EpuckScenario) -> str:
    """How badly one frame measures the range, in words."""
    if scenario.radio.is_board:
        return "lognormal, as the real board, each frame"
    return f"+- {scenario.radio.range_noise:g} m, each frame"


def bearing_noise(scenario: EpuckScenario) -> str:
    """How badly one frame measures a bearing, in words."""
    return f"+- {scenario.radio.bearing_noise:.3g} rad, each frame"

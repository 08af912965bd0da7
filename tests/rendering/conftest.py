"""What the tests of the pictures share."""

import pytest

import baselines.controllers  # noqa: F401 the controllers, also where no package is installed
from swarm_forage_env.scenarios import find_scenario


@pytest.fixture(scope="session")
def busy():
    """An es1 of fast robots and near areas: trips and exchanges soon, whatever is calibrated."""
    numbers = {"robot.cruise_speed": 0.12, "task.area_distance": 0.7, "sensors.wheel_noise": 0.02}
    return find_scenario("es1", numbers)

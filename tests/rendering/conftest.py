"""What the tests of the pictures share."""

import subprocess
import sys

import pytest

import baselines.controllers  # noqa: F401 the controllers, also where no package is installed
from swarm_forage_env.scenarios import find_scenario


@pytest.fixture(scope="session")
def busy():
    """An es1 of fast robots and near areas: trips and exchanges soon, whatever is calibrated."""
    numbers = {"robot.cruise_speed": 0.12, "task.area_distance": 0.7, "sensors.wheel_noise": 0.02}
    return find_scenario("es1", numbers)


@pytest.fixture
def process_free_of_pygame():
    """Whether some lines import pygame, in a process of their own: the text that it prints."""

    def run(lines):
        code = f"import sys\nfrom swarm_forage_env import parallel_env\n{lines}\n"
        code += "print('pygame' in sys.modules)"
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, timeout=300
        )
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    return run

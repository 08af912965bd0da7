"""The setups of the papers, number by number: TR Table 2 and 6.1, ANTS 4.1."""

import math
import re

import pytest

from swarm_forage_env.epuck.parts import Arena, Radio, Robot, Sensors
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.scenario import Scenario, Task
from swarm_forage_env.parameters import Parameters
from swarm_forage_env.scenarios import find_scenario

TABLE = {
    #             length width robots duration start area range
    "es1": (1.7, 1.2, 10, 1800.0, 0.2, 0.1, 0.15),
    "es2": (4.25, 3.0, 50, 7200.0, 0.5, 0.1, 0.15),
    "es3": (8.5, 6.0, 100, 7200.0, 0.5, 0.1, 0.15),
    "real": (1.7, 1.2, 10, 1800.0, 0.2, 0.1, 0.15),
    "ants2008": (3.0, 3.0, 30, 3600.0, 0.5, 0.2, 0.25),
}

UNIT = r"\[(m|s|rad|m/s)\]"
DIMENSIONLESS = r"(?i)\b(share|lost|robots|frames|messages|reading x|board)\b"
ORIGIN = r"\b(published|derived|chosen)\b"


@pytest.mark.parametrize("name", TABLE)
def test_the_setup_is_the_published_one(name):
    scenario = find_scenario(name)
    arena, task = scenario.arena, scenario.task
    found = (arena.length, arena.width, task.n_robots, task.duration, task.start_radius,
             task.area_radius, scenario.radio.max_range)  # fmt: skip
    assert found == TABLE[name]
    assert scenario.name == name


@pytest.mark.parametrize("name", TABLE)
def test_robot_noise_and_loss_are_the_published_ones(name):
    scenario = find_scenario(name)
    robot, sensors, radio = scenario.robot, scenario.sensors, scenario.radio
    assert (robot.radius, robot.axle, robot.max_speed) == (0.035, 0.053, 0.129)
    assert (sensors.proximity_noise, sensors.ground_noise) == (0.2, 0.3)
    assert (sensors.ground_ahead, sensors.ground_spacing) == (0.03, 0.009)
    assert (radio.near, radio.loss_near, radio.loss_far) == (0.01, 0.01, 0.5)
    assert radio.bearing_noise == pytest.approx(math.radians(20.0))
    assert scenario.tick == 0.1
    assert scenario.n_ticks == round(10 * TABLE[name][3])
    assert find_scenario("es1", {"tick": 0.03}).n_ticks == 60_000
    with pytest.raises(ValueError, match="frozen"):
        scenario.radio.max_range = 1.0


def test_the_real_robots_differ_in_their_speed_and_in_what_an_exchange_takes_only():
    simulated, real = find_scenario("es1"), find_scenario("real")
    assert real.radio.is_board
    assert not simulated.radio.is_board
    longer = real.radio.exchange_time / simulated.radio.exchange_time
    assert 1.2 <= longer <= 1.3  # TR 6.2
    back = {"range_model": "uniform"} | simulated.radio.model_dump(
        include={"exchange_time", "frames"}
    )
    back["cruise_speed"] = simulated.robot.cruise_speed
    assert find_scenario(real, back | {"name": "es1"}) == simulated


@pytest.mark.parametrize("part", [Arena, Robot, Sensors, Radio, Task, Scenario])
def test_every_number_says_what_it_is_in_which_unit_and_where_it_comes_from(part):
    for name, field in part.model_fields.items():
        if name == "name" or isinstance(field.default, Parameters):
            continue
        text = field.description or ""
        assert re.search(UNIT, text) or re.search(DIMENSIONLESS, text), f"{name}: {text!r}"
        assert re.search(ORIGIN, text), f"{name}: {text!r}"


def test_a_text_that_is_no_scenario_is_refused():
    for wrong in (5, None, {"name": "es1"}):
        with pytest.raises(ConfigError, match="must be a name, a TOML file or a Scenario"):
            find_scenario(wrong)

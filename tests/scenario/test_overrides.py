"""Single numbers changed by name, and what happens to those that cannot be."""

import json
import math
from bisect import bisect_left

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.parameters import Parameters, leaves, override, resolve
from swarm_forage_env.scenarios import find_scenario


@pytest.mark.parametrize("name", ["radio.max_range", "max_range"])
@pytest.mark.parametrize("value", [0.2, "0.2"])
def test_a_number_is_changed_by_its_path_or_by_its_last_word(name, value):
    changed = find_scenario("es1", {name: value})
    assert changed.radio.max_range == 0.2
    assert changed.radio.slots == find_scenario("es1").radio.slots


def test_every_field_can_be_set_and_the_original_stays_as_it_was():
    before, other = find_scenario("es1").model_copy(deep=True), find_scenario("es2")
    assert find_scenario("es1", leaves(other.model_dump())) == other
    assert find_scenario("es1") == before
    for name in ("moving-prey", "mg1-square"):  # lists, as text
        values = leaves(find_scenario(name).model_dump(mode="json")).items()
        texts = {field: json.dumps(each) for field, each in values if isinstance(each, list)}
        assert find_scenario(name, texts) == find_scenario(name)


class Twin(Parameters):
    size: float = 1.0


class Two(Parameters):
    left: Twin = Twin()
    right: Twin = Twin()


def test_a_word_that_two_fields_end_in_is_refused_with_both():
    with pytest.raises(ConfigError, match=r"'size' is ambiguous; write left\.size or right\.size"):
        override(Two(), {"size": 2.0})
    assert override(Two(), {"left.size": 2.0}) == Two(left=Twin(size=2.0))


@pytest.mark.parametrize(
    ("what", "typo", "advice"),
    [
        ("scenario parameter", "radio.maxrange", "did you mean 'radio.max_range'"),
        ("scenario parameter", "max_rnge", "did you mean 'radio.max_range'"),
        ("scenario parameter", "sensor.wheel_noise", "did you mean 'sensors.wheel_noise'"),
        ("scenario parameter", "xyzzy", "known: arena"),
        ("scenario", "xyzzy", "known: agg"),
        ("scenario", "ES1", "did you mean 'es1'"),
        ("scenario", "SwarmForage/ES1-v2", "did you mean 'es1'"),
        ("scenario", "es1-v2", "did you mean 'es1'"),
    ],
)
def test_an_unknown_name_is_refused_with_the_nearest_or_all_known(what, typo, advice):
    with pytest.raises(UnknownNameError, match=f"^no {what} named '{typo}', {advice}"):
        find_scenario(typo) if what == "scenario" else find_scenario("es1", {typo: 1.0})


NUMBERS = [
    path
    for path, value in leaves(Scenario().model_dump()).items()
    if isinstance(value, int | float) and not isinstance(value, bool)
]


@pytest.mark.parametrize("path", NUMBERS)
@pytest.mark.parametrize(
    "value", [math.nan, math.inf, -math.inf, "nan", "-inf", -1.0, "many", None]
)
def test_no_number_may_be_negative_infinite_or_none_at_all(path, value):
    check_refused("es1", {path: value}, [f"{path}={value!r}: ", "must be"])


HUGE = {"length": 300.0, "width": 300.0, "start_radius": 100.0, "area_distance": 250.0,
        "max_range": 50.0}  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        ({"area_distance": 1.6}, ["=1.6", "1.7 x 1.2 m; area_distance may be at most 1.5"]),
        (
            {"area_radius": 10},
            ["radius 10.0", "1.2 m; area_distance", "area_radius at most 0.6 [m]"],
        ),
        ({"area_distance": 0.5}, ["task.area_distance=0.5", "start circle", "at least 0.6"]),
        ({"start_radius": 0.45, "area_distance": 1.0}, ["start circle of radius 0.45", "1.1"]),
        ({"arena.width": 0.4}, ["task.start_radius=0.2", "outside the arena", "at most 0.165"]),
        ({"n_robots": 500}, ["task.n_robots=500", "at most", "enlarge task.start_radius"]),
        ({"radius": 0.1}, ["task.n_robots=10", "at most", "radius 0.1"]),
        ({"cruise_speed": 0.2}, ["cruise_speed=0.2", "at most", "0.129"]),
        ({"near": 0.2}, ["near=0.2", "below max_range=0.15"]),
        ({"loss_near": 0.9}, ["loss_near=0.9", "at most loss_far=0.5"]),
        ({"range_model": "bord"}, ["radio.range_model='bord'", "'uniform' or 'board'"]),
        ({"duration": 0.01}, ["task.duration=0.01", "at least one tick of 0.1 s"]),
        ({"tick": 1e-308}, ["tick=1e-308", "greater than or equal to 0.001"]),
        ({"slots": 2**63}, [f"radio.slots={2**63}", "less than or equal to 10000"]),
        ({"radius": 1e-200}, ["robot.radius=1e-200", "greater than or equal to 0.001"]),
        ({"duration": 1e308}, ["task.duration=1e+308", "at most 1e+12"]),
        ({"duration": 1e9}, ["task.duration=1000000000.0", "at most 1e+08 s"]),
        ({"length": 2e5, "width": 2e5}, ["arena.length=200000.0", "at most 10000000 squares with"]),
        (HUGE | {"n_robots": 20_000}, ["task.n_robots=20000", "neighbours may be at most 1000000"]),
        ({"cruise_speed": 0.129, "tick": 0.5}, ["cruise_speed=0.129", "at most 0.105 [m/s]"]),
        ({"frames": 10**6}, ["radio.frames=1000000", "less than or equal to 10000"]),
        ({"max_range": -1, "n_robots": 0}, ["radio.max_range=-1", "; ", "task.n_robots=0"]),
    ],
)
def test_a_message_names_the_field_the_value_and_what_is_allowed(changes, parts):
    check_refused("es1", changes, parts)


def check_refused(scenario, changes, parts):
    """Assert that changes are refused in a line with these parts."""
    with pytest.raises(ConfigError) as error:
        find_scenario(scenario, changes)
    message = str(error.value)
    assert [part for part in parts if part not in message] == []
    assert "\n" not in message


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        ({"n_robots": 60_000}, ["task.n_robots=60000", "less than or equal to 2000"]),
        ({"tick": 1e-308}, ["tick=1e-308", "greater than or equal to 0.001"]),
        ({"duration": 1e12}, ["task.duration=1000000000000.0", "at most 5e+08 s"]),
        ({"duration": 0.1}, ["must be at least one tick"]),
        ({"tolerance": -0.1}, ["task.tolerance=-0.1"]),
        ({"min_speed": 0.6}, ["must be below max_speed=0.5"]),
        ({"first_goal": 5.0}, ["must be below half of side=10"]),
    ],
)
def test_a_limit_of_waypoints_is_told(changes, parts):
    check_refused("waypoints-05", changes, parts)


def test_the_bound_that_a_message_tells_is_accepted():
    assert find_scenario("es1", {"area_distance": 0.6}).task.area_distance == 0.6
    assert find_scenario("es1", {"start_radius": 0.565, "area_distance": 1.33})


def crowd(n_robots, start_radius, radius):
    """A scenario with so many robots in a start circle, None if it is refused."""
    changes = {"n_robots": n_robots, "start_radius": start_radius, "radius": radius,
               "length": 3.0, "width": 3.0, "area_distance": 2.0}  # fmt: skip
    try:
        return find_scenario("es1", changes)
    except ConfigError:
        return None


@settings(max_examples=50)
@given(st.integers(0, 1000), st.floats(0.2, 15.0), st.floats(0.005, 0.1))
def test_the_largest_swarm_that_is_not_refused_finds_room(seed, ratio, radius):
    start_radius = min(ratio * radius, 0.8)
    refused = bisect_left(range(1, 400), True, key=lambda n: not crowd(n, start_radius, radius))
    largest = range(1, 400)[refused - 1]
    world = ForagingWorld([crowd(largest, start_radius, radius)], [seed], "kinematic")
    assert world.n_robots == largest
    assert largest < 400


def test_a_whole_path_wins_over_a_last_word():
    assert resolve("tick", {"tick": 0, "inner.tick": 0}, "parameter") == "tick"


@pytest.mark.parametrize("name", ["ssgikf", "ssgiff:beta=0.1"])
def test_a_controller_in_the_place_of_a_scenario_is_told(name):
    with pytest.raises(ConfigError, match=f"is a controller, and .* first, as in `es1 {name}`"):
        find_scenario(name)

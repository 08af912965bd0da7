"""Numbers of a scenario are drawn anew for every episode, from the episode's seed alone."""

import numpy as np
import pytest
from scipy import stats

import swarm_forage_env.foraging.task  # noqa: F401 enters the task
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.randomise import MAX_TOGETHER, Randomisation
from swarm_forage_env.scenarios import find_scenario

ES1 = find_scenario("es1")
DISTANCE, FRAMES = {"task.area_distance": (0.8, 1.5)}, {"radio.frames": (1, 4)}


def drawn(ranges, seeds=range(2000)):
    """What is drawn for one name under many seeds."""
    (name,) = ranges
    return np.array([Randomisation(ES1, ranges).draw(seed)[1][name] for seed in seeds])


def test_the_scenario_has_the_numbers_that_are_told_and_its_others_as_before():
    scenario, numbers = Randomisation(ES1, {**DISTANCE, "frames": (1, 4)}).draw(7)
    assert list(numbers) == ["task.area_distance", "radio.frames"]
    assert scenario.task.area_distance == numbers["task.area_distance"]
    assert scenario.radio.frames == numbers["radio.frames"]
    back = {"area_distance": ES1.task.area_distance, "frames": ES1.radio.frames}
    assert find_scenario(scenario, back) == ES1


def test_one_seed_is_one_episode_whatever_was_drawn_before():
    draws = Randomisation(ES1, DISTANCE)
    first = [draws.draw(seed) for seed in (3, 4, 5)]
    assert [draws.draw(seed) for seed in (5, 4, 3)] == first[::-1]
    assert len({numbers["task.area_distance"] for _, numbers in first}) == 3


def test_what_is_drawn_for_a_name_does_not_depend_on_what_else_is_randomised():
    alone, other = Randomisation(ES1, DISTANCE), {"sensors.wheel_noise": (0.0, 0.2), **FRAMES}
    for ranges in ({**DISTANCE, **other}, {**other, **DISTANCE}):
        for seed in range(20):
            (name,) = DISTANCE
            together = Randomisation(ES1, ranges).draw(seed)[1]
            assert together[name] == alone.draw(seed)[1][name]


def test_draws_are_uniform_and_those_of_two_names_independent(believable):
    distance = drawn(DISTANCE)
    noise = drawn({"sensors.wheel_noise": (0.0, 0.2)})
    believable(stats.kstest(distance, "uniform", (0.8, 0.7)).pvalue)
    believable(stats.kstest(noise, "uniform", (0.0, 0.2)).pvalue)
    believable(stats.pearsonr(distance, noise).pvalue)
    believable(stats.pearsonr(distance[1:], distance[:-1]).pvalue)


def test_of_whole_numbers_both_ends_are_drawn_and_all_alike(believable):
    frames = drawn(FRAMES)
    assert frames.dtype.kind == "i"
    numbers, counts = np.unique(frames, return_counts=True)
    assert numbers.tolist() == [1, 2, 3, 4]
    believable(stats.chisquare(counts).pvalue)
    assert set(drawn({"task.area_distance": (0.9, 0.9)}, range(20))) == {0.9}


REFUSED = {
    "high below low": ({"task.area_distance": (1.5, 0.8)}, "low must be at most high"),
    "one number": ({"task.area_distance": 1.0}, "must be two numbers, low and high"),
    "text": ({"task.area_distance": ("0.8", "1.0")}, "must be two numbers"),
    "not a number": ({"task.area_distance": (float("nan"), 1.0)}, "low must be at most high"),
    "halves of frames": ({"radio.frames": (1.0, 2.5)}, "must be two whole numbers"),
    "a name": ({"name": (1, 2)}, "name='es1' is no number"),
    "how many robots": ({"n_robots": (5, 10)}, r"task\.n_robots determines the sizes"),
    "slots": ({"radio.slots": (1, 4)}, r"radio\.slots determines the sizes"),
    "a typo": ({"task.area_distanse": (0.8, 1.5)}, r"did you mean 'task\.area_distance'"),
    "one twice": ({**DISTANCE, "area_distance": (0.8, 0.9)}, "given twice, once as"),
    "low too low": (
        {"task.area_distance": (0.1, 1.5)},
        r"randomise, at task\.area_distance=0\.1: .* must be at least 0\.6",
    ),
    "high too high": ({"task.area_distance": (0.8, 2.0)}, r"at task\.area_distance=2\.0: "),
    "ends that fit alone and not together": (
        {"radio.near": (0.01, 0.12), "radio.max_range": (0.1, 0.3)},
        r"at radio\.near=0\.12, radio\.max_range=0\.1: near=0\.12: must be below",
    ),
    "infinite": ({"radio.max_range": (0.1, float("inf"))}, r"at radio\.max_range=inf: "),
}


@pytest.mark.parametrize(("ranges", "why"), REFUSED.values(), ids=REFUSED)
def test_what_is_no_range_of_the_scenario_is_refused_at_once(ranges, why):
    with pytest.raises((ConfigError, UnknownNameError), match=why):
        Randomisation(ES1, ranges)


def test_a_distance_of_areas_that_have_places_of_their_own_is_refused():
    text = r"task\.area_distance has no effect in 'two-prey', which uses task\.areas instead"
    with pytest.raises(ConfigError, match=text):
        Randomisation(find_scenario("two-prey"), DISTANCE)


def test_of_many_ranges_the_ends_are_tried_alone_and_all_together():
    names = ("proximity_noise", "ground_noise", "wheel_noise", "loss_near", "loss_far",
             "range_noise", "exchange_time", "ground_ahead", "cruise_speed")  # fmt: skip
    ranges = dict.fromkeys(names, (0.01, 0.02))
    assert len(ranges) > MAX_TOGETHER
    Randomisation(ES1, {**ranges, "loss_near": (0.0, 0.01)}).draw(1)
    with pytest.raises(ConfigError, match=r"loss_near=0\.02: must be at most"):
        Randomisation(ES1, {**ranges, "loss_near": (0.02, 0.02)})
    with pytest.raises(ConfigError, match=r"^randomise, at radio\.loss_far=0\.005: "):
        Randomisation(ES1, {**ranges, "loss_far": (0.005, 0.5)})


def test_waypoints_are_randomised_too():
    scenario, numbers = Randomisation(find_scenario("waypoints-05"), {"side": (6, 10)}).draw(3)
    assert 6.0 <= scenario.task.side == numbers["task.side"] <= 10.0
    assert isinstance(numbers["task.side"], float)

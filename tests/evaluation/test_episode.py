"""An episode: what it holds, and that it does not depend on its company."""

import numpy as np
import pytest

from swarm_forage_env.loop import Loop
from tests.evaluation.conftest import run


@pytest.mark.parametrize("physics", ["rigid", "kinematic"])
def test_an_episode_in_a_block_is_the_episode_alone(configure, physics):
    configuration = configure(physics=physics, task_duration=60.0)
    together = run(configuration, [5, 1, 2**64 - 1])
    assert together == [run(configuration, [seed])[0] for seed in (5, 1, 2**64 - 1)]


def test_an_episode_says_what_it_is_of(configuration):
    (episode,) = run(configuration, [7])
    assert (episode.scenario, episode.controller, episode.seed) == ("es1", "ssgikf", 7)
    assert (episode.physics, episode.n_robots, episode.duration_s) == ("kinematic", 10, 20.0)


def test_what_nobody_ever_knew_or_reached_is_missing(configure):
    (episode,) = run(configure(task_duration=1.0), [0])
    assert episode.recruitment_time_s is None
    assert episode.localisation_error_m is None
    assert episode.round_trips == 0


def test_the_localisation_error_is_sampled_once_a_second(configure):
    """The same mean, from the poses and beliefs themselves."""
    configuration = configure(task_duration=60.0)
    scenario = configuration.scenario
    loop = Loop(scenario, configuration.controller, [3], configuration.physics)
    errors = []
    for tick in range(1, scenario.n_ticks + 1):
        loop.step()
        if tick % 10 == 0:
            errors += believed_minus_true(loop)
    (episode,) = run(configuration, [3])
    assert errors
    assert episode.localisation_error_m == pytest.approx(np.mean(errors), rel=1e-6)


def believed_minus_true(loop):
    situation, truth = loop.situation, loop.world.areas
    for i, (x, y, heading) in enumerate(loop.world.state.pose):
        turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
        for area in np.flatnonzero(situation.known[i]):
            place = (x, y) + turn @ situation.areas[i, area]
            yield float(np.hypot(*(place - truth[area])))


def test_the_series_agree_with_the_numbers_at_the_end(configure):
    """On the path in each hundredth; the last robot recruited is the recruitment time."""
    (episode,) = run(configure(task_duration=600.0), [3])
    path = episode.on_path_over_time
    assert len(path) == 100
    assert path[0] == 0.0
    assert np.mean(path[50:]) == pytest.approx(episode.on_path_share, abs=0.03)
    assert sorted(episode.recruited_at_s) == list(episode.recruited_at_s)
    if len(episode.recruited_at_s) == episode.n_robots:
        assert episode.recruited_at_s[-1] == episode.recruitment_time_s
    else:
        assert episode.recruitment_time_s is None


def test_a_short_episode_has_a_sample_a_tick(configure):
    (episode,) = run(configure(task_duration=1.0), [3])
    assert episode.on_path_over_time == (0.0,) * 10

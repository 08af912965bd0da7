"""A named controller takes registered parts for its layers, and their parameters."""

import pytest

import baselines.controllers  # noqa: F401 enters the controllers
from baselines.estimators.covariance_intersection import CovarianceIntersection
from baselines.estimators.dead_reckoning import DeadReckoning
from baselines.estimators.decentralised_ekf import DecentralisedEKF
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario

BOIDS = CONTROLLERS["boids-adaptive"]


def test_a_layer_is_chosen_by_its_registered_name():
    chosen = BOIDS.with_parameters({"estimator": "covariance_intersection"})
    assert chosen.estimator == CovarianceIntersection()
    assert (chosen.weighting, chosen.motion) == (BOIDS.weighting, BOIDS.motion)
    assert CONTROLLERS["ssgikf"].with_parameters({"weighting": "sgiff"}).weighting.beta > 0.0


@pytest.mark.parametrize("names", [["estimator", "setting"], ["setting", "estimator"]])
def test_the_parameters_of_a_chosen_layer_can_be_named_in_any_order(names):
    values = {"estimator": "dead_reckoning", "setting": "authors"}
    chosen = BOIDS.with_parameters({name: values[name] for name in names})
    assert chosen.estimator == DeadReckoning(setting="authors")


def test_a_chosen_layer_keeps_the_parameters_that_both_have():
    authors = BOIDS.with_parameters({"setting": "authors"})
    assert authors.estimator == DecentralisedEKF(setting="authors")
    chosen = authors.with_parameters({"estimator": "covariance_intersection"})
    assert chosen.estimator == CovarianceIntersection(setting="authors")


def test_a_name_that_no_part_has_is_refused_with_the_nearest():
    with pytest.raises(UnknownNameError, match="did you mean 'dead_reckoning'"):
        BOIDS.with_parameters({"estimator": "dead_reckonning"})


def test_a_parameter_that_the_chosen_layer_has_not_is_refused():
    with pytest.raises(UnknownNameError, match="setting"):
        BOIDS.with_parameters({"estimator": "social_odometry", "setting": "authors"})


def test_who_reckons_alone_tells_nothing_to_weigh():
    assert BOIDS.talks
    assert not BOIDS.with_parameters({"estimator": "dead_reckoning"}).talks


@pytest.mark.parametrize("name", ["boids-goal", "boids-static", "boids-adaptive"])
def test_boids_run_on_both_tasks_and_subsumption_forages(name):
    waypoints, foraging = find_scenario("waypoints-05"), find_scenario("es1")
    assert CONTROLLERS[name].supports(waypoints)
    assert CONTROLLERS[name].supports(foraging)
    assert CONTROLLERS["subsumption"].supports(foraging)
    with pytest.raises(ConfigError, match="its motion is not made for the task waypoints"):
        CONTROLLERS["subsumption"].check_supports(waypoints)


def test_social_odometry_is_refused_where_robots_visit_waypoints():
    chosen = BOIDS.with_parameters({"estimator": "social_odometry"})
    with pytest.raises(ConfigError, match="its estimator is not made for the task waypoints"):
        chosen.check_supports(find_scenario("waypoints-05"))

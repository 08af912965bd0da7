"""PPO on the layers: it begins as subsumption, goes on after a kill, and keeps its best."""

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from numpy.testing import assert_array_equal

from swarm_forage_env.loop import Loop
from training import ppo
from training.actor_critic import MotionActor
from training.checkpoint import BEST_POLICY
from training.policy_file import load_policy, observation_layout
from training.ppo import clone_behaviour, record_demonstrations
from training.ppo_learner import PPOHyperparameters
from training.training_loop import ProgressLogger

BUSY = {"robot.cruise_speed": "0.12", "task.area_distance": "0.62"}

TALKATIVE = {"robot.max_speed": "0.4", "robot.cruise_speed": "0.4", "task.area_distance": "0.6",
             "radio.exchange_time": "0.1", "radio.max_range": "0.5"}  # fmt: skip
"""Robots find an area and tell of it within some 10 s."""

QUICK = PPOHyperparameters(decision_period=4, n_steps=8, n_epochs=1, n_minibatches=2)


@pytest.fixture(autouse=True)
def quick(monkeypatch, tmp_path):
    """Rollouts of a moment, and one epoch of cloning."""
    monkeypatch.chdir(tmp_path)
    every_tick = replace(QUICK, decision_period=1)
    hyperparameters = {"weighting": every_tick, "motion": QUICK, "both": every_tick}
    monkeypatch.setattr(ppo, "HYPERPARAMETERS", hyperparameters)
    monkeypatch.setattr("training.ppo.EPOCHS", 1)


@pytest.fixture
def motion(experiment):
    """A motion experiment of two intervals, in two scenarios."""

    def make(**changes):
        terms = {
            "layer": "motion",
            "algorithm": "ppo",
            "scenarios": ("es1", "es1:task.n_robots=6"),
            "population": None,
            "settings": BUSY | {"task.duration": "20"},
            "budget": 1024,
            "every": 512,
            "worlds": 2,
        }
        return experiment(**terms | changes)

    return make


def silent(_):
    """Say nothing."""


def parameters(folder):
    return load_policy(folder / "latest.safetensors").weights


def test_a_run_keeps_its_best_with_a_card_that_tells_its_curve(motion):
    said = []
    experiment = motion()
    policy = ppo.train(experiment, said.append)
    card = policy.card
    assert card.layer == "motion"
    assert card.curve[0].step == 0
    assert card.score.keys() == set(experiment.scenarios)
    assert any("copied" in line for line in said)
    assert any("robot steps/s" in line for line in said)
    assert list((experiment.out / "tensorboard").iterdir())
    last = ppo.PPOTraining(experiment).curve
    assert [point.step for point in last] == [0, 704, 1408]  # 22 robots, 8 decisions of 4 ticks
    simulated = [point.simulated_s for point in last]
    assert simulated == pytest.approx([0.0, 9.6, 19.2])  # 32 ticks of 0.1 s in three worlds
    assert [point.value for point in card.curve] == [point.value for point in last]
    best = max(last, key=lambda point: point.value)
    assert card.score == best.round_trips


def test_a_finished_run_writes_its_best_again(motion):
    experiment = motion()
    first = ppo.train(experiment, silent)
    first.source.unlink()
    again = ppo.train(experiment, silent)
    for name, array in first.weights.items():
        assert_array_equal(again.weights[name], array)
    assert again.card.score == first.card.score


def test_a_stopped_run_ends_where_it_would_have_ended(motion, tmp_path):
    whole = motion(out=tmp_path / "whole")
    ppo.train(whole, silent)
    stopped = motion(out=tmp_path / "stopped")
    with ProgressLogger(stopped.out, "robot step", silent) as progress:
        training = ppo.PPOTraining(stopped)
        training.warm_start()
        training.evaluate()
        training.advance(progress)
        training.evaluate()
        training.advance(progress)  # lost, as nothing was kept after it
    ppo.train(stopped, silent)
    expected, found = parameters(whole.out), parameters(stopped.out)
    assert expected.keys() == found.keys()
    for name, array in expected.items():
        assert_array_equal(found[name], array)


def test_the_first_interval_of_a_motion_trains_the_critic_alone(motion, tmp_path):
    experiment = motion(out=tmp_path / "run")
    with ProgressLogger(experiment.out, "robot step", silent) as progress:
        training = ppo.PPOTraining(experiment)
        training.warm_start()
        steps = []
        for _ in range(3):
            training.evaluate()
            steps.append(parameters(experiment.out))
            critic = training._policy.critic.state_dict()
            steps[-1]["critic"] = critic["value.weight"].numpy().copy()
            training.advance(progress)
    changed = [{name for name in a if (a[name] != b[name]).any()} for a, b in pairwise(steps)]
    assert changed[0] == {"critic"}
    assert {"critic", "motion.wheels.weight", "motion.first.weight"} <= changed[1]


def test_both_layers_are_trained_once_the_critic_is(motion, tmp_path, monkeypatch):
    rollout = 120 * 2 * 10
    longer = replace(QUICK, decision_period=1, n_steps=120, n_epochs=3)
    monkeypatch.setattr(ppo, "HYPERPARAMETERS", {"both": longer})
    monkeypatch.setattr(ppo, "run_episodes", lambda *_: [SimpleNamespace(round_trips=1)] * 2)
    terms = {"scenarios": ("es1",), "budget": 3 * rollout, "every": rollout}
    experiment = motion(layer="both", out=tmp_path / "both", settings=TALKATIVE, **terms)
    training, kept, rates = ppo.PPOTraining(experiment), [], []
    with ProgressLogger(experiment.out, "robot step", silent) as progress:
        training.warm_start()
        training.evaluate()
        for _ in range(2):
            kept.append(parameters(experiment.out))
            training.advance(progress)
            rates += [group["lr"] for group in training._learner._optimizer.param_groups]
            training.evaluate()
    start, waited = kept
    end = parameters(experiment.out)
    assert {name.partition(".")[0] for name in end} == {"motion", "weighting"}
    for name, array in end.items():
        assert_array_equal(waited[name], start[name])
        assert np.isfinite(array).all()
        assert (array != start[name]).any(), name
    assert [point.step for point in training.curve] == [0, rollout, 2 * rollout]
    rate = QUICK.learning_rate
    assert rates == pytest.approx([rate, rate * 2 / 3]), "it falls with what is left to do"


@pytest.mark.parametrize("met", [True, False])
def test_a_weighting_learns_from_exchanges_of_areas_that_both_know(motion, tmp_path, met):
    experiment = motion(layer="weighting", out=tmp_path / "weighting", scenarios=("es1",))
    training = ppo.PPOTraining(experiment)
    training._set_trainable(learn=True)
    policy = training._policy
    actor = training._actors["weighting"]
    torch.manual_seed(0)
    torch.nn.init.normal_(actor.arrays["output.weight"])  # it starts at zero
    observed = torch.rand(50, *training._env.observation_space.shape) + 0.1
    for each in ("own_known", "heard_known"):
        observed[:, actor._columns[each]] = float(met)
    with torch.no_grad():
        actions, *_ = policy(observed)
    values, log_prob, _ = policy.evaluate_actions(observed, actions)
    (log_prob.mean() + values.mean()).backward()
    for name, array in actor.arrays.items():
        assert bool((array.grad != 0.0).any()) == met, name


def test_the_policy_that_is_kept_is_the_best_one(motion, tmp_path, monkeypatch):
    scores = iter([[5, 6], [6, 7], [9, 9], [9, 9]])
    monkeypatch.setattr(
        ppo, "run_episodes", lambda *_: [SimpleNamespace(round_trips=n) for n in next(scores)]
    )
    experiment = motion(out=tmp_path / "run", scenarios=("es1",), budget=4000)
    training, latest = ppo.PPOTraining(experiment), []
    with ProgressLogger(experiment.out, "robot step", silent) as progress:
        for _ in range(4):
            training.evaluate()
            latest.append(parameters(experiment.out))
            training.advance(progress)
    best = load_policy(experiment.out / BEST_POLICY)
    assert [point.round_trips["es1"].mean for point in best.card.curve] == [5.5, 6.5, 9.0, 9.0]
    assert best.card.score["es1"].mean == 9.0
    for name, array in best.weights.items():
        assert_array_equal(array, latest[2][name])
    for other in (latest[1], latest[3]):
        assert any((best.weights[name] != other[name]).any() for name in best.weights)


def test_a_copy_does_what_it_was_shown(motion, monkeypatch):
    monkeypatch.setattr("training.ppo.EPOCHS", 10)
    experiment = motion()
    scenario = experiment.scenarios_by_name["es1"]
    layout = observation_layout("motion", scenario)
    loop = Loop(scenario, experiment.base_controller, range(20), "kinematic")
    pairs = record_demonstrations(loop, layout)
    observed, wheels = pairs
    assert not wheels[layout.records(observed)["situation"].is_talking > 0].any()
    torch.manual_seed(0)
    actor = MotionActor(layout)
    before = clone_behaviour(actor, [pairs])
    assert clone_behaviour(actor, [pairs]) < min(before, 0.5 * np.mean(wheels**2))


def test_the_hyperparameters_reach_worlds_and_policy(motion):
    terms = {"decision_period": 3, "discount": 0.9, "shaping": 0.5}
    experiment = motion(worlds=4)
    env = ppo.make_env(experiment, PPOHyperparameters(**terms))
    assert [(each.n_worlds, each.world.n_robots) for each in env.blocks] == [(2, 10), (4, 6)]
    config = env.blocks[0].config
    for name, wanted in {**terms, "learn": "motion", "action": "wheels", "normalise": False,
                         "physics": "kinematic"}.items():  # fmt: skip
        assert getattr(config, name) == wanted
    policy = ppo.PPOTraining(experiment)._policy
    assert policy.log_std.tolist() == pytest.approx([QUICK.log_std] * 2)

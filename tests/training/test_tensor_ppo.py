"""PPO in tensors on a CPU: the rows are those of SB3, and so is what is learned from them."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose, assert_array_equal
from stable_baselines3.common.utils import set_random_seed

from swarm_forage_env import ArrayEnv, ConfigError
from training import tensor_ppo
from training.actor_critic import LayerActorCriticPolicy
from training.sb3_setup import PPOHyperparameters, SB3Learner, env_options, model_state
from training.tensor_ppo import Rollout, TensorPPO, advantages
from training.tensor_rows import TensorRows
from training.vec_env import SwarmVecEnv

BUSY = {"robot.cruise_speed": "0.12", "task.area_distance": "0.62", "task.duration": "4"}

ONE_BATCH = PPOHyperparameters(decision_period=4, n_steps=12, n_epochs=2, n_minibatches=1)
"""One minibatch, so that the order of its rows does not count; episodes of ten decisions."""

FAST = {"physics": "kinematic", "task.n_robots": 4, "max_cycles": 6}


@pytest.fixture
def run(experiment, tmp_path):
    """An experiment of two worlds in which episodes end within a rollout."""

    def make(layer="motion"):
        return experiment(
            layer=layer, algorithm="ppo", population=None, settings=BUSY, worlds=2,
            controller="ssgiff", out=tmp_path,
        )  # fmt: skip

    return make


def rows_of(experiment, terms):
    """The rows of an experiment on a CPU."""
    scenario = experiment.scenarios_by_name["es1"]
    return TensorRows([ArrayEnv(scenario, n_worlds=2, **env_options(experiment, terms))])


def learner_of(experiment, terms):
    """PPO in tensors on those rows, with the networks of the layers."""
    set_random_seed(experiment.seed)
    rows = rows_of(experiment, terms)
    policy = LayerActorCriticPolicy(
        rows.observation_space, rows.action_space, lambda _: 4e-4, log_std_init=terms.log_std,
        layout=rows.observation_layout, layers=experiment.layers,
    )  # fmt: skip
    return TensorPPO(rows, policy, terms)


def both_learned(experiment, terms):
    """What SB3 and PPO in tensors know after one call of `learn`, from the same start."""
    theirs = SB3Learner(experiment, terms)
    own = learner_of(experiment, terms)
    begin = model_state(own)
    for name, array in model_state(theirs).items():
        assert_array_equal(begin[name], array, err_msg=name)
    for learner in (theirs, own):
        learner.learn(20, 4e-4, seed=5)
    return begin, model_state(theirs), model_state(own)


@pytest.mark.parametrize("layer", ["motion", "weighting", "both"])
def test_an_update_is_that_of_stable_baselines3(run, layer):
    begin, theirs, own = both_learned(run(layer), ONE_BATCH)
    assert any(not np.array_equal(begin[name], own[name]) for name in begin if "actors" in name)
    for name, array in theirs.items():
        assert_allclose(own[name], array, rtol=1e-4, atol=1e-6, err_msg=name)


def test_a_row_goes_through_what_it_goes_through_under_sb3():
    env = SwarmVecEnv("es1", n_worlds=2, seed=3, stagger=True, **FAST)
    rows = TensorRows([ArrayEnv("es1", n_worlds=2, stagger=True, **FAST)])
    rows.seed(3)
    assert_array_equal(rows.reset(), env.reset())
    rng, ends = np.random.default_rng(0), []
    for _ in range(8):
        actions = rng.uniform(-1.0, 1.0, (8, 2)).astype(np.float32)
        seen, rewards, dones, infos = env.step(actions)
        step = rows.step(torch.from_numpy(actions))
        assert_array_equal(step.seen, seen)
        assert_array_equal(step.rewards, rewards)
        assert_array_equal(step.over, np.flatnonzero(dones))
        for row in step.over.tolist():
            assert_array_equal(step.final[row], infos[row]["terminal_observation"])
        ends.append(len(step.over))
    assert ends == [0, 0, 4, 0, 0, 4, 0, 0]


def test_blocks_of_several_scenarios_are_joined():
    terms = [{"n_worlds": 2, "task.n_robots": 6}, {"n_worlds": 1, "task.n_robots": 10}]
    blocks = [ArrayEnv("es1", **{**FAST, **each}) for each in terms]
    rows = TensorRows(blocks)
    rows.seed(0)
    assert rows.reset().shape == (22, len(rows.observation_layout))
    assert rows.step(torch.zeros(22, 2)).rewards.shape == (22,)
    with pytest.raises(ConfigError, match="nan"):
        rows.step(torch.full((22, 2), float("nan")))


def test_the_advantages_of_a_rollout_by_hand():
    one = torch.ones(3, 1)
    begins = torch.tensor([[1.0], [0.0], [1.0], [0.0]])
    rollout = Rollout(one, one, one, torch.full((4, 1), 2.0), one, begins)
    # The last: 1 + 0.5 x 2 - 2 = 0. The second ends an episode: 1 - 2. The first: 0 + 0.25 x -1.
    assert advantages(rollout, 0.5, 0.5).flatten().tolist() == [-0.25, -1.0, 0.0]


def test_many_rows_make_short_rollouts_of_many_minibatches(run, monkeypatch):
    learner = learner_of(run(), ONE_BATCH)
    assert learner.n_steps == 12
    monkeypatch.setattr(tensor_ppo, "ROLLOUT", 100)
    monkeypatch.setattr(tensor_ppo, "FEWEST_STEPS", 3)
    monkeypatch.setattr(tensor_ppo, "MINIBATCH", 20)
    assert learner.n_steps == 5  # of 20 rows
    sizes = []
    evaluate = learner.policy.evaluate_actions
    monkeypatch.setattr(
        learner.policy,
        "evaluate_actions",
        lambda seen, actions: sizes.append(len(seen)) or evaluate(seen, actions),
    )
    learner.learn(1, 1e-4, seed=0)
    assert sizes == [20] * 5 * ONE_BATCH.n_epochs


def test_worlds_go_on_from_one_call_to_the_next(run):
    terms = replace(ONE_BATCH, n_steps=4)
    learner = learner_of(run(), terms)
    steps = []
    for _ in range(3):
        learner.learn(1, 1e-4, seed=0)
        steps.append(learner.rows.blocks[0].episodes.steps.tolist())
    assert steps == [[4, 4], [8, 8], [2, 2]]
    assert learner.num_timesteps == 3 * 4 * 20
    learner.learn(4 * 20, 1e-4, seed=0)  # as many as one rollout has
    assert learner.num_timesteps == 4 * 4 * 20


def test_choices_are_refused():
    rows = TensorRows([ArrayEnv("es1", discrete=True, **FAST)])
    rows.seed(0)
    rows.reset()
    assert rows.step(torch.zeros(4, dtype=torch.int64)).rewards.shape == (4,)
    with pytest.raises(ConfigError, match="discrete: PPO in tensors gives numbers"):
        TensorPPO(rows, None, ONE_BATCH)


def test_a_policy_acts_in_the_mode_of_use_and_is_updated_in_that_of_training(run, monkeypatch):
    learner, modes = learner_of(run(), replace(ONE_BATCH, n_steps=2)), []
    monkeypatch.setattr(learner.policy, "set_training_mode", modes.append)
    learner.learn(1, 1e-4, seed=0)
    assert modes == [False, True]


def test_worlds_that_go_on_are_kept_with_what_was_seen_last(run):
    terms = replace(ONE_BATCH, n_steps=4)
    first, second = (learner_of(run(), terms) for _ in range(2))
    taken = []
    for each in (first, second):
        each.rows.records = lambda: {"0.a": np.array(3)}
        each.rows.take_records = taken.append
    start = first.worlds_state()
    assert not start["has_begun"]
    assert_array_equal(start["seen"], np.zeros((20, len(first.observation_layout))))
    second.restore_worlds(start)
    assert (second._seen, taken) == (None, [])
    first.learn(1, 1e-4, seed=0)
    kept = first.worlds_state()
    second.restore_worlds(kept)
    assert taken == [kept]
    assert kept["0.a"] == 3
    assert_array_equal(second._seen, first._seen)
    assert_array_equal(second._begins, first._begins)


def test_episodes_of_an_experiment_in_tensors_end_one_after_the_other(experiment, tmp_path):
    mine = experiment(layer="motion", algorithm="ppo", population=None, worlds=3, out=tmp_path)
    learner = tensor_ppo.make_tensor_ppo(mine, replace(ONE_BATCH, log_std=-0.75))
    (block,) = learner.rows.blocks
    learner.rows.seed(0)
    learner.rows.reset()
    assert block.episodes.ends.tolist() == [50, 100, 150]  # 60 s of decisions of four ticks
    assert learner.policy.log_std.tolist() == [-0.75, -0.75]
    assert learner.num_timesteps == 0

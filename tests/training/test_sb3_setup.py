"""What stable-baselines3's PPO is told of an experiment, what it logs, and its kept state."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from swarm_forage_env import ArrayEnv
from training import multi_scenario_vec_env, tensor_rows
from training.multi_scenario_vec_env import MultiScenarioVecEnv
from training.sb3_setup import (
    Curves,
    PPOHyperparameters,
    SB3Learner,
    env_options,
    model_state,
    restore_model,
)
from training.tensor_rows import TensorRows

TERMS = PPOHyperparameters(
    decision_period=3, discount=0.9, gae_lambda=0.8, shaping=0.5, n_steps=6, n_minibatches=3,
    n_epochs=5, learning_rate=0.25, log_std=-0.5,
)  # fmt: skip


def test_the_hyperparameters_reach_worlds_and_learner(experiment, tmp_path):
    mine = experiment(layer="motion", algorithm="ppo", population=None, seed=3, out=tmp_path)
    assert env_options(mine, TERMS) == {
        "controller": mine.base_controller, "learn": "motion", "action": "wheels",
        "normalise": False, "physics": "kinematic", "decision_period": 3, "discount": 0.9,
        "shaping": 0.5,
    }  # fmt: skip
    learner = SB3Learner(mine, TERMS)
    model = learner._model
    assert (model.n_steps, model.n_epochs, model.batch_size) == (6, 5, 6 * 10 // 3)
    assert (model.gamma, model.gae_lambda, model.learning_rate) == (0.9, 0.8, 0.25)
    assert (model.seed, str(model.device)) == (3, "cpu")
    assert model.policy.log_std.tolist() == [-0.5, -0.5]
    assert (learner.num_timesteps, learner.n_rows, learner.stepping_s) == (0, 10, 0.0)
    assert list((tmp_path / "tensorboard").iterdir())


def test_numbers_that_are_not_kept_from_tensorboard_are_its_curves(tmp_path):
    curves = Curves(tmp_path)
    told = {"loss": 0.5, "count": 3, "mean": np.float32(2.0), "name": "text", "hidden": 1.0}
    excluded = {**dict.fromkeys(told, ()), "count": None, "hidden": ("tensorboard",)}
    curves.write(told, excluded, 7)
    curves.write({"loss": 0.25}, {"loss": ("stdout",)})
    curves.close()
    read = EventAccumulator(str(tmp_path)).Reload()
    found = {
        name: sorted((each.step, each.value) for each in read.Scalars(name))
        for name in read.Tags()["scalars"]
    }
    assert found == {"loss": [(0, 0.25), (7, 0.5)], "count": [(7, 3.0)], "mean": [(7, 2.0)]}


class Learner:
    """One number that is learned."""

    def __init__(self):
        self.policy = torch.nn.Linear(1, 1, bias=False)
        torch.nn.init.constant_(self.policy.weight, 1.0)
        self.policy.optimizer = torch.optim.Adam(self.policy.parameters(), 0.1)
        self.num_timesteps = 5

    def step(self, slope):
        self.policy.optimizer.zero_grad()
        (slope * self.policy.weight).sum().backward()
        self.policy.optimizer.step()


@pytest.mark.parametrize("n_steps", [0, 1, 2])
def test_a_restored_learner_goes_on_as_the_first_after_any_number_of_steps(n_steps):
    first, second = Learner(), Learner()
    for _ in range(n_steps):
        first.step(1.0)
    kept = model_state(first)
    assert kept["policy.weight"].shape == kept["exp_avg.weight"].shape == (1, 1)
    assert (kept["step.weight"].shape, float(kept["step.weight"])) == ((), n_steps)
    first.num_timesteps = 9
    restore_model(second, kept)
    assert second.num_timesteps == 5
    for slope in (-3.0, 0.5):
        first.step(slope)
        second.step(slope)
        assert second.policy.weight.item() == first.policy.weight.item()


class Rows:
    """An environment of so many rows, whose every number is the same."""

    def __init__(self, n, fill, clock=None):
        self.num_envs, self.fill, self.clock = n, fill, clock
        self.observation_layout = self.observation_space = self.action_space = fill

    def seed(self, seed):
        return [seed] * self.num_envs

    def reset(self):
        self.clock.seconds += 2.0
        self.reset_infos = [self.fill] * self.num_envs
        return np.full((self.num_envs, 1), self.fill)

    def step_async(self, actions):
        self.actions = actions

    def step_wait(self):
        self.clock.seconds += 3.0
        row = np.full(self.num_envs, self.fill)
        return row[:, None], row, row > 2, [self.fill] * self.num_envs


def test_environments_of_several_scenarios_are_one_and_their_time_is_counted(monkeypatch):
    clock = SimpleNamespace(seconds=100.0)
    timer = SimpleNamespace(perf_counter=lambda: clock.seconds)
    monkeypatch.setattr(multi_scenario_vec_env, "time", timer)
    blocks = [Rows(n, k, clock) for k, n in enumerate((2, 1, 3), 1)]
    env = MultiScenarioVecEnv(blocks)
    assert (env.num_envs, env.stepping_s) == (6, 0.0)
    assert (env.observation_layout, env.observation_space, env.action_space) == (1, 1, 1)
    assert env.seed(4) == [4] * 6
    assert env.reset().ravel().tolist() == [1, 1, 2, 3, 3, 3]
    assert env.reset_infos == [1, 1, 2, 3, 3, 3]
    assert env.stepping_s == 6.0
    env.step_async(np.arange(6))
    assert [each.actions.tolist() for each in blocks] == [[0, 1], [2], [3, 4, 5]]
    observed, rewards, done, infos = env.step_wait()
    assert observed.ravel().tolist() == rewards.tolist() == infos == [1, 1, 2, 3, 3, 3]
    assert done.tolist() == [False] * 3 + [True] * 3
    assert env.stepping_s == 15.0


def test_the_time_of_rows_in_tensors_is_counted_and_their_records_have_a_block_each(monkeypatch):
    seconds = iter((5.0, 9.0))
    timer = SimpleNamespace(perf_counter=lambda: next(seconds))
    monkeypatch.setattr(tensor_rows, "time", timer)
    rows = TensorRows([ArrayEnv("es1", n_worlds=n, physics="kinematic") for n in (1, 2)])
    assert rows.stepping_s == 0.0
    rows.reset()
    rows.step(torch.zeros(rows.n_rows, 2))
    assert rows.stepping_s == 4.0
    taken = {}
    rows.blocks = [
        SimpleNamespace(records=lambda k=k: {"a": k, "b": 10 * k},
                        take_records=lambda own, k=k: taken.update({k: own}))
        for k in (1, 2)
    ]  # fmt: skip
    kept = rows.records()
    assert kept == {"0.a": 1, "0.b": 10, "1.a": 2, "1.b": 20}
    rows.take_records({**kept, "seen": 5})
    assert taken == {1: {"a": 1, "b": 10}, 2: {"a": 2, "b": 20}}

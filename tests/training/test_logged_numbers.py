"""What each algorithm logs of a step, worked by hand: its speeds, and what it learned from."""

import errno
import os
import socket
import sys
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from swarm_forage_env.errors import ConfigError
from training import cma_es, dagger, ppo, training_loop
from training.checkpoint import LOCK, lock_folder
from training.cma_es import CMAESTraining
from training.dagger import DAggerTraining
from training.experiment import step_seed
from training.ppo import PPOTraining
from training.ppo_learner import PPOHyperparameters

TICKS = {"a": SimpleNamespace(n_ticks=10, tick=0.5), "b": SimpleNamespace(n_ticks=100, tick=0.1)}
"""Two scenarios: episodes of 5 s and of 10 s."""


@pytest.fixture
def clock(monkeypatch):
    """Four seconds pass between two looks at the clock."""
    for module in (cma_es, dagger, ppo):
        times = iter((1000.0, 1004.0))
        monkeypatch.setattr(
            module, "time", SimpleNamespace(perf_counter=lambda times=times: next(times))
        )


class Logged:
    """What is logged, by step."""

    def __init__(self):
        self.steps = {}

    def log_scalars(self, step, values):
        self.steps[step] = values


def test_a_round_of_imitation_logs_its_shares_and_speeds(monkeypatch, clock):
    training, log, saved = DAggerTraining.__new__(DAggerTraining), Logged(), []
    training._n_worlds, training._scenarios, training._rounds = {"a": 3, "b": 1}, TICKS, 2
    monkeypatch.setattr(DAggerTraining, "_exchanges", lambda self: "exchanges")
    monkeypatch.setattr(
        DAggerTraining, "_fit", lambda self, found: {"a": 0.25, "b": 0.5} if found else {}
    )
    monkeypatch.setattr(DAggerTraining, "_save", lambda self: saved.append(self.done))
    told = training.advance(log)
    assert told == "round 3: gain per exchange as a share of the oracle's: a 25%, b 50%"
    # A round simulates 3 x 5 s and 1 x 10 s.
    assert log.steps == {3: {"share/a": 0.25, "share/b": 0.5, "speed/episodes_per_s": 1.0,
                             "speed/simulated_s_per_s": 6.25}}  # fmt: skip
    assert saved == [3]
    assert training._simulated_s == 75.0


def test_a_generation_logs_its_values_its_spread_and_its_speeds(monkeypatch, clock):
    training, log = CMAESTraining.__new__(CMAESTraining), Logged()
    seeds, told, kept, reseeded = [], [], [], []
    population = np.array([[1.0, 2.0], [3.0, 2.0], [5.0, 8.0]], np.float32)
    asked = iter(population)
    training._experiment = SimpleNamespace(
        seed=7, worlds=4, training_seeds=lambda first, n: seeds.append((first, n))
    )
    training._search = SimpleNamespace(
        population_size=3, ask=lambda: next(asked), reseed_rng=reseeded.append
    )
    training._rollouts = SimpleNamespace(
        scenarios=TICKS, simulated_s=lambda worlds: 15.0 * worlds,
        round_trips=lambda networks, seeds: {"a": np.array([[0, 0], [1, 1], [3, 3]])},
    )  # fmt: skip
    training._populations = np.zeros((5, 3, 2), np.float32)
    training._losses = np.zeros((5, 3))
    monkeypatch.setattr(CMAESTraining, "_save", lambda self: kept.append(self._losses[-1]))
    monkeypatch.setattr(CMAESTraining, "_tell", lambda self, *given: told.append(given))
    training.advance(log)
    assert seeds == [(20, 4)]
    assert reseeded == [step_seed(7, 5)]
    values = np.log([1.0, 2.0, 4.0])
    ((candidates, losses),) = told
    np.testing.assert_array_equal(candidates, population)
    np.testing.assert_allclose(losses, -values)
    np.testing.assert_allclose(kept, [-values])
    assert training.done == 6
    (logged,) = log.steps.values()
    spread = (np.std([1.0, 3.0, 5.0]) + np.std([2.0, 2.0, 8.0])) / 2.0
    assert logged == pytest.approx({
        "generation/value": np.log(2.0), "generation/best": np.log(4.0),
        "generation/spread": spread, "speed/episodes_per_s": 3 * 4 * 2 / 4.0,
        "speed/simulated_s_per_s": 12 * 15.0 / 4.0,
    })  # fmt: skip


@pytest.mark.parametrize(
    ("before", "every", "rate", "decisions"),
    [(0, 500, 4e-4, 250), (250, 501, 3e-4, 251), (1000, 1, 0.0, 1), (2000, 500, 0.0, 250)],
)
def test_an_interval_learns_from_its_decisions_at_a_rate_that_falls_to_zero(
    monkeypatch, clock, before, every, rate, decisions
):
    training, log, learned = PPOTraining.__new__(PPOTraining), Logged(), []
    learner = SimpleNamespace(n_decisions=before, diagnostics={"train/std": 0.5})
    training._env = SimpleNamespace(stepping_s=10.0)

    def learn(*given):
        learned.append(given)
        learner.n_decisions, training._env.stepping_s = before + 800, 11.0

    learner.learn = learn
    training._learner, training.curve = learner, ["one"]
    training._experiment = SimpleNamespace(budget=1000, every=every, seed=3)
    training._hyperparameters = PPOHyperparameters()
    monkeypatch.setattr(PPOTraining, "done", property(lambda self: learner.n_decisions))
    monkeypatch.setattr(PPOTraining, "_actors", {"weighting": None})
    trainable = []
    monkeypatch.setattr(PPOTraining, "_set_trainable", lambda self, learn: trainable.append(learn))
    told = training.advance(log)
    ((n, found_rate, seed),) = learned
    assert (n, found_rate, seed) == (decisions, pytest.approx(rate), step_seed(3, 1))
    speeds = {"speed/robot_steps_per_s": 200.0, "speed/environment_share": 0.25}
    assert log.steps == {before + 800: {**speeds, "train/std": 0.5}}
    assert told == "200 robot steps/s, 25% of the time in the environment"
    assert trainable == [True]


def test_the_simulated_time_of_ppo_is_that_of_all_its_worlds(monkeypatch):
    training = PPOTraining.__new__(PPOTraining)
    training._env = SimpleNamespace(n_rows=50)
    training._experiment = SimpleNamespace(scenarios_by_name=TICKS)
    monkeypatch.setattr(PPOTraining, "done", 1000)
    monkeypatch.setattr(ppo, "worlds_per_scenario", lambda experiment: {"a": 4, "b": 10})
    assert training._simulated_s == pytest.approx(20 * (4 * 0.5 + 10 * 0.1))


def test_who_holds_a_folder_is_named_and_it_is_free_again_afterwards(tmp_path):
    here = f"process {os.getpid()} on {socket.gethostname()} is training there"
    for _ in range(2):
        with lock_folder(tmp_path / "x"):
            with pytest.raises(ConfigError, match=here), lock_folder(tmp_path / "x"):
                pass
            files = sorted(file.name for file in (tmp_path / "x").iterdir())
            assert len(files) == 1


def points(value):
    return SimpleNamespace(value=value, round_trips={})


@pytest.mark.parametrize(
    ("values", "value", "is_best"),
    [((), 1.0, True), ((1.0,), 1.0, False), ((1.0, 3.0, 2.0), 2.5, False), ((1.0, 3.0), 3.1, True)],
)
def test_the_policy_kept_is_the_first_one_of_the_highest_value(monkeypatch, values, value, is_best):
    training = DAggerTraining.__new__(DAggerTraining)
    training.curve, training._best = [points(each) for each in values], {"weights": "before"}
    training._rounds = 5
    monkeypatch.setattr(DAggerTraining, "_simulated_s", 0.0)
    monkeypatch.setattr(DAggerTraining, "_weights", {"weights": "now"})
    for name in ("save_best", "_save", "_round_trips"):
        monkeypatch.setattr(DAggerTraining, name, lambda *given: None)
    monkeypatch.setattr(training_loop, "evaluation_point", lambda *given: points(value))
    training.evaluate()
    assert training._best == {"weights": "now" if is_best else "before"}
    assert [each.value for each in training.curve] == [*values, value]


class Slope:
    """Exchanges whose error is the weight itself, and their oracle's gain; draws are counted."""

    def __init__(self):
        self.n_draws = 0

    def gain(self, name):
        return 2.0

    def draw(self, draws):
        self.n_draws += 1
        return self

    def error(self, actor):
        return actor.weight.sum()

    def share(self, actor, gain):
        return gain * 10.0


@pytest.mark.parametrize(("done", "moved"), [(0, 5.0), (5, 2.5), (9, 0.5)])
def test_a_fit_takes_five_hundred_steps_of_a_rate_that_falls_to_zero(done, moved):
    training, slope = DAggerTraining.__new__(DAggerTraining), Slope()
    training._experiment, training._rounds = SimpleNamespace(seed=3, budget=10), done
    training._actor = torch.nn.Linear(1, 1, bias=False)
    torch.nn.init.constant_(training._actor.weight, 7.0)
    assert training._fit({"a": slope}) == {"a": 20.0}
    assert slope.n_draws == 500
    # Adam moves by its rate at each step of a constant slope: 500 x 0.01 of what is left.
    assert training._actor.weight.item() == pytest.approx(7.0 - moved, rel=1e-3)


def test_a_folder_is_locked_with_those_above_it_and_where_there_are_no_locks(tmp_path, monkeypatch):
    deep = tmp_path / "a" / "b" / "c"
    with lock_folder(deep):
        assert (deep / LOCK).read_text().startswith(f"{os.getpid()} on ")
    (tmp_path / "file").write_text("")
    with (
        pytest.raises(ConfigError, match="file/x: cannot be written"),
        lock_folder(tmp_path / "file" / "x"),
    ):
        pass

    def no_locks(*given):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("fcntl.flock", no_locks)
    with lock_folder(deep):
        pass
    monkeypatch.setitem(sys.modules, "fcntl", None)  # as on Windows
    with lock_folder(deep):
        pass

"""Policies and experiments small enough for a test."""

from pathlib import Path

import numpy as np
import pytest

from swarm_forage_env.foraging.scenario import Scenario
from training.checkpoint import BEST_POLICY, CHECKPOINT
from training.experiment import Experiment
from training.learned_weighting import EXCHANGE_NETWORK, unflatten
from training.policy_file import Card, CurvePoint, Interval, layer_card, save_policy

BUSY = {"robot.cruise_speed": "0.12", "task.area_distance": "0.62", "task.duration": "60"}
"""Numbers of es1 under which robots soon find areas and meet."""

POINT = CurvePoint(
    step=3, simulated_s=1.0, value=0.5, round_trips={"es1": Interval(low=1.0, mean=2.0, high=3.0)}
)

SIZES = {"hidden": 2}

FILES = BEST_POLICY, "best.json", CHECKPOINT
"""Of an experiment's folder, when it has ended."""


def make_card(**changes):
    card = Card(
        layers={"weighting": layer_card("weighting", Scenario(), EXCHANGE_NETWORK.name, SIZES)},
        scenarios=("es1",), settings={}, controller="ssgiff", algorithm="cma", seed=0, versions={},
        command="swarm-forage train weighting es1", curve=(), score={},
    )  # fmt: skip
    return card.model_copy(update=changes)


def make_weights(seed=0):
    shapes = EXCHANGE_NETWORK.shapes(SIZES)
    count = sum(int(np.prod(shape)) for shape in shapes.values())
    numbers = np.random.default_rng(seed).normal(0.0, 1.0, count)
    return {f"weighting.{name}": array for name, array in unflatten(numbers, shapes).items()}


@pytest.fixture(name="make_card")
def _make_card():
    """Make a card, of a weighting unless told otherwise."""
    return make_card


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """Run in an empty folder."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def policy_file(tmp_path):
    """A policy for the weighting, random but sound."""
    file = tmp_path / "mine.safetensors"
    save_policy(file, make_weights(), make_card())
    return file


@pytest.fixture
def experiment():
    """Make an experiment of seconds; its folder is relative to the current one."""

    def make(**changes):
        terms = {
            "layer": "weighting", "scenarios": ("es1",), "algorithm": "cma", "out": Path("runs/x"),
            "budget": 3, "every": 2, "worlds": 1, "held_back": 2, "population": 4, "settings": BUSY,
            "physics": "kinematic",
        }  # fmt: skip
        return Experiment(**terms | changes)

    return make


@pytest.fixture
def broken_anywhere(tmp_path, monkeypatch):
    """Check that an experiment stopped at each of some checkpoints ends as an unbroken one.

    So does one that had ended, if its best policy is gone. The checkpoint is kept by a method of a
    class; the policy of the unbroken run is returned.
    """

    def check(train, experiment, keeper, stops):
        def finished(folder):
            folder.mkdir(exist_ok=True)
            monkeypatch.chdir(folder)
            policy = train(experiment, str)
            return policy, {name: (experiment.out / name).read_bytes() for name in FILES}

        policy, unbroken = finished(tmp_path / "unbroken")
        (experiment.out / BEST_POLICY).unlink()
        assert finished(tmp_path / "unbroken")[1] == unbroken
        for stop_at in stops:
            folder = tmp_path / f"stopped-{stop_at}"
            folder.mkdir()
            monkeypatch.chdir(folder)
            with monkeypatch.context() as stopping:
                stopping.setattr(*keeper, stopping_after(stop_at, getattr(*keeper)))
                with pytest.raises(KeyboardInterrupt):
                    train(experiment, str)
            assert finished(folder)[1] == unbroken
        return policy

    return check


def stopping_after(times, keep):
    """A method that keeps so often, and then stops the run."""
    kept = []

    def keep_or_stop(self):
        kept.append(self)
        if len(kept) > times:
            raise KeyboardInterrupt
        keep(self)

    return keep_or_stop

"""What the command `train` makes of its options, and when a training evaluates; nothing trains."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from training import train_command
from training.experiment import Experiment, step_seed, worlds_per_scenario


@pytest.fixture
def made(monkeypatch, tmp_path):
    """The experiment, and the backend, that a command line makes."""
    monkeypatch.chdir(tmp_path)
    found = []
    monkeypatch.setattr(train_command, "_run", lambda *given: found.append(given))
    monkeypatch.setattr(train_command, "_report", lambda *given: None)

    def call(*arguments):
        found.clear()
        train_command.app(["train", *arguments], standalone_mode=False)
        ((experiment, backend),) = found
        return experiment, backend

    return call


@pytest.mark.parametrize(
    ("layer", "algorithm", "numbers", "controller"),
    [
        ("weighting", "imitation", (10, 2, 24), "dsgiff-frequent"),
        ("weighting", "cma", (100, 5, 8), "dsgiff-frequent"),
        ("motion", "cma", (100, 5, 8), "ssgiff"),
        ("both", "ppo", (6_000_000, 1_500_000, 8), "ssgikf"),
    ],
)
def test_a_layer_is_trained_as_the_help_promises(made, layer, algorithm, numbers, controller):
    usual = "cma" if layer == "weighting" else "ppo"
    options = [] if algorithm == usual else [f"--algorithm={algorithm}"]
    experiment, backend = made(layer, "es1", *options)
    assert experiment == Experiment(
        layer=layer, scenarios=("es1",), algorithm=algorithm,
        out=Path(f"runs/train-{layer}-{algorithm}"), seed=0, budget=numbers[0], every=numbers[1],
        worlds=numbers[2], held_back=10, population=None, settings={}, controller=controller,
        physics="rigid", workers=2, device="cpu",
    )  # fmt: skip
    assert (backend.workers, backend.threads) == (2, 1)


@pytest.mark.parametrize(
    ("layer", "numbers"),
    [
        ("motion", (500_000_000, 250_000_000, 2048)),
        ("everything", (200_000_000, 20_000_000, 64)),
        ("weighting", (100, 5, 8)),
    ],
)
def test_a_gpu_trains_a_motion_in_thousands_of_worlds(made, monkeypatch, layer, numbers):
    monkeypatch.setattr(Experiment, "check", lambda own: None)
    experiment, _ = made(layer, "es1", "--device=cuda", "--physics=kinematic")
    assert (experiment.budget, experiment.every, experiment.worlds) == numbers


def test_the_help_lists_the_defaults_of_each_algorithm():
    shown = CliRunner().invoke(train_command.app, ["train", "--help"], env={"COLUMNS": "300"})
    for budgets in ("cma: 100, imitation: 10, ppo: 6000000", "cma: 5, imitation: 2, ppo: 1500000",
                 "cma: 8, imitation: 24, ppo: 8", "ppo on a GPU: 2048"):  # fmt: skip
        assert budgets in shown.output


def test_larger_swarms_get_fewer_worlds_and_each_at_least_one():
    scenarios = tuple(f"es1:task.n_robots={n}" for n in (3, 5, 6, 20))
    experiment = Experiment("weighting", scenarios, "ppo", Path("x"), worlds=6)
    assert list(worlds_per_scenario(experiment).values()) == [6, 3, 3, 1]


def test_every_step_has_a_seed_of_its_own_that_never_changes():
    found = {(seed, step): step_seed(seed, step) for seed in range(4) for step in range(4)}
    assert len(set(found.values())) == 16
    assert (found[0, 0], found[1, 2]) == (2968811710, 1596810411)

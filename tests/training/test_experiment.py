"""Experiments: seeds that never meet, and refusals before anything runs."""

import shlex

import pytest

from swarm_forage_env.errors import ConfigError, UnknownNameError
from training.experiment import HELD_BACK_SEEDS, LAST_SEED, TEST_SEEDS, WORLDS_PER_EXPERIMENT
from training.policy_file import load_policy, save_policy


def test_training_selection_and_test_never_share_a_seed(experiment):
    assert range(1000, 1030) == TEST_SEEDS
    first = experiment(seed=0).training_seeds(0, 1)[0]
    assert max(TEST_SEEDS) < min(HELD_BACK_SEEDS) <= max(HELD_BACK_SEEDS) < first
    last = experiment(seed=0).training_seeds(WORLDS_PER_EXPERIMENT - 1, 1)[-1]
    assert last < experiment(seed=1).training_seeds(0, 1)[0]
    assert experiment(seed=LAST_SEED).training_seeds(0, WORLDS_PER_EXPERIMENT)[-1] < 2**64


def test_training_worlds_are_new_in_each_generation(experiment):
    mine = experiment(seed=3)
    assert mine.training_seeds(0, 5)[-1] + 1 == mine.training_seeds(5, 5)[0]
    with pytest.raises(ConfigError, match="more than 10000000 training worlds"):
        mine.training_seeds(WORLDS_PER_EXPERIMENT - 1, 2)


def test_a_scenario_takes_numbers_of_its_own(experiment):
    mine = experiment(scenarios=("es1", "es1:radio.frames=50"), settings={"tick": "0.2"})
    first, second = mine.scenarios_by_name.values()
    assert (first.radio.frames, second.radio.frames) == (2, 50)
    assert first.tick == second.tick == 0.2


IMITATION = {"algorithm": "imitation", "population": None}
EVERYTHING = {"algorithm": "ppo", "layer": "everything", "population": None}

REFUSED = [
    ({"layer": "motoin"}, "no layer to learn named 'motoin', did you mean 'motion'"),
    ({"layer": "both"}, "cma: trains one layer at a time, not both"),
    ({**IMITATION, "layer": "both"}, "the weighting only, not both; the right"),
    ({"algorithm": "imitation", "population": 8}, "is for --algorithm cma"),
    ({"layer": "motion", "controller": "ssgiff:mean_run=1"}, "correction of subsumption with its"),
    ({"scenarios": ("es9",)}, "no scenario named 'es9'"),
    ({"scenarios": ("waypoints-10",), "settings": {}}, "must be one in which robots forage"),
    ({"scenarios": ("es1:radio.frame=5",)}, "did you mean 'radio.frames'"),
    ({"settings": {"task.duration": "-1"}}, "task.duration='-1'"),
    ({"controller": "ssgiif"}, "no controller named 'ssgiif', did you mean"),
    ({"controller": "no-error"}, "knows the ground truth"),
    ({"physics": "fluid"}, "no physics engine named 'fluid'"),
    ({"device": "tpu"}, "--device='tpu': must be 'cpu' or 'cuda'"),
    ({**IMITATION, "device": "cuda"}, "--device=cuda: is for --algorithm cma and ppo"),
    ({"device": "cuda", "physics": "rigid"}, "--device=cuda: the engine rigid calls a lib"),
    ({"budget": 0}, "--budget=0: must be at least 1"),
    ({"workers": 0}, "--workers=0"),
    ({"held_back": 0}, "--held-back=0: must be from 1 to 1000"),
    ({"held_back": 1001}, "--held-back=1001"),
    ({"population": 3}, "--population=3: must be at least 4"),
    ({"algorithm": "ppo", "population": 8}, "is for --algorithm cma"),
    ({"controller": "sb3"}, "must be made of three layers"),
    ({**EVERYTHING, "scenarios": ("es1", "es1:radio.slots=2")}, "observes other features in each"),
    ({"scenarios": ("es1:frames",)}, "scenario='es1:frames': 'frames' must be parameter=value"),
    ({"seed": -1}, "seed=-1"),
    ({"seed": LAST_SEED + 1}, "must be at most 1000000000"),
    ({"scenarios": ("es1", "real", "es1", "real")}, "scenario 'es1' is named twice"),
]


@pytest.mark.parametrize(("changes", "complaint"), REFUSED, ids=[text for _, text in REFUSED])
def test_what_cannot_be_trained_is_refused(experiment, changes, complaint):
    with pytest.raises((ConfigError, UnknownNameError)) as refusal:
        experiment(**changes).check()
    assert complaint in str(refusal.value)


@pytest.mark.parametrize(
    "changes",
    [{"held_back": 1, "population": 4, "budget": 1, "every": 1, "seed": 0},
     {"held_back": 1000, "population": None, "seed": LAST_SEED},
     {"layer": "motion"}, {"layer": "motion", "controller": "learned-both"},
     {"algorithm": "ppo", "layer": "both", "population": None}, IMITATION],
)  # fmt: skip
def test_what_lies_on_a_bound_can_be_trained(experiment, changes):
    experiment(**changes).check()


def test_all_that_a_result_depends_on_is_told_apart(experiment, policy_file):
    mine = experiment()
    for changes in (
        {"seed": 1}, {"worlds": 2}, {"every": 3}, {"held_back": 3}, {"population": 5},
        {"physics": "rigid"}, {"controller": "dsgiff"}, {"scenarios": ("es1:radio.frames=5",)},
    ):  # fmt: skip
        assert experiment(**changes).identity != mine.identity, changes
    two, turned = experiment(scenarios=("es1", "real")), experiment(scenarios=("real", "es1"))
    assert two.identity != turned.identity
    assert experiment(budget=9).identity == mine.identity  # a longer search goes on
    assert experiment(workers=2).identity == mine.identity
    fit = experiment(**IMITATION)
    assert experiment(**IMITATION, budget=9).identity != fit.identity
    learned = {"controller": f"learned-weighting:policy={policy_file}"}
    before, policy = experiment(**learned).identity, load_policy(policy_file)
    save_policy(policy_file, {k: 2.0 * each for k, each in policy.weights.items()}, policy.card)
    assert experiment(**learned).identity != before


@pytest.mark.parametrize(
    "changes",
    [{"scenarios": ("es1", "real:radio.frames=5"), "seed": 7, **IMITATION},
     {"layer": "motion", "seed": 2, "budget": 7, "every": 3, "worlds": 5, "held_back": 6,
      "population": 9, "workers": 4, "controller": "dsgiff", "physics": "rigid"}],
)  # fmt: skip
def test_the_command_makes_the_same_experiment_again(experiment, monkeypatch, changes):
    from training import train_command

    mine = experiment(**changes)
    met = []
    monkeypatch.setattr(train_command, "_run", lambda experiment, _: met.append(experiment))
    monkeypatch.setattr(train_command, "_report", lambda *_: None)
    program, *arguments = shlex.split(mine.command)
    assert program == "swarm-forage"
    assert train_command.app(arguments, standalone_mode=False) in (None, 0)
    assert met == [mine]


def test_a_checkpoint_of_a_cpu_is_what_it_was_and_a_gpu_has_its_own(experiment):
    assert "device" not in experiment().identity
    assert "--device" not in experiment().command
    assert experiment(device="cuda").identity["device"] == "cuda"
    assert "--device=cuda" in experiment(device="cuda").command

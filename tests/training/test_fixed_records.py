"""What a training is told cannot be changed afterwards."""

from dataclasses import FrozenInstanceError

import pytest

from training.candidate_rollouts import (
    CandidateMotion,
    CandidateRollouts,
    CandidateWeighting,
    RolloutJob,
)
from training.experiment import Experiment
from training.ladder.rungs import Rung
from training.ladder.runs import Job, Run
from training.ladder.summary import Row
from training.policy_file import Policy
from training.ppo_equations import Rollout
from training.ppo_learner import PPOHyperparameters
from training.tensor_vec_env import Step

RECORDS = {
    CandidateMotion: "policy", CandidateRollouts: "physics", CandidateWeighting: "network",
    Experiment: "seed", Job: "seed", PPOHyperparameters: "discount", Policy: "source",
    Rollout: "rewards", RolloutJob: "seeds", Row: "seeds", Run: "seed", Rung: "name",
    Step: "rewards",
}  # fmt: skip


@pytest.mark.parametrize("record", RECORDS, ids=lambda each: each.__name__)
def test_a_record_cannot_be_changed(record):
    made = object.__new__(record)
    with pytest.raises(FrozenInstanceError):
        setattr(made, RECORDS[record], 1)

"""Train by transitions of other policies: behaviour cloning, and reward-weighted regression.

The transitions are of every tick, and so a policy drives the wheels in every tick, beside the same
other layers as those of the other trainers. A robot-step is a transition that is read, each time
that it is; the environment is stepped only to record them, and for evaluations.
"""

import copy
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import torch

from swarm_forage_env.arrays import Array
from training.cloning import Cloner, CloningOptions
from training.experiment import FIRST_TRAINING_SEED
from training.ladder.own_trainer import acting
from training.ladder.play import Watch
from training.ladder.rungs import Algorithm, Rung
from training.policy_card import CardKeywords
from training.transition_recording import DatasetOptions, Recording, Transitions
from training.transitions import read


def train(rung: Rung, algorithm: Algorithm, seed: int, watch: Watch) -> None:
    """Record transitions, and learn until as many were read as the watch says."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    settings = dict(algorithm.settings)
    played, keywords = record(rung, seed, **settings.pop("dataset"))
    watch.keywords = {**watch.keywords, **keywords.model_dump()}
    options = CloningOptions(**settings)
    cloner, n_read = Cloner(played, options), 0
    policy = cloner.policy
    while n_read < watch.robot_steps:
        cloner.step()
        n_read += options.batch
        if watch.due(n_read):
            watch.evaluate(n_read, acting(policy), lambda: acting(copy.deepcopy(policy)))


def record(
    rung: Rung, seed: int, policies: Sequence[str], episodes: int, learners: int
) -> tuple[Mapping[str, Array], CardKeywords]:
    """Transitions of a few robots of each episode, and the keywords under which they act.

    Each training has `episodes` seeds of its own, all of them seeds of trainings, the same for
    every policy.
    """
    changes = [f"{name}={value}" for name, value in rung.keywords.items() if "." in name]
    first, physics = FIRST_TRAINING_SEED + seed * episodes, rung.keywords.get("physics")
    request = DatasetOptions(rung.keywords["scenario"], policies, episodes, first, changes, physics)
    recordings = [Recording(each, learners) for each in request.configurations()]
    with TemporaryDirectory() as folder:
        store = Transitions(Path(folder))
        for recording in recordings:
            for _ in store.record(recording, request.seeds(), threads=1):
                pass
        return read(folder), recordings[0].card.keywords

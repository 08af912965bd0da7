"""The learner: PPO of stable-baselines3 on the environments of an experiment, and its state."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.logger import configure

from swarm_forage_env.arrays import Array
from training.actor_critic import LayersPolicy
from training.experiment import Experiment, worlds_of
from training.multi_scenario_vec_env import Blocks
from training.progress import FOLDER
from training.vec_env import SwarmVecEnv

MOMENTS = ("step", "exp_avg", "exp_avg_sq")
"""What Adam remembers of each parameter."""


@dataclass(frozen=True)
class Method:
    """How PPO learns."""

    decision_period: int = 2
    """Ticks for which an action is held: the running motion decides in each, and stops for an
    exchange of a few ticks, which a longer period would miss."""
    discount: float = 0.998
    """Of a decision; the mean horizon is 100 s, about a round trip."""
    trace: float = 0.98
    """Lambda of the advantages."""
    shaping: float = 1.0
    """Weight of the potential."""
    steps: int = 256
    """Decisions of each robot in a rollout."""
    batches: int = 4
    """Batches into which a rollout is cut, in each epoch."""
    epochs: int = 4
    rate: float = 4e-4
    """Learning rate at the start; it falls to zero over the budget."""
    log_std: float = -1.2
    """Logarithm of the standard deviation of the first actions."""


EVERY_TICK = Method(decision_period=1, discount=0.999, log_std=-2.0)
"""An encounter is seen for one tick, so that a weight is decided in each."""

METHODS: Mapping[str, Method] = {"weighting": EVERY_TICK, "motion": Method(), "both": EVERY_TICK}
"""By what is trained."""


def environments(experiment: Experiment, method: Method) -> Blocks:
    """The robots of all scenarios."""
    scenarios = experiment.worlds_by_name
    return Blocks(
        [
            SwarmVecEnv(
                scenarios[name],
                n_worlds=n_worlds,
                controller=experiment.recipe,
                learn=experiment.layer,
                physics=experiment.physics,
                decision_period=method.decision_period,
                discount=method.discount,
                shaping=method.shaping,
            )
            for name, n_worlds in worlds_of(experiment).items()
        ]
    )


def learner(environment: Blocks, experiment: Experiment, method: Method) -> PPO:
    """PPO with the networks of the learned layers."""
    model = PPO(
        LayersPolicy,
        environment,
        learning_rate=method.rate,
        n_steps=method.steps,
        batch_size=method.steps * environment.num_envs // method.batches,
        n_epochs=method.epochs,
        gamma=method.discount,
        gae_lambda=method.trace,
        policy_kwargs={
            "layout": environment.observation_layout,
            "layers": experiment.layers,
            "log_std_init": method.log_std,
        },
        seed=experiment.seed,
        device="cpu",
    )
    model.set_logger(configure(str(experiment.out / FOLDER), ["tensorboard"]))
    return model


def state_of(model: PPO) -> dict[str, Array]:
    """All parameters, what the optimiser remembers of them, and how many steps were made."""
    arrays = {f"policy.{name}": array for name, array in model.policy.state_dict().items()}
    remembered = model.policy.optimizer.state
    for name, parameter in model.policy.named_parameters():
        for moment in MOMENTS:
            kept = remembered.get(parameter, {}).get(moment)
            empty = torch.zeros(() if moment == "step" else parameter.shape)
            arrays[f"{moment}.{name}"] = empty if kept is None else kept
    found = {name: array.detach().numpy().copy() for name, array in arrays.items()}
    return {**found, "num_timesteps": np.array(model.num_timesteps)}


def restore(model: PPO, arrays: Mapping[str, Array]) -> None:
    """Bring a model to a state that `state_of` told."""
    tensors = {name: torch.from_numpy(np.array(array)) for name, array in arrays.items()}
    policy = model.policy
    policy.load_state_dict({name: tensors[f"policy.{name}"] for name in policy.state_dict()})
    for name, parameter in policy.named_parameters():
        if tensors[f"step.{name}"] > 0:
            moments = {moment: tensors[f"{moment}.{name}"] for moment in MOMENTS}
            policy.optimizer.state[parameter] = moments
    model.num_timesteps = int(arrays["num_timesteps"])

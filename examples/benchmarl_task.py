"""BenchMARL: one of its algorithms on one of our tasks, from scratch, with evaluation and video.

    make .venv-torchrl/.ready            # the tested set, with torchrl and benchmarl beside
    .venv-torchrl/bin/python examples/benchmarl_task.py --task near --algorithm mappo

QMIX, VDN and IQL choose among a few ways to steer, the others steer by numbers. Under `runs` are
the curves, a film of each evaluation (with the extra `render`), and a JSON file for marl-eval. On
BenchMARL's own command line, with all of its options:

    .venv-torchrl/bin/python -m training.benchmarl_tasks task=swarm_forage/near algorithm=qmix
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import torch
from benchmarl.algorithms import algorithm_config_registry
from benchmarl.experiment import Experiment
from benchmarl.models.mlp import MlpConfig
from torchrl.envs.utils import ExplorationType, set_exploration_type

from training.benchmarl_tasks import EpisodeMetrics, KeepsPolicy, SwarmForageTask, settings


def main(arguments: Sequence[str] | None = None) -> EpisodeMetrics:
    """Read the command line, train, and compare the policy, stochastic too, with random actions."""
    names = [task.name.lower() for task in SwarmForageTask]
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--task", default="near", choices=names)
    parser.add_argument("--algorithm", default="mappo", choices=sorted(algorithm_config_registry))
    parser.add_argument("--frames", type=int, default=192_000, help="decisions of a swarm")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("runs/benchmarl"))
    chosen = parser.parse_args(arguments)
    chosen.out.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(1)  # quicker for networks this small

    task = SwarmForageTask[chosen.task.upper()].get_task()
    algorithm = algorithm_config_registry[chosen.algorithm].get_from_yaml()
    if chosen.algorithm in ("mappo", "masac"):  # a critic for each robot, which earns its own
        algorithm.share_param_critic = False
    evaluation = EpisodeMetrics()
    experiment = Experiment(
        task=task,
        algorithm_config=algorithm,
        model_config=MlpConfig.get_from_yaml(),
        critic_model_config=MlpConfig.get_from_yaml(),
        seed=chosen.seed,
        config=settings(task, max_n_frames=chosen.frames, save_folder=str(chosen.out.resolve())),
        callbacks=[evaluation, KeepsPolicy()],
    )
    experiment.run()

    episodes = []
    for policy in (experiment.policy, None):  # in the same worlds
        torch.manual_seed(1000)
        env = task.get_env_fun(16, experiment.continuous_actions, None, "cpu")()
        with torch.no_grad(), set_exploration_type(ExplorationType.RANDOM):
            episodes.append(env.episodes(env.rollout(env.max_cycles, policy)))
    stochastic, random = episodes
    for name, learned in evaluation.last.items():
        chance, drawn = stochastic[name].mean(), random[name].mean()
        print(
            f"{name}: {learned.mean():.2f} learned, {chance:.2f} the same, stochastic,"
            f" {drawn:.2f} random actions"
        )
    print(f"kept: {experiment.folder_name / 'policy.pt'}")
    return evaluation


if __name__ == "__main__":
    main()

"""TorchRL and BenchMARL: the examples learn, every task is made; run by `make test-torchrl`."""

import copy
import json
import math
import pickle

import numpy as np
import pytest

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.scenarios import find_scenario

pytestmark = [
    pytest.mark.torchrl,
    pytest.mark.filterwarnings("ignore"),  # they warn about each other's versions
    pytest.mark.usefixtures("one_thread"),
]


@pytest.fixture
def terms(small):
    """What the environment is made with."""
    return {"scenario": "es1", "decision_period": 1, "max_cycles": 20, **small}


@pytest.fixture
def settle(tmp_path):
    """A function that shortens the experiment of a task to two iterations and two evaluations."""
    from training.benchmarl_tasks import settings

    def made(task, **more):
        task.config |= {"max_cycles": 15}
        few = {
            f"{kind}_policy_{name}": number
            for kind in ("on", "off")
            for name, number in {"collected_frames_per_batch": 60, "n_envs_per_worker": 2}.items()
        }
        few |= {"on_policy_minibatch_size": 30, "off_policy_n_optimizer_steps": 2}
        few |= {"off_policy_train_batch_size": 16, "off_policy_memory_size": 120}
        few |= {"evaluation_interval": 60, "evaluation_episodes": 3, "max_n_frames": 120}
        return settings(task, save_folder=str(tmp_path), **{**few, **more})

    return made


@pytest.fixture
def run(settle):
    """A function that runs such an experiment, of a task or of the one of a name."""
    from benchmarl.algorithms import algorithm_config_registry
    from benchmarl.experiment import Experiment
    from benchmarl.models.mlp import MlpConfig

    from training.benchmarl_tasks import SwarmForageTask

    def ran(task, algorithm, callback=None, **more):
        task = SwarmForageTask[task].get_task() if isinstance(task, str) else task
        experiment = Experiment(
            task=task,
            algorithm_config=algorithm_config_registry[algorithm].get_from_yaml(),
            model_config=MlpConfig.get_from_yaml(),
            critic_model_config=MlpConfig.get_from_yaml(),
            seed=1,
            config=settle(task, **more),
            callbacks=[callback] if callback else [],
        )
        experiment.run()
        return experiment

    return ran


@pytest.mark.parametrize("is_ippo", [False, True])
def test_torchrl_trains_one_policy_and_one_seed_gives_one_policy(example, terms, is_ippo):
    import torch

    mappo = example("torchrl_mappo")
    untrained, one, other = (
        list(mappo.train(iterations, steps=10, is_ippo=is_ippo, **terms).parameters())
        for iterations in (0, 2, 2)
    )
    assert all(torch.equal(a, b) for a, b in zip(one, other, strict=True))
    assert all(torch.isfinite(values).all() for values in one)
    assert not any(torch.equal(a, b) for a, b in zip(untrained, one, strict=True))


def test_torchrl_compares_a_policy_with_random_actions(example, terms):
    mappo = example("torchrl_mappo")
    policy = mappo.train(0, **terms)
    assert mappo.round_trips(policy, **terms) == mappo.round_trips(None, **terms) == 0.0


@pytest.mark.parametrize("is_continuous", [True, False])
def test_every_file_is_a_task_whose_worlds_are_as_their_specs_say(is_continuous):
    from benchmarl.environments import task_config_registry
    from torchrl.envs import check_env_specs

    from training.benchmarl_tasks import FOLDER, SwarmForageTask

    assert len(SwarmForageTask) == len(list(FOLDER.glob("*.yaml"))) > 5
    for each in SwarmForageTask:
        assert task_config_registry[f"swarm_forage/{each.name.lower()}"] is each
        task = each.get_task()
        env = task.get_env_fun(2, is_continuous, seed=0, device="cpu")()
        check_env_specs(env)
        assert env.batch_size == (2,)
        assert bool(env.array_env.config.discrete) != is_continuous


def test_the_rewards_of_a_task_are_scaled():
    from training.benchmarl_tasks import SwarmForageClass

    keywords = {"scenario": "near", "physics": "kinematic", "shaping": 1.0, "max_cycles": 8}
    task = SwarmForageClass("near", {**keywords, "reward_scale": 100})
    env = task.get_env_fun(2, True, seed=0, device="cpu")()
    (scale,) = task.get_env_transforms(env)
    plain = env.rollout(8)["next"]
    scaled = scale(plain.clone())[env.group, "reward"]
    assert plain[env.group, "reward"].any()
    np.testing.assert_allclose(scaled, 100.0 * plain[env.group, "reward"], rtol=1e-6)


@pytest.mark.parametrize("algorithm", ["mappo", "masac", "qmix"])
def test_benchmarl_trains_and_evaluates_a_task(run, tmp_path, algorithm):
    from training.benchmarl_tasks import EpisodeMetrics

    evaluation = EpisodeMetrics()
    experiment = run("NEAR", algorithm, evaluation)
    assert (experiment.n_iters_performed, experiment.total_frames) == (2, 120)
    assert experiment.continuous_actions == (algorithm != "qmix")
    assert math.isfinite(experiment.mean_return)
    assert evaluation.last["round_trips"].shape == (3,)
    assert experiment.config.gamma == experiment.task.config["discount"]
    (file,) = tmp_path.rglob("*.json")
    scores = json.loads(file.read_text())["swarm_forage"]["near"][algorithm]["seed_1"]
    assert set(scores) == {"absolute_metrics", "step_1", "step_2"}
    assert scores["step_2"]["round_trips"] == [0.0] * 3
    assert len(scores["step_2"]["return"]) == 3
    logged = {path.name for path in tmp_path.rglob("*.csv")}
    assert {"collection_round_trips.csv", "eval_round_trips.csv"} <= logged


@pytest.mark.parametrize(
    ("algorithm", "keywords"),
    [
        ("mappo", {"decision_period": 3, "walk": False}),
        ("maddpg", {"learn": "both", "controller": "dsgiff"}),
        ("qmix", {"discrete": (2, 5), "learn": "everything"}),
    ],
)
def test_a_policy_is_evaluated_under_the_keywords_of_its_training(
    run, evaluated, algorithm, keywords
):
    import torch
    from torchrl.envs.utils import ExplorationType, set_exploration_type

    from training.benchmarl_tasks import KeepsPolicy, SwarmForageClass
    from training.torchrl_env import SwarmTorchEnv

    task = SwarmForageClass("near", {"scenario": "near", "physics": "kinematic", **keywords})
    experiment = run(task, algorithm, KeepsPolicy(), evaluation=False)
    env = SwarmTorchEnv(n_worlds=1, seed=7, **{**task.config, "max_cycles": 100})
    with torch.no_grad(), set_exploration_type(ExplorationType.DETERMINISTIC):
        env.rollout(40, experiment.policy)
    name = f"torchscript:{experiment.folder_name}/policy.pt"
    ticks = 40 * env.array_env.config.period
    poses = evaluated(name, find_scenario("near"), 7, ticks)
    np.testing.assert_allclose(poses, env.array_env.world.robots["pose"], atol=1e-3)
    assert np.isfinite(evaluated(name, find_scenario("es1"), 7, ticks)).all()  # 10 robots, not 5


def test_a_policy_with_parameters_of_each_robot_is_not_saved(terms, tmp_path):
    from tensordict.nn import TensorDictModule
    from torch import nn
    from torchrl.modules import MultiAgentMLP

    from training.torchrl_env import SwarmTorchEnv, save_policy

    env = SwarmTorchEnv(**terms)
    n_robots, n_observed = env.observation_spec["epuck", "observation"].shape[1:]
    kind = {"centralized": False, "share_params": False}  # codespell:ignore centralized
    net = MultiAgentMLP(n_observed, 2, n_robots, **kind)
    keys = [("epuck", "observation")], [("epuck", "action")]
    policy = TensorDictModule(nn.Sequential(net, nn.Tanh()), *keys)
    with pytest.raises(ConfigError, match="depend on more than what the robot observes"):
        save_policy(policy, env, tmp_path / "policy.pt")
    assert not list(tmp_path.iterdir())


def test_an_evaluation_is_filmed(run, tmp_path):
    pytest.importorskip("pygame")
    pytest.importorskip("imageio_ffmpeg")
    run("NEAR", "ippo")
    films = sorted(tmp_path.rglob("*.mp4"))
    assert [film.name for film in films] == ["eval_video_0.mp4", "eval_video_1.mp4"]
    assert all(film.stat().st_size for film in films)


def test_the_worlds_of_training_end_one_after_the_other_and_those_of_evaluation_together():
    import torch
    from torchrl.envs import TransformedEnv

    from training.benchmarl_tasks import SwarmForageTask

    task = SwarmForageTask.NEAR.get_task()
    task.config |= {"max_cycles": 6}
    make = task.get_env_fun(3, True, seed=0, device="cpu")
    training = TransformedEnv(make(), task.get_reward_sum_transform(make()))
    for env, ends in ((make(), {5}), (training, {1, 3, 5})):
        seen = env.rollout(6, break_when_any_done=False)
        assert set(seen["next", "done"].squeeze(-1).nonzero()[:, 1].tolist()) == ends
    returns = seen["next", "epuck", "episode_reward"][2, -1]
    torch.testing.assert_close(returns, seen["next", "epuck", "reward"][2].sum(0))


def test_a_static_evaluation_is_on_the_same_episodes_and_training_on_others(run):
    import torch

    experiment = run("ES1", "ippo", evaluation_static=True, render=False)
    task = experiment.task
    torch.manual_seed(experiment.seed)
    made = task.get_env_fun(2, True, experiment.seed, "cpu")
    first, second = (made().reset()["state"] for _ in range(2))
    assert not torch.equal(first, second)
    env = made()
    starts = []
    for _ in range(2):
        env.set_seed(experiment.seed)
        starts.append(env.reset()["state"])
    assert torch.equal(*starts)


def test_a_misspelt_setting_is_refused():
    from swarm_forage_env.errors import UnknownNameError
    from training.benchmarl_tasks import SwarmForageTask, settings

    with pytest.raises(UnknownNameError, match="did you mean 'max_n_iters'"):
        settings(SwarmForageTask.NEAR.get_task(), max_n_iter=3)


def pickled(env):
    return pickle.loads(pickle.dumps(env))


@pytest.mark.parametrize("engine", ["kinematic", "rigid"])
@pytest.mark.parametrize("copied", [copy.deepcopy, pickled])
def test_a_copy_in_mid_episode_goes_on_as_the_original(engine, copied):
    import torch

    from training.torchrl_env import SwarmTorchEnv

    env = SwarmTorchEnv("es1", n_worlds=2, seed=3, physics=engine, max_cycles=20)
    torch.manual_seed(1)
    actions = [env.full_action_spec.rand() for _ in range(12)]
    state = after(env, env.reset(), actions[:4], [])
    other, seen, theirs = copied(env), [], []
    after(other, state.clone(), actions[4:], theirs)
    after(env, state.clone(), actions[4:], seen)
    assert seen == theirs
    assert len(set(seen)) == 8


def after(env, state, actions, seen):
    """The state after these actions; what was observed is appended."""
    for action in actions:
        state = env.step_mdp(env.step(state.update(action)))
        seen.append(state[env.group, "observation"].numpy().tobytes())
    return state

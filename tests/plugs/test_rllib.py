"""RLlib, new API stack: worlds in one block, and the example; run by `make test-rllib`."""

from pathlib import Path

import numpy as np
import pytest

from swarm_forage_env import ConfigError, parallel_env
from swarm_forage_env.scenarios import find_scenario

pytestmark = [
    pytest.mark.rllib,
    pytest.mark.filterwarnings("ignore"),  # ray warns about itself
]

FORMS = [
    {"learn": "motion", "decision_period": 2, "shaping": 1.0},
    {"learn": "weighting", "learners": [0, 2], "randomise": {"radio.max_range": (0.1, 0.2)}},
    {"learn": "everything", "discrete": True},
]


@pytest.fixture
def ray():
    import ray

    ray.init(num_cpus=3, include_dashboard=False, ignore_reinit_error=True)
    yield ray
    ray.shutdown()


def some(env, rng):
    """Actions of every world."""
    agents = env.single_action_spaces
    for space in agents.values():
        space.seed(int(rng.integers(2**31)))
    return [{agent: space.sample() for agent, space in agents.items()} for _ in range(env.num_envs)]


@pytest.mark.parametrize("options", FORMS)
def test_a_world_goes_through_what_it_goes_through_alone(options, small):
    from training.rllib_env import SwarmMultiAgentEnv, SwarmVectorEnv

    terms = {**small, **options, "max_cycles": 5}
    block, rng = SwarmVectorEnv(terms, 3), np.random.default_rng(0)
    alone, single = parallel_env(**terms), SwarmMultiAgentEnv(terms)
    far = {"task.area_distance": 1.2}
    observed, infos = block.reset(seed=4, options=far)
    others = [env.reset(seed=5, options=far)[0] for env in (alone, single)]
    assert infos == 3 * [{agent: {} for agent in alone.possible_agents}]
    for _ in range(5):
        for other in others:
            assert list(observed[1]) == list(other)
            np.testing.assert_array_equal(list(observed[1].values()), list(other.values()))
        actions = some(block, rng)
        observed, rewards, _, truncated, infos = block.step(actions)
        told = [env.step(actions[1]) for env in (alone, single)]
        others = [each[0] for each in told]
        assert all(rewards[1] == each[1] for each in told)
        assert truncated[1]["__all__"] == told[1][3]["__all__"] == all(told[0][3].values())
    assert truncated[1]["__all__"]
    for agent, expected in told[0][4].items():
        assert infos[1][agent] | {"unshaped_reward": expected["unshaped_reward"]} == expected
    last = block.env.world.robots["pose"].copy()
    _, rewards, terminated, truncated, _ = block.step([{}, {}, {}])
    assert truncated[1] == terminated[1] == {"__all__": False}
    assert set(rewards[1].values()) == {0.0}
    assert (block.env.world.robots["pose"] != last).all(axis=2).any()


def test_what_a_block_cannot_do_is_refused_in_a_line(small):
    from training.rllib_env import SwarmVectorEnv

    with pytest.raises(ConfigError, match=r"step_on=.exchange.: .*; leave SwarmEnvRunner"):
        SwarmVectorEnv({"learn": "weighting", "step_on": "exchange", **small}, 2)
    with pytest.raises(ConfigError, match="n_worlds=4: is for ArrayEnv, SwarmVecEnv and"):
        SwarmVectorEnv({"n_worlds": 4, **small}, 2)
    with pytest.raises(ConfigError, match="epuck_0 of world 0 has none; every agent needs one"):
        SwarmVectorEnv(small, 2).step([{}, {}])


@pytest.mark.parametrize(
    "keywords",
    [
        {"decision_period": 3, "walk": False},
        {"learn": "weighting", "controller": "dsgiff", "normalise": False, "decision_period": 1},
        {"learn": "everything", "discrete": (2, 5)},
    ],
)
def test_a_module_is_evaluated_under_the_keywords_of_its_training(
    example, ray, evaluated, keywords
):
    import torch
    from ray.rllib.utils.spaces.space_utils import unsquash_action

    from training.rllib_env import SavesPolicies, SwarmMultiAgentEnv

    terms = {"scenario": "near", "physics": "kinematic", "max_cycles": 60, **keywords}
    configured = example("rllib_ppo").configure(1, 2, 60, **terms)
    algorithm = configured.callbacks(SavesPolicies).build_algo()
    algorithm.train()
    algorithm.stop()
    module, env = algorithm.get_module("robot"), SwarmMultiAgentEnv(configured.env_config)
    assert repr(env).startswith("<SwarmMultiAgentEnv near: learn=")
    space, observed = env.action_spaces["epuck_0"], env.reset(seed=7)[0]
    for _ in range(40):
        rows = torch.from_numpy(np.array(list(observed.values())))
        given = module.forward_inference({"obs": rows})["action_dist_inputs"].detach().numpy()
        chosen = given.argmax(1) if keywords.get("discrete") else given[:, : space.shape[0]]
        actions = chosen if keywords.get("discrete") else unsquash_action(chosen, space)
        observed, *_ = env.step(dict(zip(observed, actions, strict=True)))
    block = env._block.env
    name = f"torchscript:{Path(algorithm.logdir) / 'robot.pt'}"
    poses = evaluated(name, find_scenario("near"), 7, 40 * block.config.period)
    np.testing.assert_allclose(poses, block.world.robots["pose"], atol=1e-3)


def test_a_saved_policy_has_the_card_of_its_environment_whatever_made_it(ray, evaluated, tmp_path):
    from ray.rllib.algorithms.dqn import DQNConfig

    from training.policy_card import read_policy_card
    from training.rllib_env import save_policies

    make = "swarm_forage_env:SwarmForage/Near-v2"
    config = DQNConfig().environment(make, env_config={"discrete": True, "decision_period": 4})
    algorithm = config.env_runners(num_env_runners=0).build_algo()
    (file,) = save_policies(algorithm, tmp_path)
    card = read_policy_card(file)
    assert (card.scenario, card.keywords.decision_period) == ("near", 4)
    evaluated(f"torchscript:{file}", find_scenario("near"), 7, 4)  # DQN's, too, runs by its name
    del algorithm.get_module("default_policy").observation_space.policy_card
    with pytest.raises(ConfigError, match="'default_policy': its observation space has no card"):
        save_policies(algorithm, tmp_path)
    algorithm.stop()


def test_env_runners_in_other_processes_step_a_block_each(example, small, ray):
    config = example("rllib_ppo").configure(1, 2, 60, learn="motion", max_cycles=60, **small)
    algorithm = config.env_runners(num_env_runners=2).build_algo()
    told = algorithm.train()["env_runners"]
    blocks = algorithm.env_runner_group.foreach_env_runner(
        lambda runner: (
            type(runner.env).__name__,
            [(each.is_truncated, each.is_terminated) for each in runner.sample(num_episodes=2)],
            runner.env.env.episodes.streams.copy(),
        ),
        local_env_runner=False,
    )
    algorithm.stop()
    assert told["num_env_steps_sampled_lifetime"] == 120
    names, ends, streams = zip(*blocks, strict=True)
    assert names == ("SwarmVectorEnv",) * 2
    assert ends == ([(True, False)] * 2,) * 2, "a time-out is bootstrapped"
    assert len(np.unique(np.concatenate(streams), axis=0)) == 4, "each has worlds of its own"


def test_the_example_trains_and_compares(example, tmp_path, capsys):
    example("rllib_ppo").main(["--robot-steps=1", "--episodes=1", f"--out={tmp_path / 'kept'}"])
    told = capsys.readouterr().out
    assert "102,400 robot-steps:" in told
    assert "the trained policy:" in told
    assert (tmp_path / "kept" / "rllib_checkpoint.json").is_file()
    assert (tmp_path / "kept" / "robot.json").is_file()

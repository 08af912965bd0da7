"""A rollout of PPO on a GPU: each decision a CUDA graph of the network and of the worlds."""

import numpy as np
import pytest

from swarm_forage_env import array_env

pytestmark = pytest.mark.gpu


def test_a_rollout_of_cuda_graphs_is_the_rollout():
    torch = pytest.importorskip("torch")
    if not torch.cuda.is_available():
        pytest.skip("no NVIDIA GPU, or torch is built for a CPU")
    from training.actor_critic import ActorCritic
    from training.ppo_learner import PPOHyperparameters, PPOLearner
    from training.tensor_vec_env import TensorVecEnv

    terms = {"physics": "kinematic", "max_cycles": 20, "stagger": True, "shaping": 1.0}
    found = []
    for is_graph in (False, True):
        env = TensorVecEnv([array_env("es1", device="cuda", n_worlds=8, **terms)])
        torch.manual_seed(0)
        policy = ActorCritic(len(env.observation_layout), 2)
        learner = PPOLearner(env, policy, PPOHyperparameters(n_steps=16, n_minibatches=1))
        learner._repeated_epoch = None
        if not is_graph:
            learner._repeated = None
        learner.learn(3 * 16 * 10 * env.n_rows, seed=1)
        env.check()
        steps = env.blocks[0].episodes.steps.tolist()
        found.append((learner.state(), learner._rollout, steps))
        assert learner.robot_steps == 3 * 16 * 10 * env.n_rows
    (mine, first, steps), (his, second, his_steps) = found
    assert steps == his_steps
    assert first.ends.any()
    torch.testing.assert_close(first.observations, second.observations)
    torch.testing.assert_close(first.rewards, second.rewards)
    for name, array in mine.items():
        np.testing.assert_allclose(his[name], array, rtol=1e-4, atol=1e-5, err_msg=name)

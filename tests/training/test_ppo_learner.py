"""PPO in tensors: it learns what stable-baselines3 learns, on rows of any blocks of worlds."""

from copy import deepcopy
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose
from stable_baselines3 import PPO

from swarm_forage_env import ArrayEnv, ConfigError
from swarm_forage_env.spaces import Feature
from training import actor_critic, ppo_learner, tensor_vec_env
from training.actor_critic import ActorCritic, RecurrentActorCritic
from training.ppo_learner import PPOHyperparameters, PPOLearner
from training.tensor_vec_env import TensorVecEnv, tensor_of, torch_device, worlds_on
from training.vec_env import SwarmVecEnv

WORLDS = {"n_worlds": 2, "physics": "kinematic", "task.n_robots": 4, "max_cycles": 6,
          "decision_period": 10, "shaping": 1.0, "stagger": True}  # fmt: skip
"""Eight rows, whose episodes end within a rollout at two different times."""

EXCHANGES = {"learn": "weighting", "step_on": "exchange", "decision_period": None,
             "max_cycles": 600, "shaping": 0.0}  # fmt: skip

TERMS = PPOHyperparameters(
    discount=0.9, gae_lambda=0.8, n_steps=12, n_minibatches=3, n_epochs=4, learning_rate=3e-3
)
FOURS = replace(TERMS, rows_together=4)


def learner_of(terms=TERMS, policy=None, **changes):
    """A learner on those worlds, of a policy of dense layers."""
    env = TensorVecEnv([ArrayEnv("es1", **WORLDS | changes)])
    return PPOLearner(env, policy or ActorCritic(len(env.observation_layout), 2), terms)


def named(policy):
    """Parameters of a policy of stable-baselines3 by the names of an `ActorCritic`."""
    names = {"log_std": policy.log_std}
    for own, layers in {
        "actor": (*policy.mlp_extractor.policy_net, policy.action_net),
        "critic": (*policy.mlp_extractor.value_net, policy.value_net),
    }.items():
        names |= {f"{own}.{n}": each for n, each in torch.nn.Sequential(*layers).named_parameters()}
    return {name: each.detach().clone() for name, each in names.items()}


class Layers(ActorCritic):
    """Dense layers that the learner does not know as such: they stay modules."""


@pytest.mark.parametrize(("kind", "span"), [(ActorCritic, 512), (ActorCritic, 5), (Layers, 512)])
def test_rollout_advantages_and_update_are_those_of_stable_baselines3(monkeypatch, kind, span):
    monkeypatch.setattr(actor_critic, "SPAN", span)
    reference = PPO(
        "MlpPolicy", SwarmVecEnv("es1", **WORLDS), n_steps=12, batch_size=32, n_epochs=4,
        learning_rate=3e-3, gamma=0.9, gae_lambda=0.8, seed=0, device="cpu",
    )  # fmt: skip
    found, start = [], named(reference.policy)
    own = learner_of(policy=kind(reference.observation_space.shape[0], 2))
    own.policy.load_state_dict(start)
    minibatches = [torch.randperm(96) for _ in range(4)]
    by_decision, by_row = iter(minibatches), (n % 8 * 12 + n // 8 for n in minibatches)
    monkeypatch.setattr(torch, "randperm", lambda n, **_: next(by_decision))
    monkeypatch.setattr(np.random, "permutation", lambda n: next(by_row).numpy())
    advantages = ppo_learner.advantages
    monkeypatch.setattr(
        ppo_learner, "advantages", lambda *given: found.append(advantages(*given)) or found[0]
    )
    own.learn(960, seed=5)
    torch.manual_seed(5)
    reference.env.seed(5)
    reference.learn(96)
    assert_allclose(found[0].T.flatten(), reference.rollout_buffer.advantages.ravel(), atol=1e-5)
    assert own.diagnostics["train/clip_fraction"] > 0.0
    for name, parameter in named(reference.policy).items():
        learned = own.policy.get_parameter(name).detach()
        assert_allclose(learned, parameter, atol=1e-5, err_msg=name)
        assert (learned != start[name]).any(), name


def test_a_reward_is_credited_to_the_last_action_that_counted():
    column = torch.tensor
    rollout = ppo_learner.Rollout(
        noise=torch.empty(3, 1, 0), states=torch.empty(1, 0),
        observations=torch.empty(4, 1, 0), actions=torch.empty(3, 1, 0),
        log_probs=torch.empty(3, 1), values=column([[10.0], [99.0], [30.0], [40.0]]),
        rewards=column([[1.0], [2.0], [3.0]]), ends=torch.zeros(3, 1),
        acts=column([[True], [False], [True]]),
    )  # fmt: skip
    first, _, last = ppo_learner.advantages(rollout, 0.5, 0.8).flatten().tolist()
    assert last == pytest.approx(3.0 + 0.5 * 40.0 - 30.0)
    assert first == pytest.approx(1.0 + 0.5 * 2.0 + 0.25 * (30.0 + 0.8 * last) - 10.0)


def test_the_policy_learns_from_the_actions_that_count_alone(monkeypatch):
    counts, told, loss = [], [], ppo_learner.clipped_loss
    monkeypatch.setattr(
        ppo_learner,
        "clipped_loss",
        lambda ratio, gains: counts.append(ratio.shape[1]) or loss(ratio, gains),
    )
    learner = learner_of(**EXCHANGES)
    step, env = learner.env.step, learner.env
    monkeypatch.setattr(env, "step", lambda given: told.append(env.acts) or step(given))
    learner.learn(1, seed=0)
    assert not told[0].any()  # nobody's exchange ends as an episode begins
    acting = sum(int(each.sum()) for each in told)
    assert acting >= 6
    assert sum(counts) == acting * TERMS.n_epochs
    assert max(counts) - min(counts) <= 1


def test_worlds_go_on_from_one_call_to_the_next_until_a_seed_resets_them():
    learner, found = learner_of(replace(TERMS, n_steps=4), stagger=False), []
    for seed, decisions in ((None, 1), (None, 33), (0, 32), (7, 1)):
        learner.learn(10 * decisions, seed)
        episodes = learner.env.blocks[0].episodes
        next_seed = deepcopy(episodes.generators[0]).integers(2**32)
        found.append((episodes.steps.tolist(), learner.robot_steps, next_seed))
    steps, robot_steps, seeds = zip(*found, strict=True)
    assert steps == ([4, 4], [0, 0], [4, 4], [4, 4])  # twelve decisions are two episodes
    assert robot_steps == (320, 960, 1280, 1600)
    assert seeds[0] == seeds[2] != seeds[3]


@pytest.mark.parametrize(
    ("n_rows", "n_steps"), [(1, 128), (8192, 128), (8193, 127), (2**16, 16), (2**20, 16)]
)
def test_a_rollout_is_a_million_decisions_and_sixteen_of_each_row_at_least(n_rows, n_steps):
    learner = PPOLearner.__new__(PPOLearner)
    learner.env, learner.policies = SimpleNamespace(n_rows=2 * n_rows), [None, None]
    learner._hyperparameters = PPOHyperparameters()
    assert learner.n_steps == n_steps


def test_long_rollouts_have_many_minibatches(monkeypatch):
    monkeypatch.setattr(ppo_learner, "MIN_MINIBATCH", 20)
    learner, sizes = learner_of(), []
    descend = learner._descend
    monkeypatch.setattr(
        learner, "_descend", lambda *given: sizes.append(given[0].shape) or descend(*given)
    )
    learner.learn(1)
    assert sizes == [(1, 24)] * 4 * TERMS.n_epochs


class RobotAndTime:
    """The number of the robot, and the share of its world's time that is left."""

    def features(self, scenario, agents):
        return [Feature(name, "", 0.0, 4.0) for name in ("robot", "time")]

    def write(self, context, out):
        out[:, :, 0] = range(out.shape[1])
        out[:, :, 1] = context.time_left[:, None]


def test_minibatches_are_of_whole_worlds_where_rows_go_together():
    learner, found = learner_of(FOURS, observation=RobotAndTime), []
    descend, seen = (
        learner._descend,
        lambda numbers: learner._table.flatten(0, 1)[numbers.flatten(), :2],
    )
    learner._descend = lambda *given: found.append(seen(given[0])) or descend(*given)
    learner.learn(1)
    assert sum(map(len, found)) == 96 * TERMS.n_epochs
    for seen in found:
        numbers, times = seen.view(-1, 4, 2).unbind(2)
        assert (numbers == torch.arange(4) / 4).all()
        assert (times == times[:, :1]).all()
    assert len(times.unique()) > 1


def remembering(terms=TERMS, **changes):
    """A learner whose policy has a memory."""
    env = ArrayEnv("es1", **WORLDS | changes)
    sizes = len(env.observation_layout), env.action_space.shape[0]
    return learner_of(terms, RecurrentActorCritic(*sizes, hidden=(8, 8)), **changes)


def test_states_decision_by_decision_are_those_of_one_call():
    torch.manual_seed(0)
    network = RecurrentActorCritic(5, 2, hidden=(8, 8))
    seen, before = torch.randn(7, 3, 5), torch.randn(3, 8)
    ends = torch.zeros(7, 3)
    ends[2, 1] = ends[5, 0] = ends[6, 2] = 1.0
    each = network.each_state(torch.tanh(network.encoder(seen)), before, ends)
    torch.testing.assert_close(each, network.states(seen, before, ends))


def test_a_memory_is_of_one_episode_and_is_run_again_from_where_a_rollout_began():
    learner = remembering(learn="everything")
    learner.env.seed(0)
    first, observations = deepcopy(learner._roll_out(learner.env.reset()))
    second, _ = learner._roll_out(observations)
    assert not first.states.any()
    assert 0 < second.states.any(1).sum() < 8  # an episode ends as the rollout does
    policy, learner._adam.descend = learner.policy, lambda *_: None
    for rollout in (first, second):
        learner._rollout = rollout
        learner._update(rollout)
        numbers = learner._groups(rollout.acts)[0].flatten(1)
        _, critic_loss, log_ratio = learner._descend(numbers, numbers[:, :0])
        gains = ppo_learner.advantages(rollout, TERMS.discount, TERMS.gae_lambda)
        assert_allclose(log_ratio, 0.0, atol=1e-4)
        assert_allclose(critic_loss, gains.square().mean()[None], rtol=1e-4)
        time, row = rollout.ends[:-1].nonzero(as_tuple=True)
        assert len(set(time.tolist())) > 1
        fresh = policy.next_states(rollout.observations[time + 1, row], torch.zeros(len(row), 8))
        assert_allclose(
            rollout.values[time + 1, row], policy.critic(fresh)[:, 0].detach(), atol=1e-5
        )
    remembering(n_worlds=1, learners=1).learn(1, seed=0)  # a single row is a single minibatch


def group(terms=TERMS, hidden=(64, 64), **changes):
    """A learner of two policies, one of which may have other layers."""
    policies = [
        ActorCritic(len(learner_of().env.observation_layout), 2, hidden=each)
        for each in (hidden, (64, 64))
    ]
    return learner_of(terms, policies, **changes)


@pytest.mark.parametrize(
    ("make", "terms", "changes", "message"),
    [
        (learner_of, TERMS, {**EXCHANGES, "max_cycles": 2}, "0 exchanges in a rollout"),
        (learner_of, replace(TERMS, rows_together=3), {}, "=3: must divide the 8 rows"),
        (learner_of, FOURS, EXCHANGES, "rows that go together must act in the same"),
        (learner_of, TERMS, {"discrete": True, "policy": torch.nn.Linear(1, 1)}, "gives contin"),
        (remembering, FOURS, {}, "rows_together=4: a network with memory"),
        (group, TERMS, {"n_worlds": 3}, "2 policies side by side: need equal parts"),
        (group, TERMS, EXCHANGES, "2 policies side by side: must act in every"),
        (group, TERMS, {"hidden": (8,)}, "2 policies side by side: must be dense layers"),
        (remembering, TERMS, EXCHANGES, "rows that go together must act in"),
    ],
)
def test_what_cannot_be_learned_is_refused(make, terms, changes, message):
    with pytest.raises(ConfigError, match=message):
        make(terms, **changes).learn(1, seed=0)


def test_blocks_of_several_scenarios_are_joined_and_their_time_is_counted(monkeypatch):
    seconds = iter((5.0, 9.0, 9.0))
    timer = SimpleNamespace(perf_counter=lambda: next(seconds))
    monkeypatch.setattr(tensor_vec_env, "time", timer)
    sizes = {"n_worlds": 2, "task.n_robots": 6}, {"n_worlds": 1, "task.n_robots": 10}
    env = TensorVecEnv([ArrayEnv("es1", **WORLDS | each) for each in sizes])
    env.seed(0)
    assert env.reset().shape == (22, len(env.observation_layout))
    assert env.step(torch.zeros(22, 2)).rewards.shape == (22,)
    assert env.stepping_s == 4.0
    bad = {"nan": torch.full((22, 2), float("nan")), r"must be \(22, 2\)": torch.zeros(21, 2)}
    for says, actions in bad.items():
        with pytest.raises(ConfigError, match=says):
            env.step(actions)
    with pytest.raises(ConfigError, match=r"seeds \(1, 2\): must divide 1 worlds equally"):
        env.seed(1, 2)
    with pytest.raises(ConfigError, match="block 1: has action='course', and block 0 None; a"):
        TensorVecEnv([env.blocks[0], ArrayEnv("es1", action="course", **WORLDS)])


def test_torch_must_find_the_gpu_that_the_worlds_are_on(monkeypatch, experiment):
    for module in ("training.tensor_vec_env", "baselines.evaluation.evaluate_options"):
        monkeypatch.setattr(f"{module}.usable_gpu", lambda: None)
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    with pytest.raises(ConfigError, match=r"device='cuda': torch .* finds no GPU; install its"):
        torch_device("cuda")
    with pytest.raises(ConfigError, match=r"--device='cuda': torch .* finds no GPU"):
        experiment(layer="motion", algorithm="ppo", population=None, device="cuda").check()
    experiment(device="cuda").check()  # a search needs no torch


def test_worlds_are_on_a_gpu_for_cuda_alone():
    assert [worlds_on(each) for each in ("cpu", "meta", "cuda", "cuda:0")] == [
        "cpu", "cpu", "cuda", "cuda",
    ]  # fmt: skip
    with pytest.raises(ConfigError, match="device='cuda:1': worlds run on the first GPU"):
        worlds_on("cuda:1")
    assert torch_device("cpu") == torch.device("cpu")


def test_a_tensor_shares_the_memory_of_its_array():
    array = np.zeros((2, 3), np.float32)
    tensor_of(array)[1, 2] = 5.0
    assert array[1, 2] == 5.0
    assert tensor_of(np.broadcast_to(np.ones(2), (3, 2))).shape == (3, 2)


def test_policies_side_by_side_learn_what_each_learns_alone(monkeypatch):
    monkeypatch.setattr(actor_critic, "SPAN", 5)
    seeds, changes = (5, 9, 2), {"stagger": False}
    policies = [learner_of().policy for _ in seeds]
    together = learner_of(policy=deepcopy(policies), **changes | {"n_worlds": 6})
    together.learn(2 * 960, seeds)
    for k, (seed, policy) in enumerate(zip(seeds, policies, strict=True)):
        alone = learner_of(policy=policy, **changes)
        alone.learn(2 * 960, seed)
        mine, found = together.state(k), alone.state()
        assert mine.keys() == found.keys()
        for name, array in found.items():
            assert_allclose(mine[name], array, rtol=1e-3, atol=1e-5, err_msg=f"{k} {name}")
        assert together.all_diagnostics[k] == pytest.approx(alone.diagnostics, rel=1e-3, abs=1e-5)
        assert mine["robot_steps"] == 2 * 960


def test_a_group_goes_on_from_the_states_of_its_policies():
    learners = group(stagger=False), group(stagger=False)
    learners[0].learn(1, seed=0)
    for k in range(2):
        learners[1].restore(learners[0].state(k), k)
    for learner in learners:
        learner.learn(1, seed=3)
    for k in range(2):
        mine, his = (each.state(k) for each in learners)
        for name, array in mine.items():
            assert (array == his[name]).all(), name

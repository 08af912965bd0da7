"""Worlds on a GPU repeat their bits, ticks and episodes of a CPU; skipped without a GPU."""

import copy
import os
from dataclasses import replace

import numpy as np
import pytest

from baselines.evaluation.episode import run_episodes
from swarm_forage_env import ConfigError, array_env, device_loop
from swarm_forage_env.compiler import _bound_grid
from swarm_forage_env.device_loop import DeviceLoop
from swarm_forage_env.loop import Loop
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario
from tests.columns import check_same_bits

pytestmark = pytest.mark.gpu

FIVE = "nc", "ssgikf", "dsgikf", "ssgiff", "learned-motion"
LONG = [
    pytest.param(scenario, controller, marks=pytest.mark.slow)
    for scenario in ("es1", "es2:task.duration=1800", "es3:task.duration=1800")
    for controller in FIVE
]
"""Whole episodes, and half hours of worlds of 50 and 100 robots."""

MILLION = 1_000_000


@pytest.fixture
def torch():
    """Torch, where it is built for a GPU."""
    found = pytest.importorskip("torch")
    if not found.cuda.is_available():
        pytest.skip("torch is built for a CPU")
    return found


def scenario_of(text):
    """A scenario that may have a change, as es1:task.n_robots=4."""
    name, _, change = text.partition(":")
    return find_scenario(name, dict([change.split("=")]) if change else {})


def loop_of(scenario, controller, seeds, is_blank=False):
    """Worlds on a CPU."""
    what = scenario_of(scenario), CONTROLLERS[controller], seeds, "kinematic"
    return Loop(*what, is_blank=is_blank)


def after(ticks, scenario="es1", controller="ssgikf", seeds=range(64)):
    """The robots of these worlds after so many ticks on a GPU."""
    loop = DeviceLoop(loop_of(scenario, controller, seeds))
    for _ in range(ticks):
        loop.step()
    robots = loop.download().world.robots.copy()
    loop.check()
    return robots


def test_one_seed_gives_the_same_bits_twice_and_on_another_grid(monkeypatch):
    first = after(300)
    check_same_bits(after(300), first)
    monkeypatch.setattr(device_loop, "MAX_THREADS", 32)
    check_same_bits(after(300), first)
    monkeypatch.setattr(device_loop, "MAX_THREADS", 4)  # a thread has several robots
    check_same_bits(after(300), first)


def test_a_world_in_a_million_is_the_world_alone():
    def robots(seeds, which):
        gpu = DeviceLoop(loop_of("es1:task.n_robots=4", "ssgikf", seeds, is_blank=True))
        gpu.reset(seeds)
        for _ in range(200):
            gpu.step()
        gpu.check()
        return [gpu.memory.read(gpu.arrays["robots"][world : world + 1]) for world in which]

    picked = 0, 4_711, MILLION - 1
    for seed, found in zip(picked, robots(range(MILLION), picked), strict=True):
        check_same_bits(*robots([seed], [0]), found)


@pytest.mark.parametrize("scenario", ["es1", "es2", "es3", "mg1-hexagon"])
@pytest.mark.parametrize("controller", FIVE)
def test_ticks_are_those_of_a_cpu_bit_for_bit(scenario, controller):
    cpu = loop_of(scenario, controller, range(16))
    cpu.run(600)
    gpu = DeviceLoop(copy.deepcopy(cpu))
    cpu.run(50)
    gpu.run(50)
    there = gpu.download()
    gpu.check()
    check_same_bits(cpu.world.robots, there.world.robots)
    check_same_bits(cpu.controller.minds, there.controller.minds)


@pytest.mark.parametrize(
    ("scenario", "controller"),
    [("es1:task.duration=300", "ssgikf"), ("es1:task.duration=300", "learned-both"), *LONG],
)
def test_episodes_are_those_of_a_cpu(scenario, controller):
    what = scenario_of(scenario), CONTROLLERS[controller], range(100), "kinematic", os.cpu_count()
    cpu, gpu = (
        [replace(each, wall_s=0.0) for each in run_episodes(*what, device=device)]
        for device in ("cpu", "cuda")
    )
    assert gpu == cpu
    assert any(each.localisation_error_m for each in gpu)
    assert any(each.on_path_share for each in gpu)


def test_kept_machine_code_runs(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    found = []
    for hits in (0, 1):
        _bound_grid.cache_clear()
        there = DeviceLoop(loop_of("es1", "nc", range(3)))
        there.step()
        assert sum(there._run.dispatcher.stats.cache_hits.values()) == hits
        found.append(there.download().world.robots.copy())
    check_same_bits(*found)


def test_worlds_that_begin_anew_in_a_step_are_those_that_are_reset_after_it():
    terms = {"device": "cuda", "n_worlds": 9, "physics": "kinematic", "max_cycles": 4}
    one, two = (array_env("es1", stagger=True, stack=2, shaping=0.5, **terms) for _ in range(2))
    actions = one.memory.to_device(np.full((9, 10, 2), 0.3, np.float32))
    one.reset(seed=5), two.reset(seed=5)
    outputs = None
    for _ in range(10):
        final, rewards, *_ = one.step(actions)
        step = two.step_and_reset(actions, outputs)
        outputs = step.outputs
        np.testing.assert_array_equal(one.is_over, step.is_over)
        for mine, his in ((final, step.final), (rewards, step.rewards)):
            np.testing.assert_array_equal(mine.copy_to_host(), his.copy_to_host())
        if one.is_over.any():
            final, _ = one.reset(worlds=one.is_over)
        np.testing.assert_array_equal(final.copy_to_host(), step.observations.copy_to_host())
    check_same_bits(one.download().world.robots, two.download().world.robots)


def test_tensors_of_torch_go_in_and_come_out_without_a_copy(torch):
    env = array_env("es1", device="cuda", n_worlds=8, physics="kinematic")
    seen, _ = env.reset(seed=0)
    tensor = torch.as_tensor(seen, device="cuda")
    assert tensor.data_ptr() == seen.__cuda_array_interface__["data"][0]
    actions = torch.zeros((8, 10, 2), device="cuda")
    told = env.step(actions)
    kinds = [torch.as_tensor(each, device="cuda").dtype for each in told[:4]]
    assert kinds == [torch.float32, torch.float64, torch.bool, torch.bool]
    env.step(torch.full_like(actions, float("nan")))
    with pytest.raises(ConfigError, match="actions of world 0"):
        env.check()


def test_a_step_in_a_stream_of_torch_waits_for_what_was_asked_before_it(torch):
    """What follows the kernels on the default stream would read actions that are not there yet."""
    terms = {"device": "cuda", "n_worlds": 64, "physics": "kinematic"}
    drawn = torch.rand((64, 10, 2), device="cuda") - 0.5
    usual, other = array_env("es1", **terms), array_env("es1", **terms)
    seen = [torch.as_tensor(usual.reset(seed=0)[0], device="cuda")]
    seen += [torch.as_tensor(usual.step(drawn * k)[0], device="cuda") for k in (1.0, -1.0)]
    stream = torch.cuda.Stream()
    stream.wait_stream(torch.cuda.current_stream())
    with torch.cuda.stream(stream):
        other.stream = stream.cuda_stream
        found = [torch.as_tensor(other.reset(seed=0)[0], device="cuda").clone()]
        for k in (1.0, -1.0):
            actions = torch.zeros_like(drawn)
            torch.cuda._sleep(200_000_000)  # about a tenth of a second
            actions += drawn * k
            found.append(torch.as_tensor(other.step(actions)[0], device="cuda").clone())
    other.stream = 0
    stream.synchronize()  # codespell:ignore
    for mine, his in zip(seen, found, strict=True):
        assert torch.equal(mine, his)
    assert usual.state().tobytes() == other.state().tobytes()


def test_the_environment_of_torchrl_keeps_its_tensors_on_the_gpu(torch):
    pytest.importorskip("torchrl")
    from torchrl.envs import check_env_specs

    from training.torchrl_env import SwarmTorchEnv

    terms = {"physics": "kinematic", "return_state": False, "max_cycles": 5, "stagger": True}
    env = SwarmTorchEnv("es1", n_worlds=8, device="cuda", **terms)
    check_env_specs(env, seed=0)
    seen = env.rollout(10, break_when_any_done=False)
    assert all(seen[key].is_cuda for key in seen.keys(True, True))
    assert seen["next", "done"].sum() >= 8


def test_ppo_in_tensors_learns_on_the_gpu(torch):
    from training.actor_critic import ActorCritic
    from training.ppo_learner import PPOHyperparameters, PPOLearner
    from training.tensor_vec_env import TensorVecEnv

    terms = {"physics": "kinematic", "max_cycles": 20, "stagger": True, "shaping": 1.0}
    env = TensorVecEnv([array_env("es1", device="cuda", n_worlds=64, **terms)])
    policy = ActorCritic(len(env.observation_layout), 2)
    learner = PPOLearner(env, policy, PPOHyperparameters(n_steps=32))
    before = [each.detach().clone() for each in learner.policy.parameters()]
    learner.learn(2 * 32 * 10 * env.n_rows, seed=0)
    assert learner.robot_steps == 2 * 32 * 10 * env.n_rows
    for old, new in zip(before, learner.policy.parameters(), strict=True):
        assert new.is_cuda
        assert torch.isfinite(new).all()
        assert (new.cpu() != old.cpu()).any()


def test_an_update_of_ppo_as_graphs_is_the_update(torch):
    from training.actor_critic import ActorCritic
    from training.ppo_learner import PPOHyperparameters, PPOLearner
    from training.tensor_vec_env import TensorVecEnv

    learned = []
    for is_graph in (False, True):
        env = TensorVecEnv([array_env("es1", device="cuda", n_worlds=8, physics="kinematic")])
        torch.manual_seed(0)
        policies = [ActorCritic(len(env.observation_layout), 2) for _ in range(2)]
        learner = PPOLearner(env, policies, PPOHyperparameters(n_steps=16, n_minibatches=7))
        if not is_graph:
            learner._repeated_epoch = None
        learner.learn(3 * 16 * 10 * env.n_rows // 2, seed=1)
        learned.append(learner.state(1))
    for name, array in learned[0].items():
        np.testing.assert_allclose(learned[1][name], array, rtol=1e-4, atol=1e-5, err_msg=name)


def test_a_candidate_among_many_has_the_round_trips_that_it_has_alone(tmp_path):
    from training.candidate_rollouts import CandidateRollouts
    from training.experiment import Experiment
    from training.linear_motion_policy import LINEAR_MOTION

    terms = Experiment("motion", ("es1",), "cma", tmp_path, settings={"task.duration": "300"})
    what = terms.scenarios_by_name, terms.base_controller, "kinematic"
    rollouts = CandidateRollouts(*what, architecture=LINEAR_MOTION, device="cuda")
    networks = np.random.default_rng(0).normal(0.0, 0.1, (8, 60)).astype(np.float32)
    together = rollouts.round_trips(networks, range(20))["es1"]
    alone = rollouts.round_trips(networks[3:4], range(20))["es1"]
    np.testing.assert_array_equal(together[3], alone[0])
    assert len(np.unique(together.sum(axis=1))) > 1


def test_memory_is_flat():
    from numba import cuda

    env = array_env("es1", device="cuda", n_worlds=1024, physics="kinematic", max_cycles=10_000)
    env.reset(seed=0)
    actions = env.memory.to_device(np.zeros((1024, 10, 2), np.float32))
    free = []
    for n_steps in (50, 500):
        for _ in range(n_steps):
            env.step(actions)
        env.loop.check()  # waits for the GPU
        free.append(cuda.current_context().get_memory_info().free)
    assert free[0] - free[1] < 2**24

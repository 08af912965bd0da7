"""SwarmTorchEnv: what TorchRL is told of a block of worlds; run by `make test-torchrl`."""

import numpy as np
import pytest

from swarm_forage_env import ArrayEnv, ConfigError, parallel_env

pytestmark = [
    pytest.mark.torchrl,
    pytest.mark.filterwarnings("ignore"),  # its parts warn about each other's versions
    pytest.mark.usefixtures("one_thread"),
]

FORMS = [
    {"learn": "motion"},
    {"learn": "weighting"},
    {"learn": "both", "discrete": True},
    {"learn": "everything"},
    {"discrete": True, "categorical_actions": False},
    {"return_state": False},
    {"normalise": False},
    {"learners": 2},
    {"learn": "weighting", "step_on": "exchange"},
    {"randomise": {"radio.max_range": (0.1, 0.2)}},
    {"scenario": "waypoints-05"},
    {"scenario": "waypoints-05", "discrete": True},
]


@pytest.fixture
def make(small):
    """A function that makes an environment of a few worlds."""
    from training.torchrl_env import SwarmTorchEnv

    def made(n_worlds=2, **options):
        return SwarmTorchEnv(n_worlds=n_worlds, **{"max_cycles": 20, **small, **options})

    return made


def rollout(env, steps, seed, **terms):
    import torch

    env.set_seed(seed)
    torch.manual_seed(seed)
    return env.rollout(steps, **terms)


@pytest.mark.parametrize("form", FORMS, ids=str)
def test_it_does_as_its_specs_say(make, form):
    from torchrl.envs import check_env_specs

    check_env_specs(make(**form), seed=0)


def test_it_has_the_keys_of_the_wrapper_of_pettingzoo(make, small):
    from torchrl.envs.libs.pettingzoo import PettingZooWrapper

    env = make(n_worlds=1)
    wrapped = PettingZooWrapper(parallel_env(max_cycles=20, **small), return_state=True)
    assert env.group_map == wrapped.group_map == {"epuck": [f"epuck_{k}" for k in range(4)]}
    own, theirs = env.rollout(3), wrapped.rollout(3)
    leaves = set(own.keys(True, True))
    assert leaves == set(theirs.keys(True, True))
    for key in leaves:
        assert own[key].dtype == theirs[key].dtype, key
        assert own[key].shape == (1, *theirs[key].shape), key


@pytest.mark.parametrize("form", FORMS[:3], ids=str)
def test_a_rollout_is_that_of_the_parallel_env_number_for_number(make, small, form):
    seen = rollout(make(**form), 20, seed=5)
    for world in range(2):
        env = parallel_env(max_cycles=20, **small, **form)
        observations, infos = env.reset(seed=5 + world)
        for step in range(20):
            now = seen[world, step]
            assert np.array_equal(now["epuck", "observation"], list(observations.values()))
            actions = dict(zip(env.agents, now["epuck", "action"].numpy(), strict=True))
            observations, rewards, _, truncated, infos = env.step(actions)
            then = now["next"]
            expected = np.array(list(rewards.values()), np.float32)
            assert np.array_equal(then["epuck", "reward"][:, 0], expected)
            assert np.array_equal(then["state"], env.state())
            assert then["truncated"].all() == all(truncated.values()) == (step == 19)
            for k, info in enumerate(infos.values()):
                told = then["epuck", "info"][k].to_dict()
                assert told == {name: np.float32(value) for name, value in info.items()}


def test_a_reset_takes_seeds_and_options_as_the_batch_api_does(make, small):
    terms = {"seed": 5, "options": {"task.area_distance": 1.2}}
    observed, _ = ArrayEnv(n_worlds=2, **small).reset(**terms)
    assert np.array_equal(make().reset(**terms)["epuck", "observation"], observed)


def nothing(before, events, after):
    """A reward of one's own."""
    return 0.0


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"device": "cuda:1"}, "device='cuda:1': worlds run on the first GPU; set CUDA_VISIBLE"),
        ({"device": "cuda"}, "return_state=True: the state is written on a CPU only"),
        ({"device": "cuda", "return_state": False, "reward": nothing}, "nothing.*on a CPU only"),
    ],
)
def test_what_does_not_run_on_a_gpu_is_refused(make, options, complaint):
    with pytest.raises(ConfigError, match=complaint):
        make(**options)


def test_a_world_is_started_anew_at_its_end_from_another_seed(make):
    seen = rollout(make(max_cycles=5), 10, seed=1, break_when_any_done=False)
    assert seen["next", "truncated"].squeeze(-1).nonzero()[:, 1].tolist() == [4, 9, 4, 9]
    assert not seen["next", "terminated"].any()
    assert not (seen["state"][:, 0] == seen["state"][:, 5]).all(-1).any()


def test_staggered_worlds_end_one_after_the_other_and_the_others_go_on(make):
    seen = rollout(make(max_cycles=6, stagger=True), 9, seed=1, break_when_any_done=False)
    over = seen["next", "done"].squeeze(-1)
    assert over.nonzero().tolist() == [[0, 2], [0, 8], [1, 5]]
    whole = rollout(make(max_cycles=6), 6, seed=1)
    assert (seen[1, :6]["state"] == whole[1]["state"]).all()


def test_actions_are_the_tensors_numbers_and_results_are_never_overwritten(make):
    env = make()
    first = env.rand_step(env.reset())
    kept = first.clone()
    env.rand_step(first["next"].clone())
    assert (first == kept).all()


def test_a_frame_shows_the_first_world(make):
    pytest.importorskip("pygame")
    env = make()
    env.reset()
    frame = env.render(width=400)
    assert (frame.shape[1:], frame.dtype) == ((400, 3), np.uint8)
    assert make(scenario="waypoints-05").has_render

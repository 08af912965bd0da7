"""TorchRL and BenchMARL: the examples train; run by `make test-torchrl`."""

import math

import pytest

pytestmark = [
    pytest.mark.torchrl,
    pytest.mark.filterwarnings("ignore"),  # they warn about each other's versions
    pytest.mark.usefixtures("one_thread"),
]


@pytest.fixture
def terms(small):
    """What the environment is made with."""
    return {"scenario": "es1", "max_cycles": 60, **small}


@pytest.mark.parametrize("learn", ["motion", "weighting", "both", "everything"])
def test_torchrl_accepts_the_environment(example, terms, learn):
    from torchrl.envs import check_env_specs

    env = example("torchrl_mappo").make_env(1, learn=learn, **terms)
    check_env_specs(env)
    assert env.group_map == {"epuck": [f"epuck_{k}" for k in range(4)]}


@pytest.mark.parametrize("learn", ["motion", "weighting"])
def test_torchrl_trains_one_policy_and_one_seed_gives_one_policy(example, terms, learn):
    import torch

    mappo = example("torchrl_mappo")
    untrained, one, other = (
        list(mappo.train(iterations, 1, 120, learn=learn, **terms).parameters())
        for iterations in (0, 2, 2)
    )
    assert all(torch.equal(a, b) for a, b in zip(one, other, strict=True))
    assert all(torch.isfinite(values).all() for values in one)
    assert not any(torch.equal(a, b) for a, b in zip(untrained, one, strict=True))


@pytest.mark.parametrize(
    ("task", "learn"), [("ES1_MOTION", "motion"), ("ES1_WEIGHTING", "weighting")]
)
def test_benchmarl_trains_a_task(example, terms, tmp_path, task, learn):
    experiment = example("benchmarl_task").train(
        task, "mappo", {**terms, "learn": learn}, iterations=2, steps=240, worlds=2, out=tmp_path
    )
    assert (experiment.n_iters_performed, experiment.total_frames) == (2, 480)
    assert math.isfinite(experiment.mean_return)
    assert list(tmp_path.rglob("collection_epuck_info_round_trips.csv"))


def test_benchmarl_gives_every_world_its_own_episodes(example, terms):
    import torch

    torch.manual_seed(1)
    task = example("benchmarl_task")
    config = {**terms, "learn": "motion"}
    make = task.SwarmForageTask.ES1_MOTION.get_task(config=config).get_env_fun(2, True, 1, "cpu")
    one, other = (make().reset()["state"] for _ in range(2))
    assert not torch.equal(one, other)


def test_the_tasks_by_name_are_environments(example):
    task = example("benchmarl_task")
    assert {each.name for each in task.SwarmForageTask} == set(task.CONFIGS)
    for config in task.CONFIGS.values():
        assert task.parallel_env(**config).max_cycles == config["max_cycles"]

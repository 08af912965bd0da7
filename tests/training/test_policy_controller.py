"""Policies of other trainers run as controllers, and do what they did in training."""

import json

import numpy as np
import pytest
import torch
from gymnasium.spaces import Discrete
from numpy.testing import assert_allclose, assert_array_equal
from stable_baselines3 import A2C, DQN, PPO, SAC, TD3
from stable_baselines3.common.torch_layers import FlattenExtractor

import training.controllers  # noqa: F401 the kinds of policies, also where no package is installed
from baselines.evaluation.episode import run_episodes
from baselines.evaluation.experiment_config import changed_parameters
from swarm_forage_env import parallel_env
from swarm_forage_env.controllers import find_controller, find_controllers, parse_controller
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario
from training.policy_controller import policy_controller
from training.vec_env import SwarmVecEnv

BUSY = {"task.n_robots": 4, "robot.cruise_speed": 0.12, "task.area_distance": 0.62}
"""Numbers of es1 under which robots soon find areas and meet."""

FAST = {"physics": "kinematic", "task.duration": 60.0, **BUSY}


@pytest.fixture(scope="module")
def scenario():
    return find_scenario("es1", {"task.duration": 60.0, **BUSY})


@pytest.fixture(autouse=True)
def _one_thread():
    torch.set_num_threads(1)


@pytest.fixture
def model(tmp_path):
    """Save an untrained model of an environment; its wheels do something, as weights are larger."""

    def make(algorithm=PPO, policy_kwargs=None, file="model.zip", **options):
        env = SwarmVecEnv("es1", n_worlds=1, **FAST, **options)
        made = algorithm("MlpPolicy", env, policy_kwargs=policy_kwargs, seed=0, device="cpu")
        if algorithm in (PPO, A2C):
            with torch.no_grad():
                made.policy.action_net.weight.mul_(100.0)
        made.save(tmp_path / file)
        return made, env

    return make


def asked(controller, scenario, space):
    """What a controller asks of a saved model: layers of PPO are run by a kernel, not by torch."""
    act = controller.policy.start(controller.form(scenario)).act

    def predict(observed):
        return act(observed, None, np.zeros((len(observed), 0), np.float32))[0]

    if isinstance(space, Discrete):
        return predict
    return lambda observed: np.clip(predict(observed), space.low, space.high)


def stepped(predict, env, seed):
    """Round trips of an episode, by the deterministic policy; when its last step began, and where
    the robots were then."""
    env.reset()
    (observed,), _ = env.env.reset(seed=seed)
    done = np.array([False])
    while not done.any():
        tick, poses = env.env.world.worlds["ticks"][0], env.env.world.robots["pose"].copy()
        observed, _, done, infos = env.step(predict(observed))
    return [info["round_trips"] for info in infos], tick, poses


def ran(controller, scenario, seed, ticks):
    """Round trips of the second episode of the controller, and poses after so many ticks."""
    loop = Loop(scenario, controller, [seed + 1], "kinematic")
    loop.run(13)
    loop.reset([seed])
    for tick in range(scenario.n_ticks):
        if tick == ticks:
            poses = loop.world.robots["pose"].copy()
        loop.step()
    return loop.world.robots["round_trips"][0].tolist(), poses


KEYWORDS = {
    "motion": {"decision_period": 5},
    "in SI": {"normalise": False, "action": "wheels", "decision_period": 5},
    "stacked": {"stack": 3, "observation": ["layer", "previous_action", "time_left", "one_hot"]},
    "choices": {"discrete": True, "decision_period": 4, "controller": "dsgiff:beta=0.02"},
    "grid": {"discrete": (3, 5), "decision_period": 10},
    "corrections": {"residual": True, "controller": "ssgiff", "decision_period": 5},
    "both": {"learn": "both"},
    "weighting": {"learn": "weighting"},
    "exchanges": {"learn": "weighting", "step_on": "exchange", "stack": 2,
                  "observation": ["layer", "previous_action"]},
    "randomised": {"randomise": {"sensors.ground_noise": (0.0, 0.0)}, "decision_period": 5},
    "everything": {"learn": "everything", "decision_period": 5},
}  # fmt: skip


@pytest.mark.parametrize("name", KEYWORDS)
def test_a_saved_model_does_as_a_controller_what_it_did_in_its_environment(
    name, model, scenario, tmp_path
):
    _, env = model(**KEYWORDS[name])
    drawn = KEYWORDS[name].get("randomise", {})
    scenario = find_scenario(scenario, {key: low for key, (low, _) in drawn.items()})
    controller = find_controller(f"sb3:{tmp_path / 'model.zip'}")
    trips, tick, poses = stepped(asked(controller, scenario, env.action_space), env, 7)
    again, where = ran(controller, scenario, 7, tick)
    assert_array_equal(where, poses[0][None])
    assert again == trips


@pytest.mark.parametrize("first", ["motion", "weighting"])
def test_policies_of_two_layers_run_together(first, model, scenario, tmp_path):
    """They do what the second did in its training beside the first, and so in either order."""
    second = "weighting" if first == "motion" else "motion"
    one, other = (f"sb3:{tmp_path / layer}.zip" for layer in (first, second))
    forms = {"motion": {"residual": 0.2, "decision_period": 5}, "weighting": {}}
    model(learn=first, file=f"{first}.zip", **forms[first])
    _, env = model(learn=second, file=f"{second}.zip", controller=one, **forms[second])
    with pytest.raises(ConfigError, match=r"names no controller to run it beside .*controller="):
        find_controller(other)
    joined = find_controller(f"{other},controller={one}")
    stored = json.loads(changed_parameters(joined))  # of which `plot` makes it again
    assert find_controller("sb3").with_parameters(stored) == joined
    with pytest.raises(UnknownNameError, match="no kind of policy named 'SB4Policy'"):
        joined.with_parameters({**stored, "beside": "SB4Policy"})
    trips, ticks, poses = stepped(asked(joined, scenario, env.action_space), env, 7)
    model(learn=second, file=f"{second}.zip", **forms[second])  # the same network
    for each in (joined, find_controller(f"{one},controller={other}")):
        again, where = ran(each, scenario, 7, ticks)
        assert_array_equal(where, poses[0][None])
        assert again == trips
    for each in (one, other):
        assert (ran(find_controller(each), scenario, 7, ticks)[1] != poses[0]).any()
    with pytest.raises(ConfigError, match=r"replaces motion, and policy .* beside it motion; of"):
        find_controller(f"{other},learn=motion,controller={one},beside.learn=motion")


def test_an_episode_does_not_depend_on_its_neighbours_or_threads(model, scenario, tmp_path):
    model(decision_period=5)
    controller = find_controller(f"sb3:{tmp_path / 'model.zip'}")
    together = run_episodes(scenario, controller, [3, 4, 5], "kinematic", threads=2)
    for episode in together:
        (alone,) = run_episodes(scenario, controller, [episode.seed], "kinematic")
        assert alone.on_path_over_time == episode.on_path_over_time
        assert alone.messages == episode.messages
        assert alone.localisation_error_m == episode.localisation_error_m


@pytest.mark.parametrize(
    ("algorithm", "options"), [(A2C, {}), (DQN, {"discrete": True}), (SAC, {}), (TD3, {})]
)
def test_other_algorithms_need_no_pickle_either(algorithm, options, model, scenario, tmp_path):
    made, _ = model(algorithm, **options)
    controller = find_controller(f"sb3:{tmp_path / 'model'}")
    form = controller.form(scenario)
    observed = np.random.default_rng(0).uniform(-1, 1, (4, len(form.layout))).astype(np.float32)
    own = asked(controller, scenario, made.action_space)(observed)
    assert_allclose(own, made.predict(observed, deterministic=True)[0], rtol=1e-4, atol=1e-5)


def test_folders_of_sweeps_can_be_named(model, tmp_path, monkeypatch):
    (tmp_path / "lr=0.1,seed=3").mkdir()
    model(file="lr=0.1,seed=3/model.zip", decision_period=5)
    monkeypatch.chdir(tmp_path)
    for file in ("lr=0.1,seed=3/model.zip", f"{tmp_path}/lr=0.1,seed=3/model.zip"):
        found = find_controller(f"sb3:{file},chance=true")
        assert (found.policy.file, found.policy.chance) == (file, True)
        beside = parse_controller(f"learned-weighting:refractory=9,policy={file},pause=4")[1]
        assert beside == {"refractory": "9", "policy": file, "pause": "4"}


def test_nothing_is_unpickled_unless_asked_for(model, scenario, tmp_path, monkeypatch):
    model(policy_kwargs={"features_extractor_class": FlattenExtractor})

    def unpickled(*_, **__):
        raise AssertionError("a pickle was opened")

    with monkeypatch.context() as patched:
        patched.setattr("cloudpickle.loads", unpickled)
        patched.setattr("stable_baselines3.common.save_util.json_to_data", unpickled)
        with pytest.raises(ConfigError, match=r"its policy_kwargs can only .*trust=true"):
            find_controller(f"sb3:{tmp_path / 'model.zip'}").check_usable(scenario)
        model(file="plain.zip", policy_kwargs={"activation_fn": torch.nn.ReLU, "net_arch": [8]})
        find_controller(f"sb3:{tmp_path / 'plain.zip'}").check_usable(scenario)
    find_controller(f"sb3:{tmp_path / 'model.zip'},trust=true").check_usable(scenario)


def test_a_policy_can_be_the_team_mate_of_a_learner(model, tmp_path):
    _, env = model(decision_period=5)
    name = f"sb3:{tmp_path / 'model.zip'}"
    predict = asked(find_controller(name), find_scenario("es1", {**BUSY}), env.action_space)
    mates = ArrayEnv("es1", 1, name, learners=[1], decision_period=5, **FAST)
    env.reset()
    observed = env.env.reset(seed=5)[0][0]
    mates.reset(seed=5)
    for _ in range(40):
        action = predict(observed)
        observed = env.step(action)[0]
        mates.step(action[None, 1:2])
        assert_array_equal(mates.world.robots["pose"], env.env.world.robots["pose"])
    stands = np.float32([[[-1.0, 0.0]]])
    before = mates.world.robots["pose"].copy()
    mates.step(stands)
    moved = (mates.world.robots["pose"] != before).any(axis=2)[0]
    assert mates.world.robots["command"]["wheels"][0, 1].tolist() == [0.0, 0.0]
    assert moved[[0, 2, 3]].all()


def test_a_snapshot_under_another_policy_is_refused_and_changes_nothing(model, scenario, tmp_path):
    model(decision_period=5)
    model(file="stacked.zip", stack=2)
    model(A2C, file="alike.zip", decision_period=5)
    name, *others = (f"sb3:{tmp_path / file}.zip" for file in ("model", "stacked", "alike"))
    loop, twin = (Loop(scenario, find_controller(name), [1], "kinematic") for _ in range(2))
    loop.run(20)
    twin.run(20)
    for other in (*others, f"{name},controller=dsgiff"):
        another = Loop(scenario, find_controller(other), [2], "kinematic")
        another.run(10)
        with pytest.raises(ConfigError, match="this one, whose controller has other layers or pol"):
            loop.restore(another.snapshot())
    loop.run(100)
    twin.run(100)
    assert loop.world.robots.tobytes() == twin.world.robots.tobytes()


def test_robots_with_a_policy_and_others_make_a_swarm(model, scenario, tmp_path):
    model(decision_period=5)
    name = f"sb3:{tmp_path / 'model.zip'}"
    same = find_controllers([name] * 4, scenario)
    mixed = find_controllers({0: name, 2: name, "*": "ssgikf"}, scenario)
    other = find_controllers({0: name, 2: name, "*": "dsgiff"}, scenario)
    loops = [
        Loop(scenario, each, [1], "kinematic")
        for each in (same, mixed, other, find_controller("ssgikf"))
    ]
    for loop in loops:
        loop.step()
    alone, among, apart, ssgikf = (loop.world.robots["command"]["wheels"][0] for loop in loops)
    assert_allclose(alone[[0, 2]], among[[0, 2]], atol=1e-6)  # of fewer rows
    assert_array_equal(among[[1, 3]], ssgikf[[1, 3]])
    assert_array_equal(apart[[0, 2]], among[[0, 2]])
    assert (among[[0, 2]] != ssgikf[[0, 2]]).any()


def test_a_policy_of_everything_has_no_room_for_a_learner(model, tmp_path):
    model(learn="everything")
    with pytest.raises(ConfigError, match=r"replaces every layer, .* left for robot 0 to learn"):
        parallel_env("es1", controller=f"sb3:{tmp_path / 'model.zip'}", **FAST)


@pytest.mark.parametrize("learn", ["motion", "everything"])
def test_a_policy_of_everything_is_a_team_mate_of_learners(learn, model, scenario, tmp_path):
    made, env = model(learn="everything", decision_period=5)
    named = f"sb3:{tmp_path / 'model.zip'}"
    rest = dict.fromkeys(range(1, scenario.task.n_robots), named)
    options = {"learn": learn, "learners": 1, "decision_period": 5, "physics": "kinematic"}
    mixed = ArrayEnv(scenario, controller=rest, **options)
    mixed.reset(seed=7)
    (seen,), _ = env.env.reset(seed=7)
    predicted = made.predict(seen, deterministic=True)[0]
    still = np.zeros((1, 1, *mixed.action_shape), np.float32)
    mixed.step(still)
    actions = env.env.actions
    own = actions.form.to_raw(actions.rows(predicted))[1:, :2]
    assert_allclose(mixed.world.robots["command"]["wheels"][0, 1:], own, rtol=1e-5)
    for _ in range(20):
        mixed.step(still)
    assert np.isfinite(mixed.state()).all()


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("sb3", "which file"),
        ("sb3:", "which file"),
        ("sb3:text.zip", "must be what .* writes"),
        ("sb3:model.zip,stack=0", "stack='0'"),
        ("sb3:model.zip,step_on=exchange", "step_on='exchange': needs learn='weighting'"),
        ("sb3:model.zip,observation=layer+radar", "no observation named 'radar'"),
        ("sb3:model.zip,learn=motoin", "did you mean 'motion'"),
        ("sb3:model.zip,normalise=false", "feature 8 .* was situation.ground.left .of its"),
        ("sb3:model.zip,file=model.zip", "given twice"),
        ("sb:model.zip", "must be parameter=value|did you mean 'sb3'"),
        ("callable:math", "a module and a function"),
        ("callable:no_rules:ahead", "No module"),
        ("callable:math:back", "no attribute"),
        ("callable:math:pi", "is a float, not a function"),
    ],
)
def test_what_cannot_be_used_is_refused_by_name(name, why, model, scenario, tmp_path, monkeypatch):
    model()
    (tmp_path / "text.zip").write_text("no zip")
    monkeypatch.chdir(tmp_path)
    with pytest.raises((ConfigError, UnknownNameError), match=why):
        find_controller(name).check_usable(scenario)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (np.full((4, 2), np.nan), r"drive\.speed=nan: .* its cause, such as a division by 0"),
        (np.full((4, 2), -np.inf), r"drive\.speed=-inf: .* its cause, such as a division by 0"),
        ([[0.0, 0.0], [0.0]], r"gives no array of actions \(setting an array element"),
        (torch.zeros(4, 2, requires_grad=True), r"no array of actions \(.* requires grad"),
        (np.full((4, 2), 5), r"drive\.speed=5"),  # whole numbers are not clipped to the bounds
        (np.full((4, 3), 5.0), r"shape \(3,\): must be \(2,\)"),
    ],
    ids=["NaN", "infinite", "ragged", "with gradients", "whole", "wide"],
)
def test_actions_that_are_no_numbers_are_refused(scenario, given, message):
    bad = policy_controller(lambda seen: given)
    with pytest.raises(ConfigError, match=rf"^policy FunctionPolicy: .*{message}"):
        run_episodes(scenario, bad, [1], "kinematic")

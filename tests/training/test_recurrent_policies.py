"""Policies with a hidden state: it is of one robot, and lasts for one episode."""

import pickle

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose, assert_array_equal
from sb3_contrib import RecurrentPPO

import training.controllers  # noqa: F401 the kinds of policies, also where no package is installed
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario
from training.policy_controller import policy_controller
from training.vec_env import SwarmVecEnv

NUMBERS = {"task.n_robots": 4, "task.duration": 30.0}
PERIOD, DECISIONS = 5, 20
KEYWORDS = {"learn": "everything", "decision_period": PERIOD, "physics": "kinematic", **NUMBERS}
NEAR = find_scenario("near", NUMBERS)


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    """A model after a few steps on `near`, with larger weights, so that it moves; and its file."""
    torch.set_num_threads(1)
    env = SwarmVecEnv("near", n_worlds=2, **KEYWORDS)
    model = RecurrentPPO(
        "MlpLstmPolicy", env, n_steps=8, batch_size=16, n_epochs=1, seed=0, device="cpu",
        policy_kwargs={"lstm_hidden_size": 8, "n_lstm_layers": 2},
    )  # fmt: skip
    model.learn(8 * env.num_envs)
    with torch.no_grad():
        model.policy.action_net.weight.mul_(100.0)
    file = tmp_path_factory.mktemp("recurrent") / "model.zip"
    model.save(file)
    return model, file


def driven(model, seed, remembers=True):
    """The poses after some decisions of the model, whose states are kept by hand."""
    env = SwarmVecEnv("near", n_worlds=1, **KEYWORDS)
    (observed,), _ = env.env.reset(seed=seed)
    states = None
    for _ in range(DECISIONS):
        actions, states = model.predict(observed, states if remembers else None, deterministic=True)
        observed, *_ = env.step(actions)
    return env.env.world.robots["pose"][0].copy()


def ran(controller, seeds, scenario=NEAR):
    """The poses after as many decisions of the controller, in each world's second episode."""
    loop = Loop(scenario, controller, [seed + 1 for seed in seeds], "kinematic")
    loop.run(13)
    loop.reset(seeds)
    loop.run(PERIOD * DECISIONS)
    return loop.world.robots["pose"].copy()


def test_a_recurrent_model_does_what_it_does_by_hand_with_its_states(trained, monkeypatch):
    model, file = trained

    def unpickled(*_, **__):
        raise AssertionError("a pickle was opened")

    monkeypatch.setattr("cloudpickle.loads", unpickled)
    controller = find_controller(f"sb3:{file}")
    together = ran(controller, [7, 8])
    assert_array_equal(together, [driven(model, 7), driven(model, 8)])
    assert_array_equal(ran(controller, [8]), together[1:])
    assert controller.form(find_scenario(NEAR, {"radio.frames": 1}))  # whose bound is 1, not 2
    assert not np.array_equal(driven(model, 7, remembers=False), together[0])


def test_a_recurrent_model_draws_around_what_it_does_without_chance(trained):
    model, file = trained
    controller = find_controller(f"sb3:{file},chance=true")
    form = controller.form(NEAR)
    act, rng = controller.policy.start(form).act, np.random.default_rng(0)
    observed = rng.uniform(-1, 1, (4, len(form.layout))).astype(np.float32)
    hidden, cell = rng.normal(size=(2, 2, 4, 8)).astype(np.float32)  # of layers, robots, units
    rows = np.stack([np.r_[hidden[:, k].ravel(), cell[:, k].ravel()] for k in range(4)])
    wanted, after = model.predict(observed, (hidden, cell), deterministic=True)
    draws = rng.normal(size=(4, len(form.action.layout)))
    deviation = model.policy.log_std.exp().detach().numpy()
    mean, states = act(observed, 0.0 * draws, rows)
    assert_array_equal(np.clip(mean, -1.0, 1.0), wanted)
    assert_array_equal(states[1], np.r_[after[0][:, 1].ravel(), after[1][:, 1].ravel()])
    assert_allclose(act(observed, draws, rows)[0], mean + deviation * draws, atol=1e-5)
    assert_array_equal(ran(controller, [7, 8]), ran(controller, [8, 7])[::-1])


def waver(observed, states):
    """Drive by the number of decisions so far, and by the robot's own number."""
    after = states + 1.0 + np.arange(len(states))[:, None] * [[0.1, 0.0]]
    return np.sin(after).astype(np.float32), after


def test_a_function_keeps_a_state_for_each_robot_and_episode():
    asked = []

    def step(observed, states):
        asked.append(states[:, 0].tolist())
        return waver(observed, states)

    scenario = find_scenario("es1", NUMBERS)
    loop = Loop(scenario, policy_controller(step, n_state=2, decision_period=5), [1], "kinematic")
    asked.clear()
    loop.run(11)
    loop.reset([1])
    loop.step()
    assert_allclose(asked, [[0.0] * 4, [1.0, 1.1, 1.2, 1.3], [2.0, 2.2, 2.4, 2.6], [0.0] * 4])


def test_a_copied_episode_goes_on_with_its_states():
    mates = policy_controller(waver, n_state=2)
    env = ArrayEnv("es1", 2, mates, learners=[1], physics="kinematic", **NUMBERS)
    env.reset(seed=1)
    action = np.full((2, 1, 2), 0.5, np.float32)
    for _ in range(3):
        env.step(action)
    other = pickle.loads(pickle.dumps(env))
    for each in (env, other):
        for _ in range(3):
            each.step(action)
    assert_array_equal(env.world.robots["pose"], other.world.robots["pose"])


def test_a_function_of_a_module_has_a_state_too(tmp_path, monkeypatch):
    code = "import numpy as np\ndef own(seen, states):\n    return np.sin(states + 1), states + 1\n"
    (tmp_path / "my_memory.py").write_text(code + f"own.reads = [{str(tmp_path / 'w')!r}]\n")
    monkeypatch.syspath_prepend(tmp_path)
    named = find_controller("callable:my_memory:own,n_state=2")
    assert named.policy.reads[-2:] == (tmp_path / "my_memory.py", tmp_path / "w")
    own = policy_controller(lambda seen, states: (np.sin(states + 1), states + 1), n_state=2)
    scenario = find_scenario("es1", NUMBERS)
    assert_array_equal(ran(named, [3], scenario), ran(own, [3], scenario))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (np.zeros((4, 2)), "gives a ndarray; with n_state=3 it must give actions and the next"),
        ((np.zeros((4, 2)), np.zeros((4, 2))), r"gives states \(4, 2\) of float64; must be"),
        ((np.zeros((4, 2)), np.zeros(3)), r"gives states \(3,\) of float64; must be"),
        ((np.zeros((4, 2)), np.full((4, 3), np.nan)), r"finite float32 numbers of shape \(4, 3"),
        ((np.zeros((4, 2)), np.full((4, 3), 1e300)), r"finite float32 numbers of shape \(4, 3"),
        ((np.zeros((4, 2)), torch.zeros(4, 3, requires_grad=True)), "gives no array of states"),
    ],
    ids=["no pair", "wide", "of one robot", "NaN", "too large", "with gradients"],
)
def test_states_that_are_none_are_refused(given, message):
    bad = policy_controller(lambda seen, states: given, n_state=3)
    with pytest.raises(ConfigError, match=f"^policy FunctionPolicy: .*{message}"):
        bad.check_usable(find_scenario("es1", NUMBERS))


@pytest.mark.parametrize("n_state", [-1, 10**9, "many"])
def test_a_number_of_states_that_is_none_is_refused(n_state):
    with pytest.raises(ConfigError, match="n_state"):
        policy_controller(waver, n_state=n_state)

"""PPO from scratch: it learns what the environment shows, goes on after a kill, keeps its best."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from numpy.testing import assert_array_equal
from safetensors.numpy import load_file, save_file

from baselines.evaluation.figures.learning import read_card
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.scenarios import find_scenario
from training import ppo
from training.actor_critic import ActorCritic, log_probs_of
from training.checkpoint import BEST_POLICY
from training.ppo_learner import PPOHyperparameters
from training.training_loop import ProgressLogger

BUSY = {"robot.cruise_speed": "0.12", "task.area_distance": "0.62", "task.duration": "20"}

QUICK = PPOHyperparameters(n_steps=4, n_epochs=1, n_minibatches=2)


@pytest.fixture(autouse=True)
def quick(monkeypatch, tmp_path):
    """Rollouts of a moment."""
    monkeypatch.chdir(tmp_path)
    quick = {k: replace(each, hyperparameters=QUICK) for k, each in ppo.PRESETS.items()}
    monkeypatch.setattr(ppo, "PRESETS", quick)


@pytest.fixture
def motion(experiment):
    """A motion experiment of two intervals, in two scenarios."""

    def make(**changes):
        terms = {
            "layer": "motion", "algorithm": "ppo", "scenarios": ("es1", "es1:task.n_robots=6"),
            "population": None, "settings": BUSY, "budget": 2048, "every": 1024, "worlds": 2,
        }  # fmt: skip
        return experiment(**terms | changes)

    return make


def weights(folder, file=ppo.LATEST):
    return load_file(folder / file)


def test_a_run_keeps_its_best_with_a_card_that_tells_its_curve(motion):
    lines = []
    experiment = motion()
    controller = ppo.train(experiment, lines.append)
    card = controller.policy.card()
    assert (card.controller, card.keywords.learn) == ("ssgiff", "motion")
    record = card.training
    assert (record.algorithm, record.command) == ("ppo", experiment.command)
    assert record.score.keys() == set(experiment.scenarios)
    assert any("robot steps/s" in line for line in lines)
    assert list((experiment.out / "tensorboard").iterdir())
    last = ppo.PPOTraining(experiment).curve
    rollout = 2 * 4 * 10 * (2 * 6 + 10)  # twice 4 decisions; two worlds of 6 robots, one of 10
    assert [point.step for point in last] == [0, rollout, 2 * rollout]
    assert [point.simulated_s for point in last] == pytest.approx([0.0, 24.0, 48.0])
    assert [point.value for point in record.curve] == [point.value for point in last]
    assert record.score == max(last, key=lambda point: point.value).round_trips
    assert len(read_card(experiment.out / BEST_POLICY).curve) == len(last)


def test_a_policy_beside_learned_layers_begins_with_the_deviation_of_its_layer(motion, monkeypatch):
    preset = replace(ppo.PRESETS["motion"], log_std=-0.5)
    monkeypatch.setitem(ppo.PRESETS, "motion", preset)
    experiment = motion(controller="learned-both")
    ppo.PPOTraining(experiment).evaluate()
    assert_array_equal(weights(experiment.out)["log_std"], np.full(2, -0.5, np.float32))


def test_a_stopped_run_ends_where_it_would_have_ended(motion, broken_anywhere):
    broken_anywhere(ppo.train, motion(), (ppo.PPOTraining, "_save"), [3])


def test_the_policy_that_is_kept_is_the_best_one(motion, tmp_path, monkeypatch):
    scores = iter([[5, 6], [6, 7], [9, 9], [9, 9]])
    monkeypatch.setattr(
        ppo, "run_episodes", lambda *_: [SimpleNamespace(round_trips=n) for n in next(scores)]
    )
    experiment = motion(out=tmp_path / "run", scenarios=("es1",), budget=4000)
    training, latest = ppo.PPOTraining(experiment), []
    with ProgressLogger(experiment.out, "robot step", str) as progress:
        for _ in range(4):
            training.evaluate()
            latest.append(weights(experiment.out))
            training.advance(progress)
    record = ppo.controller_of(experiment.out / BEST_POLICY).policy.card().training
    assert [point.round_trips["es1"].mean for point in record.curve] == [5.5, 6.5, 9.0, 9.0]
    assert record.score["es1"].mean == 9.0
    assert record.curve[0].value == pytest.approx(np.log1p(5.5))
    best = weights(experiment.out, BEST_POLICY)
    np.testing.assert_equal(best, latest[2])
    for other in (latest[1], latest[3]):
        assert any((best[name] != other[name]).any() for name in best)


@pytest.mark.parametrize(
    ("layer", "keywords"),
    [
        ("weighting", {"step_on": "exchange"}),
        ("both", {}),
        ("motion", {}),
        ("everything", {"shaping": 1.0, "decision_period": 10}),
    ],
)
def test_every_layer_is_trained_in_its_environment(motion, layer, keywords, monkeypatch):
    experiment = motion(layer=layer, settings=BUSY | {"task.duration": "60"}, every=4000)
    training = ppo.PPOTraining(experiment)
    block = training._learner.env.blocks[0]
    assert block._is_staggered == (layer == "everything")
    for name, wanted in {"learn": layer, "shaping": 0.0, "action": None, **keywords}.items():
        assert getattr(block.config, name) == wanted
    before = training._weights
    with ProgressLogger(experiment.out, "robot step", str) as progress:
        training.evaluate()
        training.advance(progress)
    for name, array in training._weights.items():
        assert np.isfinite(array).all()
        assert (array != before[name]).any(), name
    monkeypatch.setattr(ppo, "MANY", 2)
    assert ppo.make_env(experiment).blocks[0]._is_staggered == (layer != "weighting")


@pytest.fixture
def network(request, motion):
    """The file of a policy whose weights are of some size; of the motion unless told otherwise."""
    layer = getattr(request, "param", "motion")
    experiment = motion(budget=1, every=1, scenarios=("es1",), layer=layer)
    training = ppo.PPOTraining(experiment)
    torch.manual_seed(1)
    with torch.no_grad():
        for each in training._learner.policy.parameters():
            each.copy_(torch.randn(each.shape) / each.shape[-1] ** 0.5)
    training.evaluate()
    return experiment.out / ppo.LATEST, training._learner.policy


def test_what_runs_without_torch_is_what_was_trained(network):
    file, policy = network
    controller = ppo.controller_of(file)
    form = controller.form(find_scenario("es1"))
    observed = np.random.default_rng(0).uniform(-1, 1, (30, len(form.layout))).astype(np.float32)
    started = controller.policy.start(form)

    def act(observed, draws=None):
        return started.act(observed, draws, np.zeros((len(observed), 0), np.float32))[0]

    with torch.no_grad():
        wanted = policy.actor(torch.from_numpy(observed)).numpy()
    np.testing.assert_allclose(act(observed), wanted, atol=1e-5)
    assert_array_equal(act(observed[:7]), act(observed)[:7])
    draws = np.full((30, 2), 2.0)
    deviation = policy.log_std.detach().exp().numpy()
    np.testing.assert_allclose(act(observed, draws), wanted + 2.0 * deviation, atol=1e-5)


@pytest.mark.parametrize("network", ["everything"], indirect=True)
def test_a_memory_runs_without_torch_as_it_was_trained(network):
    file, policy = network
    controller = ppo.controller_of(file)
    form = controller.form(find_scenario("es1"))
    observed = torch.rand(5, 30, len(form.layout)) * 2.0 - 1.0
    started = controller.policy.start(form)
    n_state, n_actions = policy.n_state, len(form.action.layout)
    assert started.n_state == n_state
    states, wanted = np.zeros((30, n_state), np.float32), torch.zeros(30, n_state)
    deviation = policy.log_std.detach().exp().numpy()
    for seen in observed:
        few, few_after = started.act(seen.numpy()[:7], None, states[:7])
        noisy, after = started.act(seen.numpy(), np.full((30, n_actions), 2.0), states)
        actions, states = started.act(seen.numpy(), None, states)
        with torch.no_grad():
            wanted = policy.next_states(seen, wanted)
            np.testing.assert_allclose(actions, policy.actor(wanted).numpy(), atol=1e-5)
        np.testing.assert_allclose(states, wanted.numpy(), atol=1e-5)
        np.testing.assert_allclose(noisy, actions + 2.0 * deviation, atol=1e-5)
        for part, whole in ((few, actions[:7]), (few_after, states[:7]), (after, states)):
            assert_array_equal(part, whole)


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda arrays: arrays.pop("1.bias"), "array '1.bias' is missing"),
        (lambda arrays: arrays.update({"x.weight": arrays["0.bias"]}), "no such array"),
        (lambda arrays: arrays["0.bias"].fill(np.nan), "holds NaN"),
        (lambda arrays: arrays["0.bias"].fill(1.0), "its card belongs to other weights"),
    ],
)
def test_a_damaged_network_is_refused_in_one_line(network, damage, message):
    file, _ = network
    arrays = {name: array.copy() for name, array in load_file(file).items()}
    damage(arrays)
    save_file(arrays, file)
    if "card" not in message:
        file.with_suffix(".json").unlink()
    with pytest.raises(ConfigError, match=message):
        ppo.controller_of(file).check_usable(find_scenario("es1"))


def test_matrices_begin_orthogonal_and_the_last_ones_with_their_own_gain():
    policy = ActorCritic(5, 2, hidden=(3,))
    assert not ActorCritic(5, 2, value_gain=0.0).outputs(torch.ones((1, 4, 5)))[2].any()
    for net, gain in ((policy.actor, 0.01), (policy.critic, 1.0)):
        first, last = net[0].weight.detach(), net[-1].weight.detach()
        assert (first @ first.T).numpy() == pytest.approx(2.0 * np.eye(3), abs=1e-5)
        assert (last @ last.T).numpy() == pytest.approx(gain**2 * np.eye(len(last)), abs=1e-6)
        assert not net[0].bias.any()
    assert policy.log_std.tolist() == [0.0, 0.0]


def test_actions_are_drawn_from_a_gaussian_whose_density_is_told():
    policy = ActorCritic(5, 2)
    with torch.no_grad():
        policy.log_std.copy_(torch.tensor([-1.0, 0.5]))
    observed = torch.randn(4000, 5)
    torch.manual_seed(0)
    with torch.no_grad():
        actions, mean = policy(observed), policy.actor(observed)
        log_probs = log_probs_of(actions, mean, policy.log_std)
    gaussian = torch.distributions.Normal(mean, policy.log_std.detach().exp())
    assert torch.allclose(log_probs, gaussian.log_prob(actions).sum(1), atol=1e-5)
    assert (actions - mean).std(0).tolist() == pytest.approx([0.368, 1.649], rel=0.05)

"""Zips of stable-baselines3 that are not as they should be, and what is read of sound ones."""

import base64
import contextlib
import functools
import io
import json
import pickle
import random
import struct
import tracemalloc
import zipfile

import gymnasium as gym
import numpy as np
import pytest
import torch
from sb3_contrib import RecurrentPPO
from stable_baselines3 import PPO, SAC, TD3
from stable_baselines3.common.vec_env import VecNormalize

import training.controllers  # noqa: F401 the kinds of policies, also where no package is installed
from swarm_forage_env import parallel_env
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.envs.config import EnvConfig
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.scenarios import find_scenario
from training.sb3_policy import SavedModel, SB3Policy, _check_spaces, read_zip
from training.vec_env import SwarmVecEnv

NUMBERS = {"task.n_robots": 4}


def env_of(**options):
    return SwarmVecEnv("es1", n_worlds=1, physics="kinematic", **NUMBERS, **options)


def untrained(**options):
    return PPO("MlpPolicy", env_of(), n_steps=8, batch_size=8, seed=0, device="cpu", **options)


usual = functools.cache(untrained)


@functools.cache
def recurrent():
    return RecurrentPPO("MlpLstmPolicy", env_of(), n_steps=8, batch_size=8, seed=0, device="cpu",
                        policy_kwargs={"lstm_hidden_size": 8})  # fmt: skip


def saved(file, **options):
    """An untrained model, in a file."""
    made = untrained(**options) if options else usual()
    made.save(file)
    return made


@pytest.fixture
def file(tmp_path):
    """An untrained model in a file."""
    saved(tmp_path / "m.zip")
    return tmp_path / "m.zip"


def with_parts(file, compression=zipfile.ZIP_STORED, **changed):
    """The same zip packed anew, with some of its parts changed; None takes one away."""
    with zipfile.ZipFile(file) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    parts |= {name.replace("_pth", ".pth"): content for name, content in changed.items()}
    with zipfile.ZipFile(file, "w", compression) as archive:
        for name, content in parts.items():
            if content is not None:
                archive.writestr(name, content)


def use(file):
    find_controller(f"sb3:{file}").check_usable(find_scenario("es1", NUMBERS))


def as_torch_saves(what):
    stream = io.BytesIO()
    torch.save(what, stream)
    return stream.getvalue()


class Intruder:
    """What runs when it is unpickled."""

    def __reduce__(self):
        return Intruder.run, ()

    @staticmethod
    def run():
        raise AssertionError("the pickle of a policy was opened")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (as_torch_saves({"a": Intruder()}), r"its weights cannot be read \(Weights only load"),
        (b"", r"its weights cannot be read \("), (b"junk", r"its weights cannot be read \("),
        (as_torch_saves({"a": torch.zeros(2)}), "its weights do not fit"),
        (as_torch_saves([torch.zeros(2)]), "its weights cannot be read"),
        (as_torch_saves({1: torch.zeros(2)}), "its weights cannot be read"),
        (None, "must be what stable-baselines3's"),
    ],
    ids=["code", "nothing", "junk", "others", "a list", "numbered", "none"],
)  # fmt: skip
def test_weights_that_are_none_are_refused_and_nothing_of_them_is_run(file, content, message):
    use(file)
    with_parts(file, policy_pth=content)
    with pytest.raises(ConfigError, match=message) as refusal:
        use(file)
    assert str(refusal.value).startswith(f"policy {file}: ")


def changed_data(file, **changes):
    with_parts(file, data=json.dumps({**told_of(file), **changes}).encode())


def told_of(file):
    return json.loads(read_zip(file)[1])


def test_a_model_that_explores_by_its_state_is_one_as_a_controller_too(tmp_path):
    made = saved(tmp_path / "m.zip", use_sde=True)
    controller = find_controller(f"sb3:{tmp_path / 'm.zip'}")
    observed = observed_by(made)
    found = chosen(controller, observed, None)
    np.testing.assert_allclose(found, made.predict(observed, deterministic=True)[0], atol=1e-6)


def chosen(controller, observed, draws):
    started = controller.policy.start(controller.form(find_scenario("es1", NUMBERS)))
    return started.act(observed, draws, np.zeros((len(observed), 0), np.float32))[0]


def stochastic(file, observed, draws):
    return chosen(find_controller(f"sb3:{file},chance=true"), observed, draws)


def observed_by(model):
    size = model.observation_space.shape[0]
    return np.random.default_rng(0).uniform(-1.0, 1.0, (4, size)).astype(np.float32)


DRAWS = np.array([[0.0, 0.0], [1.0, -2.0], [0.5, 0.0], [0.0, 3.0]])


def test_by_chance_an_action_is_its_mean_and_a_draw_times_its_deviation(tmp_path):
    made = saved(tmp_path / "m.zip", policy_kwargs={"log_std_init": -1.0})
    observed = observed_by(made)
    mean = made.policy.get_distribution(torch.as_tensor(observed)).mode().detach().numpy()
    found = stochastic(tmp_path / "m.zip", observed, DRAWS)
    np.testing.assert_allclose(found, mean + np.exp(-1.0) * DRAWS, atol=1e-6)


def test_by_chance_a_choice_is_as_frequent_as_it_is_probable(tmp_path):
    env = env_of(discrete=True)
    made = PPO("MlpPolicy", env, n_steps=8, batch_size=8, seed=0, device="cpu")
    made.save(tmp_path / "m.zip")
    observed = np.repeat(observed_by(made)[:1], 1000, axis=0)
    draws = (np.arange(1000.0)[:, None] + 0.5) / 1000.0
    found = np.bincount(stochastic(tmp_path / "m.zip", observed, draws), minlength=5) / 1000.0
    shares = made.policy.get_distribution(torch.as_tensor(observed[:1])).distribution.probs
    np.testing.assert_allclose(found, shares.detach().numpy()[0], atol=1e-3)


def test_by_chance_a_squashed_action_is_squashed_after_its_draw(tmp_path):
    made = SAC("MlpPolicy", env_of(), seed=0, device="cpu")
    made.save(tmp_path / "m.zip")
    observed = observed_by(made)
    with torch.no_grad():
        mean, log_std, _ = made.actor.get_action_dist_params(torch.as_tensor(observed))
    wanted = np.tanh(mean.numpy() + log_std.exp().numpy() * DRAWS)
    np.testing.assert_allclose(stochastic(tmp_path / "m.zip", observed, DRAWS), wanted, atol=1e-6)


def test_a_policy_without_a_distribution_cannot_act_by_chance(tmp_path):
    TD3("MlpPolicy", env_of(), seed=0, device="cpu").save(tmp_path / "m.zip")
    for name in (f"sb3:{tmp_path}/m.zip", "callable:numpy:zeros_like"):
        with pytest.raises(ConfigError, match="chance=true: the policy gives actions only"):
            find_controller(f"{name},chance=true").check_usable(find_scenario("es1", NUMBERS))


def test_a_file_may_be_named_without_its_ending(file, tmp_path):
    assert SB3Policy(file=str(tmp_path / "m")).path == file
    (tmp_path / "n").write_text("")
    assert SB3Policy(file=str(tmp_path / "n")).path == tmp_path / "n"
    with pytest.raises(ConfigError, match=r"policy .*gone: there is no such file"):
        _ = SB3Policy(file=str(tmp_path / "gone")).path
    assert SB3Policy().trust is False


@pytest.mark.parametrize(
    ("n_observed", "action", "message"),
    [
        (5, {"_shape": [2]}, r"maps 5 numbers to 2; .*\(learn=motion\) it must map 45 to 2\. Give"),
        (45, {"n": 5}, r"to one of 5 choices; .* as in sb3:m.zip,discrete=true$"),
        (81, {"_shape": [15]}, r"maps 81 numbers to 15; .* as in sb3:m.zip,learn=everything$"),
        (90, {"_shape": [2]}, r" as in sb3:m.zip,stack=2$"),
        (225, {"_shape": [10]}, r"It controls all robots at once, and runs in its own environm"),
    ],
)
def test_a_refusal_names_the_keyword_that_differs(n_observed, action, message):
    form = PolicyForm([find_scenario("near")], EnvConfig())
    spaces = {"observation_space": {"_shape": [n_observed]}, "action_space": action}
    with pytest.raises(ConfigError, match=message):
        _check_spaces("m.zip", SavedModel(policy_kwargs={}, **spaces), form)


PICKLE = base64.b64encode(pickle.dumps(Intruder())).decode()
PICKLED = {":type:": "x", ":serialized:": PICKLE}
POLICIES, INIT = "stable_baselines3.common.policies", "<function ActorCritic"
CAN = r"its policy_class can only .*trust=true"


@pytest.mark.parametrize("part", ["policy_class", "policy_kwargs"])
def test_no_file_can_say_that_it_is_trusted(file, part):
    space = told_of(file)["observation_space"]
    card = json.loads(space["policy_card"])
    card["keywords"]["trust"] = True
    changed_data(file, observation_space={**space, "policy_card": json.dumps(card)})
    changed_data(file, **{part: PICKLED})
    with pytest.raises(ConfigError, match=r"card in .*m.zip: keywords.trust: Extra inputs"):
        use(file)


@pytest.mark.parametrize(
    ("part", "value", "text"),
    [
        ("policy_class", {"__module__": "elsewhere", "__init__": f"{INIT}Policy.__init__ at"}, CAN),
        ("policy_class", {"__module__": POLICIES}, CAN),
        ("policy_class", {"__module__": POLICIES, "__init__": f"{INIT}CnnPolicy.__init__ at"}, CAN),
        ("policy_class", "text", CAN),
        ("policy_class", PICKLED, "its policy_class can only be read by unpickling"),
        ("observation_space", PICKLED, "maps no numbers to 2"),
        ("action_space", PICKLED, r"maps \d+ numbers to no;"),
    ],
)
def test_a_class_that_is_not_known_is_not_guessed_and_no_pickle_is_opened(file, part, value, text):
    changed_data(file, **{part: value})
    with pytest.raises(ConfigError, match=text):
        use(file)


def test_members_of_a_zip_are_links_to_nothing_and_are_written_nowhere(tmp_path):
    file = tmp_path / "in" / "m.zip"
    file.parent.mkdir()
    saved(file)
    link = zipfile.ZipInfo("policy.pth")
    link.external_attr = 0o120777 << 16
    weights = zipfile.ZipFile(file).read("policy.pth")
    (tmp_path / "weights").write_bytes(weights)
    with_parts(file, policy_pth=None, **{"../over": b"", "/tmp/over": b""})
    with zipfile.ZipFile(file, "a") as archive:
        archive.writestr(link, str(tmp_path / "weights"))
    with pytest.raises(ConfigError, match="its weights cannot be read"):
        use(file)
    assert not (tmp_path / "over").exists()


@pytest.mark.parametrize(
    "data",
    [None, b"no JSON", b"\xff", b"[]", b"3", b"NaN", b"{}", b"[" * 100_000 + b"]" * 100_000],
    ids=["none", "text", "bytes", "list", "number", "NaN", "empty", "deep"],
)
def test_what_a_model_tells_of_itself_must_be_an_object(file, data):
    with_parts(file, data=data)
    refuses(file, "must be what stable-baselines3's model.save")


def refuses(file, message):
    """The refusal of a file, which is one line of no great length."""
    with pytest.raises(ConfigError, match=message) as refusal:
        use(file)
    assert str(refusal.value).isprintable()
    assert len(str(refusal.value)) < 600


@pytest.mark.parametrize(
    "changes",
    [{"policy_class": {"__module__": ["os"]}}, {"policy_kwargs": None},
     {"policy_kwargs": 3}, {"policy_kwargs": "text"},
     {"policy_kwargs": [[1]]}, {"observation_space": {"_shape": 3}},
     {"action_space": {"n": "many"}}, {"use_sde": {":serialized:": ""}}],
    ids=str,
)  # fmt: skip
def test_what_a_model_tells_of_itself_is_of_known_types(file, changes):
    changed_data(file, **changes)
    refuses(file, f"must be what .* writes .{next(iter(changes))}")


@pytest.mark.parametrize(
    ("keywords", "message"),
    [({"net_arch": 1e9}, "net_arch"), ({"net_arch": [10**7, 10**4]}, "its weights do not fit: pol"),
     ({"net_arch": [2**40]}, "its weights do not fit: policy_kwargs need"),
     ({"net_arch": {"pi": [64], "vf": [10**6] * 3}}, "its weights do not fit: policy_kwargs need"),
     ({"net_arch": [-1]}, "greater than or equal to 1"), ({"net_arch": [8] * 101}, "at most 100"),
     ({"net_arch": [8]}, "its weights do not fit: array '.*' is .* must be"),
     ({"net_arch": {"x": [8]}}, "net_arch"), ({"n_critics": 10**9}, "n_critics"),
     ({"activation_fn": "<class 'torch.nn.modules.activation.Softly'>"}, "must be an activation"),
     ({"activation_fn": "<class 'torch.nn.modules.activation.torch'>"}, "must be an activation"),
     ({"activation_fn": "<class 'torch.nn.modules.activation.Threshold'>"}, "cannot be made here"),
     ({"log_std_init": 1e999}, "log_std_init"), ({"a\nb": 1}, "policy_kwargs.ab: Extra")],
    ids=str,
)  # fmt: skip
def test_a_network_is_made_only_where_its_weights_are_there(file, keywords, message):
    changed_data(file, policy_kwargs=keywords)
    refuses(file, message)


@pytest.mark.parametrize(
    ("keywords", "message"),
    [({"lstm_hidden_size": 10**6}, "its weights do not fit: policy_kwargs need"),
     ({"n_lstm_layers": 100}, "its weights do not fit: policy_kwargs need"),
     ({"n_lstm_layers": 2**40}, "n_lstm_layers"),
     ({"lstm_hidden_size": 4}, "its weights do not fit: array '.*' is .* must be"),
     ({"lstm_kwargs": {"proj_size": 2}}, "policy_kwargs.lstm_kwargs: Extra")],
    ids=str,
)  # fmt: skip
def test_an_lstm_is_made_only_where_its_weights_are_there(tmp_path, keywords, message):
    recurrent().save(tmp_path / "m.zip")
    use(tmp_path / "m.zip")
    changed_data(tmp_path / "m.zip", policy_kwargs=keywords)
    refuses(tmp_path / "m.zip", message)


@pytest.mark.parametrize("keywords", [{"net_arch": [{"pi": [8], "vf": [4]}]}, {"net_arch": []}])
@pytest.mark.filterwarnings("ignore:As shared layers")
def test_a_network_may_be_told_in_every_form(tmp_path, keywords):
    saved(tmp_path / "m.zip", policy_kwargs=keywords)
    use(tmp_path / "m.zip")


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_weights_that_are_not_finite_are_refused(file, value):
    weights = {**usual().policy.state_dict(), "log_std": torch.full((2,), value)}
    with_parts(file, policy_pth=as_torch_saves(weights))
    refuses(file, "array 'log_std' holds NaN or infinity")


def test_finite_weights_that_no_action_comes_of_are_told_in_a_line(file):
    weights = {**usual().policy.state_dict(), "log_std": torch.full((2,), -1e4)}
    with_parts(file, policy_pth=as_torch_saves(weights))
    observed = np.ones((4, 45), np.float32)
    with pytest.raises(ConfigError, match=r"m.zip: gives no action \("):
        stochastic(file, observed, np.zeros((4, 2)))


def test_a_zip_may_be_deflated_and_not_packed_otherwise(file):
    with_parts(file, compression=zipfile.ZIP_DEFLATED)
    use(file)
    with_parts(file, compression=zipfile.ZIP_LZMA)
    refuses(file, "'data' is neither stored nor deflated")


@pytest.mark.parametrize("name", [b"data", b"policy.pth"])
@pytest.mark.parametrize(("at", "to", "message"), [(8, 1, "encrypted"), (10, 77, "neither stored")])
def test_a_member_that_is_encrypted_or_packed_in_an_unknown_way_is_refused(
    file, name, at, to, message
):
    content = bytearray(file.read_bytes())
    content[content.rindex(b"PK\1\2", 0, content.rindex(name)) + at] |= to
    file.write_bytes(content)
    refuses(file, f"must be what stable-baselines3's .*{message}")


def test_of_flipped_bits_of_a_deflated_zip_none_ends_otherwise(file):
    with_parts(file, compression=zipfile.ZIP_DEFLATED)
    content = file.read_bytes()
    for bit in random.Random(0).sample(range(8 * len(content)), 60):
        changed = bytearray(content)
        changed[bit // 8] ^= 1 << bit % 8
        file.write_bytes(bytes(changed))
        with contextlib.suppress(ConfigError):
            use(file)


def peak(call):
    """The most memory that Python's own objects took during a call [MiB]."""
    tracemalloc.start()
    try:
        call()
        return tracemalloc.get_traced_memory()[1] / 2**20
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("false_size", [False, True], ids=["honest", "lies of its size"])
@pytest.mark.parametrize("name", ["data", "policy.pth"])
def test_a_member_that_swells_is_refused_before_it_does(file, monkeypatch, name, false_size):
    for limit in ("LARGEST", "MAX_JSON"):
        monkeypatch.setattr(f"training.sb3_policy.{limit}", 2**20)
    with_parts(file, compression=zipfile.ZIP_DEFLATED)
    swollen = bytes(64 * 2**20)
    with_parts(file, **{name.replace(".", "_"): None})
    with zipfile.ZipFile(file, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, swollen)
    if false_size:
        content = file.read_bytes()
        true, told = (struct.pack("<I", size) for size in (len(swollen), 1000))
        file.write_bytes(content.replace(true, told))
    wanted = "must be what .*(CRC|MiB; at most 1 MiB)"
    assert peak(lambda: refuses(file, wanted)) < 8


def test_weights_that_swell_are_refused_before_they_do(file, tmp_path, monkeypatch):
    (tmp_path / "w.pth").write_bytes(as_torch_saves({"a": torch.zeros(2**20)}))
    with_parts(tmp_path / "w.pth", compression=zipfile.ZIP_DEFLATED)
    with_parts(file, policy_pth=(tmp_path / "w.pth").read_bytes())
    monkeypatch.setattr("training.foreign_file.LARGEST", 2**20)
    refuses(file, r"weights cannot be read \(has 4.0 MiB; at most 1 MiB are read")


def in_gymnasium(**keywords):
    return gym.make("SwarmForage/ES1-v2", **keywords)


def in_supersuit(**keywords):
    supersuit = pytest.importorskip("supersuit", reason="pip install supersuit")
    worlds = supersuit.pettingzoo_env_to_vec_env_v1(parallel_env("es1", **keywords))
    return supersuit.concat_vec_envs_v1(worlds, 1, base_class="stable_baselines3")


@pytest.mark.parametrize("make", [SwarmVecEnv, in_gymnasium, in_supersuit])
def test_a_model_knows_the_keywords_of_its_training_whatever_it_was_trained_through(make, tmp_path):
    asked = {"decision_period": 3, "stack": 2, "discrete": (3, 5), "action": "course"}
    env = make(controller="ssgiff:beta=0.5", physics="kinematic", **asked)
    PPO("MlpPolicy", env, n_steps=8, batch_size=8).save(tmp_path / "m.zip")
    card = SB3Policy(file=str(tmp_path / "m.zip")).card()
    assert {name: getattr(card.keywords, name) for name in asked} == asked
    assert card.controller == "ssgiff:weighting.beta=0.5"


@pytest.mark.parametrize(
    ("make", "text"),
    [(lambda: gym.wrappers.RescaleAction(in_gymnasium(), 0, 1), r"gives actions from \(0.0, 0"),
     (lambda: VecNormalize(env_of()), r"observed situation.*=-0.* in training; .* from 0 to 1"),
     (lambda: VecNormalize(env_of(normalise=False)), "in training; here it is from 0 to inf"),
     (lambda: VecNormalize(env_of(), norm_obs=False), None)],
)  # fmt: skip
@pytest.mark.parametrize("algorithm", [functools.partial(PPO, n_steps=8, batch_size=8), SAC])
def test_what_a_wrapper_changed_is_refused_where_the_zip_shows_it(make, text, algorithm, tmp_path):
    algorithm("MlpPolicy", make(), seed=0, device="cpu").learn(8).save(tmp_path / "m.zip")
    with pytest.raises(ConfigError, match=text) if text else contextlib.nullcontext():
        use(tmp_path / "m.zip")

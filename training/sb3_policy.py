"""Policies of stable-baselines3, from the zip that `model.save("model.zip")` writes.

Its plain JSON is read, and torch loads its weights with `weights_only`. Nothing is unpickled unless
`trust=true` allows it: a pickle runs whatever code it holds.
"""

import io
import json
import re
from base64 import b64decode
from contextlib import suppress
from importlib import import_module
from itertools import islice, pairwise, product
from os.path import isfile
from pathlib import Path
from pickletools import genops
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from gymnasium.spaces import Box, Discrete
from pydantic import (
    AliasPath,
    BaseModel,
    BeforeValidator,
    Field,
    JsonValue,
    ValidationError,
    field_validator,
)

from swarm_forage_env.arrays import Array
from swarm_forage_env.envs.pilot import Pilot
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError, UnknownNameError, shown
from swarm_forage_env.parameters import Count, Parameters
from training.foreign_file import (
    LARGEST,
    LARGEST_CARD,
    LARGEST_ZIP,
    MAX_JSON,
    check_file,
    check_zip,
    read_members,
    reason,
)
from training.network_policy import Network as DenseNetwork
from training.network_policy import packed_layers
from training.policy import PolicyFile, Rows, Started, drawn_choices
from training.policy_card import PolicyCard, as_keywords, card_from
from training.policy_file import check_weights, in_one_thread, misfit

if TYPE_CHECKING:
    from stable_baselines3.common.policies import ActorCriticPolicy, BasePolicy
    from stable_baselines3.sac.policies import SACPolicy

IGNORED = (":serialized:", ":type:", "optimizer_class", "optimizer_kwargs")
"""Keys of the JSON that a policy does not depend on, unless it is trained further."""

ACTIVATION = re.compile(r"<class 'torch\.nn\.modules\.activation\.(\w+)'>")

Widths = Annotated[list[Count], Field(max_length=100)]  # sizes of the hidden layers
Branches = dict[Literal["pi", "vf", "qf"], Widths]  # hidden layers of the actor, and of the critic


class Space(BaseModel, frozen=True):
    """Space of observations or actions."""

    n: int | None = None  # number of choices
    shape: tuple[int, ...] | None = Field(None, alias="_shape", max_length=100)
    policy_card: Annotated[str, Field(max_length=LARGEST_CARD)] | None = None
    """Card of the policy as JSON, on the observation space."""

    @property
    def size(self) -> str:
        """Shape of the space, or number of its choices, in words."""
        if self.n is not None:
            return f"one of {self.n} choices"
        return "x".join(map(str, self.shape or ["no"]))


Bounds = Annotated[tuple[float, ...], BeforeValidator(lambda text: str(text).strip("[]").split())]


class ActionSpace(Space, frozen=True):
    """Action space, with bounds as printed by NumPy."""

    low: Bounds = ()
    high: Bounds = ()


class SavedModel(BaseModel, frozen=True):
    """The description of a model in the JSON of a zip."""

    module: str = Field("", validation_alias=AliasPath("policy_class", "__module__"))
    init: str = Field("", validation_alias=AliasPath("policy_class", "__init__"))
    policy_kwargs: Annotated[dict[str, JsonValue], Field(max_length=50)]
    observation_space: Space = Space()
    action_space: ActionSpace = ActionSpace()
    last_observed: str = Field("", validation_alias=AliasPath("_last_obs", ":serialized:"))
    use_sde: bool = False

    @property
    def last_numbers(self) -> Array:
        """Last observations in a flat array, without unpickling; empty unless single precision."""
        with suppress(ValueError):
            parts = [each for _, each, _ in islice(genops(b64decode(self.last_observed)), 60)]
            if "f4" in parts and "C" in parts:
                content = next((each for each in parts if isinstance(each, bytes | bytearray)), b"")
                return np.frombuffer(content, np.float32)
        return np.zeros(0, np.float32)


class Network(Parameters):
    """Keywords of a policy that need no pickle."""

    net_arch: Widths | Branches | Annotated[list[Branches], Field(max_length=1)] | None = None
    activation_fn: type[object] | None = None
    n_critics: Annotated[int, Field(ge=1, le=100)] | None = None
    ortho_init: bool = True
    use_sde: bool = False
    log_std_init: float = 0.0
    full_std: bool = True
    use_expln: bool = False
    clip_mean: float = 0.0
    squash_output: bool = False
    share_features_extractor: bool = True
    normalize_images: bool = True

    @field_validator("activation_fn", mode="before")
    @classmethod
    def _of_torch(cls, text: object) -> type[object]:
        from torch.nn.modules import activation

        match = ACTIVATION.fullmatch(str(text))
        if match is None or match[1] not in activation.__all__:
            raise ValueError("must be an activation of torch.nn")
        kind: type[object] = vars(activation)[match[1]]
        return kind

    def n_weights(self, n_observed: int) -> int:
        """Count the weights of its largest network, up to the last hidden layer, times critics."""
        arch = self.net_arch or []
        parts = [arch] if isinstance(arch, dict) else arch
        shared = [part for part in parts if isinstance(part, int)]
        branches = [each for part in parts if isinstance(part, dict) for each in part.values()]
        chains = ([n_observed, *each] for each in (shared, *branches))
        return (self.n_critics or 1) * max(sum(a * b for a, b in pairwise(c)) for c in chains)


class RecurrentNetwork(Network):
    """Keywords of a policy of RecurrentPPO: an LSTM, and the network above it."""

    lstm_hidden_size: Count = 256
    n_lstm_layers: Annotated[int, Field(ge=1, le=100)] = 1
    shared_lstm: bool = False
    enable_critic_lstm: bool = True

    def n_weights(self, n_observed: int) -> int:
        """Count the weights of the actor's LSTM and of one network above it."""
        n = self.lstm_hidden_size
        return 4 * n * (n_observed + n + 2 * n * (self.n_lstm_layers - 1)) + super().n_weights(n)


def read_zip(file: Path) -> tuple[SavedModel, bytes, bytes]:
    """Return the description of a model in its zip, the same as JSON, and its weights as bytes."""
    check_file(file, "policy", LARGEST_ZIP)
    try:
        data, weights = read_members(file, {"data": MAX_JSON, "policy.pth": LARGEST})
        return SavedModel.model_validate_json(data), data, weights
    except ValueError as error:
        raise ConfigError(
            f"policy {file}: must be what stable-baselines3's model.save() writes ({reason(error)})"
        ) from None


RECURRENT = "sb3_contrib.common.recurrent.policies"

KNOWN = {
    RECURRENT: "RecurrentActorCriticPolicy",
    "stable_baselines3.common.policies": "ActorCriticPolicy",
    "stable_baselines3.dqn.policies": "DQNPolicy",
    "stable_baselines3.sac.policies": "SACPolicy",
    "stable_baselines3.td3.policies": "TD3Policy",
}
"""Policy classes that need no pickle: of RecurrentPPO, PPO and A2C, DQN, SAC, TD3 and DDPG."""

States = tuple[Array, ...]  # hidden and cell states of an LSTM, each (layers, robots, units)

Chosen = tuple[type["BasePolicy"], dict[str, Any]]  # the class of a policy, and its keywords


class SB3Policy(PolicyFile):
    """A model that stable-baselines3 or sb3-contrib has saved: sb3:model.zip."""

    trust: bool = Field(False, description="Whether to unpickle the file: runs any code in it")

    @property
    def path(self) -> Path:
        """Path of the file, which may be given without its ending."""
        if self.file and not Path(self.file).suffix and isfile(f"{self.file}.zip"):
            return Path(f"{self.file}.zip")
        return super().path

    def card(self) -> PolicyCard | None:
        """Return the card on the observation space of the training, or else beside the file."""
        text = read_zip(self.path)[0].observation_space.policy_card
        return super().card() if text is None else card_from(text, f"in {self.file}")

    def start(self, form: PolicyForm) -> Started:
        """Start the policy; if stochastic, it draws from its distribution, if it has one."""
        import torch
        from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
        from stable_baselines3.common.policies import ActorCriticPolicy
        from stable_baselines3.sac.policies import SACPolicy

        model = self._model(form)
        dense = _dense(model)
        layers, units = 0, 0
        if isinstance(model, RecurrentActorCriticPolicy):
            layers, _, units = model.lstm_hidden_state_shape

        @torch.no_grad()
        @in_one_thread()
        def act(observed: Rows, draws: Array | None, rows: Rows) -> tuple[Array, Rows]:
            if dense is not None and draws is None:
                return dense(observed, rows)
            before = None
            if units:  # each robot's row is its hidden and its cell state
                before = tuple(rows.reshape(-1, 2, layers, units).transpose(1, 2, 0, 3))
            try:
                if draws is None:
                    actions, after = model.predict(observed, before, deterministic=True)
                else:
                    assert isinstance(model, ActorCriticPolicy | SACPolicy), "it is not asked"
                    actions, after = _drawn(model, observed, draws, before)
            except (RuntimeError, ValueError) as error:  # for example a deviation of 0
                raise ConfigError(
                    f"policy {self.file}: gives no action ({reason(error)})"
                ) from None
            if after is not None:
                rows = np.stack(after).transpose(2, 0, 1, 3).reshape(rows.shape)
            return actions, rows

        has_distribution = isinstance(model, ActorCriticPolicy | SACPolicy)
        return Started(act, 2 * layers * units, has_distribution)

    def pilot(self, form: PolicyForm) -> Pilot:
        """Return the policy for compilation with the world. ConfigError unless layers are dense."""
        network = _dense(self._model(form))
        return super().pilot(form) if network is None else network.pilot(form)

    def _model(self, form: PolicyForm) -> "BasePolicy":
        """Return the model's policy, with its weights."""
        saved, data, content = read_zip(self.path)
        _check_spaces(self.file, saved, form)
        _check_unchanged(self.file, saved, form)
        policy, keywords = (
            self._trusted(data) if self.trust else self._plain(saved, form, len(content))
        )
        if saved.use_sde:
            keywords.setdefault("use_sde", True)
        try:
            model = policy(form.observation_space, form.action_space, lambda _: 0.0, **keywords)
        except (TypeError, AssertionError, RuntimeError, ValueError) as error:
            raise ConfigError(f"policy {self.file}: cannot be made here: {reason(error)}") from None
        _load(self.file, model, content)
        model.set_training_mode(False)
        return model

    def _trusted(self, data: bytes) -> Chosen:
        """Unpickle class and keywords of the policy."""
        from stable_baselines3.common.save_util import json_to_data

        tree = json.loads(data)
        try:
            chosen = {name: tree[name] for name in ("policy_class", "policy_kwargs")}
            unpickled = json_to_data(json.dumps(chosen))
            return unpickled["policy_class"], dict(unpickled["policy_kwargs"])
        except Exception as error:  # code in a pickle can raise any error
            why = reason(error)
            raise ConfigError(f"policy {self.file}: cannot be unpickled ({why})") from None

    def _plain(self, saved: SavedModel, form: PolicyForm, n_bytes: int) -> Chosen:
        """Read class and keywords of the policy from plain JSON.

        ConfigError if a pickle holds them, or for more weights than the file has bytes for.
        """
        name, given = KNOWN.get(saved.module, ""), saved.policy_kwargs
        keywords = {key: value for key, value in given.items() if key not in IGNORED}
        texts = [str(each) for each in keywords.values()]
        is_pickled = any(each[:1] == "<" and not ACTIVATION.fullmatch(each) for each in texts)
        is_known = bool(name) and f"{name}.__init__ " in saved.init
        if not is_known or is_pickled:
            field = "policy_kwargs" if is_known else "policy_class"
            raise ConfigError(
                f"policy {self.file}: its {field} can only be read by unpickling, which runs any"
                f" code in the file; if you trust it: sb3:{self.file},trust=true"
            )
        kind = RecurrentNetwork if saved.module == RECURRENT else Network
        try:
            network = kind.model_validate(keywords)
        except ValidationError as error:
            why = f"policy_kwargs.{reason(error)}"
            raise ConfigError(f"policy {self.file}: cannot be made here: {why}") from None
        n_weights = network.n_weights(len(form.layout))
        if 4 * n_weights > n_bytes:
            raise ConfigError(
                f"policy {self.file}: its weights do not fit: policy_kwargs need at least"
                f" {n_weights:.3g} of them, and the file has {n_bytes} bytes"
            )
        return vars(import_module(saved.module))[name], network.model_dump(exclude_unset=True)


def _dense(model: "BasePolicy") -> DenseNetwork | None:
    """Return the layers of a continuous MlpPolicy of PPO or A2C; None for another policy."""
    from stable_baselines3.common.policies import ActorCriticPolicy
    from stable_baselines3.common.torch_layers import FlattenExtractor
    from torch import nn

    if type(model) is not ActorCriticPolicy or isinstance(model.action_space, Discrete):
        return None
    *hidden, last = *model.mlp_extractor.policy_net, model.action_net
    layers, between = [*hidden[::2], last], hidden[1::2]
    is_plain = type(model.features_extractor) is FlattenExtractor and not model.squash_output
    if not is_plain or not all(isinstance(each, nn.Linear) for each in layers):
        return None
    if not all(isinstance(each, nn.Tanh) for each in between):
        return None
    arrays = {name: each.numpy() for name, each in model.state_dict().items()}
    names = [f"mlp_extractor.policy_net.{2 * k}" for k in range(len(layers) - 1)] + ["action_net"]
    numbers = packed_layers(arrays, [(f"{name}.weight", f"{name}.bias") for name in names])
    sizes = [0, layers[0].in_features, *(each.out_features for each in layers)]
    return DenseNetwork(numbers, np.array(sizes))


def _drawn(
    model: "ActorCriticPolicy | SACPolicy", observed: Array, draws: Array, states: States | None
) -> tuple[Array, States | None]:
    """Draw actions from the distribution of a policy; also return the next states of an LSTM."""
    import torch
    from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
    from stable_baselines3.common.policies import ActorCriticPolicy
    from torch.distributions import Categorical, Distribution, Normal

    seen, after = torch.as_tensor(observed), None
    if not isinstance(model, ActorCriticPolicy):
        mean, log_std, _ = model.actor.get_action_dist_params(seen)  # before it is squashed
        drawn_from: object = Normal(mean, log_std.exp())
    elif isinstance(model, RecurrentActorCriticPolicy):
        assert states is not None, "an LSTM has states"
        hidden, cell = map(torch.tensor, states)
        distribution, tensors = model.get_distribution(seen, (hidden, cell), torch.zeros(len(seen)))
        drawn_from, after = distribution.distribution, tuple(each.numpy() for each in tensors)
    else:
        drawn_from = model.get_distribution(seen).distribution
    assert isinstance(drawn_from, Distribution), "its actions are no dictionary"
    if isinstance(drawn_from, Categorical):
        return drawn_choices(drawn_from.probs.double().numpy(), draws), after
    numbers = (drawn_from.mean + drawn_from.stddev * torch.as_tensor(draws)).float().numpy()
    return model.unscale_action(np.tanh(numbers)) if model.squash_output else numbers, after


def _load(file: str, model: "BasePolicy", content: bytes) -> None:
    """Load weights. ConfigError if they do not fit, and for a pickle, NaN and infinity."""
    import torch

    try:
        check_zip(content)
        weights = torch.load(io.BytesIO(content), map_location="cpu", weights_only=True)
        has = {name: tuple(each.shape) for name, each in weights.items()}
        other = misfit(has, {name: tuple(w.shape) for name, w in model.state_dict().items()})
    except Exception as error:  # an invalid file can raise any error
        raise ConfigError(f"policy {file}: its weights cannot be read ({reason(error)})") from None
    if other:
        raise ConfigError(f"policy {file}: its weights do not fit: {other}")
    try:
        model.load_state_dict(weights)
    except (RuntimeError, TypeError) as error:
        raise ConfigError(f"policy {file}: its weights do not fit: {reason(error)}") from None
    single = (item for item in model.state_dict().items() if item[1].dtype == torch.float32)
    check_weights({name: each.numpy() for name, each in single}, file)


def _check_spaces(file: str, saved: SavedModel, form: PolicyForm) -> None:
    """Raise ConfigError if the model was trained on observations or actions of other shapes."""
    trained, here = (saved.observation_space.size, saved.action_space.size), _sizes(form)
    if trained == here:
        return
    joint = tuple(str(len(form.agents) * int(each)) for each in here if each.isdigit())
    if trained == joint:
        remedy = "It controls all robots at once, and runs in its own environment only"
    else:
        remedy = f"Give the keywords of its training, as in sb3:{file},{_fitting(form, trained)}"
    raise ConfigError(
        f"policy {file}: maps {trained[0]} numbers to {trained[1]}; with these keywords"
        f" (learn={form.config.learn}) it must map {here[0]} to {here[1]}. {remedy}"
    )


def _check_unchanged(file: str, saved: SavedModel, form: PolicyForm) -> None:
    """Raise ConfigError if action bounds or observations of the training were changed by a wrapper.

    Only features of the layer are checked; in SI units, only their signs.
    """
    space, here, other = saved.action_space, form.action_space, ""
    if isinstance(here, Box):
        bounds = [tuple(float(str(end)) for end in ends) for ends in (here.low, here.high)]
        if space.low and [space.low, space.high] != bounds:
            other = f"gives actions from {shown(space.low)} to {shown(space.high)}; here they are"
            other += f" from {shown(bounds[0])} to {shown(bounds[1])}"
    layout, size = form.observed, 1.0 if form.config.normalise else np.inf
    n = min((first for _, first, _ in form.additions), default=len(layout))
    low = np.array([0.0 if each.low >= 0.0 else -size for each in layout[:n]])
    seen = saved.last_numbers
    rows = seen[: len(seen) // len(layout) * len(layout)].reshape(-1, len(layout))[:, :n]
    for row, k in np.argwhere((rows < low) | (rows > size))[:1]:
        other = f"observed {layout[k].name}={rows[row, k]:.3g} in training; here it is"
        other += f" from {low[k]:g} to {size:g}"
    if other:
        raise ConfigError(
            f"policy {file}: {other}. A wrapper such as RescaleAction or VecNormalize is not in"
            " the zip: train without it, VecNormalize with norm_obs=False; or give the keywords"
            f" of its training, as in sb3:{file},normalise=false"
        )


def _sizes(form: PolicyForm) -> tuple[str, str]:
    """Return the sizes of a policy's observation and action, in words."""
    space = form.action_space
    action = Space(n=int(space.n)) if isinstance(space, Discrete) else Space(_shape=space.shape)
    return str(len(form.layout)), action.size


def _fitting(form: PolicyForm, trained: tuple[str, str]) -> str:
    """Return the fewest keywords under which a policy has these sizes; an example if none do."""
    now, fixes = dict(form.config), []
    for learn, discrete, stack in product(form.task.policies, (False, True), range(1, 5)):
        terms = {"learn": learn, "discrete": discrete, "stack": stack}
        changed = form.config.model_copy(update={**terms, "decision_period": None})
        with suppress(ConfigError, UnknownNameError):
            if _sizes(PolicyForm([form.scenario], changed)) == trained:
                fixes.append({name: each for name, each in terms.items() if now[name] != each})
    return as_keywords(min(fixes, key=len)) if fixes else "observation=layer+time_left,walk=false"

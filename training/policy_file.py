"""Policy files: weights as safetensors, with a model card in JSON beside them.

    best.safetensors    arrays of float32, named <layer>.<array>: `weighting.hidden.weight`
    best.json           the card: architecture, training run, scores

Nothing is unpickled. A policy that does not fit a scenario is refused before it runs.
"""

import hashlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import Field, ValidationError

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.atomic_write import write_atomically
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.extras import remedy
from swarm_forage_env.foraging.policies import LEARNABLE
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.observed_fields import FieldLayout
from swarm_forage_env.parameters import Count, NotNegative, Parameters
from swarm_forage_env.spaces import Layout
from training.foreign_file import LARGEST_CARD, read_file, reason

BUNDLED = Path(__file__).parent / "policies"
"""Folder of the bundled policies, which are loaded by name."""

Weights = Mapping[str, Float32[Array, "..."]]
Shapes = Mapping[str, tuple[int, ...]]
LayerName = Literal["weighting", "motion"]


class FeatureName(Parameters):
    """Name and unit of one component of a layer's observation or action."""

    name: str
    unit: str


class LayerCard(Parameters):
    """Card of one layer: architecture, observation and action components."""

    network: str
    """Name of the architecture."""
    sizes: dict[str, Count]
    """Sizes of the network, which determine the shapes of all its arrays."""
    observes: tuple[FeatureName, ...]
    """Components of the layer's observation."""
    gives: tuple[FeatureName, ...]
    """Components of the layer's action."""


class Interval(Parameters):
    """Mean over episodes with its 95 % interval."""

    low: float
    mean: float
    high: float


class CurvePoint(Parameters):
    """Point of a learning curve: an evaluation on the held-back seeds."""

    step: NotNegative
    """Generations, rounds or robot steps so far."""
    simulated_s: NotNegative
    """Simulated time so far, summed over worlds [s]."""
    value: float
    """Score by which the best policy is chosen."""
    round_trips: dict[str, Interval]
    """Round trips in each scenario."""


class TrainingRecord(Parameters):
    """Record of the training of a policy, with its scores."""

    scenarios: tuple[str, ...]
    """Scenarios of the training, each with its own changes: `es1:radio.frames=50`."""
    settings: dict[str, str]
    """Changes of all scenarios, by dotted name."""
    algorithm: str
    command: str
    seed: int
    versions: dict[str, str]
    """Versions of the packages used."""
    curve: tuple[CurvePoint, ...]
    score: dict[str, Interval]
    """Round trips on the held-back seeds, in each scenario."""
    sha256: str = ""
    """SHA-256 hash of the weights file, with which it is written."""


class Format(Parameters):
    """Version of a card, which is validated first."""

    format: Literal[1] = 1


class Card(TrainingRecord, Format):
    """Model card of a policy: its layers, and everything needed to repeat its training."""

    layers: dict[LayerName, LayerCard] = Field(min_length=1)
    controller: str
    """Controller whose other layers were used."""

    @property
    def layer(self) -> str:
        """Layer that the policy replaces: weighting, motion or both."""
        return "both" if len(self.layers) > 1 else next(iter(self.layers))


@dataclass(frozen=True)
class Policy:
    """Loaded policy: file, weights and card."""

    source: Path
    weights: Weights
    card: Card

    def sizes_of(self, layer: LayerName, network: str, names: tuple[str, ...]) -> dict[str, int]:
        """Return the sizes of one layer's network. ConfigError for another architecture."""
        card = self._layer(layer)
        if card.network != network:
            raise self._refusal(f"its {layer} is a network '{card.network}', not '{network}'")
        if card.sizes.keys() != set(names):
            has = ", ".join(card.sizes) or "nothing"
            raise self._refusal(f"its card gives the sizes {has}: must be {', '.join(names)}")
        return card.sizes

    def weights_of(self, layer: LayerName, shapes: Shapes) -> Weights:
        """Return the weights of one layer, named without it. ConfigError if shapes differ."""
        prefix = f"{layer}."
        weights = arrays_under(prefix, self.weights)
        other = misfit(
            {f"{prefix}{name}": each.shape for name, each in weights.items()},
            {f"{prefix}{name}": shape for name, shape in shapes.items()},
        )
        if other:
            raise self._refusal(other)
        return weights

    def check_fits(self, layer: LayerName, scenario: Scenario) -> None:
        """Raise ConfigError if a layer's observation or action differs in a scenario."""
        card = self._layer(layer)
        for kind, trained, there in (
            ("observation", card.observes, observation_features(layer, scenario)),
            ("action", card.gives, _names(LEARNABLE[layer].action)),
        ):
            for k, (old, new) in enumerate(zip_longest(trained, there)):
                if old != new:
                    raise self._refusal(
                        f"does not fit '{scenario.name}': {kind} feature {k} of its {layer} was"
                        f" {_described(old)} in training and is {_described(new)} here"
                    )

    def _layer(self, layer: LayerName) -> LayerCard:
        if layer not in self.card.layers:
            raise self._refusal(f"replaces the {self.card.layer}, not the {layer}")
        return self.card.layers[layer]

    def _refusal(self, why: str) -> ConfigError:
        return ConfigError(f"policy {self.source}: {why}")


def arrays_under(prefix: str, arrays: Mapping[str, Array]) -> dict[str, Array]:
    """Return the arrays whose names have a prefix, by the rest of their names."""
    return {
        name.removeprefix(prefix): each for name, each in arrays.items() if name.startswith(prefix)
    }


def misfit(has: Shapes, wants: Shapes) -> str:
    """Describe the first array that is missing, unexpected or of another shape; empty if none."""
    for name in sorted(has.keys() | wants.keys()):
        if has.get(name) != wants.get(name):
            here, wanted = has.get(name, "missing"), wants.get(name, "no such array")
            return f"array {name[:100]!r} is {here}: must be {wanted}"
    return ""


def observation_layout(layer: str, scenario: Scenario) -> FieldLayout:
    """Return the observation layout of a layer in a scenario."""
    return LEARNABLE[layer].layout(scenario, has_walk=False)


def observation_features(layer: str, scenario: Scenario) -> tuple[FeatureName, ...]:
    """Return the components of a layer's observation in a scenario."""
    return _names(observation_layout(layer, scenario))


def layer_card(
    layer: LayerName, scenario: Scenario, network: str, sizes: Mapping[str, int]
) -> LayerCard:
    """Return the card of a layer that is trained in a scenario."""
    return LayerCard(
        network=network,
        sizes=dict(sizes),
        observes=observation_features(layer, scenario),
        gives=_names(LEARNABLE[layer].action),
    )


def save_policy(file: Path, weights: Weights, card: Card) -> None:
    """Write weights and card to files, each atomically."""
    content, sha256 = packed_weights(file, weights)
    write_both(file, content, card.model_copy(update={"sha256": sha256}))


def write_both(file: Path, content: bytes, card: Parameters) -> None:
    """Write a weights file and the card beside it, each atomically."""
    write_atomically(file, content)
    write_card(file.with_suffix(".json"), card)


def write_card(file: Path, card: Parameters) -> None:
    """Write a card as JSON, atomically."""
    write_atomically(file, (card.model_dump_json(indent=1) + "\n").encode())


def packed_weights(file: Path, weights: Weights) -> tuple[bytes, str]:
    """Return content and SHA-256 hash of a weights file. ConfigError for NaN and infinity."""
    with needed_by(f"policy {file}"):
        from safetensors.numpy import save
    check_weights(weights, str(file))
    content: bytes = save({name: np.ascontiguousarray(array) for name, array in weights.items()})
    return content, hashlib.sha256(content).hexdigest()


def read_weights(file: Path) -> tuple[Weights, str]:
    """Read the arrays and the SHA-256 hash of a weights file. ConfigError if it is damaged."""
    with needed_by(f"policy {file}"):
        from safetensors import SafetensorError
        from safetensors.numpy import load
    content = read_file(file, "policy")
    try:
        weights: Weights = load(content)
    except (SafetensorError, KeyError, ValueError) as error:
        raise ConfigError(f"policy {file}: not a safetensors file ({reason(error)})") from None
    check_weights(weights, str(file))
    return weights, hashlib.sha256(content).hexdigest()


def load_policy(policy: str | Path) -> Policy:
    """Load a policy from a file, or the bundled policy of that name.

    ConfigError if the file is missing, damaged or without a card that fits it, UnknownNameError for
    an unknown name, ModuleNotFoundError without safetensors.
    """
    file = policy_path(policy)
    weights, sha256 = read_weights(file)
    card_file = file.with_suffix(".json")
    try:
        card = Card.model_validate_json(read_file(card_file, "card", LARGEST_CARD))
    except ValidationError as error:
        raise ConfigError(f"card {card_file}: {reason(error)}") from None
    if card.sha256 != sha256:
        raise ConfigError(f"policy {file}: its card {card_file} belongs to other weights")
    for name in weights:
        if name.partition(".")[0] not in card.layers:
            raise ConfigError(f"policy {file}: array '{name}' belongs to no layer of its card")
    return Policy(file, weights, card)


def policy_path(policy: str | Path) -> Path:
    """Return the path of a policy, given as a bundled name (`weighting`) or as a path."""
    if Path(policy).suffix == ".safetensors":
        return Path(policy)
    names = [each.stem for each in BUNDLED.glob("*.safetensors")]
    if str(policy) not in names:
        raise UnknownNameError("policy", str(policy), names)
    return BUNDLED / f"{policy}.safetensors"


def check_weights(weights: Mapping[str, Array], where: str) -> None:
    """Raise ConfigError unless all arrays are finite and of single precision."""
    for name, array in weights.items():
        if array.dtype != np.float32:
            raise ConfigError(f"policy {where}: array '{name}' is {array.dtype}: must be float32")
        if not np.isfinite(array).all():
            raise ConfigError(f"policy {where}: array '{name}' holds NaN or infinity")


@contextmanager
def in_one_thread() -> Iterator[None]:
    """Run torch in one thread: faster for such small networks, and the same sums on any machine."""
    import torch

    n_threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(n_threads)


@contextmanager
def needed_by(feature: str) -> Iterator[None]:
    """Extend the error of a failed import in the block by what needs and installs the package."""
    try:
        yield
    except ModuleNotFoundError as error:
        text = f"{feature}: needs '{error.name}': {remedy(error.name)}"
        raise ModuleNotFoundError(text, name=error.name) from None


def _names(layout: Layout) -> tuple[FeatureName, ...]:
    return tuple(FeatureName(name=each.name, unit=each.unit) for each in layout)


def _described(feature: FeatureName | None) -> str:
    return "missing" if feature is None else f"{feature.name} [{feature.unit}]"

"""Policies in files: weights as safetensors, and beside them a card that says what they are.

    best.safetensors    arrays of float32, named <layer>.<array>: `weighting.hidden.weight`
    best.json           the card: for what, made how, how good

Nothing is loaded through pickle, and what does not fit is refused before it runs.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field, ValidationError

from baselines.evaluation.output_files import write_atomically
from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.envs.bounds import Bounds
from swarm_forage_env.envs.cuts import CUTS
from swarm_forage_env.envs.layout import ObservationLayout
from swarm_forage_env.envs.observation import encounter_fields, situation_fields
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.scenario import Count, NotNegative, Part, Scenario

SHIPPED = Path(__file__).parent / "policies"
"""Where the policies in the box lie: a bare name is one of them."""

Weights = Mapping[str, Float32[Array, "..."]]
Shapes = Mapping[str, tuple[int, ...]]
LayerName = Literal["weighting", "motion"]


class SlotName(Part):
    """One number that a layer sees or gives."""

    name: str
    unit: str


class LayerCard(Part):
    """The network in the place of one layer, and the numbers that it was trained on."""

    network: str
    """What kind of network."""
    sizes: dict[str, Count]
    """Its sizes, from which the shapes of all its arrays follow."""
    observes: tuple[SlotName, ...]
    """The slots of the layer's part of the observation."""
    gives: tuple[SlotName, ...]
    """The slots of the layer's part of the action."""


class Interval(Part):
    """A mean over episodes, and its 95 % interval."""

    low: float
    mean: float
    high: float


class CurvePoint(Part):
    """How good the policy was at one moment of its training, on the held-back seeds."""

    step: NotNegative
    """Generations or robot steps so far."""
    simulated_s: NotNegative
    """Simulated time so far, summed over worlds [s]."""
    value: float
    """What the best policy is chosen by."""
    round_trips: dict[str, Interval]
    """Round trips in each scenario."""


class Card(Part):
    """What a policy is, and all that it takes to make it again."""

    format: Literal[1] = 1
    """Version of the card; another one is refused."""
    layers: dict[LayerName, LayerCard] = Field(min_length=1)
    scenarios: tuple[str, ...]
    """Those it was trained on, with what differs in each: `es1:radio.frames=50`."""
    settings: dict[str, str]
    """What differs from them in all."""
    controller: str
    """The hand-written rest."""
    algorithm: str
    command: str
    seed: int
    versions: dict[str, str]
    """Of the packages it was made with."""
    curve: tuple[CurvePoint, ...]
    score: dict[str, Interval]
    """Round trips on the held-back seeds, in each scenario."""
    sha256: str = ""
    """Of the file of the weights; written by `save_policy`."""

    @property
    def layer(self) -> str:
        """What the policy takes the place of: weighting, motion or both."""
        return "both" if len(self.layers) > 1 else next(iter(self.layers))


@dataclass(frozen=True)
class Policy:
    """Weights with their card, and where they come from."""

    source: Path
    weights: Weights
    card: Card

    def sizes_of(self, layer: LayerName, network: str, names: tuple[str, ...]) -> dict[str, int]:
        """The sizes of one layer's network; ConfigError if it is another kind of network."""
        card = self._layer(layer)
        if card.network != network:
            raise self._refusal(f"its {layer} is a network '{card.network}', not '{network}'")
        if card.sizes.keys() != set(names):
            said = ", ".join(card.sizes) or "nothing"
            raise self._refusal(f"its card gives the sizes {said}: must be {', '.join(names)}")
        return card.sizes

    def weights_of(self, layer: LayerName, shapes: Shapes) -> Weights:
        """The arrays of one layer, without its name; ConfigError if they have other shapes."""
        prefix = f"{layer}."
        found = {
            name.removeprefix(prefix): array
            for name, array in self.weights.items()
            if name.startswith(prefix)
        }
        for name in sorted(found.keys() | shapes.keys()):
            has = found[name].shape if name in found else "missing"
            wants = shapes.get(name, "no such array")
            if has != wants:
                raise self._refusal(f"array '{prefix}{name}' is {has}: must be {wants}")
        return found

    def check_fits(self, layer: LayerName, scenario: Scenario) -> None:
        """ConfigError, naming the first slot that differs, if a layer there is shown others."""
        card = self._layer(layer)
        for kind, trained, there in (
            ("observation", card.observes, observed(layer, scenario)),
            ("action", card.gives, given(layer)),
        ):
            for k in range(max(len(trained), len(there))):
                old = trained[k] if k < len(trained) else None
                new = there[k] if k < len(there) else None
                if old != new:
                    raise self._refusal(
                        f"does not fit '{scenario.name}': {kind} slot {k} of its {layer} was"
                        f" {_told(old)} in training and is {_told(new)} here"
                    )

    def _layer(self, layer: LayerName) -> LayerCard:
        if layer not in self.card.layers:
            raise self._refusal(f"takes the place of {self.card.layer}, not of {layer}")
        return self.card.layers[layer]

    def _refusal(self, why: str) -> ConfigError:
        return ConfigError(f"policy {self.source}: {why}")


def observed(layer: LayerName, scenario: Scenario) -> tuple[SlotName, ...]:
    """The slots that a layer is shown in a scenario."""
    layout = encounter_layout(scenario) if layer == "weighting" else situation_layout(scenario)
    return tuple(SlotName(name=slot.name, unit=slot.unit) for slot in layout)


def encounter_layout(scenario: Scenario) -> ObservationLayout:
    """What a weighting sees in a scenario."""
    return ObservationLayout({"encounter": encounter_fields(Bounds(scenario, scenario.n_ticks))})


def situation_layout(scenario: Scenario) -> ObservationLayout:
    """What a motion sees in a scenario."""
    fields = situation_fields(Bounds(scenario, scenario.n_ticks), scenario.slots)
    return ObservationLayout({"situation": fields})


def given(layer: LayerName) -> tuple[SlotName, ...]:
    """The slots that a layer gives."""
    layout = CUTS[layer].action_layout
    return tuple(SlotName(name=slot.name, unit=slot.unit) for slot in layout)


def layer_card(
    layer: LayerName, scenario: Scenario, network: str, sizes: Mapping[str, int]
) -> LayerCard:
    """The card of a layer that is trained in a scenario."""
    return LayerCard(
        network=network,
        sizes=dict(sizes),
        observes=observed(layer, scenario),
        gives=given(layer),
    )


def save_policy(file: Path, weights: Weights, card: Card) -> None:
    """Write weights and card; each file appears whole or not at all."""
    from safetensors.numpy import save

    check_weights(weights, str(file))
    content = save({name: np.ascontiguousarray(array) for name, array in weights.items()})
    card = card.model_copy(update={"sha256": hashlib.sha256(content).hexdigest()})
    write_atomically(file, content)
    write_atomically(card_beside(file), (card.model_dump_json(indent=1) + "\n").encode())


def load_policy(policy: str | Path) -> Policy:
    """The policy in a file, or the one in the box that a bare name stands for.

    ConfigError for a file that is missing, damaged or without a card that fits it,
    UnknownNameError for a name that stands for nothing.
    """
    from safetensors import SafetensorError
    from safetensors.numpy import load

    file = policy_file(policy)
    content = _read(file, "policy")
    try:
        weights = load(content)
    except (SafetensorError, KeyError, ValueError) as error:
        raise ConfigError(f"policy {file}: not a safetensors file ({error})") from None
    card = _read_card(card_beside(file))
    if card.sha256 != hashlib.sha256(content).hexdigest():
        raise ConfigError(f"policy {file}: its card {card_beside(file)} is of other weights")
    check_weights(weights, str(file))
    for name in weights:
        if name.partition(".")[0] not in card.layers:
            raise ConfigError(f"policy {file}: array '{name}' belongs to no layer of its card")
    return Policy(file, weights, card)


def policy_file(policy: str | Path) -> Path:
    """The file of a policy that is named as `weighting` or as `runs/x/best.safetensors`."""
    if Path(policy).suffix == ".safetensors":
        return Path(policy)
    names = [each.stem for each in SHIPPED.glob("*.safetensors")]
    if str(policy) not in names:
        raise UnknownNameError("policy", str(policy), names)
    return SHIPPED / f"{policy}.safetensors"


def card_beside(file: Path) -> Path:
    """The card of a file of weights."""
    return file.with_suffix(".json")


def check_weights(weights: Mapping[str, Any], where: str) -> None:
    """ConfigError unless all arrays are finite numbers of single precision."""
    for name, array in weights.items():
        if array.dtype != np.float32:
            raise ConfigError(f"policy {where}: array '{name}' is {array.dtype}: must be float32")
        if not np.isfinite(array).all():
            raise ConfigError(f"policy {where}: array '{name}' holds NaN or infinity")


def _read_card(file: Path) -> Card:
    try:
        return Card.model_validate_json(_read(file, "card"))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise ConfigError(f"card {file}: {where}: {first['msg']}") from None


def _read(file: Path, what: str) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise ConfigError(f"{what} {file}: cannot be read ({error.strerror})") from None


def _told(slot: SlotName | None) -> str:
    return "missing" if slot is None else f"{slot.name} [{slot.unit}]"

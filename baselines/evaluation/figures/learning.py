"""Learning curves: round trips over simulated time, from the cards of trained policies."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from baselines.evaluation.figures.base import PlotOptions, figure
from baselines.evaluation.line_plots import Means, curve_panels
from swarm_forage_env.errors import ConfigError

HOUR = 3600.0  # [s]


class _Entry(BaseModel):
    """Base of the parts of a policy card that are read; other fields are ignored."""

    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False)


class Span(_Entry):
    """A mean and the ends of its 95 % interval."""

    low: float
    mean: float
    high: float


class Point(_Entry):
    """One evaluation of a policy during its training."""

    simulated_s: float = Field(ge=0.0)  # simulated time so far, summed over worlds [s]
    round_trips: dict[str, Span]  # by scenario


class TrainingCard(_Entry):
    """The training history in a policy card."""

    command: str
    curve: tuple[Point, ...] = Field(min_length=1)

    @model_validator(mode="before")
    @classmethod
    def _of_ppo(cls, card: object) -> object:
        """Return the part `training` of a card that has one, else the card itself."""
        return card.get("training", card) if isinstance(card, dict) else card


@figure("learning", "scenario")
def draw(options: PlotOptions) -> Figure:
    """Draw round trips on the held-back seeds over simulated time."""
    files = [Path(source) for source in options.sources]
    read = [read_card(file) for file in files]
    cards = dict(zip(_names(files), read, strict=True))
    panels: dict[str, dict[str, Means]] = {}
    for name, card in cards.items():
        for scenario in card.curve[0].round_trips:
            if not options.scenarios or scenario in options.scenarios:
                panels.setdefault(scenario, {})[name] = _curve(card, scenario)
    if not panels:
        known = sorted({each for card in cards.values() for each in card.curve[0].round_trips})
        raise ConfigError(
            f"--scenario {', '.join(options.scenarios)}: must be a scenario of the cards:"
            f" {', '.join(known)}"
        )
    made = " ".join(f"{name}: {card.command}." for name, card in cards.items())
    text = f"Means over the held-back seeds with 95 % intervals. {made}"
    names = "simulated time of training [h]", "round trips"
    return curve_panels(panels, names, options.caption(text))


def read_card(file: Path) -> TrainingCard:
    """Read a policy card from its path or that of the policy; ConfigError if it is no card."""
    file = file.with_suffix(".json") if file.suffix == ".safetensors" else file
    try:
        return TrainingCard.model_validate_json(file.read_bytes())
    except OSError as error:
        raise ConfigError(
            f"policy card {file}: {error.strerror}; name a .json that swarm-forage train has"
            " written beside a .safetensors"
        ) from None
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise ConfigError(
            f"policy card {file}: {where + ': ' if where else ''}{first['msg']}; not a card of"
            " this version of swarm-forage train"
        ) from None


def _names(files: Sequence[Path]) -> list[str]:
    """Return the shortest path endings that are unique."""
    parts = [file.with_suffix("").parts for file in files]
    depths = range(1, max(map(len, parts)) + 1)
    endings = (["/".join(each[-depth:]) for each in parts] for depth in depths)
    return next((each for each in endings if len({*each}) == len(each)), list(map(str, files)))


def _curve(card: TrainingCard, scenario: str) -> Means:
    points = [point for point in card.curve if scenario in point.round_trips]
    spans = [point.round_trips[scenario] for point in points]
    means = np.array([(each.mean, each.low, each.high) for each in spans])
    return Means(np.array([point.simulated_s / HOUR for point in points]), *means.T)

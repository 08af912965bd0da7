"""The checkpoint of a search: everything it was told, in one file that appears whole."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from baselines.evaluation.output_files import write_atomically
from baselines.evaluation.statistics import mean_interval
from swarm_forage_env.arrays import Array, Float32, Float64, Int64
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.scenario import Part
from training.experiment import Experiment, versions
from training.policy import Card, CurvePoint, Interval, LayerCard, LayerName

NAME = "checkpoint.safetensors"

BEST = "best.safetensors"
"""The policy that the held-back worlds judge best so far."""

RECORD = "record"
"""The one entry of the file beside its arrays."""

Identity = dict[str, str]


class Record(Part):
    """What is kept in words."""

    experiment: Identity
    curve: tuple[CurvePoint, ...]


class Checkpoint:
    """All candidates so far with their losses, and the means that were judged.

    Telling a search the same again brings it to where it was, bit for bit; so nothing of its
    inside has to be kept.
    """

    def __init__(self, file: Path, identity: Identity, population: int, numbers: int) -> None:
        """Nothing told yet."""
        self._file = file
        self._identity = identity
        self._populations = np.zeros((0, population, numbers), np.float32)
        self._losses = np.zeros((0, population), np.float64)
        self._means = np.zeros((0, numbers), np.float32)
        self.curve: list[CurvePoint] = []

    @classmethod
    def open(cls, experiment: Experiment, population: int, numbers: int) -> "Checkpoint":
        """That of an experiment's folder, or an empty one.

        ConfigError if the folder cannot be written, holds the checkpoint of another
        experiment, or one that is damaged.
        """
        file = experiment.out / NAME
        checkpoint = cls(file, experiment.identity, population, numbers)
        if file.exists():
            checkpoint._read()
        else:
            checkpoint.keep()
        return checkpoint

    @property
    def generation(self) -> int:
        """Generations told."""
        return len(self._losses)

    @property
    def best(self) -> tuple[CurvePoint, Float32[Array, " numbers"]]:
        """The point with the highest value, the first of them, and its numbers."""
        k = int(np.argmax([point.value for point in self.curve]))
        return self.curve[k], self._means[k]

    def told(
        self,
    ) -> Iterator[tuple[Float32[Array, "n numbers"], Float64[Array, " n"]]]:
        """Candidates and losses, generation by generation."""
        return zip(self._populations, self._losses, strict=True)

    def add(self, population: Float32[Array, "n numbers"], losses: Float64[Array, " n"]) -> None:
        """Note a generation."""
        self._populations = np.concatenate([self._populations, population[None]])
        self._losses = np.concatenate([self._losses, losses[None]])

    def add_point(self, point: CurvePoint, mean: Float32[Array, " numbers"]) -> None:
        """Note an evaluation."""
        self.curve.append(point)
        self._means = np.concatenate([self._means, mean[None]])

    def keep(self) -> None:
        """Write it, over the one before."""
        arrays: dict[str, Array] = {
            "populations": self._populations,
            "losses": self._losses,
            "means": self._means,
        }
        write_checkpoint(self._file, self._identity, self.curve, arrays)

    def _read(self) -> None:
        names = ("populations", "losses", "means")
        self.curve, arrays = read_checkpoint(self._file, self._identity, names)
        self._populations, self._losses, self._means = (arrays[name] for name in names)


def write_checkpoint(
    file: Path, identity: Identity, curve: list[CurvePoint], arrays: dict[str, Array]
) -> None:
    """Write the state of an experiment, over the one before."""
    from safetensors.numpy import save

    record = Record(experiment=identity, curve=tuple(curve)).model_dump_json()
    content = save(arrays, {RECORD: record})
    try:
        write_atomically(file, content)
    except OSError as error:
        raise not_writable(file.parent, error) from None


def not_writable(folder: Path, error: OSError) -> ConfigError:
    """What is to be said of a folder that takes no files."""
    return ConfigError(f"--out {folder}: cannot be written ({error.strerror}); name another folder")


def read_checkpoint(
    file: Path, identity: Identity, names: Iterable[str]
) -> tuple[list[CurvePoint], dict[str, Array]]:
    """The curve and the arrays of an experiment's checkpoint.

    ConfigError if it is damaged, lacks an array of these names or is of another experiment.
    """
    from safetensors import SafetensorError, safe_open

    try:
        with safe_open(file, "np") as kept:
            record = Record.model_validate_json(kept.metadata()[RECORD])
            arrays = {name: kept.get_tensor(name) for name in names}
    except (OSError, SafetensorError, KeyError, TypeError, ValidationError) as error:
        raise ConfigError(
            f"checkpoint {file}: cannot be read ({error}); remove it to start anew"
        ) from None
    found = record.experiment
    for name in (*identity, *sorted(found.keys() - identity.keys())):
        there, here = found.get(name, "missing"), identity.get(name, "missing")
        if there != here:
            raise ConfigError(
                f"--out {file.parent}: holds an experiment with {name} = {there}, not"
                f" {here}; name another folder"
            )
    return list(record.curve), arrays


def card_of(
    experiment: Experiment,
    layers: Mapping[LayerName, LayerCard],
    packages: tuple[str, ...],
    curve: Sequence[CurvePoint],
    score: Mapping[str, Interval],
) -> Card:
    """The card of a policy that an experiment trained with these packages."""
    return Card(
        layers=dict(layers),
        scenarios=experiment.scenarios,
        settings=dict(experiment.settings),
        controller=experiment.controller,
        algorithm=experiment.algorithm,
        command=experiment.command,
        seed=experiment.seed,
        versions=versions(*packages),
        curve=tuple(curve),
        score=dict(score),
    )


def judged(
    step: int, simulated_s: float, trips: Mapping[str, Int64[Array, " worlds"]]
) -> CurvePoint:
    """A point of the curve: the round trips in the held-back worlds of each scenario.

    Its value, by which the best is chosen, is ln(1 + mean round trips), averaged over the
    scenarios.
    """
    return CurvePoint(
        step=step,
        simulated_s=simulated_s,
        value=float(np.mean([np.log1p(each.mean()) for each in trips.values()])),
        round_trips={name: interval(each) for name, each in trips.items()},
    )


def interval(trips: Int64[Array, " worlds"]) -> Interval:
    """The mean over worlds and its 95 % interval; the mean itself where there is none."""
    found = mean_interval(trips.tolist())
    assert found is not None
    low, high = found.interval or (found.value, found.value)
    return Interval(low=low, mean=found.value, high=high)

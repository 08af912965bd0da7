"""The checkpoint of a search: everything it was told, in one file that appears whole."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from pydantic import TypeAdapter, ValidationError

from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.errors import ConfigError
from training.experiment import Experiment
from training.policy import CurvePoint, write_whole

NAME = "checkpoint.safetensors"

Identity = dict[str, str]

IDENTITY = TypeAdapter(Identity)
CURVE: TypeAdapter[list[CurvePoint]] = TypeAdapter(list[CurvePoint])


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
        from safetensors.numpy import save

        metadata = {
            "experiment": IDENTITY.dump_json(self._identity).decode(),
            "curve": CURVE.dump_json(self.curve).decode(),
        }
        arrays: dict[str, Array] = {
            "populations": self._populations,
            "losses": self._losses,
            "means": self._means,
        }
        content = save(arrays, metadata)
        try:
            write_whole(self._file, content)
        except OSError as error:
            raise ConfigError(
                f"--out {self._file.parent}: cannot be written ({error.strerror});"
                " name another folder"
            ) from None

    def _read(self) -> None:
        from safetensors import SafetensorError, safe_open

        try:
            with safe_open(self._file, "np") as kept:
                metadata = kept.metadata()
                arrays = {name: kept.get_tensor(name) for name in kept.keys()}  # noqa: SIM118
            identity = IDENTITY.validate_json(metadata["experiment"])
            self.curve = CURVE.validate_json(metadata["curve"])
            populations, losses, means = (
                arrays[name] for name in ("populations", "losses", "means")
            )
        except (OSError, SafetensorError, KeyError, TypeError, ValidationError) as error:
            raise ConfigError(
                f"checkpoint {self._file}: cannot be read ({error}); remove it to start anew"
            ) from None
        self._check(identity)
        self._populations, self._losses, self._means = populations, losses, means

    def _check(self, identity: Identity) -> None:
        """ConfigError, naming the first difference, if the file is of another experiment."""
        for name in sorted(identity.keys() | self._identity.keys()):
            there, here = identity.get(name, "missing"), self._identity.get(name, "missing")
            if there != here:
                raise ConfigError(
                    f"--out {self._file.parent}: holds an experiment with {name} = {there}, not"
                    f" {here}; name another folder"
                )

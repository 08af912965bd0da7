"""Offline transitions in Parquet files: observations, actions and rewards in every tick.

    OUT/scenario=es1/policy=ssgikf/<key>-seed00010000.transitions.parquet

`swarm-forage dataset` records all policies in one action space: the commands of the motion in every
tick, which for e-pucks are wheels. A controller plays an episode, and an environment repeats its
commands to obtain the observations and rewards of a learner. Both must end alike, bit for bit, or
nothing is stored.
"""

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from gymnasium.spaces import Box
from scipy.special import ndtr

from baselines.controller import LayeredController
from baselines.evaluation.dataset import (
    DamagedFileError,
    Dataset,
    folder_name,
    name_in,
    read_table,
    reading,
    with_checksum,
)
from baselines.evaluation.dataset_reader import TRANSITIONS
from baselines.evaluation.evaluate_options import EvaluateOptions
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.trajectories import COMPRESSION
from swarm_forage_env import envs
from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.controllers import parse_controller
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.envs.config import chosen_robots
from swarm_forage_env.envs.make import checked_parts
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.task import task_of
from training.policy import ForeignPolicy, Started
from training.policy_card import PolicyCard, card_from, card_of
from training.policy_controller import PolicyController, named_policy

CARD = b"card"
"""Metadata key of the card for a policy that is trained on a file."""

WORLD = b"world"
"""Metadata key of the world of a file; files of early versions have none."""

COLUMNS = {
    "observation": "what the robot observes before the decision; the card names the features",
    "action": "command of the robot's motion, as the environment takes it",
    "reward": "reward of the robot for the decision",
    "next_observation": "what the robot observes after the decision",
    "terminated": "whether a terminal state ended the episode: false",
    "truncated": "whether the episode ended at its duration: true in its last transition",
    "robot": "which robot: 0 to N - 1",
    "decision": "number of the decision in the episode, from 0",
    "seed": "seed of the episode",
}
"""Description of each column; its file holds them as metadata."""

BLOCK_ROWS = 1_000_000
"""Approximate number of transitions of the worlds that are played at once."""


def read(folder: str | Path, policy: str | None = None) -> dict[str, Array]:
    """Read the transitions of one policy or of all in a folder, by `COLUMNS` and `policy`.

        from training.transitions import read

        played = read("runs/es1-transitions", "ssgikf")
        played["observation"], played["action"]          # float32, (rows, features)

    The transitions of a robot in an episode follow one another; `truncated` marks the last one.
    ConfigError for a folder without transitions, of several recordings of a policy or of several
    worlds, action spaces or observations, and for a damaged file.

    Args:
        folder: Folder that `swarm-forage dataset` has written.
        policy: The name of one policy; None: all.
    """
    files = _files(Path(folder), policy)
    tables, cards, worlds = zip(*map(_read_file, files), strict=True)
    forms = [(card.scenario, card.keywords.model_dump_json(), card.observes) for card in cards]
    if len({*zip(forms, worlds, strict=True)}) > 1:
        raise ConfigError(
            f"transitions {folder}: its files differ in world, observations or actions; record each"
            " scenario, with its settings and engine, into a folder of its own"
        )
    rows = [len(table) for table in tables]
    names = np.repeat(np.array([_policy_of(file) for file in files], object), rows)
    joined = pa.concat_tables([table.replace_schema_metadata() for table in tables])
    return {name: _array(joined[name]) for name in COLUMNS} | {"policy": names}


def card_in(folder: str | Path, policy: str) -> PolicyCard:
    """Return the card for policies trained on the transitions of `policy`; errors as in `read`."""
    file, *_ = _files(Path(folder), policy)
    return _read_file(file)[1]


def world_in(folder: str | Path, policy: str) -> dict[str, Any]:
    """Return the world of the transitions of `policy`, as keywords of environments.

    They are the engine and the settings that differ from the scenario. Errors as in `read`, and
    ConfigError for a file of an early version, which does not hold them.
    """
    file, *_ = _files(Path(folder), policy)
    world = _read_file(file)[2]
    if world is None:
        raise ConfigError(f"transitions {file}: do not hold their world; record them again")
    keywords: dict[str, Any] = json.loads(world)
    return keywords


def _files(folder: Path, policy: str | None) -> list[Path]:
    files = sorted(folder.glob(f"scenario=*/policy=*/*{TRANSITIONS}"))
    files = [file for file in files if policy in (None, _policy_of(file))]
    first: dict[Path, Path] = {}
    for file in files:
        other = first.setdefault(file.parent, file)
        if file.name.partition("-")[0] != other.name.partition("-")[0]:
            raise ConfigError(
                f"transitions {folder}: {other.name} and {file.name} of '{_policy_of(file)}' differ"
                " in settings, learners or version of the code; remove one kind, or record again"
                " into another folder"
            )
    if not files:
        held = "none" if policy is None else f"none of policy '{policy}'"
        raise ConfigError(
            f"transitions {folder}: holds {held}; record some with swarm-forage dataset es1"
            f" {policy or 'ssgikf'} --out {folder}"
        )
    return files


def _policy_of(file: Path) -> str:
    return unquote(file.parent.name.partition("=")[2])


def _read_file(file: Path) -> tuple[pa.Table, PolicyCard, str | None]:
    """Read the transitions, the card and the world of a file. ConfigError if it is damaged."""
    with reading(f"transitions {file}"):
        table = read_table(file.read_bytes())
        return table, card_from(name_in(table, CARD) or "", str(file)), name_in(table, WORLD)


def _array(column: pa.ChunkedArray) -> Array:
    joined = column.combine_chunks()
    if pa.types.is_fixed_size_list(joined.type):
        return np.array(joined.flatten()).reshape(len(joined), -1)
    return np.array(joined)


class RandomPolicy(ForeignPolicy):
    """Policy of uniformly random actions, from a random stream of each robot."""

    chance: bool = True

    def start(self, form: PolicyForm) -> Started:
        """Start the policy: the normal distribution function makes uniform values of the draws."""
        space = form.action_space
        if not isinstance(space, Box):
            raise ConfigError("policy random: draws continuous actions; leave out discrete")
        low, high = space.low, space.high
        return Started(
            lambda observed, draws, states: (low + (high - low) * ndtr(draws), states),
            has_distribution=True,
        )


RANDOM = named_policy("random", RandomPolicy())


class DatasetOptions(EvaluateOptions):
    """Options of `dataset`: those of `evaluate`, and the policy `random`."""

    def find(self, name: str) -> LayeredController:
        """Return the controller of a name."""
        if name.partition(":")[0] != RANDOM.name:
            return super().find(name)
        return RANDOM.with_parameters(parse_controller(name)[1])


@dataclass(frozen=True)
class Recording:
    """Recording of one policy: the first `learners` robots of each episode, or all."""

    configuration: ExperimentConfig
    learners: int | None = None

    @property
    def keywords(self) -> dict[str, Any]:
        """Keywords of the environment; its actions are the commands of the motion in every tick."""
        forms = task_of(self.configuration.scenario).steerings
        return {
            "learn": "motion",
            "action": next((name for name, each in forms.items() if each.command is None), None),
            "reflexes": False,
            "walk": False,
            "decision_period": 1,
            "learners": self.learners,
            "physics": self.configuration.physics,
        }

    @cached_property
    def card(self) -> PolicyCard:
        """Card of a policy that is trained on the recording, with the same other layers.

        ConfigError or UnknownNameError for a policy whose motion cannot be recorded.
        """
        controller = self.configuration.controller
        if isinstance(controller, PolicyController):
            if controller.policy.learn != "motion":
                raise ConfigError(
                    f"policy '{self.configuration.label}': replaces {controller.policy.learn},"
                    " which no card can name; only policies of the motion are recorded"
                )
            controller = replace(controller.hand_written, name=controller.name_of_layers())
        return card_of(checked_parts(self.configuration.scenario, controller, self.keywords))

    @cached_property
    def key(self) -> str:
        """Hash of everything but the seed that the transitions depend on."""
        world = Path(envs.__file__).parents[1]
        files = sorted([*world.glob("envs/*.py"), *world.rglob("rewards.py"), Path(__file__)])
        text = hashlib.sha256(f"{self.configuration.key} {self.card} {self.keywords}".encode())
        for file in files:
            text.update(file.read_bytes())
        return text.hexdigest()[:16]

    @property
    def n_rows(self) -> int:
        """Number of transitions of an episode."""
        scenario = self.configuration.scenario
        agents = task_of(scenario).agents(scenario.task.n_robots)
        return int(scenario.n_ticks) * len(chosen_robots(self.learners, agents))

    @property
    def size(self) -> int:
        """Size of an episode's transitions, uncompressed [byte]."""
        return self.n_rows * (8 * len(self.card.observes) + 30)

    def play(self, seeds: Sequence[int], threads: int = 1) -> list[pa.Table]:
        """Play an episode for each seed, all at once; return a table of each.

        ConfigError if the commands do not repeat the episode, as the motion did more than that.
        """
        config = self.configuration
        loop = Loop(config.scenario, config.controller, seeds, config.physics, threads)
        env = ArrayEnv(
            config.scenario, len(seeds), config.controller, threads=threads, **self.keywords
        )
        robots, shape = env.learner_numbers, (len(seeds), len(env.learners), env.max_cycles)
        observed = np.empty((*shape[:2], shape[2] + 1, len(env.observation_layout)), np.float32)
        actions, rewards = np.empty((*shape, *env.action_shape), np.float32), np.empty(shape, "f4")
        observed[:, :, 0], _ = env.reset(seed=list(seeds))
        for tick in range(env.max_cycles):
            loop.step()
            actions[:, :, tick] = loop.world.robots["command"][env.task.commanded][:, robots]
            observed[:, :, tick + 1], rewards[:, :, tick], *_ = env.step(actions[:, :, tick])
        if not np.array_equal(loop.world.robots["pose"], env.world.robots["pose"]):
            raise ConfigError(
                f"policy '{config.label}': its commands alone do not repeat the episode, so they"
                " are not its actions; leave it out"
            )
        worlds = zip(seeds, observed, actions, rewards, strict=True)
        return [self._table(seed, robots, each) for seed, *each in worlds]

    def _table(self, seed: int, robots: Array, played: Sequence[Float32[Array, "..."]]) -> pa.Table:
        """Return the transitions of an episode; those of a robot follow one another."""
        observed, actions, rewards = played
        n_robots, n = rewards.shape
        last = np.zeros((n_robots, n), np.bool_)
        last[:, -1] = True
        columns = (
            _vectors(observed[:, :-1]), _vectors(actions), rewards.ravel(),
            _vectors(observed[:, 1:]), np.zeros(last.size, np.bool_), last.ravel(),
            np.repeat(robots.astype(np.int32), n), np.tile(np.arange(n, dtype=np.int32), n_robots),
            np.full(last.size, seed, np.uint64),
        )  # fmt: skip
        fields = [
            pa.field(name, column.type, metadata={"description": text})
            for (name, text), column in zip(COLUMNS.items(), map(pa.array, columns), strict=True)
        ]
        table = pa.table(columns, pa.schema(fields))
        config = self.configuration
        world = json.dumps({"physics": config.physics, **json.loads(config.overrides)})
        metadata = {CARD: self.card.model_dump_json(), WORLD: world}
        return table.replace_schema_metadata(
            {key: with_checksum(text) for key, text in metadata.items()}
        )


class Transitions(Dataset):
    """Folder of transitions: a file for each policy and seed."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder, TRANSITIONS)

    def file(self, recording: Recording, seed: int) -> Path:
        """Return the path of an episode's file, whether it exists or not."""
        config = recording.configuration
        folder = self.folder / folder_name(config.scenario.name, "scenario=")
        folder /= folder_name(config.label, "policy=")
        return folder / f"{recording.key}-seed{seed:08d}{TRANSITIONS}"

    def missing_seeds(self, recording: Recording, seeds: Sequence[int]) -> list[int]:
        """Return the seeds of episodes that are not stored whole; set damaged files aside."""

        def check(table: pa.Table) -> bool:
            written = tuple(table.column_names), table.num_rows, name_in(table, CARD)
            if written != (tuple(COLUMNS), recording.n_rows, recording.card.model_dump_json()):
                raise DamagedFileError("not the transitions of an episode")
            return True

        return [s for s in seeds if not self.read_checked(self.file(recording, s), check)]

    def record(self, recording: Recording, seeds: Sequence[int], threads: int) -> Iterator[int]:
        """Play and store episodes; yield the number of episodes after each block."""
        n_worlds = max(1, BLOCK_ROWS // recording.n_rows)
        for first in range(0, len(seeds), n_worlds):
            block = seeds[first : first + n_worlds]
            for seed, table in zip(block, recording.play(block, threads), strict=True):
                content = pa.BufferOutputStream()
                pq.write_table(table, content, **COMPRESSION)
                self.write(self.file(recording, seed), content.getvalue().to_pybytes())
            yield len(block)


def _vectors(rows: Float32[Array, "robots decisions numbers"]) -> pa.Array:
    return pa.FixedSizeListArray.from_arrays(pa.array(rows.ravel()), rows.shape[-1])

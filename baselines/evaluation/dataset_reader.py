"""Reader of datasets: the episodes of each configuration, with all settings of their runs."""

import json
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pyarrow as pa

from baselines.evaluation.dataset import (
    ASKED,
    IN_FOLDERS,
    LOGGER,
    TASK,
    Row,
    episode_of,
    name_in,
    read_table,
    reading,
    schema,
)
from baselines.evaluation.episode import AnyEpisode
from baselines.evaluation.experiment_config import (
    IDENTITY,
    ExperimentConfig,
    changed_parameters,
    changed_settings,
    find_layered_controller,
    short_label,
    shortened,
)
from baselines.evaluation.trajectories import ENDING
from swarm_forage_env.episode import EpisodeKind
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.parameters import leaves, validated
from swarm_forage_env.task import TASKS, Task, task_of_episode


@dataclass(frozen=True)
class EpisodeGroup:
    """The episodes of one configuration as read from a dataset, ordered by seed."""

    scenario: str
    controller: str  # its name without parameters
    asked: str  # the controller as the user named it, or its short label
    episodes: tuple[Any, ...]  # all of one task
    # The columns of `IDENTITY`, in their order:
    overrides: str
    parameters: str
    settings: str
    code: str
    key: str  # hash of the configuration, in the names of its files

    @property
    def physics(self) -> str:
        """Name of the engine."""
        physics: str = self.episodes[0].physics
        return physics

    @property
    def task(self) -> Task:
        """Task of the episodes."""
        return task_of_episode(self.episodes[0])

    @property
    def kind(self) -> EpisodeKind:
        """Kind of the episodes: their fields, metrics and score."""
        return self.task.episode

    @cached_property
    def numbers(self) -> Row:
        """Settings of scenario and controller by dotted name, as `task.n_robots` or `estimator`."""
        tree: dict[str, Row] = json.loads(self.settings)
        return leaves(tree["scenario"]) | tree["controller"]

    def label(self, without: str | None = None) -> str:
        """Return the name as given, or the short label without the parameter `without`."""
        if without is None:
            return self.asked
        return short_label(self.controller, self.parameters, without)

    def setup(self, without: str | None = None) -> str:
        """Return the scenario with its changed settings, except `without`, and the engine."""
        changes = map(shortened, changed_settings(self.overrides, without))
        return ", ".join((self.scenario, *changes, self.physics))

    @classmethod
    def of(cls, configuration: ExperimentConfig, episodes: Sequence[AnyEpisode]) -> "EpisodeGroup":
        """Return the group of newly evaluated episodes."""
        names = configuration.scenario.name, configuration.controller.name, configuration.label
        return cls(*names, tuple(episodes), *configuration.identity.values())

    def configuration(self) -> ExperimentConfig:
        """Return the same configuration on the present code.

        UnknownNameError or ConfigError if this code has no such controller or scenario, or if the
        configuration would run the code in a file, which only the user of a command can trust.
        """
        parameters = json.loads(self.parameters)
        for name, kind in {"policy": self.controller, "beside": parameters.get("beside")}.items():
            file, observed = (str(parameters.get(f"{name}.{of}")) for of in ("file", "observation"))
            is_function = kind in ("callable", "CallablePolicy")
            if is_function or ":" in observed or parameters.get(f"{name}.trust"):
                raise ConfigError(
                    f"dataset of '{self.label()}': has a policy"
                    f" {'of a module' if is_function else 'with trust=true'}, {file!r}, whose code"
                    " is not run for a plot; draw a figure that needs no policy, such as boxplot,"
                    " or trajectories stored by evaluate --trajectories"
                )
        controller = find_layered_controller(self.controller).with_parameters(parameters)
        return ExperimentConfig(self.label(), self.model(), controller, self.physics)

    def model(self) -> Any:  # noqa: ANN401 of its task
        """Return the scenario with its stored parameters; ConfigError if this code refuses them."""
        numbers = json.loads(self.settings)["scenario"]
        return validated(self.task.scenario, numbers, f"settings of {self.label()}")


def read_groups(
    sources: Sequence[str], scenarios: Sequence[str] = (), controllers: Sequence[str] = ()
) -> list[EpisodeGroup]:
    """Read the episode groups in the folders of datasets, filtered by name and sorted.

    `ssgiff` selects a controller with any parameters, `ssgiff:beta=0.01` with these. A group is
    labelled with its controller's name as given, or the short label if its files differ in it.
    ConfigError if a folder is no dataset, or of another or of several versions of the code.
    """
    parts: dict[str, list[EpisodeGroup]] = {}
    names = {each.partition(":")[0] for each in controllers}
    for file in (file for source in sources for file in _files(source)):
        scenario, controller = (_in_folder(file, field) for field in IN_FOLDERS)
        if (not scenarios or scenario in scenarios) and (not names or controller in names):
            part = _read(file, scenario, controller)
            parts.setdefault(part.key, []).append(part)
    name_of = {}
    for each in (each for each in controllers if ":" in each):
        layered = find_layered_controller(each)
        name_of[layered.name, changed_parameters(layered)] = each
    wanted = []
    for group in _named_apart([_joined(each) for each in parts.values()]):
        if name := name_of.get((group.controller, group.parameters)):
            wanted.append(replace(group, asked=name))
        elif not controllers or group.controller in controllers:
            wanted.append(group)
    if not wanted:
        raise ConfigError(_nothing(sources, scenarios, controllers))
    _check_code(wanted)
    return sorted(wanted, key=_order)


def _joined(parts: Sequence[EpisodeGroup]) -> EpisodeGroup:
    """Join the groups of one configuration; the name is empty if they have several."""
    by_seed = {each.seed: each for part in parts for each in part.episodes}
    names = {part.asked for part in parts}
    episodes = tuple(by_seed[seed] for seed in sorted(by_seed))
    return replace(parts[0], episodes=episodes, asked=names.pop() if len(names) == 1 else "")


TRANSITIONS = ".transitions.parquet"  # ending of the files that `swarm-forage dataset` writes


def _files(source: str) -> list[Path]:
    """Return the files of episodes in a folder, without other files; ConfigError if none."""
    if "://" in source:
        raise ConfigError(
            f"dataset {source}: must be a folder on this machine; copy its episodes into one,"
            " for example with `aws s3 sync`"
        )
    folder = Path(source)
    paths = [each for each in folder.rglob("*.parquet") if not each.name.startswith("_")]
    if files := sorted(each for each in paths if not each.name.endswith((ENDING, TRANSITIONS))):
        return files
    if paths:
        raise ConfigError(
            f"dataset {source}: holds trajectories or transitions, and no episodes; name a folder"
            " that swarm-forage evaluate or reproduce has written"
        )
    if folder.is_file():
        raise ConfigError(
            f"dataset {source}: is a file; name the folder that swarm-forage evaluate or reproduce"
            " has written"
        )
    reason = "holds no episodes" if folder.is_dir() else "no such folder"
    raise ConfigError(
        f"dataset {source}: {reason}; make one with swarm-forage evaluate es1 nc ssgikf --out"
        f" {source}"
    )


def _in_folder(file: Path, field: str) -> str:
    for part in file.parts:
        if part.startswith(f"{field}="):
            return unquote(part.partition("=")[2])
    raise ConfigError(
        f"dataset file {file}: is in no folder named {field}=...; name a folder that"
        " swarm-forage evaluate or reproduce has written"
    )


def _read(file: Path, scenario: str, controller: str) -> EpisodeGroup:
    with reading(f"dataset file {file}"):
        table = read_table(file.read_bytes())
        name, task = name_in(table, ASKED), name_in(table, TASK)
    for kind in (TASKS[each].episode for each in ([task] if task else TASKS)):
        complete = _with_all_columns(table, kind)
        rows = complete.to_pylist() if complete.schema.equals(schema(kind)) else []
        if len({each["configuration"] for each in rows}) == 1:
            asked = name or short_label(controller, rows[0]["parameters"])
            episodes = tuple(episode_of(each, kind, scenario, controller) for each in rows)
            identity = (rows[0][column] for column in IDENTITY)
            return EpisodeGroup(scenario, controller, asked, episodes, *identity)
    raise ConfigError(
        f"dataset file {file}: written by another version of swarm-forage, with other columns;"
        " evaluate again into another folder, or plot it with the version that wrote it"
    )


def _with_all_columns(table: pa.Table, kind: EpisodeKind) -> pa.Table:
    """Return the table with empty columns for the missing ones of `kind.sometimes`."""
    columns = schema(kind)
    if not set(columns.names) - set(table.schema.names) <= set(kind.sometimes):
        return table
    try:
        return pa.concat_tables([columns.empty_table(), table], promote_options="default")
    except pa.ArrowException:  # columns of other types
        return table


def _named_apart(groups: Sequence[EpisodeGroup]) -> Iterator[EpisodeGroup]:
    """Yield the groups, with short labels for missing names and for equal ones in one setup."""
    count = Counter((each.setup(), each.asked) for each in groups)
    for each in groups:
        is_unique = each.asked and count[each.setup(), each.asked] == 1
        short = short_label(each.controller, each.parameters)
        yield each if is_unique else replace(each, asked=short)


def _nothing(sources: Sequence[str], scenarios: Sequence[str], controllers: Sequence[str]) -> str:
    files = [file for source in sources for file in _files(source)]
    values_of = {field: {_in_folder(file, field) for file in files} for field in IN_FOLDERS}
    filters = [f"--scenario {each}" for each in scenarios]
    filters += [f"--controller {each}" for each in controllers]
    values = "; ".join(f"{field}s {', '.join(sorted(values_of[field]))}" for field in IN_FOLDERS)
    return f"{' '.join(filters)}: no such episodes in {', '.join(sources)}, which holds {values}"


def _check_code(groups: Sequence[EpisodeGroup]) -> None:
    code_of: dict[tuple[str, ...], str] = {}
    for group in groups:
        key = group.scenario, group.controller, group.physics, group.overrides, group.parameters
        if (code := code_of.setdefault(key, group.code)) != group.code:
            raise ConfigError(
                f"{group.scenario}, {group.label()}: the episodes are of several versions of"
                f" swarm-forage (code {min(code, group.code)}, {max(code, group.code)}); evaluate"
                " into another folder"
            )
    if len({group.code for group in groups}) > 1 and not _is_one_version(groups):
        words = "were run by another version of swarm-forage than others; to compare them,"
        LOGGER.warning("some of these episodes %s evaluate all again", words)


def _is_one_version(groups: Iterable[EpisodeGroup]) -> bool:
    """Whether groups of one code in this version had one before; that of a learned one differs."""
    codes: dict[str, set[str]] = {}
    for group in groups:
        with suppress(ConfigError, UnknownNameError):
            codes.setdefault(group.configuration().code, set()).add(group.code)
    is_present = {now in then for now, then in codes.items()}
    return len(is_present) < 2 and all(len(then) == 1 for then in codes.values())


def _order(group: EpisodeGroup) -> tuple[object, ...]:
    """Return the sort key: setup, then `nc` first as in the papers, then name and parameters."""
    parameters: Row = json.loads(group.settings)["controller"]
    numbers = [float(each) for each in parameters.values() if isinstance(each, int | float)]
    return group.setup(), group.controller != "nc", group.controller, numbers, group.label()

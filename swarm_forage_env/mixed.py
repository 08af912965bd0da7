"""Mixed swarms: robots of different controllers in one world.

Robots whose controllers share a language, such as those with the same estimator, form a team and
understand each other's messages. Of robots of other teams they receive only range and bearing.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from swarm_forage_env.arrays import Array, Int64, UInt8
from swarm_forage_env.compiler import entry_point, kernel
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import (
    CompiledLayers,
    Controller,
    PolicyOverLayers,
    RunningController,
    TeamController,
    has_talk,
    is_privileged,
)
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.raw_control import has_estimators
from swarm_forage_env.record import offset_of, record_dtype
from swarm_forage_env.task import task_of
from swarm_forage_env.templates import row_template
from swarm_forage_env.ticks import Arrays, joined, nothing

Team = list[int]
"""Indices of the robots that understand each other."""

Bytes = UInt8[Array, "worlds robots bytes"]


@dataclass(frozen=True)
class MixedController:
    """A separate controller for each robot of a world."""

    members: tuple[Controller, ...]
    """Controllers in the order of the robots."""

    @property
    def name(self) -> str:
        """Number of robots of each controller: `4 ssgiff, 6 learned-motion`."""
        counts = Counter(each.name for each in self.members)
        return ", ".join(f"{n} {name}" for name, n in counts.items())

    @property
    def talks(self) -> bool:
        """Whether any of its robots sends what a weighting can weigh."""
        return any(map(has_talk, self.members))

    def with_parameters(self, values: Mapping[str, Any]) -> "MixedController":
        """Return a copy with some parameters of every robot's controller changed."""
        return replace(self, members=tuple(each.with_parameters(values) for each in self.members))

    def check_supports(self, scenario: BaseScenario) -> None:
        """Raise ConfigError if a controller does not support the scenario or the other robots."""
        n_robots = scenario.task.n_robots
        if len(self.members) != n_robots:
            raise ConfigError(
                f"{len(self.members)} controllers given for the {n_robots} robots of"
                f" '{scenario.name}': must be one for each"
            )
        for each in {id(each): each for each in self.members}.values():
            if is_privileged(each) or not isinstance(each, TeamController):
                raise ConfigError(
                    f"controller '{each.name}': controls whole swarms only, and cannot be mixed"
                    " with other controllers"
                )
            each.check_supports(scenario)
        if (
            task_of(scenario).is_joint
            and len(_teams(cast(Sequence[TeamController], self.members), scenario)) > 1
        ):
            raise ConfigError(
                f"controllers '{self.name}': the robots of '{scenario.name}' correct each"
                " other's estimates, so that all need the same estimator; mix weightings and"
                " motions only"
            )


def members_of(controller: Controller, n_robots: int) -> Sequence[Controller]:
    """Return the controller of every robot of a world."""
    if isinstance(controller, MixedController):
        return controller.members
    return [controller] * n_robots


def build(
    world: Any,  # noqa: ANN401 of any task
    seeds: Sequence[int],
    controllers: Sequence[Controller],
) -> RunningController:
    """Start the controllers of a block; ConfigError if they do not fit its worlds or each other."""
    pairs = zip(controllers, world.scenarios, strict=True)
    different = {(id(own), id(scenario)): (own, scenario) for own, scenario in pairs}.values()
    for own, scenario in different:
        own.check_supports(scenario)
    members_of_controller = {id(own): members_of(own, world.n_robots) for own in controllers}
    members = {id(each): each for row in members_of_controller.values() for each in row}
    under = {
        key: each.under(world.scenario)
        if isinstance(each, PolicyOverLayers)
        else cast(TeamController, each)
        for key, each in members.items()
    }
    rows = {key: [under[id(each)] for each in row] for key, row in members_of_controller.items()}
    teams = _teams(rows[id(controllers[0])], world.scenario)
    for own, scenario in different:
        others = _teams(rows[id(own)], scenario)
        if others != teams:
            raise ConfigError(
                "controllers of one block: the same robots must understand each other in all"
                f" worlds, not {teams} in one and {others} in another"
            )
    running: list[RunningController] = []
    for team in teams:
        robots_of_team = set(team)
        only = {
            key: [each if robot in robots_of_team else None for robot, each in enumerate(row)]
            for key, row in rows.items()
        }
        leader = rows[id(controllers[0])][team[0]]
        running.append(leader.build_team(world, seeds, [only[id(own)] for own in controllers]))
    together = running[0]
    if len(running) > 1:
        together = RunningTeams(running, teams, world.robots.shape)
    for policy, robots in _policies([*members_of_controller.values()]):
        together = policy.over(world, together, robots)
    return together


def _policies(rows: Sequence[Sequence[Controller]]) -> list[tuple[PolicyOverLayers, Team]]:
    """Return each policy on top of other controllers, with its robots; ConfigError if they are not
    the same in all worlds."""
    teams: dict[int, tuple[PolicyOverLayers, Team]] = {}
    for robot, each in enumerate(rows[0]):
        policies = [
            own.policies if isinstance(own, PolicyOverLayers) else None
            for own in (row[robot] for row in rows)
        ]
        if any(policy != policies[0] for policy in policies):
            raise ConfigError(
                "controllers of one block: a robot must have the same policies in all worlds; run a"
                " block for each policy, or let ArrayEnv take the actions of all worlds"
            )
        if isinstance(each, PolicyOverLayers):
            teams.setdefault(id(each), (each, []))[1].append(robot)
    return list(teams.values())


def _teams(members: Sequence[TeamController], scenario: BaseScenario) -> list[Team]:
    """Return the teams of robots that understand each other, ordered by their first robots."""
    languages: list[object] = []
    known: dict[int, int] = {}
    teams: list[Team] = []
    for robot, controller in enumerate(members):
        if id(controller) not in known:
            language = controller.language(scenario)
            if language not in languages:
                languages.append(language)
                teams.append([])
            known[id(controller)] = languages.index(language)
        teams[known[id(controller)]].append(robot)
    return teams


class RunningTeams:
    """Teams that share a block of worlds without understanding each other.

    Each team has its own `minds` for all robots; records of robots of other teams are never
    written, so that they hold no beliefs and send nothing.
    """

    def __init__(
        self, running: Sequence[RunningController], teams: Sequence[Team], shape: tuple[int, ...]
    ) -> None:
        """Join teams; `minds` holds the fields that all estimators share, and policy messages."""
        self._running = running
        self.has_rules = any(each.has_rules for each in running)
        layered, policies = [], []
        for each, team in zip(running, teams, strict=True):
            if has_estimators(each.minds):
                layered.append((each.minds, np.array(team)))
            else:
                policies.append(each)
        common = _common([minds.dtype["estimator"] for minds, _ in layered])
        message_columns = [column for each in policies for column in _common([each.minds.dtype])]
        columns = [("estimator", record_dtype(common)), *message_columns]
        self.minds: Array = np.zeros(shape, record_dtype(columns))
        for each in policies:
            each.minds = self.minds
        self._bytes = _bytes(self.minds)
        self._copies = [
            (_bytes(minds), team, _spans(common, self.minds.dtype, minds.dtype))
            for minds, team in layered
        ]

    @property
    def compiled(self) -> CompiledLayers:
        """Layers of all teams, one by one; then shared fields are copied to `minds`."""
        copying = [
            CompiledLayers(
                {"decide_world": nothing, "observe_world": copy_world}, (self._bytes, *spans)
            )
            for spans in self._copies
        ]
        return joined([*(each.compiled for each in self._running), *copying])

    def check_on_gpu(self) -> None:
        """Raise ConfigError: teams run on a CPU only."""
        raise ConfigError(
            "device='cuda': swarms of several teams run on a CPU only; use one controller of"
            " three layers, such as ssgikf, or a policy of learn='everything'"
        )

    def call_rules(self) -> None:
        """Call the rules written in NumPy, and write their actions."""
        for each in self._running:
            each.call_rules()

    def reset(self, first: int, last: int, seeds: Sequence[int]) -> None:
        """Reset the worlds first .. last - 1."""
        for each in self._running:
            each.reset(first, last, seeds)
        minds, _, spans = self._copies[0]
        for world in range(first, last):
            copy_of_robots(self._bytes, minds, np.arange(minds.shape[1]), spans, world)

    def parameters_in(self, world: int, scenario: BaseScenario) -> list[Any]:
        """Return the parameters of each team in one world under another scenario."""
        return [each.parameters_in(world, scenario) for each in self._running]

    def write_parameters(self, world: int, numbers: Sequence[Any]) -> None:
        """Use these parameters in one world from now on."""
        for each, parameters in zip(self._running, numbers, strict=True):
            each.write_parameters(world, parameters)

    def snapshot(self) -> tuple[Array, list[Any]]:
        """Return copies of `minds` and of the state of each team."""
        return self.minds.copy(), [each.snapshot() for each in self._running]

    def restore(self, snapshot: tuple[Array, list[Any]]) -> None:
        """Restore a snapshot; arrays keep their place in memory."""
        minds, teams = snapshot
        for each, state in zip(self._running, teams, strict=True):
            each.restore(state)
        self.minds[...] = minds


@row_template
def copy_world(world_arrays: Arrays, layer_arrays: Arrays, w: int, n_robots: int) -> None:
    """Copy the shared fields of the robots of a team in a world."""
    if n_robots > 0:
        to, source, robots, spans = layer_arrays
        copy_spans(to, source, robots, spans, w)


@kernel
def copy_spans(to: Bytes, source: Bytes, robots: Array, spans: Array, w: int) -> None:
    """Copy parts of the records of some robots of a world.

    A span is the offset of a part in `to`, its offset in `source`, and its length [bytes].
    """
    for i in robots:
        for k in range(spans.shape[0]):
            at, begin = spans[k, 0], spans[k, 1]
            for byte in range(spans[k, 2]):
                to[w, i, at + byte] = source[w, i, begin + byte]


copy_of_robots = entry_point(copy_spans)


def _bytes(records: Array) -> Bytes:
    return records.view(np.uint8).reshape(*records.shape, records.dtype.itemsize)


def _spans(
    columns: Sequence[tuple[str, np.dtype[Any]]], to: np.dtype[Any], source: np.dtype[Any]
) -> Int64[Array, "parts 3"]:
    """Return the spans of estimator fields in two records that both have them."""
    begins = [
        [
            offset_of(minds, "estimator") + offset_of(minds["estimator"], name)
            for minds in (to, source)
        ]
        for name, _ in columns
    ]
    sizes = [kind.itemsize for _, kind in columns]
    return np.column_stack([begins, sizes]).astype(np.int64)


def _common(dtypes: Sequence[np.dtype[Any]]) -> list[tuple[str, np.dtype[Any]]]:
    first, *others = dtypes
    return [
        (name, first[name])
        for name in first.names or ()
        if all(name in (each.names or ()) and each[name] == first[name] for each in others)
    ]

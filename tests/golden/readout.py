"""What is read from a running swarm: plain bytes that do not depend on how the core keeps it.

The one module here that knows the project's objects. A readout is a name -> bytes: the arrays
of its docstring one after another, C-contiguous and little-endian, every zero without a sign.
Rows are robots, N consecutive ones to a world; `u1` is 0 or 1.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

import baselines.controllers
import baselines.oracles.controllers  # noqa: F401
import training.controllers  # noqa: F401 all three enter their controllers
from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import bind
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.envs.gymnasium_env import LearnerEnv
from swarm_forage_env.loop import Loop
from swarm_forage_env.record import rows
from swarm_forage_env.registry import CONTROLLERS, REFERENCES
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.task import task_of
from tests.commands import commands_of, parallel_env
from training.policy_controller import PolicyController

Readout = dict[str, bytes]

WORDS = 12
"""Numbers in a message, as `words_of` writes them."""

ENVIRONMENTS = {
    "parallel": parallel_env,
    "learner": lambda scenario, **options: LearnerEnv(
        scenario=scenario, **commands_of(scenario), **options
    ),
}


def controllers_of(scenario: str) -> list[str]:
    """The names of all controllers and references of compiled layers that run on a scenario."""
    world = find_scenario(scenario)
    found = {name: find_controller(name, references=True) for name in (*CONTROLLERS, *REFERENCES)}
    return [
        name
        for name, each in found.items()
        if each.supports(world) and not isinstance(each, PolicyController)
    ]


def start(
    scenario: str,
    controller: str,
    seeds: Sequence[int],
    physics: str | None = None,
    overrides: Mapping[str, Any] | None = None,
) -> Loop:
    """A block of worlds under a controller, sensed and about to move."""
    world, found = find_scenario(scenario, overrides), find_controller(controller, references=True)
    loop = ForagingLoop if task_of(world).name == "foraging" else Loop
    return loop(world, found, seeds, physics)


def readout(loop: Loop) -> Readout:
    """The readout of either world, after a tick or the reset."""
    if isinstance(loop, ForagingLoop):
        return foraging_readout(loop)
    return waypoints_readout(loop)


class ForagingLoop(Loop):
    """Robots that forage, with what each of them would say and reported before the last tick."""

    def __init__(self, *given: Any) -> None:
        """Nobody has said anything."""
        super().__init__(*given)
        rows_of_words = (self.world.robots.size, WORDS)
        self.words = np.zeros(rows_of_words, np.float32)
        self.known = np.zeros((self.world.robots.size, 2), np.int8)
        compose = self.controller.estimator.kernels["compose"]
        self._compose_all = bind(compose_all, {"compose": compose})

    def _begin(self, seed_of: Mapping[int, int]) -> None:
        """Sense and observe by the stages that ticks use, so that no other kernel is compiled."""
        self.controller.reset(0, len(seed_of), [*seed_of.values()])
        self.world.sense_first()
        self.run_stages("observe")

    def _advance(self, n_ticks: int, modes: Any, first: int, last: int) -> None:
        """A tick, stage by stage, in which messages are composed that nobody will hear."""
        running = self.controller
        self.run_stages("decide", first=first, last=last)
        self._compose_all(running.minds["estimator"], running._settings[0])
        self.words = words_of(rows(running.minds["estimator"]["message"]))
        self.known = rows(self.world.robots).report.known.copy()
        self.world.tick(first, last)
        self.run_stages("observe", first=first, last=last)


def compose_all(minds: Array, settings: Array) -> None:
    """Write the messages of all robots. Free name: compose."""
    for w in range(minds.shape[0]):
        for i in range(minds.shape[1]):
            compose(minds[w, i], settings[w, min(i, settings.shape[1] - 1)].estimator)


def words_of(messages: Any) -> Any:
    """Messages as words f4 (rows, 12), zeros where nothing is told.

    Of each area: has_estimate, distance, direction, p; then of each: short axis, long direction.
    """
    words = np.zeros((len(messages), WORDS), np.float32)
    sent = messages.has_estimate != 0
    plain = (sent, messages.distance, messages.direction, messages.p)
    words[:, :8] = np.stack([np.where(sent, each, 0.0) for each in plain], axis=2).reshape(-1, 8)
    if "short_axis" in messages.dtype.names:
        ellipse = (messages.short_axis, messages.long_direction)
        more = np.stack([np.where(sent, each, 0.0) for each in ellipse], axis=2)
        words[:, 8:] = more.reshape(-1, 4)
    return words


def foraging_readout(loop: ForagingLoop) -> Readout:
    """Truth, beliefs, messages, rewards and scores of robots that forage.

    - pose: x, y, heading f8 (rows, 3)
    - beliefs, as the motion layer is shown them: areas f4 (rows, 2, 2), p f4 (rows, 2),
      known u1 (rows, 2), goal i1 (rows), talking u1 (rows), target f4 (rows, 2)
    - messages heard in the tick, zeros in empty slots: valid u1 (rows, slots),
      sender i4 (rows, slots), beam f4 (rows, slots, 3), frames i4 (rows, slots),
      words f4 (rows, slots, 12)
    - rewards: round trips of the tick f4 (rows), reports of being lost so far i4 (rows),
      areas reported as known u1 (rows, 2)
    - scores so far: round trips i4 (rows), messages i4 (rows), tick of the first visit, -1
      before it, i8 (rows, 2), ticks on the path i8 (rows)
    """
    world, state, s = loop.world, loop.world.state, loop.situation
    heard, n_slots = state.heard, world.scenario.radio.slots
    full, beam = heard.is_valid[:, :n_slots] > 0, heard.range_bearing[:, :n_slots]
    sender, frames = heard.sender[:, :n_slots], heard.n_averaged[:, :n_slots].astype(np.int32)
    goal = np.array([0, 1, -1], np.int8)[s.goal.argmax(axis=1)]
    first = np.arange(world.rows)[:, None] // world.n_robots * world.n_robots
    words = loop.words[first + sender * full]
    return {
        "pose": packed("f8", state.pose),
        "beliefs": packed("f4", s.areas, s.p)
        + packed("u1", s.known > 0)
        + packed("i1", goal)
        + packed("u1", s.is_talking > 0)
        + packed("f4", s.target),
        "messages": packed("u1", full)
        + packed("i4", sender * full)
        + packed("f4", beam)
        + packed("i4", frames * full)
        + packed("f4", words * full[:, :, None]),
        "rewards": packed("f4", state.reward)
        + packed("i4", state.lost_events)
        + packed("u1", loop.known.astype(np.bool_)),
        "scores": packed("i4", state.round_trips, state.messages)
        + packed("i8", state.first_visit, state.path_ticks),
    }


def waypoints_readout(loop: Loop) -> Readout:
    """Truth, beliefs, sightings, rewards and scores of robots that visit waypoints.

    - pose: x, y, heading f8 (rows, 3)
    - beliefs: estimated pose f8 (rows, 3); as the motion layer is shown them: goal, home,
      centre, crowd, flow, velocity f4 (rows, 2) each; density, doubt, drift f4 (rows) each;
      arrived u1 (rows)
    - messages, here sightings: seen u1 (rows, N), range f4 (rows, N), bearing f4 (rows, N)
    - rewards: goals rightly claimed in the tick f4 (rows)
    - scores: goals right, then wrong so far i4 (rows), the next goal f8 (rows, 2)
    """
    state, sights, s = loop.world.state, rows(loop.world.sightings), loop.situation
    shape = (loop.world.rows, loop.world.n_robots)
    return {
        "pose": packed("f8", state.pose),
        "beliefs": packed("f8", rows(loop.controller.minds["estimator"]["belief"]).pose)
        + packed("f4", s.goal, s.home, s.centre, s.separation, s.alignment, s.velocity)
        + packed("f4", s.density, s.covariance_norm, s.dead_reckoning_offset)
        + packed("u1", s.has_arrived > 0),
        "messages": packed("u1", sights.seen.reshape(shape) > 0)
        + packed("f4", sights.range.reshape(shape), sights.bearing.reshape(shape)),
        "rewards": packed("f4", state.reward),
        "scores": packed("i4", state.right, state.wrong) + packed("f8", state.goal),
    }


def results(loop: Loop) -> dict[str, list[int]]:
    """What the episode came to, a number for each world; the worlds cannot go on afterwards."""
    state, worlds = loop.world.state, loop.world.n_worlds
    if not isinstance(loop, ForagingLoop):
        loop.world.judge(loop.situation.has_arrived > 0)  # the claims of the last tick
        counts = {"right": state.right, "wrong": state.wrong}
    else:
        counts = {
            "round_trips": state.round_trips,
            "lost_events": state.lost_events,
            "messages": state.messages,
            "first_visit": state.first_visit.sum(axis=1),
            "path_ticks": state.path_ticks,
        }
    return {name: count.reshape(worlds, -1).sum(axis=1).tolist() for name, count in counts.items()}


class Environment:
    """An environment in which a policy draws its actions at random."""

    def __init__(self, kind: str, scenario: str, options: Mapping[str, Any], seed: int) -> None:
        """One of ENVIRONMENTS; the seed is that of the first episode and of the actions."""
        self._env: Any = ENVIRONMENTS[kind](scenario=scenario, **options)
        self._is_single = kind == "learner"
        self._seed: int | None = seed
        self._rng = np.random.default_rng(seed)
        self.is_over = True

    def reset(self) -> Readout:
        """Start an episode: the first from the seed, those that follow without one."""
        observations, infos = self._env.reset(seed=self._seed)
        self._seed, self.is_over = None, False
        nothing = self._as_dict(0.0) if self._is_single else dict.fromkeys(observations, 0.0)
        return self._readout(self._as_dict(observations), nothing, self._as_dict(infos))

    def step(self) -> Readout:
        """One decision, uniform in the action space: f4, one draw for all who learn."""
        agents = ["learner"] if self._is_single else self._env.agents
        box = self._env.action_space if self._is_single else self._env.action_space(agents[0])
        drawn = self._rng.uniform(box.low, box.high, (len(agents), *box.shape)).astype(np.float32)
        actions = drawn[0] if self._is_single else dict(zip(agents, drawn, strict=True))
        observations, rewards, _, over, infos = map(self._as_dict, self._env.step(actions))
        self.is_over = all(over.values())
        return self._readout(observations, rewards, infos)

    def _as_dict(self, given: Any) -> dict[str, Any]:
        return {"learner": given} if self._is_single else given

    def _readout(
        self, observations: dict[str, Any], rewards: dict[str, Any], infos: dict[str, Any]
    ) -> Readout:
        """What an environment tells its learners, in their order.

        - observations: f4 (learners, numbers)
        - rewards: f8 (learners), then 1 if the episode is over u1
        - infos: f8 (learners, names), names in order of the alphabet
        - state: f4 (numbers); not of a single learner
        """
        names = sorted(set(next(iter(infos.values()))) - {"unshaped_reward"})  # since version 1
        logged = [[info[name] for name in names] for info in infos.values()]
        read = {
            "observations": packed("f4", np.stack(list(observations.values()))),
            "rewards": packed("f8", list(rewards.values())) + packed("u1", self.is_over),
            "infos": packed("f8", logged),
        }
        return read if self._is_single else {**read, "state": packed("f4", self._env.state())}


def packed(dtype: str, *arrays: Any) -> bytes:
    """Arrays of one kind one after another: float f, signed i or unsigned u of so many bytes."""
    return b"".join(_bytes(array, np.dtype(f"<{dtype}")) for array in arrays)


def _bytes(array: Iterable[Any], dtype: np.dtype[Any]) -> bytes:
    plain = np.asarray(array)
    if plain.dtype.kind != "b" and not np.can_cast(plain.dtype, dtype):
        raise TypeError(f"{plain.dtype} does not fit into {dtype}: the readout would lose digits")
    return (np.ascontiguousarray(plain, dtype) + dtype.type(0)).tobytes()

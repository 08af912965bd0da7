"""What is read from a running swarm: plain bytes that do not depend on how the core keeps it.

The one module here that knows the project's objects. A readout is a name -> bytes: the arrays
of its docstring one after another, C-contiguous and little-endian, every zero without a sign.
Rows are robots, N consecutive ones to a world; `u1` is 0 or 1.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

import baselines.recipes
import baselines.references.recipes  # noqa: F401
import training.controllers  # noqa: F401 all three enter their controllers
from swarm_forage_env import parallel_env
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.envs.single import LearnerEnv
from swarm_forage_env.loop import Loop, default_physics, start_loop
from swarm_forage_env.metrics import total
from swarm_forage_env.record import rows
from swarm_forage_env.registry import CONTROLLERS, REFERENCES
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.waypoints.scenario import WaypointsScenario
from swarm_forage_env.waypoints.views import estimated_pose_of

Readout = dict[str, bytes]

ENVIRONMENTS = {"parallel": parallel_env, "learner": LearnerEnv}


def controllers_of(scenario: str) -> list[str]:
    """The names of all controllers and references that run on a scenario."""
    world = find_scenario(scenario)
    names = [*CONTROLLERS, *REFERENCES]
    return [name for name in names if find_controller(name, references=True).runs_on(world)]


def start(
    scenario: str,
    controller: str,
    seeds: Sequence[int],
    physics: str | None = None,
    overrides: Mapping[str, Any] | None = None,
) -> Loop[Any]:
    """A block of worlds under a controller, sensed and about to move."""
    world, recipe = find_scenario(scenario, overrides), find_controller(controller, references=True)
    return start_loop(world, recipe, seeds, physics or default_physics(world))


def advance(loop: Loop[Any]) -> None:
    """One tick."""
    loop.step()


def readout(loop: Loop[Any]) -> Readout:
    """The readout of either world, after a tick or the reset."""
    if isinstance(loop.world.scenario, WaypointsScenario):
        return waypoints_readout(loop)
    return foraging_readout(loop)


def foraging_readout(loop: Loop[Any]) -> Readout:
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
    state, feedback = loop.world.state, loop.world.feedback
    heard, s = feedback.heard, loop.controller.estimator.situation
    full = heard.valid
    return {
        "pose": packed("f8", state.pose),
        "beliefs": packed("f4", s.areas, s.p)
        + packed("u1", s.known)
        + packed("i1", s.goal)
        + packed("u1", s.talking)
        + packed("f4", s.target),
        "messages": packed("u1", full)
        + packed("i4", heard.sender * full)
        + packed("f4", heard.beam * full[:, :, None])
        + packed("i4", heard.frames * full)
        + packed("f4", heard.words * full[:, :, None]),
        "rewards": packed("f4", feedback.reward)
        + packed("i4", state.lost_events)
        + packed("u1", state.known),
        "scores": packed("i4", state.round_trips, state.messages)
        + packed("i8", state.first_visit, state.path_ticks),
    }


def waypoints_readout(loop: Loop[Any]) -> Readout:
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
        "beliefs": packed("f8", estimated_pose_of(loop.controller.minds))
        + packed("f4", s.goal, s.home, s.centre, s.crowd, s.flow, s.velocity)
        + packed("f4", s.density, s.doubt, s.drift)
        + packed("u1", s.arrived),
        "messages": packed("u1", sights.seen.reshape(shape))
        + packed("f4", sights.range.reshape(shape), sights.bearing.reshape(shape)),
        "rewards": packed("f4", state.reward),
        "scores": packed("i4", state.right, state.wrong) + packed("f8", state.goal),
    }


def results(loop: Loop[Any]) -> dict[str, list[int]]:
    """What the episode came to, a number for each world; the worlds cannot go on afterwards."""
    state, worlds = loop.world.state, loop.world.n_worlds
    if isinstance(loop.world.scenario, WaypointsScenario):
        loop.world.judge(loop.situation.arrived)  # the claims of the last tick
        counts = {"right": state.right, "wrong": state.wrong}
    else:
        counts = {
            "round_trips": state.round_trips,
            "lost_events": state.lost_events,
            "messages": state.messages,
            "first_visit": state.first_visit.sum(axis=1),
            "path_ticks": state.path_ticks,
        }
    return {name: total(count, worlds).tolist() for name, count in counts.items()}


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
        logged = [[info[name] for name in sorted(info)] for info in infos.values()]
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

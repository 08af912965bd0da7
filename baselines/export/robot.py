"""Controller of one robot, on its own records, with the compiled functions of the simulation.

In every tick it updates its beliefs from readings and received messages, decides, and composes its
message. Its records have rows for the other robots, too, which hold their messages. Its outputs
equal those that `record_vectors` records in a simulated world, bit for bit.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np
from numba.core import types

from baselines.controller import LayeredController
from baselines.evaluation.experiment_config import ExperimentConfig, changed_settings, short_label
from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import bind
from swarm_forage_env.envs.pilot import pilot_and_layers
from swarm_forage_env.epuck.fault_record import LIAR, STALE
from swarm_forage_env.equations.random_draws import first_word
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.control import act, observe_world, update_and_describe
from swarm_forage_env.foraging.records import PolicyMessages
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import Kernel, is_privileged
from swarm_forage_env.loop import Loop
from swarm_forage_env.record import Field, Record, RecordType
from swarm_forage_env.targets import llvm_text_of
from swarm_forage_env.ticks import Arrays, nothing

compose: Kernel
set_stream: Kernel
pilot: Kernel
act_as_learner: Kernel
hear_words: Kernel
apply_action: Kernel
"""Free names of the templates, besides those of `update_and_describe` and `act`."""

VIEWS = {"swarm": "robots", "voices": "minds", "robot_words": "robots", "mind_words": "minds"}
"""Further names of records that are passed to a policy: name -> records."""

TICK = 0  # `operation` for a tick; k > 0 seeds the random stream of cause k - 1


def run_robot(records: Arrays, piloting: Arrays, i: int, operation: int, seed: int) -> int:
    """Run a tick of robot i, or seed its stream; returns 1 if its action is not finite, else 0.

    Free names: compose, set_stream, pilot; those of `update_and_describe` and `act`.
    """
    robots, minds, memories, shared, settings = records
    if operation != TICK:
        set_stream(memories[i], first_word(np.uint64(seed), i, operation - 1))
        return 0
    parameters = settings[0]
    update_and_describe(robots, minds, i, shared[i], parameters.estimator)
    pilot(i, piloting)
    is_usable = act(robots[i], minds[i], memories[i], shared[i], parameters)
    compose(minds[i], parameters.estimator)
    return 0 if is_usable else 1


def run_policy(records: Arrays, piloting: Arrays, i: int, operation: int, seed: int) -> int:
    """Run a tick of `learn=everything`. Free names: hear_words, pilot, apply_action."""
    if operation != TICK:
        return 0
    robots, minds, _, _, _ = records
    hear_words((piloting[0],), piloting[1], 0, i)
    pilot(i, piloting)
    apply_action(robots[i], minds[i])
    wheels = robots[i].command.wheels
    return 0 if math.isfinite(wheels[0] + wheels[1]) else 1


def pilot_robot(i: int, piloting: Arrays) -> None:
    """Run the policy for robot i, and count its ticks. Free name: act_as_learner."""
    robots, _, ticks, learners, rest = piloting
    learners[0] = i
    act_as_learner(robots, ticks[0], rest)
    ticks[0] += 1


@dataclass(frozen=True)
class RobotRecords:
    """Records of the controller of one robot, with a row for each robot that it may hear."""

    robots: Array
    minds: Array
    memories: Array
    shared: Array  # empty: exported estimators have no records of pairs
    settings: Array


class ExportedRobot:
    """Controller of one robot in a scenario: its records, its code and its test vectors."""

    def __init__(self, controller: LayeredController, scenario: Scenario) -> None:
        """Build the layers; ConfigError if the controller or the scenario cannot be exported."""
        if not isinstance(scenario, Scenario):
            raise ConfigError(
                f"scenario {scenario.name!r}: must be one in which robots forage, such as es1"
            )
        self.scenario, self._controller = scenario, controller
        self._pilot, layers = pilot_and_layers(controller, scenario)
        self.views = {} if self._pilot is None else VIEWS
        loop = Loop(scenario, layers, [0], "kinematic", is_blank=True)
        compiled = loop.controller.compiled
        self.message = "words"  # field of the records `minds` that holds the message
        self.payload: Mapping[str, Field] = {"words": PolicyMessages.fields["words"]}
        """Fields of a message."""
        self._run: Kernel = run_policy
        reasons = {"it knows the ground truth": is_privileged(controller)}
        if compiled.has_beliefs:
            own = controller.estimator.layer(scenario)
            reasons["its estimator stores data of each pair of robots"] = own.shared is not None
            is_own = own.observe is not observe_world
            reasons["its estimator receives messages by a template of its own"] = is_own
            kind = cast(type[Record], own.mind.fields["message"].kind)
            self.message, self.payload, self._run = "message", kind.fields, run_robot
        is_called = loop.controller.has_rules or not compiled.firsts
        reasons["one of its layers is Python code"] = is_called
        for reason, holds in reasons.items():
            if holds:
                raise ConfigError(
                    f"controller '{controller.name}' cannot be exported, because {reason}; use"
                    " another one, such as ssgikf"
                )
        self._functions, self.noise = compiled.functions, compiled.noise
        first_mind, first_memory = compiled.firsts
        n = loop.world.n_robots
        self.records = RobotRecords(
            np.zeros(n, loop.world.robots.dtype),
            np.repeat(first_mind, n),
            np.repeat(first_memory, n),
            np.zeros((n, 0)),
            np.ascontiguousarray(compiled.arrays[3][0]),
        )

    @cached_property
    def names(self) -> tuple[str, str]:
        """Names of controller and scenario, each with its changed parameters."""
        configuration = ExperimentConfig("", self.scenario, self._controller)
        settings = changed_settings(configuration.overrides)
        label = short_label(self._controller.name, configuration.parameters)
        return label, ", ".join((self.scenario.name, *settings))

    @property
    def n_robots(self) -> int:
        """Number of robots; indices of senders are smaller."""
        return len(self.records.minds)

    @property
    def message_dtype(self) -> RecordType:
        """Record type of a message, with the names of `payload`."""
        minds = self.records.minds.dtype
        if self.message == "words":
            return np.dtype([("words", minds["words"])])
        return minds[self.message]

    @cached_property
    def policy(self) -> dict[str, Array]:
        """Arrays that a learned policy reads and writes; empty without one."""
        if self._pilot is None:
            return {}
        kinds = self.records.robots.dtype, self.records.minds.dtype
        return {
            "ticks": np.zeros(1, np.int64),
            **self._pilot.arrays(1, *kinds, np.zeros(1, np.int64)),
            "no_additions": np.zeros((0, 2), np.int64),
            "time_left": np.zeros(1),
        }

    def llvm_text(self) -> str:
        """Return the controller as LLVM assembly.

        Its arguments are the records, arrays and views of a policy, then i, operation and seed.
        """
        records, n = vars(self.records), self.n_robots
        views = {
            name: each.view(np.float32)[None] if name.endswith("words") else each[None]
            for name, each in ((name, records[of]) for name, of in self.views.items())
        }
        piloting, own_pilot = "i", cast(Kernel, nothing)
        if self._pilot is not None:
            own = self._pilot.argument_expression.replace("n_robots", str(n))
            piloting = f"swarm, voices, ticks, pilot_robots, ({own},)"
            own_pilot = bind(pilot_robot, {"act_as_learner": self._pilot.kernel})
        task = f"i, operation * {1 + self.noise}, seed"
        call = f"called(({', '.join(records)}), ({piloting},), {task})"
        run = bind(self._run, {**self._functions, "pilot": own_pilot})
        arrays = {**records, **self.policy, **views}
        return llvm_text_of(run, arrays, ("i", "operation", "seed"), call, types.int64)

    @property
    def vector(self) -> np.dtype[np.void]:
        """Record type of a tick in `vectors.bin`: inputs and outputs of the controller."""
        robots, minds = self.records.robots.dtype, self.records.minds.dtype
        slots = robots["heard"]["sender"].shape[0]
        received = np.dtype([
            ("range_bearing", np.float32, 3), ("n_averaged", np.float32), ("sender", np.int32),
            ("payload", minds[self.message]),
        ], align=True)  # fmt: skip
        return np.dtype([
            ("readings", robots["readings"]), ("n", np.int32), ("received", received, slots),
            ("wheels", np.float32, 2), ("is_speaking", np.int32), ("has_payload", np.int32),
            ("payload", minds[self.message]),
        ], align=True)  # fmt: skip

    def record_vectors(self, seed: int, i: int, n_ticks: int) -> Array:
        """Return the inputs and outputs of robot i in a simulated world, tick by tick.

        Its message is recorded in ticks in which a robot listens and no fault changes the message;
        it holds zeros for an area that the robot does not report.
        """
        loop, vectors = self.loop(seed), np.zeros(n_ticks, self.vector)
        robot, (minds, *_) = loop.world.robots[0, i], loop.controller.compiled.arrays
        for vector in vectors:
            vector["readings"], n = robot["readings"], int(robot["heard"]["n"])
            vector["n"] = n
            for slot in range(n):
                received, sender = vector["received"][slot], robot["heard"]["sender"][slot]
                received["range_bearing"] = robot["heard"]["range_bearing"][slot]
                received["n_averaged"] = robot["heard"]["n_averaged"][slot]
                received["sender"], received["payload"] = sender, minds[self.message][0, sender]
            loop.step()
            vector["wheels"] = robot["command"]["wheels"]
            vector["is_speaking"] = robot["command"]["is_speaking"]
            has_payload = "is_composed" not in minds.dtype.names or minds["is_composed"][0, i]
            has_payload = has_payload and not robot["is_faulty"][[LIAR, STALE]].any()
            vector["has_payload"] = has_payload
            vector["payload"] = minds[self.message][0, i] if has_payload else 0
            if "has_estimate" in self.payload:
                for name in self.payload:
                    vector["payload"][name][vector["payload"]["has_estimate"] == 0] = 0
        return vectors

    def busiest(self, seeds: Sequence[int], n_ticks: int) -> tuple[int, int]:
        """Return seed and index of the robot that receives most messages in the first ticks."""
        loop = Loop(self.scenario, self._controller, seeds, "kinematic")
        loop.run(n_ticks)
        messages = loop.world.robots["messages"]
        world, robot = np.unravel_index(int(messages.argmax()), messages.shape)
        return seeds[int(world)], int(robot)

    def loop(self, seed: int) -> Loop:
        """Return the loop of a simulated world with this seed, at its start."""
        return Loop(self.scenario, self._controller, [seed], "kinematic")

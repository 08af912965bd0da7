"""A policy compiled beside the world: without Python it observes and acts as a learner does."""

from dataclasses import dataclass
from typing import Protocol

from swarm_forage_env.arrays import Array, Float32, Int64
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.interface import Kernel, TeamController
from swarm_forage_env.observed_fields import write_fields
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.ticks import BEGINS, RUNS, Arrays

forward: Kernel
observe: Kernel
write_raw: Kernel
command: Kernel
"""Free names of the template: the policy; what writes observations and reads actions."""


@dataclass(frozen=True)
class Pilot:
    """A policy of every robot, as a kernel with numbers."""

    form: PolicyForm
    """What it observes and gives."""
    forward: Kernel
    """Writes the action of a robot: of what it observes, the numbers, the sizes, the robot's state,
    which it advances, and room for what lies between."""
    numbers: Float32[Array, " numbers"]
    sizes: Int64[Array, " sizes"]
    n_state: int
    n_between: int
    """Numbers of that room."""


class Piloted(Protocol):
    """A controller whose learned layer is a policy that may be compiled."""

    def under(self, scenario: BaseScenario) -> TeamController:
        """The controller of the other layers."""

    def pilot(self, scenario: BaseScenario) -> Pilot:
        """The policy; ConfigError for one that Python must call."""


def act_as_learner(world_arrays: Arrays, piloting: Arrays) -> None:
    """Let the policy act for all robots of one world where a decision is due.

    One robot may be left alone, which a visitor drives. Free names: forward, observe, write_raw,
    command.
    """
    robots, world = world_arrays[0], world_arrays[1][0]
    fields, out_fields, learners, scaling, beside, rows, form, network, marks, modes = piloting
    numbers, sizes, states, between, actions, low, high = network
    period, motion, has_reflexes, is_walking, weighting, left_alone = marks
    if world.ticks % period != 0:
        return
    modes[0] = BEGINS if world.ticks == 0 else RUNS
    observe(fields, learners, scaling, beside, modes, rows, (0, 1))
    raw, seen = beside[2], rows[2]
    for i in range(robots.shape[1]):
        if world.ticks == 0:
            states[i, :] = 0.0
        forward(seen[0, i], numbers, sizes, states[i], between, actions[0, i])
        for k in range(low.shape[0]):
            actions[0, i, k] = min(max(actions[0, i, k], low[k]), high[k])
        write_raw(actions, 0, i, form, raw[0, i])
        if i != left_alone[0]:
            action = robots[0, i].action
            action.motion, action.weighting = motion, weighting
            action.has_reflexes, action.is_walking = has_reflexes, is_walking
            write_fields(raw[0, i], out_fields, 0, i)

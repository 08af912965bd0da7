"""Gathering: a robot wanders, stops on black floor, and leaves less often near more robots.

Francesca et al. 2014, AutoMoDe: a novel approach to the automatic design of control software for
robot swarms (Swarm Intelligence 8), for the states, exploration and stop, and for transitions by
the colour of the floor and the number of neighbours. Garnier et al. 2008, Artificial Life 14, on
micro-robots that gather as cockroaches do, for leaving less often with more neighbours.

Not in the papers, and chosen here: the probabilities, the law by which they fall, and that the
neighbours are the robots heard in the last tick. Exploration is that of subsumption.
"""

from typing import ClassVar

import numpy as np
from pydantic import Field

from baselines.motion.base import MOTIONS
from baselines.motion.subsumption import (
    KEEP_RIGHT,
    Course,
    SubsumptionParameters,
    Wheels,
    avoid,
    head_for,
    wander,
)
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.control import NoSituation
from swarm_forage_env.epuck.records import Heard, Readings
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.equations.random_draws import unit
from swarm_forage_env.interface import MotionLayer
from swarm_forage_env.parameters import Share
from swarm_forage_env.record import Numbers, field

BLACK_BELOW = 0.25  # darker floor counts as black


class GatheringCourse(Course):
    """Memory of the motion: the course, and whether the robot has stopped."""

    has_stopped: bool = field(np.bool_)


@kernel
def steer(
    situation: NoSituation,
    readings: Readings,
    heard: Heard,
    wheels: Wheels,
    course: GatheringCourse,
    numbers: Numbers,
) -> None:
    """Stop or explore, depending on floor and neighbours. Source: Francesca2014, Garnier2008.

    A robot that has stopped on black floor leaves in a tick with probability leave / (1 + n)^2,
    where n robots are heard. Exploring is wandering and avoiding obstacles, as in subsumption.
    """
    near = 1.0 + heard.n
    if readings.ground[1] > BLACK_BELOW:
        course.has_stopped = False
    elif course.has_stopped:
        course.has_stopped = unit(course.stream, 0) >= numbers.leave / (near * near)
    else:
        course.has_stopped = unit(course.stream, 0) < numbers.stop
    wheels[0] = wheels[1] = 0.0
    if course.has_stopped:
        return
    creep = 0.0
    if avoid(course, readings, numbers, KEEP_RIGHT):
        creep = numbers.creep
    else:
        wander(course, numbers)
    head_for(course.turn, creep, wheels, course, numbers)


@MOTIONS.register("gather")
class Gather(SubsumptionParameters):
    """Robots stop on black floor, and leave it less often the more robots are near.

    Source: Francesca2014 (AutoMoDe), Section 3, for the states; Garnier2008 for leaving.
    """

    tasks: ClassVar[tuple[str, ...]] = ("epuck",)
    stop: Share = Field(0.1, description="Probability of a stop on black floor in a tick (chosen)")
    leave: Share = Field(
        0.002, description="Probability of leaving black floor in a tick, when alone (chosen)"
    )

    def layer(self, scenario: EpuckScenario) -> MotionLayer:
        """Return the compiled motion with its parameters in a scenario."""
        return MotionLayer(steer, self.numbers(scenario), GatheringCourse)

"""Social odometry: each robot keeps its own estimate of both areas, and imitates better ones.

Gutierrez et al. 2009 (TR), Sections 4 and 5; Gutierrez et al. 2008 (ANTS), Section 4.2.

Not in the paper, and chosen here:
- an exchange lasts the radio's exchange time and averages what the partner says in it, each
  message weighted by its frames; one partner at a time, drawn by the radio's random slots;
- after an exchange everybody is ignored for `pause`, and the same partner for `refractory`:
  a filter that shrinks p at each of many exchanges makes a crowd sure of a wrong place;
- a robot does not stop for a message that tells it nothing it could use;
- on its way a single filter sends only the estimate of the area it comes from (TR 6.1.2 says
  why the other one harms);
- the point stored on entering an area is its centre, if the robot was heading there;
- how near to the believed centre is "there", and how far it then looks on, before it is lost;
- a robot that just got lost ignores messages for `deaf_when_lost`;
- optionally, a message costs precision (`message_path`), who is on its way and too unsure of an
  area does not tell of it (`tells_within`), which ends rumours, and who is sure of an area does
  not stop for what is told of it (`listens_above`); in the papers none of these;
- a robot that was told of an area without having visited any heads for the nearer one.
"""

import math
from typing import Any, cast

import numpy as np
from pydantic import Field

from baselines.estimators.base import ESTIMATORS
from baselines.estimators.beliefs import forget, no_beliefs
from baselines.estimators.conversing import converse, merge, speak
from baselines.estimators.describing import describe_encounter, describe_situation
from baselines.estimators.reckoning import choose_goal, dead_reckon, find_areas, notice_loss
from baselines.weighting.sgikf import SGIKF
from swarm_forage_env.arrays import Array, Bool, Float32
from swarm_forage_env.interface import WORDS, Encounter, Heard, Readings, Situation
from swarm_forage_env.scenario import NotNegative, Part, Positive, Scenario, record


@ESTIMATORS.register("social_odometry")
class SocialOdometryParameters(Part):
    """What the papers leave open about exchanging and losing estimates."""

    speaks: bool = Field(True, description="Broadcast at all; false for no communication")
    double: bool = Field(
        False,
        description="Exchange both areas; false: tell where it comes from, correct where it goes."
        " TR 6.1 (published)",
    )
    message_path: NotNegative = Field(
        0.0,
        description="What is heard counts as if its sender had gone this much farther, for a"
        " message costs precision too [m]. 0: TR 4.2 (published)",
    )
    tells_within: NotNegative = Field(
        0.0,
        description="Knowing both areas, it tells of one only while its own p is at most this [m];"
        " 0: always, as in TR 5.2 (published)",
    )
    listens_above: NotNegative = Field(
        0.0,
        description="It stops for what is told of an area that it knows only while its own p of it"
        " is at least this [m]; 0: always, as in TR 5.2 (published)",
    )
    refractory: NotNegative = Field(
        20.0, description="A partner is not talked to again for this long [s] (derived)"
    )
    pause: NotNegative = Field(
        15.0, description="After an exchange nobody is listened to for this long [s] (derived)"
    )
    deaf_when_lost: NotNegative = Field(
        5.0, description="A robot that got lost ignores messages for this long [s] (derived)"
    )
    lost_within: Positive = Field(
        0.05, description="This near to the believed centre is there [m] (derived)"
    )
    overshoot: NotNegative = Field(
        0.18, le=1.0, description="Being there, it looks straight on for this path [m] (derived)"
    )

    def start(self, scenario: Scenario, n_worlds: int) -> "SocialOdometry":
        """The running estimator of a block of worlds."""
        return SocialOdometry(self, scenario, n_worlds)


class SocialOdometry:
    """The estimates of all robots of a block of worlds."""

    own_rule: Any = SGIKF()
    """The weighting that goes with it, where none is chosen."""

    def __init__(
        self, parameters: SocialOdometryParameters, scenario: Scenario, n_worlds: int
    ) -> None:
        """Robots that know nothing yet."""
        n_robots = scenario.task.n_robots
        rows = n_worlds * n_robots
        self.parameters = parameters
        self.beliefs = no_beliefs(rows)
        self._n_robots = n_robots
        self._axle = scenario.robot.axle
        self._to_centre = scenario.sensors.ground_ahead + scenario.task.area_radius
        self._record = _record(parameters, scenario)
        self.encounter = _no_encounter(rows)
        self.situation: Situation = cast(Situation, None)

    def observe(self, readings: Readings, heard: Heard, wheels: Float32[Array, "rows 2"]) -> None:
        """Take in one tick: move, find, get lost, choose where to go, talk."""
        b = self.beliefs
        readings = self._reckon(readings)
        notice_loss(
            readings.odometry, self._record,
            b.pose, b.location, b.known, b.came_from, b.goal, b.look_on, b.deaf, b.partner, b.lost,
        )  # fmt: skip
        choose_goal(b.pose, b.location, b.known, b.came_from, b.goal, b.look_on)
        self._describe(readings, heard, wheels, self._talk(heard))

    def merge(self, g: Float32[Array, "rows areas"], heard_p_share: float) -> None:
        """Blend what the conversations that just ended brought, with weight g."""
        b = self.beliefs
        merge(
            self.encounter.valid, g, heard_p_share, self.parameters.double, b.goal,
            b.heard_sum, b.heard_weight, b.heard_p, b.location, b.p, b.known,
        )  # fmt: skip

    def say(
        self,
    ) -> tuple[Float32[Array, "rows words"], Bool[Array, " rows"], Bool[Array, " rows"]]:
        """The words to broadcast, who broadcasts, and who just got lost."""
        b = self.beliefs
        words = np.zeros((len(b.pose), WORDS), np.float32)
        speaking = np.zeros(len(b.pose), np.bool_)
        if self.parameters.speaks:
            double = self.parameters.double
            within = self.parameters.tells_within or math.inf
            speak(double, within, b.pose, b.location, b.p, b.known, b.goal, words, speaking)
        return words, speaking, b.lost.copy()

    def reset(self, world: int, seed: int) -> None:
        """Forget everything about one world."""
        forget(self.beliefs, world, self._n_robots)

    def _reckon(self, readings: Readings) -> Readings:
        """Move, and find areas; what the rest of the tick goes by."""
        b = self.beliefs
        dead_reckon(readings.odometry, self._axle, b.pose, b.p)
        find_areas(
            readings.ground, self._to_centre,
            b.pose, b.location, b.p, b.known, b.on_area, b.came_from, b.look_on,
        )  # fmt: skip
        return readings

    def _talk(self, heard: Heard) -> Bool[Array, " rows"]:
        """Listen to the partners; which conversations ended."""
        b = self.beliefs
        ended = np.empty(len(b.pose), np.bool_)
        converse(
            heard.valid, heard.sender, heard.words, heard.beam, heard.frames, self._record,
            b.pose, b.known, b.p, b.goal, b.deaf, b.partner, b.talk_left,
            b.heard_sum, b.heard_weight, b.heard_p, b.range_sum, b.frames, b.met, b.met_for, ended,
        )  # fmt: skip
        return ended

    def _describe(
        self,
        readings: Readings,
        heard: Heard,
        wheels: Float32[Array, "rows 2"],
        ended: Bool[Array, " rows"],
    ) -> None:
        b, e = self.beliefs, self.encounter
        describe_encounter(
            ended, b.pose, b.location, b.p, b.known,
            b.heard_sum, b.heard_weight, b.heard_p, b.range_sum, b.frames,
            e.own_p, e.heard_p, e.own_known, e.heard_known, e.disagreement,
            e.own_distance, e.heard_distance, e.range, e.frames,
        )  # fmt: skip
        e.valid[:] = ended
        e.goal[:] = np.where(ended, b.goal, -1)
        rows = len(b.pose)
        s = Situation(
            proximity=readings.proximity,
            ground=readings.ground,
            target=np.empty((rows, 2), np.float32),
            areas=np.empty((rows, 2, 2), np.float32),
            p=np.empty((rows, 2), np.float32),
            known=b.known.copy(),
            goal=b.goal.copy(),
            talking=np.empty(rows, np.bool_),
            heard=heard.valid,
            beam=heard.beam,
            wheels=wheels,
        )
        describe_situation(
            b.pose, b.location, b.p, b.known, b.goal, b.look_on, b.partner,
            s.target, s.areas, s.p, s.talking,
        )  # fmt: skip
        self.situation = s


def _record(parameters: SocialOdometryParameters, scenario: Scenario) -> Array:
    """The parameters as kernels read them, times in ticks."""
    return record(
        double=parameters.double,
        message_path=parameters.message_path,
        listens_above=parameters.listens_above,
        lost_within=parameters.lost_within,
        overshoot=parameters.overshoot,
        talk_ticks=max(1, round(scenario.radio.exchange_time / scenario.tick)),
        refractory_ticks=round(parameters.refractory / scenario.tick),
        pause_ticks=round(parameters.pause / scenario.tick),
        deaf_ticks=round(parameters.deaf_when_lost / scenario.tick),
    )


def _no_encounter(rows: int) -> Encounter:
    return Encounter(
        valid=np.zeros(rows, np.bool_),
        own_p=np.zeros((rows, 2), np.float32),
        heard_p=np.zeros((rows, 2), np.float32),
        own_known=np.zeros((rows, 2), np.bool_),
        heard_known=np.zeros((rows, 2), np.bool_),
        disagreement=np.zeros((rows, 2), np.float32),
        own_distance=np.zeros((rows, 2), np.float32),
        heard_distance=np.zeros((rows, 2), np.float32),
        range=np.zeros(rows, np.float32),
        frames=np.zeros(rows, np.float32),
        goal=np.full(rows, -1, np.int8),
    )

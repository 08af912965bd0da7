"""How large the numbers of a scenario can get: the finite bounds of every space."""

import math
from dataclasses import dataclass

from swarm_forage_env.foraging.scenario import Scenario

SLACK = 1.01
"""Room for the rounding to float32 at each hand-over of an estimate, over a whole episode."""

BOARD_RANGE = 0.01 * math.exp(9.06422)
"""Largest gap that the model of the real board can measure, at no power received [m]."""


@dataclass(frozen=True, slots=True)
class Bounds:
    """The largest value of each quantity within `n_ticks` ticks of a scenario.

    Every bound follows from the scenario alone:

        step       = (max_speed + wheel_noise cruise_speed) tick
        beam       = max_range + range_noise              (uniform ranges)
                   = 2 radius + exp(9.06422) / 100        (the board's, at no power)
        turn       = 2 step / axle
        path       = (n_ticks + 1) step + n_ticks message_path
        believed   = diagonal + ground_ahead + area_radius + n_ticks (step + beam)

    An encoder tells at most `step` in a tick. A path grows by the longer of the two wheels'
    paths, |drho| + |dtheta| b / 2 = max(|dU_l|, |dU_r|) <= step, and what is heard and blended
    in was told by a robot under the same bound, plus `message_path` a tick at most. A believed
    area starts at most ground_ahead + area_radius away; in each tick dead reckoning moves it by
    at most `step`, and one radio hop adds at most one measured beam: the worst case, in which
    an estimate is handed on in every tick, always outwards. The diagonal of the arena is room
    for looking on straight past the place. Estimates in use stay far below both. Where robots
    are faulty a worn encoder tells more, and a lie adds its p and, in every tick, its shift.

    They hold for weights g in [0, 1], for a `heard_p_share` of at most 1, and for estimators
    that reckon p and locations as social odometry does. A p that is a standard deviation, as
    that of `sikf`, stays below `path` while the heading's is below sqrt(3) rad.
    """

    scenario: Scenario
    n_ticks: int
    message_path: float = 0.0
    """What a message adds to the p that it tells [m]."""

    @property
    def step(self) -> float:
        """Path of a wheel in a tick, as its encoder tells it [m]."""
        robot, noise = self.scenario.robot, self.scenario.sensors.wheel_noise
        most, worn = robot.max_speed, self.scenario.faults.worn
        if worn.is_any:
            most, noise = most * (1.0 + worn.bias), noise * max(worn.noise_factor, 1.0)
        return SLACK * (most + noise * robot.cruise_speed) * self.scenario.tick

    @property
    def turn(self) -> float:
        """Turn in a tick, as the encoders tell it [rad]."""
        return 2.0 * self.step / self.scenario.robot.axle

    @property
    def path(self) -> float:
        """Path since leaving an area, p [m]."""
        liar = self.scenario.faults.liar
        told = liar.p if liar.is_any else 0.0
        return SLACK * ((self.n_ticks + 1) * self.step + self.n_ticks * self.message_path + told)

    @property
    def beam(self) -> float:
        """Measured length of a beam [m]."""
        radio = self.scenario.radio
        if radio.is_board:
            return SLACK * (2.0 * self.scenario.robot.radius + BOARD_RANGE)
        return SLACK * (radio.max_range + radio.range_noise)

    @property
    def believed(self) -> float:
        """Distance to where an area is believed to be, and each coordinate of it [m]."""
        scenario = self.scenario
        diagonal = math.hypot(scenario.arena.length, scenario.arena.width)
        found = scenario.sensors.ground_ahead + scenario.task.area_radius
        liar = self.scenario.faults.liar
        shift = liar.shift if liar.is_any else 0.0
        return SLACK * (diagonal + found + self.n_ticks * (self.step + self.beam + shift))

    @property
    def frames(self) -> float:
        """Readings averaged in one exchange, which ends one tick after its time."""
        ticks = max(1, round(self.scenario.radio.exchange_time / self.scenario.tick))
        return float(self.scenario.radio.frames * (ticks + 1))

    @property
    def brightness(self) -> float:
        """Reading of a ground sensor over white floor."""
        return SLACK * (1.0 + self.scenario.sensors.ground_noise)

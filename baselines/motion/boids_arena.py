"""Boids among e-pucks: the rules steer a robot that knows its goal, over avoidance and walk.

Smith et al. 2021 (BOIDS), Section 3, over Gutierrez et al. 2009 (TR), Section 5.1.

Not in the papers, and chosen here:
- talking, avoiding and the random walk of `subsumption` stay as they are; the rules take the
  place of the straight way to the goal;
- neighbours are the senders heard in this tick, in the direction and distance of their beams;
  which way they go follows from the bearings at both ends;
- home is the nest, as far as it is known; the length of the world is the arena's longer side;
- the stimulus of the covariance is p of the goal, as a share of `trust`; nothing tells an e-puck
  how far it is from dead reckoning, so that e = 0.
"""

import math
from collections.abc import Sequence

import numpy as np

from baselines.motion.flock import flock
from baselines.motion.subsumption import SubsumptionParameters
from swarm_forage_env.arrays import NEST, Array, Bool, Float32, Float64, Int8
from swarm_forage_env.interface import Situation
from swarm_forage_env.kernels.compiler import kernel
from swarm_forage_env.scenario import Scenario, record

FLOW, CROWD, CENTRE, HOME, GOAL = range(5)
"""Ways, in the order of the gains."""


@kernel
def neighbours_of_beams(  # noqa: PLR0913 inputs first, then the outputs
    heard: Bool[Array, "rows slots"],
    beam: Float32[Array, "rows slots beam"],
    target: Float32[Array, "rows 2"],
    nest: Float32[Array, "rows 2"],
    p: Float32[Array, "rows areas"],
    goal: Int8[Array, " rows"],
    numbers: Array,
    out_ways: Float32[Array, "rows 5 2"],
    out_stimuli: Float32[Array, "rows 3"],
) -> None:  # fmt: skip
    """Ways (flow, crowd, centre, home, goal) and stimuli (rho, s, e) of robots that forage.

    Source: BOIDS, Eq. 21 to 23 and Section 4, of what an e-puck hears.
    """
    for i in range(heard.shape[0]):
        n, cx, cy, fx, fy = 0, 0.0, 0.0, 0.0, 0.0
        for slot in range(heard.shape[1]):
            if heard[i, slot]:
                n += 1
                ahead = float(beam[i, slot, 1])
                cx += beam[i, slot, 0] * math.cos(ahead)
                cy += beam[i, slot, 0] * math.sin(ahead)
                course = ahead + math.pi - float(beam[i, slot, 2])
                fx += math.cos(course)
                fy += math.sin(course)
        share = max(n, 1)
        out_ways[i, FLOW, 0], out_ways[i, FLOW, 1] = fx / share, fy / share
        out_ways[i, CROWD, 0], out_ways[i, CROWD, 1] = -cx, -cy
        out_ways[i, CENTRE, 0], out_ways[i, CENTRE, 1] = cx / share, cy / share
        out_ways[i, HOME] = nest[i]
        out_ways[i, GOAL] = target[i]
        out_stimuli[i, 0] = n / numbers[0]["n_robots"]
        out_stimuli[i, 1] = p[i, goal[i]] / numbers[0]["trust"] if goal[i] >= 0 else 0.0
        out_stimuli[i, 2] = 0.0


class ArenaBoids:
    """The motion of all robots of a block of worlds in which they forage."""

    def __init__(
        self,
        fixed: tuple[float, ...],
        adaptive: bool,
        trust: float,
        scenario: Scenario,
        seeds: Sequence[int],
    ) -> None:
        """Robots about to start a random walk."""
        self._below = SubsumptionParameters().start(scenario, seeds)
        self._fixed: Float64[Array, 5] = np.array(fixed)
        self._gains: Float64[Array, 5] = np.zeros(5)
        self._cruise = scenario.robot.cruise_speed
        self._numbers = record(
            adaptive=adaptive,
            side=max(scenario.arena.length, scenario.arena.width),
            max_speed=self._cruise,
            n_robots=scenario.task.n_robots,
            trust=trust,
        )

    def __call__(self, situation: Situation) -> Float32[Array, "rows 2"]:
        """Left and right wheel of every robot, in [-1, 1] of the cruise speed."""
        s, rows = situation, len(situation.goal)
        ways = np.empty((rows, 5, 2), np.float32)
        stimuli = np.empty((rows, 3), np.float32)
        nest = np.ascontiguousarray(s.areas[:, NEST])
        neighbours_of_beams(
            s.heard, s.beam, s.target, nest, s.p, s.goal, self._numbers, ways, stimuli
        )
        velocity = np.zeros((rows, 2), np.float32)
        velocity[:, 0] = self._cruise * s.wheels.mean(axis=1)
        pull = np.empty((rows, 2), np.float32)
        nobody = np.zeros(rows, np.bool_)
        flock(ways, velocity, stimuli, nobody, self._fixed, self._numbers, self._gains, pull)
        return self._below.towards(situation, pull)

    def reset(self, world: int, seed: int) -> None:
        """Forget one world's courses, and walk at random from this seed from now on."""
        self._below.reset(world, seed)

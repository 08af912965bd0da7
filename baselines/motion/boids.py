"""Boids: alignment, separation, cohesion, home and goal, with fixed or adaptive gains.

Smith et al. 2021 (BOIDS), Sections 3 and 4.

Not in the paper, and as the authors' code has it: every rule seeks its direction from the
present velocity (`seek`); the sum is a pull at full strength; a robot that has just claimed its
goal goes by the other rules until it has a new one; gains are not clamped, so that they turn
negative where a stimulus exceeds its allowed value.
"""

from importlib import import_module
from typing import ClassVar, Literal

from pydantic import Field

from baselines.motion.base import MOTIONS
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import MotionLayer
from swarm_forage_env.parameters import NotNegative, Part, Positive
from swarm_forage_env.task import task_of
from swarm_forage_env.waypoints.scenario import WaypointsScenario


@MOTIONS.register("boids")
class BoidsParameters(Part):
    """Boids: a robot adds up the rules of its neighbours and its goal, each with a gain.

    Its parameters say how the gains come about, and give the fixed ones.
    """

    tasks: ClassVar[tuple[str, ...]] = ("foraging", "waypoints")

    gains: Literal["goal", "static", "adaptive"] = Field(
        "adaptive", description="Goal alone, the fixed gains below, or those of Eq. 33-37"
    )
    alignment: NotNegative = Field(
        1.0, description="K_a of static gains. BOIDS, authors' code (code)"
    )
    separation: NotNegative = Field(
        1.0, description="K_s of static gains. BOIDS, authors' code (code)"
    )
    cohesion: NotNegative = Field(
        1.0, description="K_c of static gains. BOIDS, authors' code (code)"
    )
    homing: NotNegative = Field(1.0, description="K_h of static gains. BOIDS, authors' code (code)")
    seeking: NotNegative = Field(
        1.0, description="K_g of static gains. BOIDS, authors' code (code)"
    )
    trust: Positive = Field(
        10.0,
        description="Where robots forage, p of the goal at which nothing is trusted any more: a"
        " path [m], or of the covariance filters a standard deviation [m] (chosen)",
    )

    @property
    def fixed(self) -> tuple[float, float, float, float, float]:
        """The gains of the rules where they do not adapt."""
        if self.gains == "goal":
            return 0.0, 0.0, 0.0, 0.0, 1.0
        return self.alignment, self.separation, self.cohesion, self.homing, self.seeking

    def layer(self, scenario: Scenario | WaypointsScenario) -> MotionLayer:
        """The functions of the motion, with its numbers in a scenario.

        Those of each task are in a module of its own, `boids_foraging` or `boids_waypoints`.
        """
        of_task = import_module(f"baselines.motion.boids_{task_of(scenario).name}")
        layer: MotionLayer = of_task.layer(self, scenario)
        return layer

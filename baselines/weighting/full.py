"""The full correction: what the filter says is done."""

from typing import ClassVar

import numpy as np

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.scenario import Part
from swarm_forage_env.waypoints_interface import Correction
from swarm_forage_env.waypoints_scenario import WaypointsScenario


@WEIGHTING_RULES.register("full")
class Full(Part):
    """Every correction is carried out as the filter computes it.

        g_i = 1

    Source: BOIDS, Section 2.
    """

    worlds: ClassVar[tuple[type[Part], ...]] = (WaypointsScenario,)
    heard_p_share: ClassVar[float] = 0.0

    def __call__(self, encounter: Correction) -> Float32[Array, "rows 1"]:
        """g for each row."""
        return np.ones((len(encounter.valid), 1), np.float32)

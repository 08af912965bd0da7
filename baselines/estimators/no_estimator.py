"""No estimator: the motion uses the sensors of an e-puck directly."""

from typing import ClassVar

from baselines.estimators.base import ESTIMATORS
from baselines.weighting.base import no_gain
from swarm_forage_env.epuck.control import NoMind
from swarm_forage_env.interface import EstimatorLayer, WeightingLayer
from swarm_forage_env.parameters import Parameters
from swarm_forage_env.ticks import nothing


@ESTIMATORS.register("no_estimator")
class NoEstimator(Parameters):
    """Robots keep nothing and tell each other nothing but where they are, as a radio shows it.

    Source: none needed.
    """

    tasks: ClassVar[tuple[str, ...]] = ("epuck",)
    speaks: ClassVar[bool] = False

    def layer(self, scenario: object) -> EstimatorLayer:
        """Records without content, and nothing to take in."""
        return EstimatorLayer(NoMind, {}, {}, nothing, own_weighting=WeightingLayer(no_gain))

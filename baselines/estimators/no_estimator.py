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
    """No belief and empty messages: the radio shows only range and bearing of the senders.

    Source: none needed.
    """

    tasks: ClassVar[tuple[str, ...]] = ("epuck",)
    speaks: ClassVar[bool] = False

    def layer(self, scenario: object) -> EstimatorLayer:
        """Return a layer with empty records that updates nothing."""
        return EstimatorLayer(NoMind, {}, {}, nothing, own_weighting=WeightingLayer(no_gain))

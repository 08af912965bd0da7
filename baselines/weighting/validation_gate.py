"""Validation gate: reject received estimates farther from the own one than errors explain.

BarShalomFortmann1988, Tracking and Data Association: a measurement is associated with a track only
if it falls into a region around the prediction, as wide as the errors of both explain.
VanCalck2023, A blockchain-based information market to incentivise cooperation in swarms of
self-interested robots (Scientific Reports 13): foraging robots are sceptical in a similar way. They
accept a place that differs from their own by more than a share of its distance only if another
robot confirms it.

Not in the papers, and chosen here:
- the gate is as wide as `slack`, for the radio and for the size of an area, and `drift` of the
  paths that both robots have travelled since the area, for their odometry;
- inside the gate the gain is that of the Social Generalised Induced Kalman Filter;
- a robot copies the estimate of an area that it does not know, as in all rules: it has no estimate
  to compare it with;
- an estimate outside the gate is discarded, however many robots report it.
"""

from pydantic import Field

from baselines.weighting.base import WEIGHTING_RULES
from baselines.weighting.sgikf import gain as sgikf_gain
from swarm_forage_env.compiler import kernel
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import WeightingLayer
from swarm_forage_env.parameters import NotNegative, Parameters
from swarm_forage_env.record import Numbers


@kernel
def gain(exchange: Exchange, area: int, numbers: Numbers) -> float:
    """Return the gain of SGIKF inside the gate, 0 outside. Source: BarShalomFortmann1988."""
    paths = float(exchange.own_p[area]) + float(exchange.heard_p[area])
    if exchange.disagreement[area] > numbers.slack + numbers.drift * paths:
        return 0.0
    return sgikf_gain(exchange, area, numbers)


@WEIGHTING_RULES.register("validation_gate")
class ValidationGate(Parameters):
    """The gain of SGIKF for estimates inside a gate around the own one, else 0.

        g_i = p_i / (p_i + p_j)  if  d <= slack + drift (p_i + p_j),  else 0
        d = |X_j - x_i|

    p_i and p_j are the own and the heard path since the area, x_i and X_j the own and the heard
    place [m].

    Source: BarShalomFortmann1988, the validation gate; VanCalck2023, scepticism; TR, Eq. 33.
    """

    slack: NotNegative = Field(
        0.2, description="Width of the gate for robots that just left the area [m] (chosen)"
    )
    drift: NotNegative = Field(
        0.05, description="Growth of the gate's width for each metre travelled since (chosen)"
    )

    def layer(self, scenario: Scenario) -> WeightingLayer:
        """Return the compiled rule with the width of the gate."""
        return WeightingLayer(gain, {"slack": self.slack, "drift": self.drift})

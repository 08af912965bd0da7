"""Sceptical odometry: social odometry that copies an area only with a second witness.

Gutierrez et al. 2009 (TR), Sections 4 and 5, for social odometry. VanCalck2023, A blockchain-based
information market to incentivise cooperation in swarms of self-interested robots (Scientific
Reports 13), for the second witness: sceptical robots keep a location pending until another robot
sends it too.

Not in the papers, and chosen here:
- only an area that the robot does not know needs a witness: for a known one the weighting rule
  decides, such as `validation_gate`;
- a robot keeps one pending place of each area, the last one received, in its own frame; another
  robot confirms it with a place within `agreement` of it, and the robot copies that second place;
- all choices of `social_odometry`.
"""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from pydantic import Field

from baselines.estimators.base import ESTIMATORS
from baselines.estimators.belief import NOBODY, Belief, SocialMind
from baselines.estimators.message_exchange import heard_place, is_merged, merge_area
from baselines.estimators.social_odometry import KERNELS, SocialOdometryParameters
from swarm_forage_env.arrays import Array, Float64, Int32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.interface import Kernel
from swarm_forage_env.parameters import NotNegative
from swarm_forage_env.record import Numbers, field


class ScepticalBelief(Belief):
    """Belief with the locations that wait for a second witness."""

    pending: Float64[Array, "areas 2"] = field(np.float64, 2, 2, unit="m")
    """Last heard location of each unknown area, own frame."""
    pending_sender: Int32[Array, " areas"] = field(np.int32, 2, start=NOBODY)
    """Robot that sent it; NOBODY if nothing is pending."""


class ScepticalMind(SocialMind):
    """State of a robot under sceptical odometry."""

    belief: ScepticalBelief = field(ScepticalBelief)


@kernel
def is_confirmed(belief: ScepticalBelief, area: int, agreement: float) -> bool:
    """Return whether a second robot confirms the heard location of an area; make it pending.

    Source: VanCalck2023.
    """
    x, y = heard_place(belief, area)
    apart = hypot(x - belief.pending[area, 0], y - belief.pending[area, 1])
    witness = belief.pending_sender[area]
    belief.pending[area, 0], belief.pending[area, 1] = x, y
    belief.pending_sender[area] = belief.last_partner
    return bool(witness != NOBODY and witness != belief.last_partner and apart <= agreement)


@kernel
def merge(mind: ScepticalMind, shared: Array, heard_p_share: float, numbers: Numbers) -> None:
    """Blend heard estimates of known areas; copy those of unknown areas if two robots agree."""
    belief = mind.belief
    for area in range(2):
        if not is_merged(belief, area, numbers):
            continue
        if belief.known[area] or is_confirmed(belief, area, numbers.agreement):
            merge_area(belief, area, float(mind.exchange.weight[area]), heard_p_share)
            belief.pending_sender[area] = NOBODY


@ESTIMATORS.register("sceptical_odometry")
class ScepticalOdometryParameters(SocialOdometryParameters):
    """Social odometry that copies an unknown area only if a second witness confirms it."""

    mind = ScepticalMind
    kernels: ClassVar[Mapping[str, Kernel]] = {**KERNELS, "merge": merge}

    agreement: NotNegative = Field(
        0.3,
        description="Largest distance between two reported places of an area that confirm each"
        " other [m] (chosen)",
    )

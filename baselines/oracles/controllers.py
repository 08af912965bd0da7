"""The named oracles, one line each, in the registry REFERENCES."""

from dataclasses import dataclass
from typing import ClassVar

from baselines.controller import LayeredController
from baselines.controllers import FREQUENT, SINGLE, SINGLE_FIELDS, SUBSUMPTION
from baselines.oracles.global_average import GlobalAverage
from baselines.oracles.no_error import PerfectOdometry
from baselines.oracles.oracle import OracleWeighting
from baselines.weighting.sgiff import SGIFF
from baselines.weighting.sgikf import SGIKF
from swarm_forage_env.registry import REFERENCES


@dataclass(frozen=True)
class Oracle(LayeredController):
    """Controller with a layer that reads the ground truth: for comparison only."""

    is_privileged: ClassVar[bool] = True  # no environment runs it


NAMED = (
    Oracle("no-error", PerfectOdometry(**SINGLE_FIELDS), SGIFF(beta=1e-3), SUBSUMPTION),
    Oracle("global", GlobalAverage(**SINGLE_FIELDS | {"speaks": False}), SGIKF(), SUBSUMPTION),
    Oracle("oracle-weighting", SINGLE, OracleWeighting(), SUBSUMPTION),
    Oracle("oracle-weighting-frequent", FREQUENT, OracleWeighting(), SUBSUMPTION),
)
"""Perfect odometry and global communication (ANTS, Section 5); then the best weighting, with the
exchange of the papers and with that of `dsgiff-frequent`, which learned weightings use too."""

ABOUT = (
    "ssgiff whose robots know their poses",
    "all robots share one mean of their estimates",
    "ssgikf that keeps whichever estimate is nearer to the truth",
    "oracle-weighting over the exchange of dsgiff-frequent",
)

for controller, about in zip(NAMED, ABOUT, strict=True):
    REFERENCES.register(controller.name, about)(controller)

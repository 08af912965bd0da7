"""The named references, one line each; they are entered in a registry of their own."""

from baselines.recipes import SINGLE, SUBSUMPTION
from baselines.references.global_average import GlobalAverage
from baselines.references.no_error import PerfectOdometry
from baselines.references.oracle import OracleWeighting
from baselines.references.reference import Reference
from baselines.weighting.sgiff import SGIFF
from baselines.weighting.sgikf import SGIKF
from swarm_forage_env.registry import REFERENCES

SINGLE_FIELDS = SINGLE.model_dump()

RECIPES = (
    Reference("no-error", PerfectOdometry(**SINGLE_FIELDS), SGIFF(beta=1e-3), SUBSUMPTION),
    Reference("global", GlobalAverage(**SINGLE_FIELDS | {"speaks": False}), SGIKF(), SUBSUMPTION),
    Reference("oracle-weighting", SINGLE, OracleWeighting(), SUBSUMPTION),
)
"""Perfect odometry and global communication (ANTS, Section 5), and the best weighting."""

for recipe in RECIPES:
    REFERENCES.register(recipe.name)(recipe)

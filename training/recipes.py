"""The named learned controllers, one line each: `learned-weighting:policy=runs/x/best.safetensors`.

Everything but the learned layers is as in `dsgiff-wary`, or as in `ssgiff` with a learned motion.
"""

from baselines.controller import Recipe
from baselines.recipes import SINGLE, SUBSUMPTION, WARY
from baselines.weighting.sgiff import SGIFF
from swarm_forage_env.registry import CONTROLLERS
from training.motion import LearnedMotion
from training.weighting import LearnedWeighting

RECIPES = (
    Recipe("learned-weighting", WARY, LearnedWeighting(), SUBSUMPTION),
    Recipe("learned-motion", SINGLE, SGIFF(), LearnedMotion()),
    Recipe("learned-both", WARY, LearnedWeighting(), LearnedMotion()),
)

for recipe in RECIPES:
    CONTROLLERS.register(recipe.name)(recipe)

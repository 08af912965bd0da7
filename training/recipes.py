"""The named learned controllers, one line each: `learned-weighting:policy=runs/x/best.safetensors`.

Everything but the learned layers is as in `ssgiff`.
"""

from baselines.controller import Recipe
from baselines.recipes import SINGLE, SUBSUMPTION
from baselines.weighting.sgiff import SGIFF
from swarm_forage_env.registry import CONTROLLERS
from training.motion import LearnedMotion
from training.weighting import LearnedWeighting

RECIPES = (
    Recipe("learned-weighting", SINGLE, LearnedWeighting(), SUBSUMPTION),
    Recipe("learned-motion", SINGLE, SGIFF(), LearnedMotion()),
    Recipe("learned-both", SINGLE, LearnedWeighting(), LearnedMotion()),
)

for recipe in RECIPES:
    CONTROLLERS.register(recipe.name)(recipe)

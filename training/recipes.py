"""The named learned controllers, one line each: `learned-weighting:policy=runs/x/best.safetensors`.

Everything but the learned layer is as in `ssgiff`.
"""

from baselines.controller import Recipe
from baselines.recipes import SINGLE, SUBSUMPTION
from swarm_forage_env.registry import CONTROLLERS
from training.weighting import LearnedWeighting

RECIPES = (Recipe("learned-weighting", SINGLE, LearnedWeighting(), SUBSUMPTION),)

for recipe in RECIPES:
    CONTROLLERS.register(recipe.name)(recipe)

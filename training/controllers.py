"""The named learned controllers, as `learned-weighting:policy=runs/x/best.safetensors`.

The other layers are those of `dsgiff-brisk` for a learned weighting, of `ssgiff` for a learned
motion, and of `dsgiff-wary` for both.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from baselines.controller import Recipe
from baselines.recipes import BRISK, SINGLE, SUBSUMPTION, WARY
from baselines.weighting.sgiff import SGIFF
from swarm_forage_env.registry import CONTROLLERS
from training.learned_motion import LearnedMotion
from training.learned_weighting import LearnedWeighting
from training.policy_file import LayerName

RECIPES = (
    Recipe("learned-weighting", BRISK, LearnedWeighting(), SUBSUMPTION),
    Recipe("learned-motion", SINGLE, SGIFF(), LearnedMotion()),
    Recipe(
        "learned-both",
        WARY,
        LearnedWeighting(policy="weighting-both"),
        LearnedMotion(policy="motion-both"),
    ),
)

for recipe in RECIPES:
    CONTROLLERS.register(recipe.name)(recipe)

LEARNED_LAYERS: Mapping[LayerName, Any] = {"weighting": LearnedWeighting, "motion": LearnedMotion}
"""Class of each learned layer, which runs a policy from a file."""


def with_learned_layers(recipe: Recipe, layers: Sequence[LayerName], policy: Path) -> Recipe:
    """Copy a controller, with some layers replaced by those of a policy file."""
    parts = {layer: LEARNED_LAYERS[layer](policy=str(policy)) for layer in layers}
    return replace(recipe, **parts)


def controller_name(recipe: Recipe) -> str | None:
    """Name a recipe of learned layers for the command `evaluate`; None if it has no name."""
    kinds = [type(part) for part in recipe.layers.values()]
    for each in RECIPES:
        if kinds == [type(part) for part in each.layers.values()]:
            usual = each.parameters
            changes = [f"{k}={v}" for k, v in recipe.parameters.items() if v != usual[k]]
            return f"{each.name}:{','.join(changes)}" if changes else each.name
    return None

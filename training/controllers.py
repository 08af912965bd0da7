"""The named learned controllers, one line each: `learned-weighting:policy=runs/x/best.safetensors`.

Everything but the learned layers is as in `dsgiff-brisk` with a learned weighting alone, as in
`ssgiff` with a learned motion alone, and as in `dsgiff-wary` with both.
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
"""What runs a layer's policy from a file."""


def with_learned_layers(recipe: Recipe, layers: Sequence[LayerName], policy: Path) -> Recipe:
    """The same controller with a policy in the place of some layers."""
    parts = {layer: LEARNED_LAYERS[layer](policy=str(policy)) for layer in layers}
    return replace(recipe, **parts)


def controller_name(recipe: Recipe) -> str | None:
    """The learned controller with these layers, as `evaluate` takes it; None if none has them."""
    kinds = [type(part) for part in recipe.layers.values()]
    for each in RECIPES:
        if kinds == [type(part) for part in each.layers.values()]:
            usual = each.parameters
            changes = [f"{k}={v}" for k, v in recipe.parameters.items() if v != usual[k]]
            return f"{each.name}:{','.join(changes)}" if changes else each.name
    return None

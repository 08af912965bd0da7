"""The named learned controllers, as `learned-weighting:policy=runs/x/best.safetensors`.

The other layers are those of `dsgiff-frequent` for a learned weighting, of `ssgiff` for a
learned motion, and of `dsgiff-penalised` for both.

Policies of other trainers are named by kind and file, as `sb3:model.zip`; their other layers are
those that they were trained beside.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from baselines.controller import LayeredController
from baselines.controllers import FREQUENT, PENALISED, SINGLE, SUBSUMPTION
from baselines.weighting.sgiff import SGIFF
from swarm_forage_env.registry import CONTROLLERS, POLICIES
from training.callable_policy import CallablePolicy
from training.learned_motion import LearnedMotion
from training.learned_weighting import LearnedWeighting
from training.onnx_policy import OnnxPolicy
from training.policy_controller import named_policy
from training.policy_file import LayerName
from training.sb3_policy import SB3Policy
from training.torchscript_policy import TorchScriptPolicy

NAMED = (
    LayeredController("learned-weighting", FREQUENT, LearnedWeighting(), SUBSUMPTION),
    LayeredController("learned-motion", SINGLE, SGIFF(), LearnedMotion()),
    LayeredController(
        "learned-both",
        PENALISED,
        LearnedWeighting(policy="weighting-both"),
        LearnedMotion(policy="motion-both"),
    ),
)

for controller in NAMED:
    CONTROLLERS.register(controller.name)(controller)

KINDS = {
    "sb3": SB3Policy,
    "torchscript": TorchScriptPolicy,
    "onnx": OnnxPolicy,
    "callable": CallablePolicy,
}
"""Policies of other trainers, by the word before the colon."""

for kind, policy in KINDS.items():
    POLICIES.register(kind)(named_policy(kind, policy()))

LEARNED_LAYERS: Mapping[LayerName, Any] = {"weighting": LearnedWeighting, "motion": LearnedMotion}
"""Class of each learned layer, which runs a policy from a file."""


def with_learned_layers(
    controller: LayeredController, layers: Sequence[LayerName], policy: Path
) -> LayeredController:
    """Copy a controller, with some layers replaced by those of a policy file."""
    parts = {layer: LEARNED_LAYERS[layer](policy=str(policy)) for layer in layers}
    return replace(controller, **parts)


def controller_name(controller: LayeredController) -> str | None:
    """Name a controller of learned layers for the command `evaluate`; None if it has no name."""
    kinds = [type(part) for part in controller.layers.values()]
    for each in NAMED:
        if kinds == [type(part) for part in each.layers.values()]:
            usual = each.parameters
            changes = [f"{k}={v}" for k, v in controller.parameters.items() if v != usual[k]]
            return f"{each.name}:{','.join(changes)}" if changes else each.name
    return None

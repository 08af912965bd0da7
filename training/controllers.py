"""Named learned controllers, such as `learned-weighting:policy=runs/x/best.safetensors`.

Policies of other trainers are named by kind and file, such as `sb3:model.zip`; the other layers are
those of their training.
"""

from collections.abc import Sequence
from dataclasses import replace
from inspect import getdoc
from pathlib import Path

from baselines.controller import LayeredController
from baselines.controllers import FREQUENT, PENALISED, SINGLE, SUBSUMPTION
from baselines.estimators.reputation_odometry import ReputationOdometryParameters
from baselines.weighting.sgiff import SGIFF
from swarm_forage_env.parameters import Parameters
from swarm_forage_env.registry import CONTROLLERS, POLICIES
from training.exported_policies import CallablePolicy, OnnxPolicy, TorchScriptPolicy
from training.learned_weighting import (
    REPUTATION_NETWORK,
    LearnedReputation,
    LearnedWeighting,
    network_over,
)
from training.linear_motion_policy import LearnedMotion
from training.network_policy import NetworkPolicy
from training.policy_controller import named_policy
from training.policy_file import LayerName
from training.sb3_policy import SB3Policy

REPUTATION = ReputationOdometryParameters(weighs_unknown=True, pause=5.0, refractory=10.0)

TABLE = (
    ("learned-weighting", "a network weights received estimates, over dsgiff-frequent",
     FREQUENT, LearnedWeighting(), SUBSUMPTION),
    ("learned-motion", "a linear policy corrects the motion, over ssgiff",
     SINGLE, SGIFF(), LearnedMotion()),
    ("learned-both", "a learned weighting and motion, over dsgiff-penalised",
     PENALISED, LearnedWeighting(policy="weighting-both"), LearnedMotion(policy="motion-both")),
    ("learned-robust", "learned-both with a motion that was trained in many worlds",
     PENALISED, LearnedWeighting(policy="weighting-both"), LearnedMotion(policy="motion-robust")),
    ("learned-sceptical", "a network weights by how right the reports of each sender were",
     REPUTATION, LearnedReputation(), SUBSUMPTION),
)  # fmt: skip
"""Name, description and layers of each controller."""

NAMED = tuple(LayeredController(name, *layers) for name, _, *layers in TABLE)

for controller, (name, about, *_) in zip(NAMED, TABLE, strict=True):
    CONTROLLERS.register(name, about)(controller)

KINDS = {
    "sb3": SB3Policy,
    "torchscript": TorchScriptPolicy,
    "onnx": OnnxPolicy,
    "callable": CallablePolicy,
    "network": NetworkPolicy,
}
"""Kinds of policies of other trainers, by the word before the colon of a name."""


NETWORKS = {
    "learned-ppo": ("motion-ppo", "a network drives, trained from scratch in es1 by PPO"),
    "learned-generalist": ("motion-generalist", "learned-ppo trained in ten worlds, not one"),
}
"""Bundled network of each controller, and its description."""

for name, (network, about) in NETWORKS.items():
    CONTROLLERS.register(name, about)(
        named_policy(name, NetworkPolicy()).with_parameters({"file": network})
    )

for kind, policy in KINDS.items():
    first_line = (getdoc(policy) or "").partition("\n")[0]
    POLICIES.register(kind, first_line)(named_policy(kind, policy()))


def with_learned_layers(
    controller: LayeredController, layers: Sequence[LayerName], policy: Path
) -> LayeredController:
    """Copy a controller, with some layers replaced by those of a policy file.

    Args:
        controller: A hand-written controller.
        layers: Layers to replace: `weighting`, `motion`.
        policy: A file that `swarm-forage train` has written.
    """
    remembers = network_over(controller.estimator) is REPUTATION_NETWORK
    kinds: dict[LayerName, type[Parameters]] = {
        "weighting": LearnedReputation if remembers else LearnedWeighting,
        "motion": LearnedMotion,
    }
    parts = {each: kinds[each].model_validate({"policy": str(policy)}) for each in layers}
    return replace(controller, **parts)  # type: ignore[arg-type] # no `name` in it


def controller_name(controller: LayeredController) -> str | None:
    """Return the name of a controller of learned layers for `evaluate`; None if it has none."""
    kinds = [type(part) for part in controller.layers.values()]
    for each in NAMED:
        if kinds == [type(part) for part in each.layers.values()]:
            usual = each.parameters
            changes = [f"{k}={v}" for k, v in controller.parameters.items() if v != usual[k]]
            return f"{each.name}:{','.join(changes)}" if changes else each.name
    return None

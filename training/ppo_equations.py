"""Equations of PPO on tensors: advantages of a rollout, and the loss of a minibatch."""

from dataclasses import dataclass

import torch
from torch import Tensor

CLIP_RANGE = 0.2
"""Clipping of the ratio of probabilities after and before: as stable-baselines3."""


@dataclass(frozen=True)
class Rollout:
    """Transitions of a rollout, decisions by rows."""

    observations: Tensor
    actions: Tensor
    log_probs: Tensor
    values: Tensor
    """Of the observations; one decision more than the others."""
    rewards: Tensor
    """At the end of an episode with the discounted value of its last observation."""
    ends: Tensor
    """1 where an episode ends with the decision, else 0."""


def advantages(rollout: Rollout, discount: float, gae_lambda: float) -> Tensor:
    """Generalised advantage estimates, decisions by rows.

        delta_t = r_t + discount v_{t+1} - v_t
        A_t     = delta_t + discount lambda A_{t+1}

    where v_{t+1} and A_{t+1} are 0 if an episode ends at t.

    Source: Schulman2016, Eq. 16.
    """
    out = torch.empty_like(rollout.rewards)
    later = torch.zeros_like(rollout.rewards[0])
    for k in reversed(range(len(out))):
        decay = discount * (1.0 - rollout.ends[k])
        delta = rollout.rewards[k] + decay * rollout.values[k + 1] - rollout.values[k]
        out[k] = later = delta + decay * gae_lambda * later
    return out


def clipped_loss(ratio: Tensor, gains: Tensor) -> Tensor:
    """The clipped surrogate loss of a minibatch, whose advantages are normalised.

    Source: Schulman2017, Eq. 7.
    """
    normal = (gains - gains.mean()) / (gains.std() + 1e-8)
    clipped = torch.clamp(ratio, 1.0 - CLIP_RANGE, 1.0 + CLIP_RANGE)
    return -torch.min(normal * ratio, normal * clipped).mean()


def policy_change(log_ratio: Tensor) -> dict[str, float]:
    """How far an update moved the policy, from log probabilities after less those before."""
    ratio = torch.exp(log_ratio)
    return {
        "train/approx_kl": (ratio - 1.0 - log_ratio).mean().item(),
        "train/clip_fraction": ((ratio - 1.0).abs() > CLIP_RANGE).float().mean().item(),
    }

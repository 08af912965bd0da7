"""Behaviour cloning: a network that learns a hand-written or learned motion from its transitions.

    pip install 'swarm-forage[train]'
    swarm-forage dataset es1 learned-both --episodes 10 --learners 3 --out runs/transitions
    python examples/behaviour_cloning.py runs/transitions learned-both       # some minutes

At the end the clone plays beside the same other layers, on seeds that the dataset does not hold.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch

from baselines.evaluation.episode import run_episodes
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.scenarios import find_scenario
from training.cloning import Cloner, CloningOptions
from training.network_policy import save_network
from training.policy_file import Weights
from training.transitions import card_in, read

HELD_OUT = range(1000, 10**6)


def clone(folder: Path, policy: str, steps: int, seed: int) -> Weights:
    """The weights of a network that acts as was done after such observations."""
    torch.manual_seed(seed)
    cloner = Cloner(read(folder, policy), CloningOptions())
    for step in range(1, steps + 1):
        log_likelihood = cloner.step()
        if step % max(1, steps // 5) == 0:
            print(f"step {step:,}: mean log-likelihood of the wheels {log_likelihood:.2f}")
    return cloner.policy.to_numpy()


def main(arguments: Sequence[str] | None = None) -> dict[str, float]:
    """Clone, save the network with its card, and print its score beside the original's."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folder", type=Path, help="of swarm-forage dataset")
    parser.add_argument("policy", help="whose motion is cloned, as it was recorded")
    parser.add_argument("--steps", type=int, default=10_000, help="of 1,024 transitions")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--episodes", type=int, default=10, help="held-out ones")
    parser.add_argument("--out", type=Path, default=Path("runs/behaviour_cloning"))
    chosen = parser.parse_args(arguments)
    card = card_in(chosen.folder, chosen.policy)
    file = chosen.out / "clone.safetensors"
    save_network(file, clone(chosen.folder, chosen.policy, chosen.steps, chosen.seed), card)
    name = f"network:{file},controller={card.controller}"
    scenario, means = find_scenario(card.scenario), {}
    for each in (chosen.policy, name, f"{name},chance=true"):
        episodes = run_episodes(scenario, find_controller(each), HELD_OUT[: chosen.episodes])
        means[each] = float(np.mean([episode.round_trips for episode in episodes]))
        print(f"{means[each]:6.1f} round trips an episode: {each}")
    return means


if __name__ == "__main__":
    main()

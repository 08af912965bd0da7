"""Networks of weights by chance, as policies in es1."""

import numpy as np

from swarm_forage_env.envs.make import checked_parts
from training.network_policy import save_network, shapes_of
from training.policy_card import card_of


def any_network(folder, n_state, learn="motion"):
    """The name of a policy with hidden units, and a memory of so many numbers."""
    found, rng = folder / "any.safetensors", np.random.default_rng(0)
    parts = checked_parts("es1", None, {"learn": learn})
    form = parts.form
    shapes = shapes_of([len(form.layout), 16, len(form.action.layout)], n_state)
    weights = {name: rng.normal(0.0, 0.05, shape).astype("f4") for name, shape in shapes.items()}
    save_network(found, weights, card_of(parts))
    return f"network:{found}"

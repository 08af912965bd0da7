"""Kinds of figures of `swarm-forage plot`; importing this package registers them."""

from swarm_forage_env.registry import load_folder

load_folder(__name__, __path__)

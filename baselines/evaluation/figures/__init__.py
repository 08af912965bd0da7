"""The kinds of figures of `swarm-forage plot`, one a module; importing this registers them."""

from swarm_forage_env.registry import load_folder

load_folder(__name__, __path__)

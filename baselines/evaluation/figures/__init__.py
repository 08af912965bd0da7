"""The kinds of figures of `swarm-forage plot`, one a file; the folder loads itself."""

from swarm_forage_env.registry import load_folder

load_folder(__name__, __path__)

"""`python -m swarm_forage_env`: run the command `swarm-forage` if it is not on the PATH.

This package contains no commands; it runs the one that its distribution installed.
"""

import sys
from importlib.metadata import entry_points

COMMAND = "swarm-forage"


def main() -> None:
    """Run the installed command, or exit with one line on stderr if there is none."""
    commands = list(entry_points(group="console_scripts", name=COMMAND))
    if not commands:
        sys.exit(f"{COMMAND}: is not installed; in a checkout: pip install '.[evaluate]'")
    commands[0].load()()


if __name__ == "__main__":
    main()

"""`python -m calibration`, which says in one line what to install where optuna is missing."""

import sys

from swarm_forage_env.extras import missing_told

if __name__ == "__main__":
    with missing_told():
        from calibration.command import run_command

        sys.exit(run_command())

"""Entry point of the console script `swarm-forage`: the baselines' commands, and `train`."""

import os
import sys

from swarm_forage_env.extras import report_missing

INTERRUPTED = 130  # exit status after Ctrl-C (128 + SIGINT)


def main() -> None:
    """Run one command; print one line on stderr if a package that it needs is missing."""
    try:
        with report_missing():
            import training.ladder.commands
            import training.train_command  # noqa: F401 both add their commands
            from baselines.cli import run

            status = run()
    except KeyboardInterrupt:
        status = INTERRUPTED
    if status == INTERRUPTED:  # an interrupted compiler prints errors while it shuts down
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stderr.fileno())
    sys.exit(status)


if __name__ == "__main__":
    main()

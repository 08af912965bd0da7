"""Entry point of the console script `swarm-forage`: the baselines' commands, and `train`."""

import os
import sys

from swarm_forage_env.extras import missing_told

INTERRUPTED = 130  # exit status after Ctrl-C (128 + SIGINT)


def main() -> None:
    """Run one command, and print one line on stderr if a package that it needs is missing."""
    try:
        with missing_told():
            from baselines.cli import app, run
            from training.ladder.commands import add_benchmark
            from training.train_command import add_commands

            add_commands()
            add_benchmark(app)
            status = run()
    except KeyboardInterrupt:
        status = INTERRUPTED
    if status == INTERRUPTED:  # a compiler stopped half-way complains while it is taken down
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stderr.fileno())
    sys.exit(status)


if __name__ == "__main__":
    main()

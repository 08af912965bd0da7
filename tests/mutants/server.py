"""Start the tests of mutants from a process that has imported what they need of other packages.

python -m tests.mutants.server FOLDER   # until its input ends; nothing of this code is imported
"""

import importlib
import os
import selectors
import socket
import sys
from pathlib import Path

from tests.mutants.covering import run

PACKAGES = (
    "_pytest.assertion.rewrite", "gymnasium", "hypothesis", "jaxtyping", "joblib",
    "matplotlib.pyplot", "numba", "pettingzoo", "polars", "pydantic", "pymunk", "pytest",
    "rich.console", "scipy.stats", "stable_baselines3",
)  # fmt: skip
BROKEN = 255
"""Status of a process in which not a test failed, but what chooses them."""


def serve(folder):
    """A process of its own for each group that is asked for; its status is the answer."""
    address = folder / "server"
    address.unlink(missing_ok=True)
    with socket.socket(socket.AF_UNIX) as listening, selectors.DefaultSelector() as ready:
        listening.bind(str(address))
        listening.listen()
        ready.register(listening, selectors.EVENT_READ)
        ready.register(sys.stdin, selectors.EVENT_READ)
        while all(key.fileobj is listening for key, _ in ready.select()):
            answer(folder, listening.accept()[0])


def answer(folder, client):
    """Run the tests of the mutant that is in the tree now, with the output of the one who asks."""
    with client:
        group, files, _, _ = socket.recv_fds(client, 100, 2)
        child = os.fork()
        if child == 0:
            status = BROKEN
            try:
                for number, file in zip((1, 2), files, strict=True):
                    os.dup2(file, number)
                status = run(folder, group.decode())
                sys.stdout.flush()
            finally:
                os._exit(status)
        for file in files:
            os.close(file)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        if status != BROKEN:
            client.sendall(bytes([abs(status)]))


if __name__ == "__main__":
    for package in PACKAGES:
        importlib.import_module(package)
    if "swarm_forage_env" in sys.modules:
        raise SystemExit("a package imports the code whose mutants are tried")
    serve(Path(sys.argv[1]))

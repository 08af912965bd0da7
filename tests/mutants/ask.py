"""Have the tests of the mutant in this tree run by the server: the status is that of pytest.

python tests/mutants/ask.py ADDRESS GROUP
"""

import os
import signal
import socket
import sys
import time

PATIENCE = 300
"""How long the server may take to start [s]."""


def connect(server, address):
    """Connect as soon as the server listens."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end and server.connect_ex(address) != 0:
        time.sleep(0.1)


if __name__ == "__main__":
    address, group = sys.argv[1:]
    parent = os.getppid()
    status = b""
    try:
        with socket.socket(socket.AF_UNIX) as server:
            connect(server, address)
            socket.send_fds(server, [group.encode()], [1, 2])
            status = server.recv(1)
    except OSError as error:
        sys.stderr.write(f"{address}: {error}\n")
    if not status:  # no mutant may count as noticed for want of a server
        if os.getppid() == parent:  # else the run has ended before
            os.kill(parent, signal.SIGINT)
            time.sleep(10.0)
        sys.exit("no answer: the run is stopped, and the same command goes on")
    sys.exit(status[0])

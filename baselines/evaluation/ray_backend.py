"""Ray backend: runs calls on the nodes of a cluster, and runs them again if a node dies.

    swarm-forage evaluate es1 ssgikf --backend ray --workers 64 --address ray-head:6379

Calls return their results to this process, which stores them. A call whose worker or node dies
runs again on another one; as it depends on its job only, it returns the same bits.
"""

import hashlib
import logging
import os
import platform
import signal
import socket
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import BrokenExecutor
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import version
from itertools import islice
from pathlib import Path
from typing import Any

import ray
from ray._private import worker as ray_worker
from ray.exceptions import RayError, RayTaskError

from baselines.evaluation.backends import Backend, JobT, Results, ResultT
from baselines.evaluation.experiment_config import LIBRARIES, OURS
from swarm_forage_env.errors import ConfigError

LOGGER = logging.getLogger("swarm-forage")

MAX_RETRIES = 10  # maximum number of times that a call is run again after its worker or node died

NAMESPACE = "swarm-forage"  # of the connections that a backend makes

WAIT = 10.0  # maximum time to wait for an answer of an address [s]


@dataclass(frozen=True)
class RayBackend(Backend):
    """Backend of workers of a Ray cluster: the one at an address, or else a local one.

    Ray reserves `threads` CPUs for each call.
    """

    address: str | None = None

    def connect(self) -> None:
        """Join the cluster, or start a local one that ends with this process.

        ConfigError if no cluster answers at the address. A program that has called `ray.init`
        keeps its cluster.
        """
        if ray.is_initialized():
            return
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # sends no usage reports
        options: dict[str, object] = {"address": self.address, "namespace": NAMESPACE}
        if self.address is None:
            cpus = self.workers * self.threads
            options |= {"address": "local", "num_cpus": cpus, "include_dashboard": False}
        else:
            _check_answers(self.address)
        handler = signal.getsignal(signal.SIGTERM)  # Ray replaces it
        try:
            ray.init(**options, log_to_driver=False, logging_level=logging.ERROR)
            ray_worker.print_to_stdstream = _log  # otherwise printed to stdout, among the results
        except (ConnectionError, RuntimeError, ValueError):
            raise _no_cluster(self.address) from None
        finally:
            if threading.current_thread() is threading.main_thread():
                signal.signal(signal.SIGTERM, handler)

    def run(self, function: Callable[[JobT], ResultT], jobs: Sequence[JobT]) -> Results[ResultT]:
        """Call the function with every job; a call whose worker dies runs again on another one.

        If the caller stops early, this process leaves the cluster, which ends the calls that run;
        it stays in a cluster that the program itself has joined, where they run to their end.
        """
        if not jobs:
            return
        self.connect()
        cpus = (node["Resources"].get("CPU", 0) for node in ray.nodes() if node["Alive"])
        if (most := max(cpus, default=0)) < self.threads:
            waits = "--threads=%d: the largest node has %g CPUs; waiting for one with more"
            LOGGER.warning(waits, self.threads, most)
        remote = ray.remote(num_cpus=self.threads, max_retries=MAX_RETRIES)(_call)
        shared, todo = ray.put((function, code_here())), iter(jobs)
        running = [remote.remote(shared, job) for job in islice(todo, self.workers)]
        try:
            while running:
                (ended, *_), running = ray.wait(running)
                running += [remote.remote(shared, job) for job in islice(todo, 1)]
                yield _result(ended)
        finally:  # `ray.cancel` of a call that has just ended aborts this process, up to Ray 2.60
            if running and ray.get_runtime_context().namespace == NAMESPACE:
                ray.shutdown()


def _log(message: Mapping[str, Sequence[str]], ignore_prefix: bool) -> None:
    """Log the first sentence of Ray's message about a node or worker that died."""
    for text in message["lines"]:
        LOGGER.warning("ray: %s", text.partition(". ")[0])


def _check_answers(address: str) -> None:
    """Raise ConfigError unless HOST:PORT answers; Ray itself would try for many minutes."""
    host, colon, port = address.removeprefix("ray://").rpartition(":")
    if not colon:  # auto, or the name of a cluster
        return
    try:
        socket.create_connection((host, int(port)), timeout=WAIT).close()
    except (OSError, ValueError, OverflowError):
        raise _no_cluster(address) from None


def _no_cluster(address: str | None) -> ConfigError:
    return ConfigError(
        f"--address={address}: no Ray cluster answers there that has this version of Ray and of"
        " Python; `ray start --head` starts one and prints its address"
    )


@cache
def code_here() -> str:
    """Return the hash of the source of OURS and of the versions of Python and LIBRARIES."""
    text = hashlib.sha256(platform.python_version().encode())
    for library in LIBRARIES:
        text.update(version(library).encode())
    for name in OURS:
        folder = Path(import_module(name).__path__[0])
        for file in sorted(folder.rglob("*.py")):
            text.update(f"{file.relative_to(folder)}\n".encode() + file.read_bytes())
    return text.hexdigest()[:16]


def _call(shared: tuple[Callable[[JobT], ResultT], str], job: JobT) -> ResultT:
    function, code = shared
    if code_here() != code:
        raise ConfigError(
            f"--backend=ray: node {platform.node()} has another swarm-forage,"
            f" {', '.join(LIBRARIES)} or Python than this machine; install the same on every node"
        )
    return function(job)


def _result(ended: object) -> Any:  # noqa: ANN401 of any kind
    """Return the result of a call or raise its error; BrokenExecutor if its workers kept dying."""
    try:
        return ray.get(ended)
    except RayTaskError as error:
        raise error.cause from None
    except RayError as error:
        raise BrokenExecutor(str(error)) from error

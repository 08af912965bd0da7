"""How often each fault is tried, and what is told of it."""

import os
import random
import sys

import pytest

TRIES = int(os.environ.get("FAULTS", "20"))
"""Faults of each kind; `make faults FAULTS=1000` for many."""

SEED = int(os.environ.get("FAULTS_SEED", "1"))


@pytest.fixture
def tries():
    """A function: how often a fault is tried, of which one try costs so many times the usual."""

    def number(cost=1):
        return max(1, TRIES // cost)

    return number


@pytest.fixture
def rng(request):
    """Random numbers of this test, from the seed that is printed."""
    return random.Random(f"{SEED} {request.node.name}")


@pytest.fixture
def tell(request, capsys):
    """Print how often a fault was tried, and what came of it."""

    def told(**counts):
        numbers = ", ".join(f"{name.replace('_', ' ')} {n}" for name, n in counts.items())
        with capsys.disabled():
            sys.stdout.write(f"\n{request.node.name}, seed {SEED}: {numbers}\n")

    return told

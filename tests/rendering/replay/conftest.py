"""An episode to replay, and a made-up one that takes no time."""

import numpy as np
import pytest

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.loop import Loop
from swarm_forage_env.task import stage_of
from tests.rendering.scenes import scene_of, scenes_of


@pytest.fixture(scope="session")
def stage(busy):
    return stage_of(busy, "ssgikf")


@pytest.fixture(scope="session")
def scenes(busy):
    """Two and a half minutes of ten robots."""
    return scenes_of(Loop(busy, find_controller("ssgikf"), [1]), 1500)


@pytest.fixture(scope="session")
def made_up():
    """A scene of three robots at a tick, in which one message is heard."""

    def scene(tick):
        rng = np.random.default_rng(tick)
        known = rng.random((3, 2)) < 0.5
        return scene_of(
            rng.uniform(-3.0, 3.0, (3, 3)),
            time=0.1 * tick,
            activity=rng.integers(0, 5, 3).astype(np.int8),
            believed=np.where(known[:, :, None], rng.uniform(-9.0, 9.0, (3, 2, 2)), 0.0),
            known=known,
            p=np.where(known, rng.uniform(0.0, 40.0, (3, 2)), 0.0).astype(np.float32),
            messages=np.array([[tick % 3, (tick + 1 + tick // 3 % 2) % 3]], np.int32),
            round_trips=np.full(3, tick // 10, np.int32),
            on_path=(tick % 4) / 3,
        )

    return scene

"""An episode to replay, a made-up one that takes no time, and how a page is read back."""

import base64
import json
import re
import zlib

import numpy as np
import pytest

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.loop import Loop
from swarm_forage_env.scene import Scene
from swarm_forage_env.task import stage_of

TICKS = 1500


@pytest.fixture(scope="session")
def stage(busy):
    return stage_of(busy, "ssgikf")


@pytest.fixture(scope="session")
def scenes(busy):
    """Two and a half minutes of ten robots."""
    loop = Loop(busy, find_controller("ssgikf"), [1])
    found = [loop.scene()]
    for _ in range(TICKS):
        loop.step()
        found.append(loop.scene())
    return found


@pytest.fixture(scope="session")
def made_up():
    """A scene of three robots at a tick, in which one message is heard."""

    def scene(tick):
        rng = np.random.default_rng(tick)
        known = rng.random((3, 2)) < 0.5
        return Scene(
            time=0.1 * tick,
            pose=rng.uniform(-3.0, 3.0, (3, 3)),
            doing=rng.integers(0, 5, 3).astype(np.int8),
            believed=np.where(known[:, :, None], rng.uniform(-9.0, 9.0, (3, 2, 2)), 0.0),
            known=known,
            p=np.where(known, rng.uniform(0.0, 40.0, (3, 2)), 0.0).astype(np.float32),
            messages=np.array([[tick % 3, (tick + 1 + tick // 3 % 2) % 3]], np.int32),
            round_trips=np.full(3, tick // 10, np.int32),
            on_path=(tick % 4) / 3,
        )

    return scene


@pytest.fixture(scope="session")
def parts():
    return _parts


@pytest.fixture(scope="session")
def unpacked():
    return _unpacked


def _parts(page):
    """What the page says about its recording, and the packed recording."""
    about, recording = (
        re.search(rf'id="{name}">(.*?)</script>', page, re.DOTALL)[1]
        for name in ("about", "recording")
    )
    return json.loads(about), base64.b64decode(recording)


def _unpacked(about, packed):
    """Times, on-path shares, the messages of each frame, and robots x frames of each column."""
    data, frames = zlib.decompress(packed), about["frames"]
    times, on_path = np.frombuffer(data, "<f4", 2 * frames).reshape(2, frames)
    counts = np.frombuffer(data, "<u4", frames, 8 * frames)
    pairs = np.frombuffer(data, "<u2", 2 * about["messages"], 12 * frames).reshape(-1, 2)
    at = 12 * frames + pairs.nbytes
    columns = {}
    size = (len(data) - at) // (2 * len(about["columns"]))
    for column in about["columns"]:
        low, high = np.frombuffer(data, np.uint8, 2 * size, at).reshape(2, -1, frames)
        codes = np.cumsum(low + 256 * high.astype(np.int64), axis=1) % 65536
        columns[column["name"]] = column["low"] + column["step"] * codes
        at += 2 * size
    assert at == len(data)
    heard = [set(map(tuple, part.tolist())) for part in np.split(pairs, counts[:-1])]
    return times, on_path, heard, columns

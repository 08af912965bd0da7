"""How the page of a replay is read back."""

import base64
import json
import re
import zlib

import numpy as np


def parts(page):
    """What the page says about its recording, and the packed recording."""
    about, recording = (
        re.search(rf'id="{name}">(.*?)</script>', page, re.DOTALL)[1]
        for name in ("about", "recording-0")
    )
    return json.loads(about), base64.b64decode(recording)


def unpacked(about, packed):
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

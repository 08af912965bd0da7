"""Recording: the scenes of an episode, subsampled, rounded and packed for a page.

Each quantity of each robot becomes a column of 16-bit codes over time. Packed are the differences
from frame to frame, with low and high bytes apart, which compress well.
"""

import math
import zlib

import numpy as np

from swarm_forage_env.arrays import NEST, PREY, Array, Float32, Int64
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.scene import Scene

CODES = 2**16
SENDER_AND_RECEIVER = np.array([CODES, 1])
"""Factors that encode sender and receiver as one integer."""

PLACE, BELIEVED, PATH, WHOLE = 0.001, 0.002, 0.005, 1.0
"""Resolution of true positions, of believed positions, of path lengths and standard deviations
[m], and of integers; coarser only if the range requires it."""

TURN = 2.0 * math.pi / 1024
"""Resolution of headings [rad]; CODES steps are a whole number of turns."""

ANGLES = ("heading", "direction")
"""Columns of angles, unwrapped over the frames; their codes wrap around."""


class Recording:
    """Every n-th scene of an episode and the last, each with all messages since the one before."""

    def __init__(self, every: int = 1) -> None:
        self.every = every
        self._scenes = 0
        self._latest: Scene | None = None
        self._times: list[float] = []
        self._shares: list[float] = []
        self._rows: list[Float32[Array, "columns robots"]] = []
        self._heard: list[Int64[Array, " pairs"]] = []
        self._pending: list[Int64[Array, " pairs"]] = []

    def add(self, scene: Scene) -> None:
        """Add the next scene of the episode. ConfigError if it is not later than the last."""
        if self._latest is not None and scene.time <= self._latest.time:
            raise ConfigError(
                f"scene of {scene.time:g} s after one of {self._latest.time:g} s: a recording"
                " holds the scenes of one episode in order of time; start a new recording for"
                " each episode"
            )
        self._latest = scene
        self._pending.append(scene.messages @ SENDER_AND_RECEIVER)
        if self._scenes % self.every == 0:
            self._keep(scene)
        self._scenes += 1

    def pack(self) -> tuple[dict[str, object], bytes]:
        """Return a description of the packed values, and the values, deflated.

        Little-endian: times [s] and shares of robots as float32, the cumulative number of messages
        per frame as uint32, sender and receiver of each message as uint16, and then each column:
        low bytes of the differences of all robots, one robot after the other, then high bytes.
        """
        if self._latest is None:
            raise ConfigError("no scene was recorded: add one before writing")
        if self._times[-1] < self._latest.time:
            self._keep(self._latest)
        steps = {name: step for name, (step, _) in _columns(self._latest).items()}
        values = dict(zip(steps, np.stack(self._rows, axis=2), strict=True))
        scales = {name: _scale(name, steps[name], each) for name, each in values.items()}
        counts = np.cumsum([len(pairs) for pairs in self._heard])
        parts = [
            np.array([self._times, self._shares], "<f4").tobytes(),
            counts.astype("<u4").tobytes(),
            np.stack(np.divmod(np.concatenate(self._heard), CODES), axis=1).astype("<u2").tobytes(),
        ]
        parts += [_differences(name, values[name], *scale) for name, scale in scales.items()]
        columns = [{"name": name, "low": low, "step": step} for name, (low, step) in scales.items()]
        frames = {"frames": len(self._times), "every": self.every}
        about = frames | {"messages": int(counts[-1]), "columns": columns}
        return about, zlib.compress(b"".join(parts))

    def _keep(self, scene: Scene) -> None:
        columns = [each.astype(np.float32) for _, each in _columns(scene).values()]
        self._times.append(scene.time)
        self._shares.append(scene.share)
        self._rows.append(np.stack(columns))
        self._heard.append(np.unique(np.concatenate(self._pending)))
        self._pending = []


def _columns(scene: Scene) -> dict[str, tuple[float, Array]]:
    """Return the recorded columns by their names in the page: resolution and values per robot."""
    x, y, heading = scene.pose.T
    columns: dict[str, tuple[float, Array]] = {
        "x": (PLACE, x),
        "y": (PLACE, y),
        "heading": (TURN, heading),
        "doing": (WHOLE, scene.activity),
    }
    if (own := scene.localised) is not None:
        columns |= {"right": (WHOLE, own.right), "wrong": (WHOLE, own.wrong)}
        columns |= _place("goal", PLACE, own.goal) | _place("believed", BELIEVED, own.believed)
        long, short, direction = own.ellipse.T
        columns |= {"long": (PATH, long), "short": (PATH, short), "direction": (TURN, direction)}
    else:
        known = scene.known[:, NEST] + 2 * scene.known[:, PREY]
        columns |= {"known": (WHOLE, known), "trips": (WHOLE, scene.round_trips)}
        for area, name in ((NEST, "nest"), (PREY, "prey")):
            columns |= _place(name, BELIEVED, scene.believed[:, area])
            columns[f"{name}P"] = PATH, scene.p[:, area]
    if scene.faulty is not None:
        columns["faulty"] = WHOLE, scene.faulty
    return columns


def _place(name: str, step: float, places: Array) -> dict[str, tuple[float, Array]]:
    return {f"{name}X": (step, places[:, 0]), f"{name}Y": (step, places[:, 1])}


def _scale(name: str, step: float, values: Float32[Array, "robots frames"]) -> tuple[float, float]:
    """Return the value of code 0, and the step between codes."""
    if name in ANGLES:
        return 0.0, step
    low, high = float(values.min()), float(values.max())
    return low, max(step, (high - low) / (CODES - 1))


def _differences(
    name: str, values: Float32[Array, "robots frames"], low: float, step: float
) -> bytes:
    exact = values.astype(np.float64)
    codes = np.rint(((np.unwrap(exact) if name in ANGLES else exact) - low) / step).astype(np.int64)
    steps = np.diff(codes, axis=1, prepend=0) % CODES
    return (steps % 256).astype(np.uint8).tobytes() + (steps // 256).astype(np.uint8).tobytes()

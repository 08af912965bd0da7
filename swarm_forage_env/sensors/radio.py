"""The range-and-bearing board: short-range, lossy, and imprecise while moving."""

import numpy as np

from swarm_forage_env.arrays import Array, Int32
from swarm_forage_env.interface import WORDS, Heard
from swarm_forage_env.kernels.radio import deliver, hand_over, measure
from swarm_forage_env.neighbours import Neighbours
from swarm_forage_env.scenario import Scenario, record
from swarm_forage_env.state import SwarmState
from swarm_forage_env.streams import Cause, Streams


class RadioBoard:
    """Delivers what robots near by broadcast in the last tick."""

    def __init__(self, scenario: Scenario, rows: int) -> None:
        """Boards of this scenario, for so many robots."""
        self.reach = scenario.radio.max_range
        """Farthest sender, centre to centre [m]."""
        radio = scenario.radio
        self._radio = record(
            max_range=radio.max_range,
            near=radio.near,
            loss_near=radio.loss_near,
            loss_far=radio.loss_far,
            range_noise=radio.range_noise,
            bearing_noise=radio.bearing_noise,
            frames=radio.frames,
        )
        self._is_board = scenario.radio.is_board
        self._n_robots = scenario.task.n_robots
        self._diameter = 2.0 * scenario.robot.radius
        self._sender: Int32[Array, "rows slots"] = np.zeros((rows, scenario.slots), np.int32)
        self._count: Int32[Array, " rows"] = np.zeros(rows, np.int32)

    def silence(self) -> Heard:
        """What is heard before anyone has spoken."""
        rows, slots = self._sender.shape
        return Heard(
            valid=np.zeros((rows, slots), np.bool_),
            sender=np.zeros((rows, slots), np.int32),
            words=np.zeros((rows, slots, WORDS), np.float32),
            beam=np.zeros((rows, slots, 3), np.float32),
            frames=np.zeros((rows, slots), np.int32),
        )

    def __call__(self, state: SwarmState, neighbours: Neighbours, streams: Streams) -> Heard:
        """The messages that reach each robot in this tick."""
        heard = self.silence()
        deliver(
            state.pose,
            neighbours.pairs,
            neighbours.n_pairs,
            state.speaking,
            self._radio,
            streams[Cause.LOSS],
            streams[Cause.SLOT],
            self._sender,
            self._count,
        )
        measure(
            state.pose,
            state.wheels,
            self._sender,
            self._count,
            self._radio,
            self._is_board,
            self._diameter,
            streams[Cause.RADIO],
            heard.beam,
            heard.frames,
        )
        hand_over(
            self._sender,
            self._count,
            state.words,
            self._n_robots,
            heard.valid,
            heard.sender,
            heard.words,
            state.messages,
        )
        return heard

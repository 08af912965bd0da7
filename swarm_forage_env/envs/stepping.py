"""What the batches of both worlds do alike: reset, hold an action, reward, tell the truth."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.envs.layout import Sheet
from swarm_forage_env.envs.rewards import Reward


class Stepping:
    """Worlds with a policy in the place of a layer; a row of every array is a robot."""

    cut: Any
    world: Any
    truth: Any
    _period: int
    _reward: Reward
    _sheet: Sheet
    _potential: Any
    _shaped: bool

    def reset(self, seeds: Sequence[int]) -> Float32[Array, "rows numbers"]:
        """Start every world anew, each from its seed; what every robot observes."""
        self.cut.reset(seeds)
        return self._sheet.write(self.cut.parts)

    def state(self, share_gone: float) -> Float32[Array, " numbers"]:
        """The truth about the first world, as the layout of `truth` says."""
        return np.asarray(self.truth.state(self.cut.beliefs, share_gone)[0])

    def log(self) -> list[list[float]]:
        """What is logged of each robot, in the order of `infos`."""
        numbers: list[list[float]] = self.truth.log(self.cut.beliefs).tolist()
        return numbers

    def step(
        self, action: Float32[Array, "rows numbers"]
    ) -> tuple[Float32[Array, "rows numbers"], Float64[Array, " rows"]]:
        """Hold an action, known to be within its space, for a decision period."""
        before = self._potential(self.world.state) if self._shaped else None
        earned = self.cut.tick(action).reward.astype(np.float64)
        for _ in range(self._period - 1):
            earned += self.cut.tick(action).reward
        if before is not None:
            earned += self._potential.shaping(before, self._potential(self.world.state))
        reward = self._reward(earned.reshape(self.world.n_worlds, -1)).ravel()
        return self._sheet.write(self.cut.parts), reward

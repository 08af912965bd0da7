"""A decision of all learners in one GPU launch: from actions to observations of new episodes.

    act -> [ticks] -> settle -> observe -> [begin -> sense -> observe where it is over]

Nothing is read back: errors are noted, and raised by `DeviceLoop.check`. The CPU repeats the
counting of decisions and the drawing of episode seeds, so that it has the same values.
"""

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float64, Int64, UInt64
from swarm_forage_env.compiler import inlined
from swarm_forage_env.device_loop import DeviceLoop
from swarm_forage_env.envs.decision import Decisions
from swarm_forage_env.envs.decision_kernels import (
    ActionArrays,
    RewardArrays,
    Scaling,
    Span,
    act_in_world,
    observe_in_world,
    settle_in_world,
)
from swarm_forage_env.envs.episodes import Episodes
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.equations.pcg64 import draw_seed
from swarm_forage_env.interface import Kernel
from swarm_forage_env.observed_fields import Fields
from swarm_forage_env.templates import row_template
from swarm_forage_env.ticks import SKIP, START, Arrays, Errors, restart_world, run_world
from swarm_forage_env.worlds_on_cpu import PlacedArray

lane: Kernel
barrier: Kernel
first_world: Kernel
end_world: Kernel
"""Free names of the template, in addition to those of its row templates."""

TickArrays = tuple[Arrays, Arrays, Errors]
"""Arrays of the worlds and of the layers, and the error of each world."""

Observed = tuple[Fields, Scaling, Array, Array]
"""Observed fields, their scaling, the additions, and the stacks."""

Clock = tuple[Int64[Array, " worlds"], Int64[Array, " worlds"], UInt64[Array, "worlds 4"]]
"""Decisions of each episode so far and at its end, and the random stream of later episode seeds."""

Schedule = tuple[int, int, int, int]
"""Number of ticks; 2 if ended worlds are reset, else 1; decisions of a new episode; and the noise
source of the motions."""

Outputs = tuple[Float64[Array, "2 worlds learners"], Array, Array, Bool[Array, " worlds"]]
"""Rewards, unshaped and shaped; single and stacked observations, each after the decision and after
the resets; and whether each episode is over."""


@row_template
def begin_episode(
    tick_arrays: TickArrays, clock: Clock, starts: Arrays, schedule: Schedule, w: int, n_robots: int
) -> None:
    """Begin the next episode of a world, from the next seed of its stream."""
    steps, ends, streams = clock
    if n_robots > 0 and lane() == 0:
        starts[3][w] = draw_seed(streams[w])
        steps[w], ends[w] = 0, schedule[2]
    barrier()
    restart_world(tick_arrays[0], tick_arrays[1], starts, schedule[3], tick_arrays[2], w, n_robots)


def decide_at_once(  # noqa: PLR0913 inputs, outputs and settings
    tick_arrays: TickArrays,
    action_arrays: ActionArrays,
    reward_arrays: RewardArrays,
    observing: Observed,
    clock: Clock,
    starts: Arrays,
    schedule: Schedule,
    out: Outputs,
    span: Span,
) -> None:
    """Run one decision of every world, and begin the next episode where one is over.

    A world with a refused action does not run until the error is raised.
    """
    fields, scaling, additions, frames = observing
    steps, ends, _ = clock
    state, last = (tick_arrays[0][0], tick_arrays[0][1], tick_arrays[2]), span[1]
    for each in range(first_world(span[0]), end_world(last)):
        w = min(each, last - 1)
        learners = action_arrays[1][: action_arrays[1].shape[0] if each < last else 0]
        n_robots = state[0].shape[1] if each < last else 0
        mode = act_in_world(state, action_arrays, reward_arrays, w, learners, n_robots)
        for part in range(schedule[1]):
            n, n_ticks = 0 if mode == SKIP else n_robots, schedule[0] if part == 0 else 1
            if part == 1:
                begin_episode(tick_arrays, clock, starts, schedule, w, n)
            run_world(tick_arrays[0], tick_arrays[1], mode, tick_arrays[2], w, n, n_ticks)
            if part == 0:
                settle_in_world(state, reward_arrays, out[0], w, learners, n_robots)
                if n_robots > 0 and lane() == 0:
                    steps[w] += 1
                    out[3][w] = steps[w] >= ends[w]
                barrier()
            extras = additions, share_left(steps[w], ends[w]), action_arrays[4]
            rows = out[1][part], frames, out[2][part]
            observe_in_world(fields, learners, scaling, extras, mode, rows, w)
            mode = START if n_robots > 0 and out[3][w] else SKIP
            barrier()


@inlined
def share_left(steps: int, end: int) -> float:
    """Return the remaining share of an episode, as `Episodes.share_left` does."""
    return 1.0 - min(steps / max(end, 1), 1.0)


class WholeDecision(Decisions):
    """Decisions of worlds on a GPU, each in one launch."""

    _worlds: DeviceLoop

    def __init__(
        self,
        worlds: DeviceLoop,
        form: PolicyForm,
        learners: Int64[Array, " learners"],
        episodes: Episodes,
    ) -> None:
        super().__init__(worlds, form, learners, episodes)
        clock = episodes.steps, episodes.ends, episodes.streams
        self._clock = tuple(map(worlds.memory.to_device, clock))
        self._decide = worlds.kernel(decide_at_once, {**worlds.functions, **self._functions})

    def output_arrays(self) -> tuple[PlacedArray, ...]:
        """Return new arrays for the results of a decision, as `Outputs`; they can be reused."""
        empty = self._worlds.memory.empty
        rewards = empty((2, *self._rows), np.float64)
        return rewards, *self.observing.output_arrays(2), empty(self._rows[:1], np.bool_)

    def upload_counts(self) -> None:
        """Copy counts and streams that were changed on the CPU to the GPU."""
        episodes = self._episodes
        if episodes.needs_upload:
            clock = episodes.steps, episodes.ends, episodes.streams
            for there, here in zip(self._clock, clock, strict=True):
                self._worlds.memory.write(there, here)
            episodes.needs_upload = False

    def __call__(
        self, actions: PlacedArray, n_ticks: int, length: int, out: tuple[PlacedArray, ...]
    ) -> None:
        """Launch a decision; if `length` > 0, reset ended worlds to episodes of that length."""
        worlds, acting = self._worlds, self._action_arrays(actions)
        observing, clock = self.observing.arguments, self._clock
        schedule = n_ticks, 2 if length else 1, length, worlds.layers.noise
        arrays = worlds.tick_arrays, acting, self._reward_arrays, observing, clock, worlds.starts
        self._decide(*arrays, schedule, out)

"""A decision of all learners in one launch of a GPU: from actions to observations of new episodes.

    check -> take -> [ticks] -> credit -> observe -> [begin -> sense -> observe where it is over]

No number is read back: what goes wrong is noted, and raised where somebody asks. The CPU counts
the decisions of each world and draws the seeds of its episodes too, so that it knows both.
"""

from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float64, Int64, UInt64
from swarm_forage_env.compiler import inlined
from swarm_forage_env.device_loop import DeviceLoop
from swarm_forage_env.envs.decision import Decisions
from swarm_forage_env.envs.decision_kernels import (
    Form,
    Rows,
    Scaling,
    Span,
    Terms,
    credit_in_world,
    observe_in_world,
    write_actions_of_world,
)
from swarm_forage_env.envs.episodes import Episodes
from swarm_forage_env.envs.policy_form import PolicyForm
from swarm_forage_env.equations.pcg64 import draw_seed
from swarm_forage_env.interface import Kernel
from swarm_forage_env.observed_fields import Fields
from swarm_forage_env.templates import row_template
from swarm_forage_env.ticks import (
    BEGINS,
    N_TROUBLES,
    REFUSED,
    RUNS,
    STANDS,
    Arrays,
    restart_world,
    run_world,
)
from swarm_forage_env.worlds_on_cpu import PlacedArray

lane: Kernel
lanes: Kernel
barrier: Kernel
first_world: Kernel
end_world: Kernel
check_actions: Kernel
potential: Kernel
"""Free names of the template, beside those of the row templates that it names."""

Ticking = tuple[Arrays, Arrays, Int64[Array, " worlds_and_one"]]
"""Arrays of the worlds and of the layers, and what went wrong."""

Acting = tuple[Fields, Int64[Array, " learners"], Array, Form, Rows, Any]
"""Where actions go, who acts, the actions, how they are read, what the layers took, and bounds."""

Crediting = tuple[Float64[Array, "2 worlds robots"], Terms, Float64[Array, "worlds robots"]]
"""Potentials before and after the ticks, how rewards are made, and what was earned."""

Observed = tuple[Fields, Scaling, Array, Array]
"""Where observations lie, how they are scaled, what is beside the layer, and frames."""

Clock = tuple[Int64[Array, " worlds"], Int64[Array, " worlds"], UInt64[Array, "worlds 4"]]
"""Decisions of each episode so far and at its end, and the stream of the seeds of the next ones."""

How = tuple[int, int, int, int]
"""How many ticks; 2 if worlds are reset, else 1; decisions of an episode that begins; and what
motions draw for."""

Out = tuple[Float64[Array, "2 worlds learners"], Array, Array, Bool[Array, " worlds"]]
"""Rewards, unshaped and shaped; what is observed, without and with the frames before, of the
decision and then of how worlds go on; and where an episode is over."""


@inlined
def no_potential(robot: object, world: object) -> float:
    """The potential of a task without one."""
    return 0.0


@row_template
def act_in_world(
    ticking: Ticking,
    acting: Acting,
    crediting: Crediting,
    w: int,
    learners: Int64[Array, " learners"],
    n_robots: int,
) -> int:
    """Check the actions of the learners of a world and hand them over; how the world goes on.

    Free names: lane, lanes, barrier, check_actions, potential; those of write_actions_of_world.
    """
    robots, worlds, trouble = ticking[0][0], ticking[0][1], ticking[2]
    fields, _, given, form, raw, limits = acting
    potentials, terms, earned = crediting
    n = learners.shape[0]
    check_actions(given, limits, trouble, w, n)
    barrier()
    is_refused = trouble[w] % N_TROUBLES == REFUSED
    write_actions_of_world(fields, learners, given, form, raw, w, 0 if is_refused else n)
    for i in range(lane(), n_robots, lanes()):
        earned[w, i] = 0.0
        if terms[1] > 0.0:
            potentials[0, w, i] = potential(robots[w, i], worlds[w])
    barrier()
    return STANDS if is_refused or n_robots == 0 else RUNS


@row_template
def settle_in_world(  # noqa: PLR0913 what is read, what is written, and where
    ticking: Ticking,
    crediting: Crediting,
    clock: Clock,
    out: Out,
    w: int,
    learners: Int64[Array, " learners"],
    n_robots: int,
) -> None:
    """Credit the learners of a world after its ticks, and count the decision.

    Free names: lane, lanes, barrier, potential; those of credit_in_world.
    """
    robots, worlds = ticking[0][0], ticking[0][1]
    potentials, terms, earned = crediting
    steps, ends, _ = clock
    for i in range(lane(), n_robots if terms[1] > 0.0 else 0, lanes()):
        potentials[1, w, i] = potential(robots[w, i], worlds[w])
    barrier()
    credit_in_world(learners, earned, potentials, terms, out[0], w, learners.shape[0])
    if n_robots > 0 and lane() == 0:
        steps[w] += 1
        out[3][w] = steps[w] >= ends[w]
    barrier()


@row_template
def begin_episode(
    ticking: Ticking,
    clock: Clock,
    starts: Arrays,
    how: How,
    w: int,
    n_robots: int,
) -> None:
    """Begin the next episode of a world, from the next seed of its stream.

    Free names: lane, barrier; those of restart_world.
    """
    steps, ends, streams = clock
    if n_robots > 0 and lane() == 0:
        starts[3][w] = draw_seed(streams[w])
        steps[w], ends[w] = 0, how[2]
    barrier()
    restart_world(ticking[0], ticking[1], starts, how[3], ticking[2], w, n_robots)


def decide_at_once(  # noqa: PLR0913 what is read, what is written, and how
    ticking: Ticking,
    acting: Acting,
    crediting: Crediting,
    observing: Observed,
    clock: Clock,
    starts: Arrays,
    how: How,
    out: Out,
    which: Span,
) -> None:
    """One decision of every world, and the beginning of the next episode where one is over.

    A world of a refused action stands until the refusal is raised. Free names: lanes, and those of
    the row templates.
    """
    fields, scaling, additions, frames = observing
    last = which[1]
    for each in range(first_world(which[0]), end_world(last)):
        w = min(each, last - 1)
        learners = acting[1][: acting[1].shape[0] if each < last else 0]
        n_robots = ticking[0][0].shape[1] if each < last else 0
        mode = act_in_world(ticking, acting, crediting, w, learners, n_robots)
        for part in range(how[1]):
            n, n_ticks = 0 if mode == STANDS else n_robots, how[0] if part == 0 else 1
            if part == 1:
                begin_episode(ticking, clock, starts, how, w, n)
            run_world(ticking[0], ticking[1], mode, ticking[2], w, n, n_ticks)
            if part == 0:
                settle_in_world(ticking, crediting, clock, out, w, learners, n_robots)
            beside = additions, share_left(clock[0][w], clock[1][w]), acting[4]
            rows = out[1][part], frames, out[2][part]
            observe_in_world(fields, learners, scaling, beside, mode, rows, w)
            mode = BEGINS if n_robots > 0 and out[3][w] else STANDS
            barrier()


@inlined
def share_left(steps: int, end: int) -> float:
    """The share of an episode that is left, as `Episodes.share_left` tells it."""
    return 1.0 - min(steps / max(end, 1), 1.0)


class WholeDecision(Decisions):
    """The decisions of worlds on a GPU, each in one launch."""

    _worlds: DeviceLoop

    def __init__(
        self,
        worlds: DeviceLoop,
        form: PolicyForm,
        learners: Int64[Array, " learners"],
        episodes: Episodes,
    ) -> None:
        super().__init__(worlds, form, learners)
        self._episodes, phi = episodes, form.task.potential
        clock = episodes.steps, episodes.ends, episodes.streams
        self._clock = tuple(map(worlds.memory.to_device, clock))
        functions = {
            **worlds.functions,
            **form.action.functions,
            "check_actions": self._allowed,
            "potential": phi.of if self._terms[1] > 0.0 and phi else no_potential,
        }
        self._decide = worlds.kernel(decide_at_once, functions)

    def room(self) -> tuple[PlacedArray, ...]:
        """Room for what a decision gives, as `Out`; another one overwrites it."""
        empty = self._worlds.memory.empty
        rewards = empty((2, *self._rows), np.float64)
        return rewards, *self.observing.room(2), empty(self._rows[:1], np.bool_)

    def catch_up(self) -> None:
        """Tell the GPU of decisions and streams that the CPU has set."""
        episodes = self._episodes
        if episodes.is_ahead:
            clock = episodes.steps, episodes.ends, episodes.streams
            for there, here in zip(self._clock, clock, strict=True):
                self._worlds.memory.write(there, here)
            episodes.is_ahead = False

    def __call__(
        self, actions: PlacedArray, n_ticks: int, length: int, out: tuple[PlacedArray, ...]
    ) -> None:
        """One decision; a length other than 0 resets ended worlds, for episodes of that length.

        Nothing but a launch on arrays that stay, which a CUDA graph can repeat.
        """
        worlds = self._worlds
        acting = self._fields, self._learners, actions, self._conversion, self.raw, self._limits
        crediting = self._potentials, self._terms, self._earned
        how = n_ticks, 2 if length else 1, length, worlds.layers.noise
        observing, clock = self.observing.handed, self._clock
        self._decide(worlds.ticking, acting, crediting, observing, clock, worlds.starts, how, out)

"""A step of an environment on a GPU: actions in, observations and rewards out, a thread a learner.

Templates over the same grid as those of the worlds. An action of the caller's is read only.
"""

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64, Int8, Int64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.envs.frames import fill_frames, push_frame
from swarm_forage_env.envs.observations import normalise_row, write_direction
from swarm_forage_env.envs.rewards import mean_of, shaping
from swarm_forage_env.interface import Kernel
from swarm_forage_env.observed_fields import Spans, Words
from swarm_forage_env.record import Numbers
from swarm_forage_env.ticks import REFUSED, note

lane: Kernel
lanes: Kernel
barrier: Kernel
first_world: Kernel
command: Kernel
put: Kernel
potential: Kernel
log: Kernel
"""Free names of the templates: lanes, a form of steering, functions of an addition to an
observation, and of a task."""

HALF, ONE = np.float32(0.5), np.float32(1.0)


@kernel
def as_given(first: float, second: float, sharpest_turn: float) -> tuple[float, float]:
    """The two numbers are the command."""
    return first, second


def check_actions(
    given: Float32[Array, "worlds learners numbers"],
    low: Float32[Array, " numbers"],
    high: Float32[Array, " numbers"],
    trouble: Int64[Array, " worlds_and_one"],
) -> None:
    """Note a world in which a number of an action is not within its bounds; NaN is not.

    Free names: lanes.
    """
    w = first_world(0)
    n = given.shape[1] if w < given.shape[0] else 0
    for learner in range(lane(), n, lanes()):
        for k in range(given.shape[2]):
            if not low[k] <= given[w, learner, k] <= high[k]:
                note(trouble, w, REFUSED, 0)


def check_choices(
    given: Int64[Array, "worlds learners"], n_choices: int, trouble: Int64[Array, " worlds_and_one"]
) -> None:
    """Note a world in which there is no such choice. Free names: lanes."""
    w = first_world(0)
    n = given.shape[1] if w < given.shape[0] else 0
    for learner in range(lane(), n, lanes()):
        if not 0 <= given[w, learner] < n_choices:
            note(trouble, w, REFUSED, 0)


@kernel
def write_fields(
    row: Float32[Array, " numbers"],
    robots: Float32[Array, " words"],
    minds: Float32[Array, " words"],
    n_robots: int,
    i: int,
    spans: Spans,
) -> None:
    """Write an action to the records of robot i of a world."""
    for s in range(spans.shape[0]):
        words = minds if spans[s, 0] else robots
        size = np.uint64(words.shape[0]) // np.uint64(n_robots)
        at = np.uint64(i) * size + spans[s, 1]
        for k in range(spans[s, 2]):
            words[at + k] = row[spans[s, 3] + k]


@kernel
def read_fields(
    robots: Float32[Array, " words"],
    minds: Float32[Array, " words"],
    n_robots: int,
    i: int,
    spans: Spans,
    row: Float32[Array, " numbers"],
) -> None:
    """Write the fields of robot i of a world to an observation."""
    for s in range(spans.shape[0]):
        words = minds if spans[s, 0] else robots
        size = np.uint64(words.shape[0]) // np.uint64(n_robots)
        at = np.uint64(i) * size + spans[s, 1]
        for k in range(spans[s, 2]):
            row[spans[s, 3] + k] = words[at + k]


def take_choices(  # noqa: PLR0913 what an action is, and where it goes
    robots: Words,
    minds: Words,
    n_robots: int,
    spans: Spans,
    learners: Int64[Array, " learners"],
    given: Int64[Array, "worlds learners"],
    choices: Float32[Array, "choices numbers"],
    raw: Float32[Array, "worlds learners numbers"],
) -> None:
    """Write the actions that the learners have chosen. Free names: lanes."""
    w = first_world(0)
    n = given.shape[1] if w < given.shape[0] else 0
    for learner in range(lane(), n, lanes()):
        row, chosen = raw[w, learner], given[w, learner]
        for k in range(row.shape[0]):
            row[k] = choices[chosen, k]
        write_fields(row, robots[w], minds[w], n_robots, learners[learner], spans)


def take_actions(  # noqa: PLR0913 what an action is, and where it goes
    robots: Words,
    minds: Words,
    n_robots: int,
    spans: Spans,
    learners: Int64[Array, " learners"],
    given: Float32[Array, "worlds learners numbers"],
    raw: Float32[Array, "worlds learners numbers"],
    n_symmetric: int,
    steers_at: int,
    sharpest_turn: float,
) -> None:
    """Write the actions of the learners.

    The first `n_symmetric` numbers are weights in [-1, 1]; those from `steers_at` on, if it is not
    negative, steer. Free names: lanes, command.
    """
    w = first_world(0)
    n = given.shape[1] if w < given.shape[0] else 0
    for learner in range(lane(), n, lanes()):
        row = raw[w, learner]
        for k in range(given.shape[2]):
            number = given[w, learner, k]
            row[k] = HALF * (number + ONE) if k < n_symmetric else number
        if steers_at >= 0:
            left, right = command(row[steers_at], row[steers_at + 1], sharpest_turn)
            row[steers_at], row[steers_at + 1] = left, right
        write_fields(row, robots[w], minds[w], n_robots, learners[learner], spans)


def stop_at_exchanges(
    worlds: Array,
    minds: Array,
    learners: Int64[Array, " learners"],
    ends: Int64[Array, " worlds"],
    runs: Int8[Array, " worlds"],
    ticks: Int64[Array, " worlds"],
) -> None:
    """Let the worlds stand whose time is up, or in which a learner has just ended an exchange.

    `ticks` is how many each world has behind it. Free names: lanes.
    """
    w = first_world(0)
    n = learners.shape[0] if w < runs.shape[0] and runs[w] else 0
    for learner in range(lane(), n, lanes()):
        world: Numbers = worlds[w]
        ticks[w] = world.ticks
        if world.ticks >= ends[w] or minds[w, learners[learner]].exchange.is_valid:
            runs[w] = 0


def write_acts(
    minds: Array,
    learners: Int64[Array, " learners"],
    out: Float64[Array, "worlds learners"],
) -> None:
    """Write 1 for a learner whose next action counts, as it has just ended an exchange; else 0.

    Free names: lanes.
    """
    w = first_world(0)
    n = out.shape[1] if w < out.shape[0] else 0
    for learner in range(lane(), n, lanes()):
        out[w, learner] = minds[w, learners[learner]].exchange.is_valid


def begin(
    robots: Array,
    worlds: Array,
    is_new: Int8[Array, " worlds"],
    raw: Float32[Array, "worlds learners numbers"],
    potentials: Float64[Array, "worlds robots"],
) -> None:
    """Forget the last actions in new worlds, and note the potential of every robot.

    Free names: lanes, potential.
    """
    w = first_world(0)
    is_world = w < robots.shape[0]
    first, step = lane(), lanes()
    for learner in range(first, raw.shape[1] if is_world and is_new[w] else 0, step):
        for k in range(raw.shape[2]):
            raw[w, learner, k] = 0.0
    for i in range(first, robots.shape[1] if is_world else 0, step):
        potentials[w, i] = potential(robots[w, i], worlds[w])


def credit(  # noqa: PLR0913 what was earned, what is given for it, and to whom
    robots: Array,
    worlds: Array,
    learners: Int64[Array, " learners"],
    earned: Float64[Array, "worlds robots"],
    potentials: Float64[Array, "worlds robots"],
    shaped: Float64[Array, "2 worlds robots"],
    discount: float,
    weight: float,
    is_team: bool,
    out: Float64[Array, "2 worlds learners"],
) -> None:
    """Write what every learner is given, its own or its team's mean: unshaped, then shaped.

    What was earned is forgotten, and the potential noted from which the next step begins.
    Free names: lanes, potential.
    """
    w = first_world(0)
    is_world = w < robots.shape[0]
    first, step = lane(), lanes()
    for i in range(first, robots.shape[1] if is_world else 0, step):
        shaped[0, w, i] = shaped[1, w, i] = earned[w, i]
        earned[w, i] = 0.0
        if weight > 0.0:
            after = potential(robots[w, i], worlds[w])
            shaped[1, w, i] += shaping(potentials[w, i], after, discount, weight)
            potentials[w, i] = after
    barrier()
    for learner in range(first, learners.shape[0] if is_world else 0, step):
        for k in range(2):
            own = shaped[k, w, learners[learner]]
            out[k, w, learner] = mean_of(shaped[k, w]) if is_team else own


def show_layer(  # noqa: PLR0913 what an observation is written from, and where it goes
    robots: Words,
    minds: Words,
    n_robots: int,
    spans: Spans,
    learners: Int64[Array, " learners"],
    direction: Int64[Array, "2"],
    out: Float32[Array, "worlds learners numbers"],
) -> None:
    """Write what the layer of every learner is shown.

    `direction` is where the observed target starts, or -1, and where its direction goes.
    Free names: lanes.
    """
    w = first_world(0)
    n = out.shape[1] if w < out.shape[0] else 0
    for learner in range(lane(), n, lanes()):
        row = out[w, learner]
        read_fields(robots[w], minds[w], n_robots, learners[learner], spans, row)
        if direction[0] >= 0:
            write_direction(row, direction[0], direction[1])


def add_part(  # noqa: PLR0913 what an addition is written from, and where it goes
    learners: Int64[Array, " learners"],
    n_robots: int,
    time_left: Float64[Array, " worlds"],
    raw: Float32[Array, "worlds learners numbers"],
    first: int,
    last: int,
    out: Float32[Array, "worlds learners numbers"],
) -> None:
    """Write an addition to what every learner observes, in the columns first .. last - 1.

    Free names: lanes, put.
    """
    w = first_world(0)
    n = out.shape[1] if w < out.shape[0] else 0
    for learner in range(lane(), n, lanes()):
        row = out[w, learner, first:last]
        put(learners[learner], n_robots, time_left[w], raw[w, learner], row)


def normalise(
    bound: Float32[Array, " numbers"],
    squashes: Array,
    out: Float32[Array, "worlds learners numbers"],
) -> None:
    """Normalise what every learner observes. Free names: lanes."""
    w = first_world(0)
    n = out.shape[1] if w < out.shape[0] else 0
    for learner in range(lane(), n, lanes()):
        normalise_row(out[w, learner], bound, squashes)


def stack_frames(
    seen: Float32[Array, "worlds learners numbers"],
    is_new: Int8[Array, " worlds"],
    is_step: bool,
    kept: Float32[Array, "worlds learners frames numbers"],
    out: Float32[Array, "worlds learners all"],
) -> None:
    """Write the last observations of every learner.

    A step adds one in every world; without one, it is all of them in new worlds. Free names: lanes.
    """
    w = first_world(0)
    n = out.shape[1] if w < out.shape[0] else 0
    for learner in range(lane(), n, lanes()):
        frames = kept[w, learner]
        if is_step:
            push_frame(frames, seen[w, learner])
        elif is_new[w]:
            fill_frames(frames, seen[w, learner])
        for frame in range(frames.shape[0]):
            for k in range(frames.shape[1]):
                out[w, learner, frame * frames.shape[1] + k] = frames[frame, k]


def write_log(
    robots: Array,
    minds: Array,
    worlds: Array,
    learners: Int64[Array, " learners"],
    out: Float64[Array, "worlds learners infos"],
) -> None:
    """Write what is logged of each learner. Free names: lanes, log."""
    w = first_world(0)
    n = out.shape[1] if w < out.shape[0] else 0
    for learner in range(lane(), n, lanes()):
        i = learners[learner]
        log(robots[w, i], minds[w, i], worlds[w], out[w, learner])

"""Kernels of a decision of the learners, shared by CPU and GPU: actions in, observations out.

    act -> [ticks] -> settle -> observe

Each is a template over worlds (`swarm_forage_env.lanes`); `whole_decision` runs all in one launch.
The array of actions is read-only.
"""

from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64, Int8, Int64
from swarm_forage_env.compiler import inlined, kernel
from swarm_forage_env.envs.extra_observations import write_additions
from swarm_forage_env.envs.rewards import mean_of, shaping
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.interface import Kernel
from swarm_forage_env.observed_fields import Fields, read_fields, write_fields
from swarm_forage_env.record import Numbers
from swarm_forage_env.templates import row_template
from swarm_forage_env.ticks import N_ERRORS, REFUSED, RUN, SKIP, START, Errors, note

lane: Kernel
lanes: Kernel
barrier: Kernel
first_world: Kernel
end_world: Kernel
write_raw: Kernel
command: Kernel
potential: Kernel
log: Kernel
check_actions: Kernel
"""Free names of the templates: lanes; check and conversion of actions; and functions of a task."""

HALF, ONE = np.float32(0.5), np.float32(1.0)

Form = tuple[Float32[Array, "choices numbers"], int, int, float]
"""Layer inputs of each choice; number of leading weights given in [-1, 1]; index of the first of
two steering features, or -1; and the sharpest turn, or the share of a residual."""

Scaling = tuple[int, int, bool, Float32[Array, " numbers"], Array]
"""Index of the observed target, or -1; index of its direction; whether the direction of the random
walk is already there; typical size of each feature, empty without normalisation; and whether each
feature is squashed."""

Span = tuple[int, int]
"""Range of worlds: the first, and the last + 1."""

Rows = Float32[Array, "worlds learners numbers"]

Terms = tuple[float, float, bool]
"""Discount and weight of the shaping, and whether rewards are the mean over the team."""

State = tuple[Array, Array, Errors]
"""Records of the robots and of the worlds, and the error of each world."""

ActionArrays = tuple[Fields, Int64[Array, " learners"], Array, Form, Rows, Any]
"""Target fields, learners, actions, conversion, layer inputs, and bounds or number of choices."""

RewardArrays = tuple[Float64[Array, "worlds robots"], Terms, Float64[Array, "worlds robots"]]
"""Potentials before the ticks, terms of the reward, and accumulated rewards."""


@kernel
def as_command(first: float, second: float, sharpest_turn: float) -> tuple[float, float]:
    """Return the two steering features as the command."""
    return first, second


@kernel
def share_of_command(first: float, second: float, share: float) -> tuple[float, float]:
    """Return a share of the two steering features as the command."""
    return share * first, share * second


@row_template
def raw_of_continuous(actions: Rows, w: int, learner: int, form: Form, row: Array) -> None:
    """Write the layer inputs of a continuous action."""
    _, n_symmetric, steers_at, by = form
    for k in range(row.shape[0]):
        number = actions[w, learner, k]
        row[k] = HALF * (number + ONE) if k < n_symmetric else number
    if steers_at >= 0:
        left, right = command(row[steers_at], row[steers_at + 1], by)
        row[steers_at], row[steers_at + 1] = left, right


@inlined
def raw_of_discrete(
    actions: Int64[Array, "worlds learners"], w: int, learner: int, form: Form, row: Array
) -> None:
    """Write the layer inputs of a discrete action."""
    for k in range(row.shape[0]):
        row[k] = form[0][actions[w, learner], k]


def convert(actions: Rows, form: Form, raw: Rows, span: Span) -> None:
    """Write the layer inputs of the actions of a policy."""
    for w in range(first_world(span[0]), min(end_world(span[1]), span[1])):
        for learner in range(lane(), raw.shape[1], lanes()):
            write_raw(actions, w, learner, form, raw[w, learner])


@row_template
def check_numbers(
    actions: Rows,
    bounds: tuple[Float32[Array, " numbers"], Float32[Array, " numbers"]],
    errors: Errors,
    w: int,
    n_learners: int,
) -> None:
    """Note REFUSED for a world in which an action is NaN or out of bounds."""
    low, high = bounds
    for learner in range(lane(), n_learners, lanes()):
        for k in range(actions.shape[2]):
            if not low[k] <= actions[w, learner, k] <= high[k]:
                note(errors, w, REFUSED, 0)


@row_template
def check_choices(
    actions: Int64[Array, "worlds learners"],
    n_choices: int,
    errors: Errors,
    w: int,
    n_learners: int,
) -> None:
    """Note REFUSED for a world in which an action is not the index of a choice."""
    for learner in range(lane(), n_learners, lanes()):
        if not 0 <= actions[w, learner] < n_choices:
            note(errors, w, REFUSED, 0)


@inlined
def no_potential(robot: object, world: object) -> float:
    """Return 0, the potential without shaping."""
    return 0.0


@row_template
def act_in_world(
    state: State,
    action_arrays: ActionArrays,
    reward_arrays: RewardArrays,
    w: int,
    learners: Int64[Array, " learners"],
    n_robots: int,
) -> int:
    """Check the actions of a world's learners and write them; return the mode of the world."""
    robots, worlds, errors = state
    fields, _, actions, form, raw, limits = action_arrays
    potentials, terms, rewards = reward_arrays
    n = learners.shape[0]
    check_actions(actions, limits, errors, w, n)
    barrier()
    is_refused = errors[w] % N_ERRORS == REFUSED
    for learner in range(lane(), 0 if is_refused else n, lanes()):
        write_raw(actions, w, learner, form, raw[w, learner])
        write_fields(raw[w, learner], fields, w, learners[learner])
    for i in range(lane(), n_robots, lanes()):
        rewards[w, i] = 0.0
        if terms[1] > 0.0:
            potentials[w, i] = potential(robots[w, i], worlds[w])
    barrier()
    return SKIP if is_refused or n_robots == 0 else RUN


def act(state: State, action_arrays: ActionArrays, reward_arrays: RewardArrays, span: Span) -> None:
    """Write the actions of the learners to their layers, and set the rewards to zero."""
    last = span[1]
    for each in range(first_world(span[0]), end_world(last)):
        w = min(each, last - 1)
        learners = action_arrays[1][: action_arrays[1].shape[0] if each < last else 0]
        n_robots = state[0].shape[1] if each < last else 0
        act_in_world(state, action_arrays, reward_arrays, w, learners, n_robots)


@row_template
def settle_in_world(
    state: State,
    reward_arrays: RewardArrays,
    out: Float64[Array, "2 worlds learners"],
    w: int,
    learners: Int64[Array, " learners"],
    n_robots: int,
) -> None:
    """Write the reward of every learner, its own or the team's mean: unshaped, then shaped.

    The shaped rewards of the robots overwrite the potentials before the ticks.
    """
    robots, worlds, _ = state
    potentials, (discount, weight, is_team), rewards = reward_arrays
    shaped = potentials[w] if weight > 0.0 else rewards[w]
    for i in range(lane(), n_robots if weight > 0.0 else 0, lanes()):
        after = potential(robots[w, i], worlds[w])
        shaped[i] = rewards[w, i] + shaping(potentials[w, i], after, discount, weight)
    barrier()
    for learner in range(lane(), learners.shape[0], lanes()):
        i = learners[learner]
        out[0, w, learner] = mean_of(rewards[w]) if is_team else rewards[w, i]
        out[1, w, learner] = mean_of(shaped) if is_team else shaped[i]


def settle(
    state: State,
    reward_arrays: RewardArrays,
    learners: Int64[Array, " learners"],
    out: Float64[Array, "2 worlds learners"],
    span: Span,
) -> None:
    """Write the rewards of every learner after the ticks of a decision."""
    last = span[1]
    for each in range(first_world(span[0]), end_world(last)):
        w = min(each, last - 1)
        acting = learners[: learners.shape[0] if each < last else 0]
        n_robots = state[0].shape[1] if each < last else 0
        settle_in_world(state, reward_arrays, out, w, acting, n_robots)


def stop_at_exchanges(  # noqa: PLR0913 inputs and outputs
    worlds: Array,
    minds: Array,
    learners: Int64[Array, " learners"],
    ends: Int64[Array, " worlds"],
    modes: Int8[Array, " worlds"],
    ticks: Int64[Array, " worlds"],
    span: Span,
) -> None:
    """Count ticks; stop worlds that are over, or in which a learner has just ended an exchange."""
    for w in range(first_world(span[0]), min(end_world(span[1]), span[1])):
        n_learners = learners.shape[0] if modes[w] == RUN else 0
        for learner in range(lane(), n_learners, lanes()):
            world: Numbers = worlds[w]
            ticks[w] = world.ticks
            if world.ticks >= ends[w] or minds[w, learners[learner]].exchange.is_valid:
                modes[w] = 0


def write_acts(
    minds: Array,
    learners: Int64[Array, " learners"],
    out: Float64[Array, "worlds learners"],
    span: Span,
) -> None:
    """Write 1 for each learner that has just ended an exchange and acts next, else 0."""
    for w in range(first_world(span[0]), min(end_world(span[1]), span[1])):
        for learner in range(lane(), out.shape[1], lanes()):
            out[w, learner] = minds[w, learners[learner]].exchange.is_valid


def observe(  # noqa: PLR0913 inputs and outputs
    fields: Fields,
    learners: Int64[Array, " learners"],
    scaling: Scaling,
    extras: tuple[Int64[Array, "additions 2"], Float64[Array, " worlds"], Rows],
    modes: Int8[Array, " worlds"],
    rows: tuple[Rows, Float32[Array, "worlds learners frames numbers"], Rows],
    span: Span,
) -> None:
    """Write the observations of every learner.

    `rows` are the single observations, the stacks kept between calls, and the stacked observations.
    `extras` are the named additions, the remaining share of the episode, and the last actions,
    which mode START sets to zero. Mode RUN appends to the stacks, mode SKIP keeps them.
    """
    additions, time_left, raw = extras
    for w in range(first_world(span[0]), min(end_world(span[1]), span[1])):
        now = additions, time_left[w], raw
        observe_in_world(fields, learners, scaling, now, modes[w], rows, w)


@row_template
def observe_in_world(  # noqa: PLR0913 inputs, outputs and world
    fields: Fields,
    learners: Int64[Array, " learners"],
    scaling: Scaling,
    extras: tuple[Int64[Array, "additions 2"], float, Rows],
    mode: int,
    rows: tuple[Rows, Float32[Array, "worlds learners frames numbers"], Rows],
    w: int,
) -> None:
    """Write the observations of every learner of one world, as `observe` does."""
    additions, time_left, raw = extras
    observed, stacks, out = rows
    read_fields(fields, w, learners, observed[w])
    for learner in range(lane(), learners.shape[0], lanes()):
        row, action, i = observed[w, learner], raw[w, learner], learners[learner]
        if mode == START:
            for k in range(action.shape[0]):
                action[k] = 0.0
        if scaling[0] >= 0:
            write_direction(row, scaling[0], scaling[1], scaling[2])
        write_additions(additions, i, fields[4], time_left, action, row)
        if scaling[3].shape[0] > 0:
            normalise_row(row, scaling[3], scaling[4])
        if stacks.shape[2] > 0:
            update_frames(stacks[w, learner], row, mode, out[w, learner])


@inlined
def update_frames(
    stack: Float32[Array, "frames numbers"],
    observed: Float32[Array, " numbers"],
    mode: int,
    out: Float32[Array, " all"],
) -> None:
    """Write a learner's stacked observations, oldest first: RUN appends one, START fills all."""
    n_frames, n = stack.shape
    for frame in range(n_frames):
        for k in range(n):
            if mode == START or (mode == RUN and frame == n_frames - 1):
                stack[frame, k] = observed[k]
            elif mode == RUN:
                stack[frame, k] = stack[frame + 1, k]
            out[frame * n + k] = stack[frame, k]


@inlined
def write_direction(row: Float32[Array, " numbers"], at: int, to: int, has_walk: bool) -> None:
    """Write the unit vector of the two features at index `at` to index `to`.

    For a zero vector, keep the direction of the random walk if `has_walk`, else write zeros.
    """
    x, y = row[at], row[at + 1]
    size = hypot(x, y)
    if size > 0.0:
        row[to], row[to + 1] = x / size, y / size
    elif not has_walk:
        row[to] = row[to + 1] = 0.0


@inlined
def normalise_row(
    row: Float32[Array, " numbers"], bound: Float32[Array, " numbers"], squashes: Array
) -> None:
    """Normalise in place: divide each feature by its bound, or squash it with its scale."""
    for k in range(row.shape[0]):
        if squashes[k]:
            row[k] = row[k] / (abs(row[k]) + bound[k])
        else:
            row[k] = row[k] / bound[k]


def write_log(
    robots: Array,
    minds: Array,
    worlds: Array,
    learners: Int64[Array, " learners"],
    out: Float64[Array, "worlds learners infos"],
    span: Span,
) -> None:
    """Write the logged values of each learner; those that are not logged are 0."""
    for w in range(first_world(span[0]), min(end_world(span[1]), span[1])):
        for learner in range(lane(), out.shape[1], lanes()):
            i, row = learners[learner], out[w, learner]
            for k in range(row.shape[0]):
                row[k] = 0.0
            log(robots[w, i], minds[w, i], worlds[w], row)

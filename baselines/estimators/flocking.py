"""Kernels of localisation: what the weighting and the motion layer are shown of the beliefs."""

import math

import numpy as np

from baselines.estimators.matrices import spectral_norm3
from swarm_forage_env.arrays import Array, Bool, Float32, Float64
from swarm_forage_env.kernels.compiler import kernel
from swarm_forage_env.kernels.frames import to_body
from swarm_forage_env.kernels.steering import seek


@kernel
def describe_correction(  # noqa: PLR0913 inputs first, then the outputs
    seen: Bool[Array, "rows robots"],
    far: Float32[Array, "rows robots"],
    bearing: Float32[Array, "rows robots"],
    pose: Float64[Array, "rows 3"],
    P: Float64[Array, "rows 3 3"],
    out_valid: Bool[Array, " rows"],
    out_neighbours: Float32[Array, " rows"],
    out_own_doubt: Float32[Array, " rows"],
    out_heard_doubt: Float32[Array, " rows"],
    out_disagreement: Float32[Array, " rows"],
) -> None:
    """The correction that all who see or are seen are about to make.

    Where the robot is, by its neighbours, is known from those who see it.
    """
    n_robots = seen.shape[1]
    for i in range(seen.shape[0]):
        first = i // n_robots * n_robots
        n, n_back, doubt, x, y = 0, 0, 0.0, 0.0, 0.0
        for other in range(n_robots):
            j = first + other
            if seen[i, other] or seen[j, i - first]:
                n += 1
                doubt += spectral_norm3(P[j])
            if seen[j, i - first]:
                n_back += 1
                direction = float(bearing[j, i - first]) + pose[j, 2]
                x += pose[j, 0] + far[j, i - first] * math.cos(direction)
                y += pose[j, 1] + far[j, i - first] * math.sin(direction)
        out_valid[i] = n > 0
        out_neighbours[i] = n / n_robots
        out_own_doubt[i] = spectral_norm3(P[i])
        out_heard_doubt[i] = doubt / n if n > 0 else 0.0
        out_disagreement[i] = 0.0
        if n_back > 0:
            out_disagreement[i] = math.hypot(x / n_back - pose[i, 0], y / n_back - pose[i, 1])


@kernel
def away_from_one_by_one(  # noqa: PLR0913 inputs first
    i: int,
    first: int,
    seen: Bool[Array, " robots"],
    reach: float,
    speed: float,
    pose: Float64[Array, "rows 3"],
    velocity: Float64[Array, "rows 2"],
) -> tuple[float, float]:
    """Separation as the authors' code sums it: steered anew after each neighbour.

    After every neighbour the sum is divided by their number so far and replaced by the force
    that seeks its direction, five times a unit vector, so that the last ones weigh most.

    Source: BOIDS, authors' code.
    """
    x, y, dx, dy, n = 0.0, 0.0, 0.0, 0.0, 0
    for other in range(seen.shape[0]):
        if not seen[other]:
            continue
        ax, ay = pose[i, 0] - pose[first + other, 0], pose[i, 1] - pose[first + other, 1]
        d = math.hypot(ax, ay)
        if 0.0 < d < reach:
            n += 1
            x += ax / (d * d)
            y += ay / (d * d)
        if n > 0:
            dx, dy = x / n, y / n
            sx, sy = seek(dx, dy, velocity[i, 0], velocity[i, 1], speed)
            x, y = 5.0 * sx, 5.0 * sy
    return dx, dy


@kernel
def means_of_neighbours(  # noqa: PLR0913 inputs first, then the output
    i: int,
    first: int,
    seen: Bool[Array, " robots"],
    reach: float,
    pose: Float64[Array, "rows 3"],
    velocity: Float64[Array, "rows 2"],
    out: Float64[Array, "3 2"],
) -> int:
    """Mean position, mean velocity and sum of the ways from those seen and believed in reach.

    How many they are; zeros without any.

    Source: BOIDS, Eq. 21 to 23.
    """
    out[:, :] = 0.0
    n = 0
    for other in range(seen.shape[0]):
        j = first + other
        dx, dy = pose[i, 0] - pose[j, 0], pose[i, 1] - pose[j, 1]
        if seen[other] and 0.0 < math.hypot(dx, dy) < reach:
            n += 1
            for k in range(2):
                out[0, k] += pose[j, k]
                out[1, k] += velocity[j, k]
                out[2, k] += pose[i, k] - pose[j, k]
    if n > 0:
        out[:2] /= n
    return n


@kernel
def describe_flock(  # noqa: PLR0913 inputs first, then the outputs
    seen: Bool[Array, "rows robots"],
    compass: Float32[Array, " rows"],
    goal: Float32[Array, "rows 2"],
    numbers: Array,
    reckoned: Float64[Array, "rows 3"],
    pose: Float64[Array, "rows 3"],
    P: Float64[Array, "rows 3 3"],
    velocity: Float64[Array, "rows 2"],
    out_vectors: Float32[Array, "rows 6 2"],
    out_stimuli: Float32[Array, "rows 3"],
) -> None:
    """Vectors (goal, home, centre, crowd, flow, velocity) and stimuli (rho, s, e) of each robot.

    The flow is the neighbours' mean velocity or, as the authors' code has it, their mean
    position; the crowd is the sum of the ways from them, or that of `away_from_one_by_one`.

    Source: BOIDS, Section 4, for the stimuli.
    """
    n_robots = seen.shape[1]
    reach, authors = numbers[0]["reach"], numbers[0]["authors"] > 0.0
    means, ways = np.zeros((3, 2)), np.zeros((6, 2))
    for i in range(seen.shape[0]):
        first = i // n_robots * n_robots
        n = means_of_neighbours(i, first, seen[i], reach, pose, velocity, means)
        for k in range(2):
            ways[0, k] = goal[i, k] - pose[i, k]
            ways[1, k] = -pose[i, k]
            ways[2, k] = means[0, k] - pose[i, k] if n > 0 else 0.0
            ways[3, k] = means[2, k]
            ways[4, k] = means[0, k] if authors else means[1, k]
            ways[5, k] = velocity[i, k]
        if authors:
            speed = numbers[0]["max_speed"]
            ways[3] = away_from_one_by_one(i, first, seen[i], reach, speed, pose, velocity)
        for k in range(6):
            out_vectors[i, k] = to_body(ways[k, 0], ways[k, 1], float(compass[i]))
        out_stimuli[i, 0] = seen[i].sum() / n_robots
        out_stimuli[i, 1] = spectral_norm3(P[i]) / numbers[0]["doubt_max"]
        drift = math.hypot(pose[i, 0] - reckoned[i, 0], pose[i, 1] - reckoned[i, 1])
        out_stimuli[i, 2] = drift / numbers[0]["drift_max"]

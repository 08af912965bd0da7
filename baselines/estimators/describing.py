"""Kernels of social odometry, part three: what the layers are shown of the beliefs."""

import math

from baselines.estimators.beliefs import NOBODY, NOWHERE
from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int8, Int32
from swarm_forage_env.kernels.compiler import kernel
from swarm_forage_env.kernels.frames import to_body


@kernel
def describe_situation(  # noqa: PLR0913 inputs first, then the outputs
    pose: Float64[Array, "rows 3"],
    location: Float64[Array, "rows areas 2"],
    p: Float64[Array, "rows areas"],
    known: Bool[Array, "rows areas"],
    goal: Int8[Array, " rows"],
    look_on: Float64[Array, " rows"],
    partner: Int32[Array, " rows"],
    out_target: Float32[Array, "rows 2"],
    out_areas: Float32[Array, "rows areas 2"],
    out_p: Float32[Array, "rows areas"],
    out_talking: Bool[Array, " rows"],
) -> None:
    """Areas and target in the body frame; zeros for what is unknown.

    At the place where the area should be, the target is the rest of the way straight on.
    """
    for i in range(pose.shape[0]):
        for area in range(2):
            out_areas[i, area, :] = 0.0
            out_p[i, area] = 0.0
            if known[i, area]:
                dx, dy = location[i, area, 0] - pose[i, 0], location[i, area, 1] - pose[i, 1]
                out_areas[i, area, 0], out_areas[i, area, 1] = to_body(dx, dy, pose[i, 2])
                out_p[i, area] = p[i, area]
        out_target[i, :] = 0.0
        if goal[i] != NOWHERE:
            out_target[i, :] = out_areas[i, goal[i]]
            if look_on[i] >= 0.0:
                out_target[i, 0], out_target[i, 1] = look_on[i], 0.0
        out_talking[i] = partner[i] != NOBODY


@kernel
def describe_encounter(  # noqa: PLR0913 inputs first, then the outputs
    ended: Bool[Array, " rows"],
    pose: Float64[Array, "rows 3"],
    location: Float64[Array, "rows areas 2"],
    p: Float64[Array, "rows areas"],
    known: Bool[Array, "rows areas"],
    heard_sum: Float64[Array, "rows areas 2"],
    heard_weight: Float64[Array, "rows areas"],
    heard_p: Float64[Array, "rows areas"],
    range_sum: Float64[Array, " rows"],
    frames: Float64[Array, " rows"],
    out_own_p: Float32[Array, "rows areas"],
    out_heard_p: Float32[Array, "rows areas"],
    out_own_known: Bool[Array, "rows areas"],
    out_heard_known: Bool[Array, "rows areas"],
    out_disagreement: Float32[Array, "rows areas"],
    out_own_distance: Float32[Array, "rows areas"],
    out_heard_distance: Float32[Array, "rows areas"],
    out_range: Float32[Array, " rows"],
    out_frames: Float32[Array, " rows"],
) -> None:
    """The exchanges that ended, in the order told; zeros in all other rows."""
    for i in range(p.shape[0]):
        out_range[i] = range_sum[i] / frames[i] if ended[i] else 0.0
        out_frames[i] = frames[i] if ended[i] else 0.0
        for area in range(2):
            own = ended[i] and known[i, area]
            told = ended[i] and heard_weight[i, area] > 0.0
            out_own_known[i, area] = own
            out_heard_known[i, area] = told
            out_own_p[i, area] = p[i, area] if own else 0.0
            out_heard_p[i, area] = heard_p[i, area] if told else 0.0
            out_disagreement[i, area] = 0.0
            out_own_distance[i, area] = 0.0
            out_heard_distance[i, area] = 0.0
            x, y = location[i, area, 0], location[i, area, 1]
            if own:
                out_own_distance[i, area] = math.hypot(x - pose[i, 0], y - pose[i, 1])
            if told:
                heard_x = heard_sum[i, area, 0] / heard_weight[i, area]
                heard_y = heard_sum[i, area, 1] / heard_weight[i, area]
                away = math.hypot(heard_x - pose[i, 0], heard_y - pose[i, 1])
                out_heard_distance[i, area] = away
                if own:
                    out_disagreement[i, area] = math.hypot(heard_x - x, heard_y - y)

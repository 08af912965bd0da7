"""Localisation against textbook filters: prediction, intersection, decentralised EKF."""

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose, assert_array_equal

from baselines.estimators.covariance_intersection import (
    IntersectionMind,
    fuse,
    intersect,
    weigh_estimates,
)
from baselines.estimators.decentralised_ekf import (
    DecentralisedEKF,
    FilterMind,
    JointUpdate,
    bound_correlation,
    correct_both,
    multiply_factors,
    propagate_factors,
)
from baselines.estimators.pose_prediction import PoseBelief, predict, visit_home
from baselines.estimators.small_matrices import inverse3, spectral_norm3
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.equations.geometry import wrap
from swarm_forage_env.record import one_record, rows
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.waypoints.records import Readings, Sighting

intersect, correct_both = map(entry_point, (intersect, correct_both))

ROBOTS = 4
DT = 0.5
VAR_RANGE, VAR_BEARING = 0.01**2, 0.02**2
EPSILON = 1e-6

ENTRIES = st.floats(-1.0, 1.0).map(lambda x: round(x, 6))
MATRICES = arrays(np.float64, (3, 3), elements=ENTRIES)
COVARIANCES = MATRICES.map(lambda root: root @ root.T + 0.05 * np.eye(3))
ANGLES = st.floats(-math.pi, math.pi, exclude_max=True)


def numbers_of(**changed):
    """The scenario's numbers as the kernels read them, with some of them changed."""
    scenario = find_scenario("waypoints-05", {"n_robots": ROBOTS})
    return rows(one_record(DecentralisedEKF().numbers(scenario) | changed))[0]


NUMBERS = numbers_of()


def one(kind):
    """A single record."""
    return rows(kind.array((1,)))[0]


def crowd_of(kind, robots, **columns):
    """Minds of which some fields are given."""
    crowd = rows(kind.array((robots,)))
    for name, values in columns.items():
        field, _, nested = name.partition("_")
        (crowd[field][nested] if nested else crowd[field])[:] = values
    return crowd


def sight(far, bearing):
    """How one robot sees another."""
    found = one(Sighting)
    found.seen, found.range, found.bearing = True, far, bearing
    return found


def covariance(rng, size=0.05):
    root = rng.normal(size=(3, 3))
    return size * (root @ root.T + 0.3 * np.eye(3))


def jacobian(function, at):
    """By central differences, a column to each input."""
    steps = EPSILON * np.eye(len(at))
    columns = [(function(at + step) - function(at - step)) / (2.0 * EPSILON) for step in steps]
    return np.stack(columns, axis=1)


def least_eigenvalue(P):  # noqa: N803 as in the paper
    return np.linalg.eigvalsh(P).min()


def weights_of(inverses):
    crowd = crowd_of(IntersectionMind, len(inverses), entry_inverse=inverses, entry_weight=9.0)
    weigh_estimates(crowd, len(crowd), np.ones((3, 3)), np.ones((3, 3)))
    return crowd.entry.weight


@given(st.lists(COVARIANCES, min_size=1, max_size=6))
def test_the_weights_of_an_intersection_are_shares_and_those_of_the_paper(covariances):
    inverses = [np.linalg.inv(P) for P in covariances]
    det, S = np.linalg.det, sum(inverses)  # noqa: N806 as in the paper
    total = len(inverses) * det(S) + sum(det(each) - det(S - each) for each in inverses)
    paper = [(det(S) - det(S - each) + det(each)) / total for each in inverses]
    found = weights_of(inverses)
    assert_allclose(found, paper, atol=1e-9)
    assert found.sum() == pytest.approx(1.0)
    assert found.min() >= -1e-12


def fused(inverses, poses, weights):
    columns = {"entry_inverse": inverses, "entry_pose": poses, "entry_weight": weights}
    crowd, out = crowd_of(IntersectionMind, len(inverses), **columns), one(PoseBelief)
    fuse(crowd, len(crowd), np.ones((3, 3)), out)
    return out.pose, out.P


@given(COVARIANCES, COVARIANCES, st.floats(-1.0, 1.0))
def test_an_intersection_is_never_overconfident_whatever_the_correlation(A, B, k):  # noqa: N803
    inverses = [np.linalg.inv(A), np.linalg.inv(B)]
    weights = weights_of(inverses)
    cross = k * np.linalg.cholesky(A) @ np.linalg.cholesky(B).T
    joint = np.block([[A, cross], [cross.T, B]])
    columns = [fused(inverses, unit.reshape(2, 3), weights)[0] for unit in np.eye(6)]
    M = np.stack(columns, axis=1)  # noqa: N806 the fused pose is linear in both
    _, P = fused(inverses, np.zeros((2, 3)), weights)  # noqa: N806 as in the paper
    assert least_eigenvalue(P - M @ joint @ M.T) > -1e-9
    assert_allclose(M[:, :3] + M[:, 3:], np.eye(3), atol=1e-9)


def facing(rng, robots):
    """True poses, beliefs about them, and what robots that see each other measure."""
    true = np.column_stack([rng.uniform(-0.3, 0.3, (robots, 2)), rng.uniform(-3.0, 3.0, robots)])
    P = np.array([covariance(rng) for _ in range(robots)])  # noqa: N806 as in the paper
    pose = true + 0.05 * rng.normal(size=(robots, 3))
    far, bearing = np.zeros((2, robots, robots), np.float32)
    for i in range(robots):
        for j in range(robots):
            if i != j:
                far[i, j], bearing[i, j] = seen_at(np.concatenate([true[i], true[j]]))
    return pose, P, far, bearing


def seen_at(x):
    """Range and bearing at which the first of two poses sees the second."""
    dx, dy = x[3:5] - x[:2]
    return np.array([math.hypot(dx, dy), wrap(math.atan2(dy, dx) - x[2])])


def pose_from(x, far, back, own):
    """What a robot at x believes of the pose of one that it sees, and that sees it."""
    direction = x[2] + back
    there = x[:2] + far * np.array([math.cos(direction), math.sin(direction)])
    return np.array([*there, x[2] + back + math.pi - own])


def intersected(pose, P, far, bearing, g):  # noqa: N803 as in the paper
    """What robots believe that believed, and sent, where they are, and all see each other."""
    columns = {"belief_pose": pose, "belief_P": P, "sent_pose": pose, "sent_P": P}
    crowd = crowd_of(IntersectionMind, len(pose), **columns, exchange_weight=g)
    sightings = Sighting.array(far.shape).view(np.recarray)
    sightings.seen, sightings.range, sightings.bearing = (
        ~np.eye(len(pose), dtype=bool),
        far,
        bearing,
    )
    intersect(crowd, np.zeros(0), sightings, NUMBERS)
    return crowd.belief.pose, crowd.belief.P


@pytest.mark.parametrize("g", [1.0, 0.25, 0.0])
@pytest.mark.parametrize("robots", [2, 4])
def test_a_share_of_an_intersection_is_taken_from_the_weights_of_the_neighbours(robots, g):
    world = facing(np.random.default_rng(robots), robots)
    pose, P, far, bearing = world  # noqa: N806 as in the paper
    after, covariances = intersected(*world, g=g)
    for i in range(robots):
        poses, inverses = [pose[i]], [np.linalg.inv(P[i])]
        for j in [j for j in range(robots) if j != i]:
            measured = np.array([far[j, i], bearing[j, i], bearing[i, j]], float)
            expected = pose_from(pose[j], *measured)
            expected[2] = pose[i, 2] + wrap(expected[2] - pose[i, 2])
            at = np.concatenate([pose[j], measured])
            J = jacobian(lambda x: pose_from(x[:3], *x[3:]), at)  # noqa: N806 a Jacobian
            noise = np.diag([VAR_RANGE, VAR_BEARING, VAR_BEARING])
            heard = J[:, :3] @ P[j] @ J[:, :3].T + J[:, 3:] @ noise @ J[:, 3:].T
            poses.append(expected)
            inverses.append(np.linalg.inv(heard))
        weights = g * weights_of(inverses)
        weights[0] += 1.0 - g
        weighed = [w * each for w, each in zip(weights, inverses, strict=True)]
        information = sum(weighed)
        vector = sum(each @ x for each, x in zip(weighed, poses, strict=True))
        assert_allclose(covariances[i], np.linalg.inv(information), rtol=1e-5, atol=1e-7)
        assert_allclose(after[i], np.linalg.solve(information, vector), atol=1e-6)


def step(x):
    """Where (x, y, theta, speed, turn) leads in a tick: turned first, then gone."""
    theta = x[2] + x[4] * DT
    return np.array([x[0] + x[3] * DT * math.cos(theta), x[1] + x[3] * DT * math.sin(theta), theta])


def inputs(measured):
    """What is left of a measurement in single precision."""
    return np.array(measured, np.float32).astype(float)


@given(COVARIANCES, ANGLES, st.floats(-0.2, 0.7), st.floats(-1.2, 1.2))
def test_a_prediction_propagates_pose_covariance_and_factors(P, theta, speed, turn):  # noqa: N803
    motion, belief, factors = np.array([speed, turn], np.float32), one(PoseBelief), np.array([P])
    at = np.array([0.4, -1.0, theta, *inputs(motion)])
    J = jacobian(step, at)  # noqa: N806 a Jacobian
    noise = np.diag([0.05**2 + 0.005**2, 0.02**2 + 0.05**2])
    expected = J[:, :3] @ P @ J[:, :3].T + J[:, 3:] @ noise @ J[:, 3:].T
    belief.pose[:], belief.P[:] = at[:3], P
    predict(belief, motion, NUMBERS)
    assert_allclose(belief.P, expected, atol=1e-8)
    assert_array_equal(belief.P, belief.P.T)
    there = step(at)
    assert_allclose(belief.pose, [*there[:2], wrap(there[2])], atol=1e-12)
    assert_allclose(belief.velocity, (there[:2] - at[:2]) / DT, atol=1e-9)
    propagate_factors(belief, motion, DT, factors)
    assert_allclose(factors[0], J[:, :3] @ P, atol=1e-8)


def stores(robots=ROBOTS):
    """Everything the decentralised filter works on, with zero covariances and factors."""
    crowd = crowd_of(FilterMind, robots, belief_P=0.0)
    factors = np.zeros((robots, robots, 3, 3))
    return {"crowd": crowd, "pose": crowd.belief.pose, "P": crowd.belief.P, "factors": factors}


def swarm(rng, robots=ROBOTS, size=0.05):
    found = stores(robots)
    found["pose"][:] = rng.uniform(-1.0, 1.0, (robots, 3))
    found["P"][:] = [covariance(rng, size) for _ in range(robots)]
    return found


def relative(s, i, j, far, bearing, g=1.0):
    s["crowd"].exchange.weight[i] = g
    correct_both(s["crowd"], s["factors"], i, j, sight(far, bearing), NUMBERS)


def privately(s, at_home, fix, variance=1e-6):
    numbers, readings = numbers_of(home_variance=variance), one(Readings)
    for i, mind in enumerate(s["crowd"]):
        readings.at_home, readings.home_fix[:] = at_home[i], fix[i]
        visit_home(mind.belief, readings, mind.home, numbers)
        if at_home[i]:
            multiply_factors(mind.home.rest, s["factors"][i])


def moved(s, measured):
    for i, mind in enumerate(s["crowd"]):
        predict(mind.belief, measured[i], NUMBERS)
        propagate_factors(mind.belief, measured[i], DT, s["factors"][i])


def cross(s, i, j):
    return s["factors"][i, j] @ s["factors"][j, i].T


def kalman(x, P, i, j, measured, g=1.0):  # noqa: N803 as in the paper
    """A joint EKF of all robots that corrects by how i sees j, to the share g."""
    at = [*range(3 * i, 3 * i + 3), *range(3 * j, 3 * j + 3)]
    G, R = np.zeros((2, len(x))), np.diag([VAR_RANGE, VAR_BEARING])  # noqa: N806 as in the paper
    G[:, at] = jacobian(seen_at, x[at])
    K = g * P @ G.T @ np.linalg.inv(G @ P @ G.T + R)  # noqa: N806 as in the paper
    residual = measured - seen_at(x[at])
    residual[1] = wrap(residual[1])
    rest = np.eye(len(x)) - K @ G
    return x + K @ residual, rest @ P @ rest.T + K @ R @ K.T


def joint_of(s):
    P = np.zeros((3 * len(s["P"]), 3 * len(s["P"])))  # noqa: N806 as in the paper
    for i, own in enumerate(s["P"]):
        P[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = own
    return s["pose"].ravel().copy(), P


def block(P, i, j):  # noqa: N803 as in the paper
    return P[3 * i : 3 * i + 3, 3 * j : 3 * j + 3]


@pytest.mark.parametrize("pairs", list(product([(0, 1), (1, 0)], [(1, 2), (2, 1)])))
@pytest.mark.parametrize("g", [1.0, 0.4, 0.0])
@pytest.mark.parametrize("seed", range(3))
def test_a_chain_of_three_shares_what_the_joint_filter_says(seed, g, pairs):
    rng = np.random.default_rng(seed)
    s = swarm(rng, robots=3, size=0.002)
    x, P = joint_of(s)  # noqa: N806 as in the paper
    for i, j in pairs:
        pair = np.concatenate([s["pose"][i], s["pose"][j]])
        measured = inputs(seen_at(pair) + np.array([0.01, 0.02]))
        relative(s, i, j, *measured, g=g)
        x, P = kalman(x, P, i, j, measured, g)  # noqa: N806 as in the paper
        assert_allclose(cross(s, i, j), block(P, i, j), atol=1e-8)
        assert_allclose(s["pose"][[i, j]].ravel(), [*x[3 * i : 3 * i + 3], *x[3 * j : 3 * j + 3]])
    assert_allclose(cross(s, 0, 1), block(P, 0, 1), atol=1e-8)
    assert_allclose(s["P"][1:], [block(P, 1, 1), block(P, 2, 2)], atol=1e-8)


@given(COVARIANCES, COVARIANCES, arrays(np.float64, (3, 3), elements=st.floats(-5.0, 5.0)))
def test_a_bounded_correlation_makes_a_joint_covariance(A, B, C):  # noqa: N803 matrices
    update = one(JointUpdate)
    update.cross[:] = C
    bound_correlation(A, B, update)
    found = update.cross
    assert least_eigenvalue(np.block([[A, found], [found.T, B]])) > -1e-9
    most = np.linalg.norm(
        np.linalg.solve(np.linalg.cholesky(A), C) @ np.linalg.inv(np.linalg.cholesky(B)).T, 2
    )
    if most <= 0.99:
        assert_array_equal(found, C)
    elif most > 1.01:
        assert_allclose(found, 0.999 / most * C, rtol=1e-5, atol=1e-9)


@given(st.integers(0, 2**32), st.floats(1e-6, 1.0))
def test_a_private_correction_is_a_kalman_update(seed, variance):
    rng = np.random.default_rng(seed)
    s = swarm(rng)
    s["factors"][:] = rng.normal(size=s["factors"].shape)
    pose, P, factors = (s[name].copy() for name in ("pose", "P", "factors"))  # noqa: N806
    fix = (pose + 0.2 * rng.normal(size=pose.shape)).astype(np.float32)
    privately(s, np.array([True, False, True, False]), fix, variance)
    for i in (0, 2):
        K = P[i] @ np.linalg.inv(P[i] + variance * np.eye(3))  # noqa: N806 as in the paper
        residual = fix[i].astype(float) - pose[i]
        expected = pose[i] + K @ residual
        expected[2] = wrap(expected[2])
        assert_allclose(s["pose"][i], expected, atol=1e-7)
        assert_allclose(s["P"][i], (np.eye(3) - K) @ P[i], atol=1e-7)
        assert_allclose(s["factors"][i], (np.eye(3) - K) @ factors[i], atol=1e-7)
    for name, was in (("pose", pose), ("P", P), ("factors", factors)):
        assert_array_equal(s[name][[1, 3]], was[[1, 3]])


MOVES = st.tuples(
    st.just("move"),
    st.lists(
        st.tuples(st.floats(-0.2, 0.7), st.floats(-1.2, 1.2)), min_size=ROBOTS, max_size=ROBOTS
    ),
)
SHORT = st.floats(-1.0, 1.0)
FIXES = st.tuples(st.just("fix"), st.tuples(st.integers(0, ROBOTS - 1), SHORT, SHORT, ANGLES))
SHARES = st.sampled_from([1.0, 0.3])
SIGHTS = st.tuples(
    st.just("sight"),
    st.tuples(st.permutations(range(ROBOTS)), st.floats(1e-3, 1.0), ANGLES, SHARES),
)
STORIES = st.lists(st.one_of(MOVES, FIXES, SIGHTS, SIGHTS), min_size=1, max_size=30)
PLACES = arrays(np.float64, (ROBOTS, 3), elements=st.floats(-1.0, 1.0))


def carried_out(s, deed, how):
    if deed == "move":
        moved(s, np.array(how, np.float32))
    elif deed == "fix":
        robot, *fix = how
        privately(s, np.arange(ROBOTS) == robot, np.tile(np.array(fix, np.float32), (ROBOTS, 1)))
    else:
        (i, j, *_), far, bearing, g = how
        relative(s, i, j, far, bearing, g)


@given(PLACES, STORIES)
def test_whatever_happens_a_covariance_stays_one(places, story):
    s = stores()
    s["pose"][:] = places
    s["P"][:] = 0.1 * np.eye(3)
    for deed, how in story:
        carried_out(s, deed, how)
        for name in ("pose", "P", "factors"):
            assert np.isfinite(s[name]).all(), name
        for P in s["P"]:  # noqa: N806 as in the paper
            assert_array_equal(P, P.T)
            assert least_eigenvalue(P) >= -1e-12 * np.linalg.norm(P, 2)


def test_a_matrix_without_an_inverse_has_no_finite_one():
    out = np.full((3, 3), 7.0)
    inverse3(np.ones((3, 3)), out)
    assert not np.isfinite(out).any()


@given(MATRICES.map(lambda each: each + each.T))
@example(np.zeros((3, 3)))
@example(np.diag([0.1, 0.1, 0.1]))
@example(np.diag([1.0, 1.0, 3.0]))
@example(np.diag([1.0, 3.0, 3.0]))
@example(np.diag([-5.0, 0.0, 4.0]))
def test_the_spectral_norm_is_the_largest_absolute_eigenvalue(P):  # noqa: N803
    largest = np.abs(np.linalg.eigvalsh(P)).max()
    assert spectral_norm3(P) == pytest.approx(largest, rel=1e-7, abs=1e-9)

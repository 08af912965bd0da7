"""Elementary functions: how far from the true value, what of special arguments, and no libm."""

import math
import re

import numpy as np
import pytest
from numba.core import config

from swarm_forage_env.compiler import kernel, plain
from swarm_forage_env.equations import elementary
from swarm_forage_env.equations.elementary import MAX_ANGLE

N = 1_000 if config.DISABLE_JIT else 300_000
RNG = np.random.default_rng(0)

needs_longdouble = pytest.mark.skipif(
    np.finfo(np.longdouble).nmant < 63, reason="no type with more digits than float64"
)
needs_machine_code = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="looks at machine code")


def sizes(low, high):
    """Arguments of all sizes from low to high, of both signs."""
    return np.exp(RNG.uniform(np.log(low), np.log(high), N)) * RNG.choice([-1.0, 1.0], N)


def quarter_turns():
    """The float64 around each multiple of pi / 2, whose sine or cosine is hardest to have."""
    n = np.arange(1, int(MAX_ANGLE / (0.5 * math.pi)))[-N:]
    near = (n * (0.5 * np.longdouble(np.pi) + 0.5 * elementary._PI_LOW)).astype(float)
    return np.concatenate([near, np.nextafter(near, 0.0), -np.nextafter(near, np.inf)])


ANGLES = [RNG.uniform(-10.0, 10.0, N), RNG.uniform(-MAX_ANGLE, MAX_ANGLE, N), quarter_turns()]
PAIRS = [
    (RNG.uniform(-1.0, 1.0, N), RNG.uniform(-1.0, 1.0, N)),
    (sizes(1e-3, 1e3), sizes(1e-3, 1e3)),
    (sizes(1e-320, 1.7e308), sizes(1e-320, 1.7e308)),
    (sizes(1e-320, 1e-300), sizes(1e-320, 1e-300)),
    (sizes(1e300, 1.7e308), sizes(1e300, 1.7e308)),
]

CASES = {
    "sin": (np.sin, 0.8, [*ANGLES, sizes(1e-310, 1e6)]),
    "cos": (np.cos, 0.8, [*ANGLES, sizes(1e-310, 1e6)]),
    "atan2": (np.arctan2, 1.5, PAIRS),
    "hypot": (np.hypot, 1.2, PAIRS),
    "exp": (np.exp, 0.9, [RNG.uniform(-1.0, 1.0, N), RNG.uniform(-708.0, 709.7, N)]),
    "log": (np.log, 0.9, [RNG.uniform(0.0, 1.0, N), RNG.uniform(0.5, 2.0, N)]),
    "log1p": (np.log1p, 0.9, [RNG.uniform(-1.0, 1.0, N), sizes(1e-300, 1.0), sizes(1e-9, 1.0)]),
    "tanh": (np.tanh, 1.5, [RNG.uniform(-1.0, 1.0, N), sizes(1e-300, 30.0)]),
    "acos": (np.arccos, 2.5, [RNG.uniform(-1.0, 1.0, N), 1.0 - np.abs(sizes(1e-16, 1.0))]),
}
"""The true function, the largest error [ulp] and arguments."""
CASES["log"][2].append(np.abs(sizes(1e-320, 1e308)))
CASES["log1p"][2].append(np.abs(sizes(1e-3, 1e308)))

SPECIAL = np.array(
    [0.0, 1.0, 5e-324, 2e-308, 1e-20, 0.5, 22.0, MAX_ANGLE, 709.78, 745.1, 745.2, 1e9, math.inf]
)
SPECIAL = np.concatenate([SPECIAL, -SPECIAL, [1.7e308, math.nan]])


def loop(name):
    """The function on arrays of arguments, as a compiled loop."""
    function = getattr(elementary, name)

    def of_one(xs, out):
        for i in range(xs.shape[0]):
            out[i] = function(xs[i])

    def of_two(ys, xs, out):
        for i in range(xs.shape[0]):
            out[i] = function(ys[i], xs[i])

    return kernel(of_two if name in {"atan2", "hypot"} else of_one)


def values(name, *arguments):
    """What the compiled function gives for arrays of arguments."""
    out = np.empty_like(arguments[0])
    loop(name)(*arguments, out)
    return out


def arguments_of(name):
    """Arrays of arguments of a function, as tuples."""
    return [each if isinstance(each, tuple) else (each,) for each in CASES[name][2]]


@needs_longdouble
@pytest.mark.parametrize("name", CASES)
def test_errors_are_as_small_as_said(name):
    true_function, bound, _ = CASES[name]
    for arguments in arguments_of(name):
        with np.errstate(over="ignore"):
            true = true_function(*(each.astype(np.longdouble) for each in arguments))
            rounded = true.astype(float)
        found, finite = values(name, *arguments), np.isfinite(rounded)
        errors = np.abs(found - true)[finite] / np.spacing(np.abs(rounded[finite]))
        assert errors.max() < bound
        assert (found == rounded)[~finite].all()


@pytest.mark.parametrize("name", CASES)
def test_special_arguments_give_what_c_gives(name):
    true_function = CASES[name][0]
    is_pair = name in {"atan2", "hypot"}
    grid = [each.ravel() for each in np.meshgrid(SPECIAL, SPECIAL)] if is_pair else [SPECIAL]
    found = values(name, *grid)
    with np.errstate(all="ignore"):
        true = true_function(*grid)
    if name in {"sin", "cos"}:
        true[np.abs(SPECIAL) > MAX_ANGLE] = math.nan
    np.testing.assert_allclose(found, true, rtol=4.5e-16, atol=5e-324)
    assert (np.signbit(found) == np.signbit(true))[~np.isnan(true)].all()


def test_e_to_a_power_that_is_hardly_a_number_is_right_to_the_last_one():
    xs = np.linspace(-745.2, -708.0, 10_000)
    with np.errstate(under="ignore"):
        assert np.abs(values("exp", xs) - np.exp(xs)).max() <= 5e-324


@pytest.mark.parametrize("name", CASES)
def test_compiled_and_plain_functions_agree_bit_for_bit(name):
    function = plain(getattr(elementary, name))
    for arguments in arguments_of(name):
        few = [each[:500] for each in arguments]
        one_by_one = [function(*map(float, each)) for each in zip(*few, strict=True)]
        assert values(name, *few).tobytes() == np.array(one_by_one).tobytes()


@pytest.mark.parametrize("name", CASES)
def test_a_float32_is_taken_as_the_float64_that_it_is(name):
    for arguments in arguments_of(name)[:1]:
        few = [each[:500].astype(np.float32) for each in arguments]
        out, again = np.empty(500), [each.astype(float) for each in few]
        loop(name)(*few, out)
        assert out.tobytes() == values(name, *again).tobytes()


@needs_machine_code
@pytest.mark.parametrize("name", CASES)
def test_machine_code_calls_no_libm_and_fuses_nothing(name):
    compiled = loop(name)
    out = np.empty(3)
    compiled(*[np.ones(3)] * (len(arguments_of(name)[0])), out)
    (text,) = compiled.inspect_llvm().values()
    (machine_code,) = compiled.inspect_asm().values()
    functions = "|".join(("tan", "pow", "floor", "log2", "fma", "fmuladd", "copysign", *CASES))
    assert re.findall(rf"@(?:llvm\.)?(?:{functions})\b", text) == []
    assert re.findall(r"\bv?fn?m(?:add|sub|la|ls)\w*", machine_code) == []

"""Elementary functions with bit-identical results on every machine.

The libm of each system rounds its sine differently. These functions use only additions,
multiplications, divisions and square roots of float64, whose rounding IEEE 754 defines, and
shifts of bits. No multiplication is fused with an addition.

Errors are given in ulp, the distance between two neighbouring float64; each is the largest over a
million random arguments and hard cases (`tests/equations/test_elementary.py`). Unless stated
otherwise, a function accepts every float64: NaN gives NaN, and zeros keep their sign.

Source: fdlibm (Sun Microsystems 1993) and Cephes (Moshier 1989): reductions and coefficients.
"""

import math

import numpy as np

from swarm_forage_env.compiler import inlined, kernel

MAX_ANGLE = 2.0**20
"""Largest absolute angle of sine and cosine [rad], 166,886 turns; they are NaN beyond it."""

_WHOLE = 1.5 * 2.0**52
"""Adding this constant rounds a float64 to an integer, which its last bits then hold."""
_WHOLE_BITS = 0x4338000000000000

_PI_LOW = 1.2246467991473532e-16
"""Difference between pi and math.pi."""
_HALF_PI_1, _REST_1 = 1.57079632673412561417e00, 6.07710050650619224932e-11
_HALF_PI_2, _REST_2 = 6.07710050630396597660e-11, 2.02226624879595063154e-21
_HALF_PI_3, _REST_3 = 2.02226624871116645580e-21, 8.47842766036889956997e-32
"""pi / 2 in pieces of 33 bits, and the remainder after each piece."""

_ATAN_HALF, _ATAN_HALF_LOW = 4.63647609000806093515e-01, 2.26987774529616870924e-17
_ATAN_1, _ATAN_1_LOW = 7.85398163397448278999e-01, 3.06161699786838301793e-17
"""atan(1/2) and atan(1), each with its remainder."""

_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
_EXPONENT, _MANTISSA = 52, (1 << 52) - 1
_ONE, _HALF_ROOT_2 = 0x3FF0000000000000, 0x3FE6A09E00000000
"""The bits of 1 and the upper bits of sqrt(1/2)."""


@inlined
def double(x: float) -> float:
    """Convert a value to float64, in compiled functions too."""
    return 1.0 * float(x)


@inlined
def bits(x: float) -> int:
    """Return the 64 bits of a float64 as an integer."""
    return int(np.float64(x).view(np.int64))


@inlined
def from_bits(k: int) -> float:
    """Return the float64 with these 64 bits."""
    return float(np.int64(k).view(np.float64))


@inlined
def cos_sin(angle: float) -> tuple[float, float]:
    """Return cosine and sine of an angle [rad]; NaN if |angle| > MAX_ANGLE.

        angle = n pi / 2 + r,  |r| <= pi / 4

    n pi / 2 is subtracted in pieces, so that r is exact to twice the digits of a float64.
    Error below 0.8 ulp.

    Source: fdlibm, e_rem_pio2.c, k_sin.c, k_cos.c.
    """
    x = double(angle)
    if abs(x) > MAX_ANGLE:
        return math.nan, math.nan
    nearest = x * 0.63661977236758134308 + _WHOLE
    n, quadrant = nearest - _WHOLE, bits(nearest)
    far, piece = x - n * _HALF_PI_1, n * _HALF_PI_2
    near = far - piece
    rest = n * _REST_2 - ((far - near) - piece)
    if abs(near) < 2.0**-30:
        far, piece = near, n * _HALF_PI_3
        near = far - piece
        rest = n * _REST_3 - ((far - near) - piece)
    r = near - rest
    low = (near - r) - rest
    z = r * r
    zz = z * z
    odd = (8.33333333332248946124e-03 + z * -1.98412698298579493134e-04) + zz * (
        (2.75573137070700676789e-06 + z * -2.50507602534068634195e-08)
        + zz * 1.58969099521155010221e-10
    )
    even = (4.16666666666666019037e-02 + z * -1.38888888888741095749e-03) + zz * (
        (2.48015872894767294178e-05 + z * -2.75573143513906633035e-07)
        + zz * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)
    )
    cube = z * r
    sine = r - ((z * (0.5 * low - cube * odd) - low) - cube * -1.66666666666666324348e-01)
    most = 1.0 - 0.5 * z
    cosine = most + (((1.0 - most) - 0.5 * z) + (zz * even - r * low))
    if quadrant & 1:
        sine, cosine = cosine, sine
    return (-cosine if (quadrant + 1) & 2 else cosine), (-sine if quadrant & 2 else sine)


@inlined
def sin(angle: float) -> float:
    """Return the sine of an angle [rad], computed by `cos_sin`."""
    return cos_sin(angle)[1]


@inlined
def cos(angle: float) -> float:
    """Return the cosine of an angle [rad], computed by `cos_sin`."""
    return cos_sin(angle)[0]


@inlined
def atan2(y: float, x: float) -> float:
    """Return the angle of the vector (x, y) from the x axis [rad], in [-pi, pi].

        atan(t) = atan(c) + atan((t - c) / (1 + c t)),  t <= 1,  c = 0, 1/2 or 1

    Error below 1.5 ulp.

    Source: fdlibm, s_atan.c, e_atan2.c.
    """
    y, x = double(y), double(x)
    across, along = abs(y), abs(x)
    hi, lo = (across, along) if across > along else (along, across)
    if not 2.0**-1000 < hi < 2.0**1000:
        hi, lo = scaled(hi, lo)
    is_middle, is_high = lo >= 0.4375 * hi, lo >= 0.6875 * hi
    c = 1.0 if is_high else 0.5 if is_middle else 0.0
    high = _ATAN_1 if is_high else _ATAN_HALF if is_middle else 0.0
    low = _ATAN_1_LOW if is_high else _ATAN_HALF_LOW if is_middle else 0.0
    t = (lo - c * hi) / (hi + c * lo)
    z = t * t
    w = z * z
    ww = w * w
    even = (3.33333333333329318027e-01 + w * 1.42857142725034663711e-01) + ww * (
        (9.09088713343650656196e-02 + w * 6.66107313738753120669e-02)
        + ww * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)
    )
    odd = (-1.99999999998764832476e-01 + w * -1.11111104054623557880e-01) + ww * (
        (-7.69187620504482999495e-02 + w * -5.83357013379057348645e-02)
        + ww * -3.65315727442169155270e-02
    )
    angle = high - ((t * (z * even + w * odd) - low) - t)
    if across > along:
        angle = 0.5 * math.pi - (angle - 0.5 * _PI_LOW)
    if bits(x) < 0:
        angle = math.pi - (angle - _PI_LOW)
    return -angle if bits(y) < 0 else angle


@kernel
def scaled(hi: float, lo: float) -> tuple[float, float]:
    """Scale two magnitudes, keeping their ratio, so that `hi` can be halved and doubled exactly."""
    if hi == 0.0:
        return 1.0, lo
    if hi == math.inf:
        return 1.0, 1.0 if lo == math.inf else 0.0 * lo
    by = 0.25 if hi > 1.0 else 2.0**54
    return hi * by, lo * by


@inlined
def hypot(x: float, y: float) -> float:
    """Return the length of the vector (x, y).

        sqrt(x^2 + y^2)

    Error below 1.2 ulp. Infinite if x or y is, as in C.
    """
    x, y = double(x), double(y)
    square = x * x + y * y
    if not 2.0**-900 < square < 2.0**1000:
        return far_hypot(x, y)
    return math.sqrt(square)


@kernel
def far_hypot(x: float, y: float) -> float:
    """Return `hypot` where the sum of squares leaves the range of float64."""
    if abs(x) == math.inf or abs(y) == math.inf:
        return math.inf
    if x != x or y != y:
        return math.nan
    by = 2.0**-600 if max(abs(x), abs(y)) > 1.0 else 2.0**600
    x, y = x * by, y * by
    return math.sqrt(x * x + y * y) / by


@inlined
def exp(x: float) -> float:
    """Return e to the power of x; infinite above 709.78, 0 below -745.13.

        x = n ln 2 + r,  e^x = 2^n e^r

    Error below 0.9 ulp; below 1 ulp for denormal results.

    Source: fdlibm, e_exp.c.
    """
    x = double(x)
    if x != x:
        return x
    if x > 709.782712893384:
        return math.inf
    if x < -745.1332191019412:
        return 0.0
    nearest = x * 1.44269504088896338700e00 + _WHOLE
    n, k = nearest - _WHOLE, bits(nearest) - _WHOLE_BITS
    high, low = x - n * _LN2_HIGH, n * _LN2_LOW
    r = high - low
    z = r * r
    last = -1.65339022054652515390e-06 + z * 4.13813679705723846039e-08
    rest = -2.77777777770155933842e-03 + z * (6.61375632143793436117e-05 + z * last)
    c = r - z * (1.66666666666666019037e-01 + z * rest)
    power = 1.0 - ((low - (r * c) / (2.0 - c)) - high)
    half = k >> 1  # two factors: 2^n may be out of range
    return power * two_to(half) * two_to(k - half)


@inlined
def two_to(k: int) -> float:
    """Return 2 to the power of an integer from -1022 to 1023."""
    return from_bits((k + 1023) << _EXPONENT)


@inlined
def log_of_sum(u: float, c: float) -> float:
    """Return ln(u + c) for a normal float64 u > 0 and a c much smaller than u.

        u = 2^k (1 + f),  sqrt(1/2) < 1 + f < sqrt(2),  ln(1 + f) = f - f^2 / 2 + s (f^2 / 2 + R)

    Source: fdlibm, e_log.c, s_log1p.c.
    """
    shifted = bits(u) + (_ONE - _HALF_ROOT_2)
    k = (shifted >> _EXPONENT) - 1023
    f = from_bits((shifted & _MANTISSA) + _HALF_ROOT_2) - 1.0
    s = f / (2.0 + f)
    z = s * s
    w = z * z
    even = 3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01)
    odd = 2.857142874366239149e-01 + w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01)
    rest = w * even + z * (6.666666666666735130e-01 + w * odd)
    half_square = 0.5 * f * f
    low = s * (half_square + rest) + (k * _LN2_LOW + c / u)
    return low - half_square + f + k * _LN2_HIGH


@inlined
def log(x: float) -> float:
    """Return the natural logarithm; -infinite at 0, NaN below.

    Error below 0.9 ulp.

    Source: fdlibm, e_log.c.
    """
    x = double(x)
    if x < 2.0**-1022:
        if x <= 0.0:
            return -math.inf if x == 0.0 else math.nan
        return log_of_sum(x * 2.0**54, 0.0) - 54.0 * (_LN2_HIGH + _LN2_LOW)
    if not x < math.inf:
        return x
    return log_of_sum(x, 0.0)


@inlined
def log1p(x: float) -> float:
    """Return the natural logarithm of 1 + x; -infinite at x = -1, NaN below.

    Error below 1 ulp.

    Source: fdlibm, s_log1p.c.
    """
    x = double(x)
    if abs(x) < 2.0**-54 or not x < math.inf:
        return x
    if x <= -1.0:
        return -math.inf if x == -1.0 else math.nan
    u = 1.0 + x
    return log_of_sum(u, 1.0 - (u - x) if x > 1.0 else x - (u - 1.0))


@inlined
def tanh(x: float) -> float:
    """Return the hyperbolic tangent.

        x + x^3 P(x^2) / Q(x^2)  where |x| < 0.625,  else +- (1 - 2 / (e^(2 |x|) + 1))

    Error below 1.5 ulp.

    Source: Cephes, tanh.c.
    """
    x = double(x)
    size = abs(x)
    if size < 0.625:
        z = x * x
        above = (-9.64399179425052238628e-01 * z - 9.92877231001918586564e01) * z
        below = ((z + 1.12811678491631932402e02) * z + 2.23548839060100448583e03) * z
        ratio = (above - 1.61468768441708447952e03) / (below + 4.84406305325125486048e03)
        value = size + size * z * ratio
    else:
        value = 1.0 - 2.0 / (exp(2.0 * size) + 1.0)
    return -value if bits(x) < 0 else value


@inlined
def acos(x: float) -> float:
    """Return the angle in [0, pi] whose cosine is x [rad]; NaN outside [-1, 1].

        atan2(sqrt((1 - x) (1 + x)), x)

    Error below 2.5 ulp.
    """
    x = double(x)
    if not abs(x) <= 1.0:
        return math.nan
    return atan2(math.sqrt((1.0 - x) * (1.0 + x)), x)

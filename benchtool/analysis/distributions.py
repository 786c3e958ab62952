"""The distributions that every measurement asks for: normal, Student's, Fisher's.

`scipy.special` has them too, and loading it takes a tenth of what a short run takes. Equation numbers are of
the NIST Digital Library of Mathematical Functions (DLMF) and of Abramowitz and Stegun (A&S).
"""

from __future__ import annotations

import math
from functools import lru_cache
from statistics import NormalDist

_SMALL = 1e-300
_PRECISION = 1e-16
_TERMS = 10_000
_MANY = 1e4  # degrees of freedom from which on expansions in their reciprocal are exact to double precision
_MANY_VALUES = 1000  # whose median is at that of their distribution
_FAR_BELOW = 25.0  # standard deviations: from there on the distribution above zero is exponential
_LEAST_SPARE = 0.5  # degrees of freedom beyond two: with fewer the deviation has no bound
_NEWTON, _LAST = 50, 3e-8  # most steps of Newton's method, and the share after which the next adds no digit


def normal_below(x: float) -> float:
    """Return the probability that a standard normal variable is below `x`."""
    return 0.5 * math.erfc(-x / math.sqrt(2.0))


def above_zero(found: float, standard: float) -> tuple[float, float]:
    """Return the median of the part above zero of a normal distribution about `found`, and the rms deviation
    from it: the best estimate of what cannot be negative, and its standard uncertainty (JCGM 106:2012, A.4.4,
    of prior knowledge).

    Where the truth is zero, the mean of that part is off by more than its standard deviation in every record.
    """
    if not standard > 0.0:
        return max(0.0, found), 0.0
    below = -found / standard
    if below > _FAR_BELOW:
        median = math.log(2.0)
        return median * standard / below, math.hypot(1.0, 1.0 - median) * standard / below
    share = normal_below(-below)
    ratio = math.exp(-0.5 * below**2) / math.sqrt(2.0 * math.pi) / share
    mean, median = ratio - below, -NormalDist().inv_cdf(0.5 * share) - below
    return standard * median, standard * math.sqrt(1.0 + below * ratio - ratio**2 + (mean - median) ** 2)


def student_below(dof: float, t: float) -> float:
    """Return the probability that a variable of Student's distribution with `dof` degrees of freedom is below
    `t`.
    """
    if math.isinf(t):
        return 0.0 if t < 0.0 else 1.0
    if dof >= _MANY:
        return normal_below(_normal_of_student(dof, t))
    tail = 0.5 * beta_ratio(0.5 * dof, 0.5, dof / (dof + t * t), t * t / (dof + t * t))
    return tail if t < 0.0 else 1.0 - tail


def students_deviation(dof: float) -> float:
    """Return standard deviation of Student's distribution, sqrt(dof / (dof - 2)), or bounded below 2.5."""
    return math.sqrt(dof / max(dof - 2.0, _LEAST_SPARE)) if math.isfinite(dof) else 1.0


@lru_cache(maxsize=4096)
def student_quantile(dof: float, probability: float) -> float:
    """Return what a variable of Student's distribution is below with this probability, of 0.5 to 0.9999.

    By the expansion about the normal quantile (A&S 26.7.5), with few degrees of freedom by Newton's method
    from there.
    """
    above = 1.0 - probability
    z = 0.0
    for _ in range(_NEWTON):
        step = (normal_below(-z) - above) / math.exp(-0.5 * z * z) * math.sqrt(2.0 * math.pi)
        z += step
        if abs(step) <= _LAST * z:
            break
    t = _student_of_normal(dof, z)
    if dof >= _MANY:
        return t
    constant = -0.5 * math.log(dof) - log_beta(0.5 * dof, 0.5)
    for _ in range(_NEWTON):
        density = math.exp(constant - 0.5 * (dof + 1.0) * math.log1p(t * t / dof))
        step = (student_below(dof, -t) - above) / density
        t += step
        if abs(step) <= _LAST * t:
            break
    return t


def fisher_above(dof: float, dof_below: float, ratio: float) -> float:
    """Return the probability that a ratio of two estimates of one variance, with these degrees of freedom
    above and below, is greater than `ratio`.
    """
    if not ratio > 0.0:
        return 1.0
    if math.isinf(ratio):
        return 0.0
    weighted = dof * ratio
    whole = dof_below + weighted
    return beta_ratio(0.5 * dof_below, 0.5 * dof, dof_below / whole, weighted / whole)


def beta_ratio(a: float, b: float, x: float, rest: float) -> float:
    """Return the regularised incomplete beta function I_x(a, b), given x and `rest`, 1 - x, so that neither
    loses digits.

    By its continued fraction (DLMF 8.17.22), after Lentz; it takes some sqrt(max(a, b)) terms.
    """
    if x <= 0.0:
        return 0.0
    if rest <= 0.0:
        return 1.0
    front = math.exp(a * math.log(x) + b * math.log(rest) - log_beta(a, b))
    if x < (a + 1.0) / (a + b + 2.0):
        return front * _fraction(a, b, x) / a
    return 1.0 - front * _fraction(b, a, rest) / b


def log_beta(a: float, b: float) -> float:
    """Return the logarithm of the beta function; with a large argument by Stirling's series (DLMF 5.11.1), as
    differences of large logarithms have no digits.
    """
    small, large = min(a, b), max(a, b)
    if large < 10.0:
        return math.lgamma(small) + math.lgamma(large) - math.lgamma(small + large)
    whole = small + large
    change = _stirling(large) - _stirling(whole) - (whole - 0.5) * math.log1p(small / large) + small
    if small < 10.0:
        return math.lgamma(small) + change - small * math.log(large)
    of_small = (small - 0.5) * math.log(small) - small + 0.5 * math.log(2.0 * math.pi) + _stirling(small)
    return of_small + change - small * math.log(large)


def _stirling(z: float) -> float:
    """ln Gamma(z) less (z - 1/2) ln z - z + ln(2 pi) / 2, for z from 10."""
    w = 1.0 / (z * z)
    return (1 / 12 - w * (1 / 360 - w * (1 / 1260 - w * (1 / 1680 - w * (1 / 1188 - w * 691 / 360360))))) / z


def _fraction(a: float, b: float, x: float) -> float:
    below = 1.0 - (a + b) * x / (a + 1.0)
    c, d = 1.0, 1.0 / (below if abs(below) > _SMALL else _SMALL)
    value = d
    for m in range(1, _TERMS):
        even = m * (b - m) * x / ((a + 2 * m - 1.0) * (a + 2 * m))
        odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1.0))
        for term in (even, odd):
            below, c = 1.0 + term * d, 1.0 + term / c
            d = 1.0 / (below if abs(below) > _SMALL else _SMALL)
            c = c if abs(c) > _SMALL else _SMALL
            value *= c * d
        if abs(c * d - 1.0) <= _PRECISION:
            break
    return value


def _student_of_normal(n: float, z: float) -> float:
    """A&S 26.7.5."""
    w = z * z
    first = (w + 1.0) / 4.0
    second = ((5.0 * w + 16.0) * w + 3.0) / 96.0
    third = (((3.0 * w + 19.0) * w + 17.0) * w - 15.0) / 384.0
    fourth = ((((79.0 * w + 776.0) * w + 1482.0) * w - 1920.0) * w - 945.0) / 92160.0
    return z * (1.0 + (first + (second + (third + fourth / n) / n) / n) / n)


def _normal_of_student(n: float, t: float) -> float:
    """The reverse of A&S 26.7.5, to the third order; beyond 40 the probability is 0 or 1."""
    if abs(t) > 40.0:
        return math.copysign(40.0, t)
    w = t * t
    first = (w + 1.0) / 4.0
    second = ((13.0 * w + 8.0) * w + 3.0) / 96.0
    third = (((35.0 * w + 19.0) * w + 1.0) * w - 15.0) / 384.0
    return t * (1.0 - (first - (second - third / n) / n) / n)


@lru_cache(None)
def median_of_exponentials(count: int) -> float:
    """Return the mean of the median of so many independent, exponentially distributed values of mean 1: the
    sum of 1 / i above the middle."""
    if count > _MANY_VALUES:
        return math.log(2.0)
    upper = sum(1.0 / each for each in range(count // 2 + 1, count + 1))
    return upper if count % 2 else upper + 1.0 / count


def equally_likely(count: int) -> tuple[float, ...]:
    """Return so many values of a standard normal distribution, each as likely as the others: the middles of
    shares of it that are equal."""
    return tuple(NormalDist().inv_cdf((each + 0.5) / count) for each in range(count))


def least_odds(by_chance: float) -> float:
    """Return the least odds of what has this probability by chance against any other cause, at most 1:
    -e p ln p (Sellke, Bayarri and Berger, Am. Statist. 55 (2001) 62)."""
    if by_chance >= 1.0 / math.e:
        return 1.0
    return -math.e * by_chance * math.log(by_chance) if by_chance > 0.0 else 0.0

"""Lengths of which the discrete Fourier transform is quick: products of small primes.

`numpy.fft` gives the bits of `scipy.fft` in the same time; what it has not are these lengths.
"""

from __future__ import annotations

from functools import lru_cache


@lru_cache(maxsize=4096)
def next_fast_length(count: int) -> int:
    """Return the least product of 2, 3 and 5 that is not below `count`, for real transforms."""
    least = 1 << max(0, count - 1).bit_length()
    of_five = 1
    while of_five < least:
        of_three = of_five
        while of_three < least:
            quotient = -(-count // of_three)
            least = min(least, of_three << max(0, quotient - 1).bit_length())
            of_three *= 3
        of_five *= 5
    return least


def previous_fast_length(count: int) -> int:
    """Return the greatest product of primes up to 11 that is not above `count`, which is at least 1."""
    while not _is_smooth(count):
        count -= 1
    return count


def _is_smooth(count: int) -> bool:
    for prime in (2, 3, 5, 7, 11):
        while count % prime == 0:
            count //= prime
    return count == 1

"""Constants and products of the exponential engines, in exact integers.

Logarithms are those of :mod:`decimal` with 60 digits, rounded to nearest. No constant here has more
than 45 bits, so that 60 digits decide every rounding.
"""

from __future__ import annotations

from decimal import ROUND_HALF_UP, Decimal, localcontext

import numpy as np

#: Fraction bits in which pieces of the piecewise form are computed.
PIECE_BITS = 62

_DIGITS = 60
_LOW_HALF = np.uint64(0xFFFF_FFFF)
_HALF = np.uint64(32)


def times_ln2(multiple: int, bits: int) -> int:
    """``multiple ln 2`` with ``bits`` fraction bits, to nearest."""
    return multiple_of_logarithm(multiple, 2, 1, bits)


def ln_one_plus(numerator: int, shift: int, bits: int) -> int:
    """``ln(1 + numerator 2^-shift)`` with ``bits`` fraction bits, to nearest."""
    return multiple_of_logarithm(1, (1 << shift) + numerator, 1 << shift, bits)


def multiple_of_logarithm(multiple: int, above: int, below: int, bits: int) -> int:
    """``multiple ln(above / below)`` with ``bits`` fraction bits, to nearest."""
    with localcontext() as context:
        context.prec = _DIGITS
        value = (Decimal(above) / Decimal(below)).ln() * multiple * (1 << bits)
        return int(value.to_integral_value(rounding=ROUND_HALF_UP))


def log2_e(bits: int) -> int:
    """``log2 e`` with ``bits`` fraction bits, to nearest."""
    return half_up((1 << (PIECE_BITS + bits + 1)) // _ln2_of_pieces(), 1)


def half_up(value: int, drop: int) -> int:
    """``value / 2^drop``, to nearest, ties towards plus infinity."""
    return (value + ((1 << drop) >> 1)) >> drop


def piece(index: int, index_bits: int, accumulator_bits: int, slope_bits: int) -> tuple[int, int]:
    """Start and slope of a piece of ``2^(1-f)``.

    The start has ``accumulator_bits`` fraction bits, the slope ``slope_bits``. The slope is that of
    the chord, rounded. The start lies halfway between the values that fit the ends and the middle.
    """
    left, middle, right = (_falling(2 * index + h, index_bits + 1) for h in range(3))
    slope = half_up((left - right) << index_bits, PIECE_BITS - slope_bits)
    fall = (slope << (PIECE_BITS - slope_bits)) >> index_bits
    high = max(left, right + fall)
    low = middle + fall // 2
    return half_up(high + low, PIECE_BITS + 1 - accumulator_bits), slope


def _ln2_of_pieces() -> int:
    """``ln 2`` with the fraction bits of the pieces, truncated."""
    with localcontext() as context:
        context.prec = _DIGITS
        return int(Decimal(2).ln() * (1 << PIECE_BITS))


def _falling(step: int, bits: int) -> int:
    """``2^(1 - step / 2^bits)``, by the series of ``exp(-t)`` with ``t = step ln 2 / 2^bits``.

    The model of the hardware truncates the terms in the same way, so that the last bits agree too.
    """
    t = (_ln2_of_pieces() * step) >> bits
    total, term, n = 0, 2 << PIECE_BITS, 0
    while term != 0:
        total += term
        n += 1
        product = (term * t) >> PIECE_BITS
        # Towards zero.
        term = -(product // n) if product >= 0 else -product // n
    return total


def product(a: np.ndarray, b: np.ndarray | int, drop: int) -> np.ndarray:
    """``floor(a b / 2^drop)`` of integers from 0 to 2^62, ``drop`` of 1 to 63.

    The product may have 128 bits; the quotient has to be below 2^63.
    """
    a = np.asarray(a).astype(np.uint64)
    b = np.asarray(b).astype(np.uint64)
    a_low, a_high = a & _LOW_HALF, a >> _HALF
    b_low, b_high = b & _LOW_HALF, b >> _HALF
    low = a_low * b_low
    middle = a_high * b_low + (low >> _HALF)
    other = a_low * b_high + (middle & _LOW_HALF)
    high = a_high * b_high + (middle >> _HALF) + (other >> _HALF)
    bottom = (other << _HALF) | (low & _LOW_HALF)
    quotient = (high << np.uint64(64 - drop)) | (bottom >> np.uint64(drop))
    return quotient.astype(np.int64)


def rounded_product(a: np.ndarray, b: np.ndarray | int, drop: int) -> np.ndarray:
    """``a b / 2^drop``, to nearest, ties upwards; limits are those of :func:`product`."""
    return (product(2 * np.asarray(a), b, drop) + 1) >> 1

"""The forms of the exponential: widths, limits, and the arithmetic of each."""

from __future__ import annotations

import math
from typing import Callable, NamedTuple, Optional, Tuple

import numpy as np

from . import _constants as constants
from ._knobs import Format, Knobs

#: Mantissa with the accumulator's fraction bits, and binary exponent.
Power = Tuple[np.ndarray, np.ndarray]
#: Computes the power of minus a value, which has the constants' fraction bits.
Powers = Callable[[np.ndarray], Power]
#: Accumulator bits, constant bits, offset.
Widths = Tuple[int, int, int]

#: Smallest widths found by exhaustive search, by F, iterations and tail.
_RESTORING_WIDTHS: dict[tuple[int, int, bool], Widths] = {
    (16, 8, False): (16, 13, 0),
    (16, 12, False): (16, 13, 3),
    (16, 16, False): (19, 19, -2),
    (16, 20, False): (18, 19, -1),
    (16, 8, True): (16, 19, 0),
    (16, 9, True): (18, 19, 0),
    (16, 12, True): (18, 19, 0),
    (16, 27, False): (27, 29, 0),
    (16, 14, True): (27, 28, 0),
    (16, 16, True): (27, 29, 0),
    (16, 20, True): (28, 27, -1),
    (16, 27, True): (27, 28, 0),
    (8, 8, False): (10, 13, 0),
    (8, 4, True): (8, 13, 0),
    (12, 12, False): (15, 13, 2),
    (12, 6, True): (12, 15, 0),
    (24, 24, False): (27, 27, -1),
    (24, 12, True): (28, 25, 2),
    (8, 23, False): (23, 24, 0),
    (8, 11, True): (20, 22, 0),
    (12, 25, False): (26, 26, 1),
    (12, 13, True): (22, 25, 0),
    (24, 18, True): (38, 37, 1),
}
_RADIX_4_WIDTHS: dict[tuple[int, int, bool], Widths] = {
    (16, 4, True): (18, 20, 1),
    (16, 8, False): (20, 19, -1),
    (16, 5, True): (17, 20, 0),
    (8, 4, False): (11, 13, 0),
    (8, 2, True): (8, 13, 0),
}
#: Clocks from knowing a power's exponent to an early termination.
_AGREEMENT = 2
#: The largest exponent that an early out distinguishes.
_LAST_EXPONENT = 24


class Engine(NamedTuple):
    """Widths that follow from the knobs."""

    accumulator_bits: int
    constant_bits: int
    offset: int = 0
    #: Whether half a unit of the last iteration is added at the start.
    centred: bool = False
    #: Digits of the exponent, and the start in units of ln 2.
    digits: int = 0
    bias: int = 0
    steps: int = 0


class Form:
    """A form of the exponential; each has one instance in :data:`FORMS`."""

    #: What the form offers beyond powers of e with the alpha output.
    general = base_two = tail = early_out = False
    #: Whether the operand is signed for every output and the result is the rounded mantissa.
    is_bare = False
    #: Smallest and largest number of iterations, and the reason.
    iterations = (2, 31, "the shift amount has 5 bits")

    def engine(self, knobs: Knobs) -> Engine:
        """Widths that follow from the knobs."""
        raise NotImplementedError

    def powers(self, knobs: Knobs) -> Powers:
        """The arithmetic, with its constants."""
        raise NotImplementedError

    def input(self, own: Format, output: str) -> tuple[bool, str]:
        """Whether an operand format is allowed, and the allowed ones."""
        if output == "alpha":
            right = not own.is_signed and 1 <= own.int_bits <= 3
            return right, "U1.x to U3.x with 4 to 24 fraction bits: the digits cover 0 to 8"
        right = own.is_signed and own.int_bits <= 6
        return right, "S0.x to S6.x with 4 to 24 fraction bits"

    def least_constant_bits(self, knobs: Knobs) -> tuple[int, str]:
        """Smallest number of fraction bits of the constants, and the reason."""
        return knobs.format.frac_bits, "at least the input's fraction bits"

    def rules(self, knobs: Knobs) -> list[tuple[bool, str, str, str, str]]:
        """Rules of this form alone: whether kept, rule, field, value, what is expected."""
        return []


def _or(given: Optional[int], otherwise: int) -> int:
    return otherwise if given is None else given


def _recurrence(
    knobs: Knobs, n: int, digits: int, bias: int, known: Optional[Widths], centres: bool
) -> Engine:
    """Widths of an engine that resolves n bits of the power by comparing and subtracting."""
    guarded = knobs.output_bits + (2 * (n + 4)).bit_length()
    accumulator, constant, offset = known or (guarded, max(guarded, n + 1), 0)
    constant = max(_or(knobs.constant_bits, constant), knobs.format.frac_bits)
    return Engine(
        accumulator_bits=_or(knobs.accumulator_bits, accumulator),
        constant_bits=constant,
        offset=_or(knobs.offset, offset),
        centred=centres and not knobs.tail and constant > n,
        digits=digits,
        bias=bias,
        steps=digits + knobs.iterations,
    )


def _with_tail(accumulator: np.ndarray, remain: np.ndarray, bits: int) -> np.ndarray:
    """The mantissa times 1 + the residual, truncated."""
    return accumulator + constants.product(accumulator, remain, bits)


def _shifted(value: np.ndarray, shift: int) -> np.ndarray:
    """``value / 2^shift``, rounded by the highest dropped bit."""
    return (value >> shift) + ((value >> (shift - 1)) & 1)


def _clocks(steps: int, knobs: Knobs) -> int:
    return -(-steps // max(knobs.iterations_per_clock, 1))


def interval(knobs: Knobs, engine: Engine) -> int:
    """Clocks of a power with all iterations."""
    return _clocks(engine.steps, knobs) + knobs.tail


def earliest_out(knobs: Knobs, engine: Engine) -> int:
    """Smallest number of clocks with an early out."""
    return _clocks(engine.digits, knobs) + _AGREEMENT


class Restoring(Form):
    """Digits of ``k ln 2`` first, then ``ln(1 + 2^-i)``, i = 1..n."""

    general = tail = early_out = True

    def engine(self, knobs: Knobs) -> Engine:
        digits, bias = 4, 12
        if knobs.output == "general":
            # x in [-2^I, 2^I): with this bias the start is not negative.
            bias = math.ceil(2.0**knobs.format.int_bits / math.log(2.0))
            digits = (2 * bias + 1).bit_length()
        known = _RESTORING_WIDTHS.get((knobs.output_bits, knobs.iterations, knobs.tail))
        return _recurrence(knobs, knobs.iterations, digits, bias, known, True)

    def powers(self, knobs: Knobs) -> Powers:
        engine, n = self.engine(knobs), knobs.iterations
        bits = engine.constant_bits
        digits = [constants.times_ln2(1 << j, bits) for j in range(engine.digits)]
        start = sum(c for j, c in enumerate(digits) if engine.bias >> j & 1)
        start += 1 << (bits - n - 1) if engine.centred else 0
        steps = [(i, constants.ln_one_plus(1, i, bits)) for i in range(1, n + 1)]
        last = self._last_iterations(knobs, engine)

        def power(value: np.ndarray) -> Power:
            remain, taken = start - value, np.zeros_like(value)
            for c in reversed(digits):
                fits = remain >= c
                remain = remain - fits * c
                taken = 2 * taken + fits
            accumulator = np.full_like(value, (1 << engine.accumulator_bits) + engine.offset)
            own_last = last[np.clip(engine.bias - taken, 0, _LAST_EXPONENT)]
            for i, c in steps:
                fits = (remain >= c) & (i <= own_last)
                remain = remain - fits * c
                accumulator = accumulator + fits * _shifted(accumulator, i)
            if knobs.tail:
                accumulator = _with_tail(accumulator, remain, bits)
            return accumulator, taken - engine.bias

        return power

    @staticmethod
    def _last_iterations(knobs: Knobs, engine: Engine) -> np.ndarray:
        """The last iteration of a power, by k."""
        last = []
        for k in range(_LAST_EXPONENT + 1):
            clocks = interval(knobs, engine)
            if knobs.early_out:
                wanted = max(knobs.output_bits + 2 - k, 0)
                own = _clocks(engine.digits + min(wanted, knobs.iterations), knobs)
                clocks = min(max(own, earliest_out(knobs, engine)), clocks)
            last.append(max(clocks * max(knobs.iterations_per_clock, 1) - engine.digits, 0))
        return np.array(last, dtype=np.int64)


class Literal(Form):
    """The recurrence as printed: ``ln(1 + 2^-i)``, i = 0..n-1, on a signed value in [-1, 1)."""

    general = is_bare = True

    def input(self, own: Format, output: str) -> tuple[bool, str]:
        right = own.is_signed and own.int_bits == 0
        return right, "S0.4 to S0.24: the recurrence covers [-1, 1)"

    def engine(self, knobs: Knobs) -> Engine:
        known = _RESTORING_WIDTHS.get((knobs.output_bits, knobs.iterations, knobs.tail))
        return _recurrence(knobs, knobs.iterations, 0, 0, known, False)

    def powers(self, knobs: Knobs) -> Powers:
        engine = self.engine(knobs)
        steps = range(knobs.iterations)
        logs = [constants.ln_one_plus(1, i, engine.constant_bits) for i in steps]

        def power(value: np.ndarray) -> Power:
            remain = -value
            accumulator = np.full_like(value, 1 << engine.accumulator_bits)
            for i, c in zip(steps, logs):
                fits = remain >= c
                remain = remain - fits * c
                accumulator = accumulator + fits * (accumulator >> i)
            return accumulator, np.zeros_like(value)

        return power


class Radix4(Form):
    """Digits of ``d 4^j ln 2``, j = 1, 0, then ``ln(1 + d 4^-j)``, j = 1..J, d of 0 to 3."""

    tail = True
    iterations = (1, 15, "digits of radix 4, whose shift amount has 5 bits")

    def engine(self, knobs: Knobs) -> Engine:
        known = _RADIX_4_WIDTHS.get((knobs.output_bits, knobs.iterations, knobs.tail))
        return _recurrence(knobs, 2 * knobs.iterations, 2, 12, known, True)

    def powers(self, knobs: Knobs) -> Powers:
        engine, n = self.engine(knobs), 2 * knobs.iterations
        bits = engine.constant_bits
        digits = [
            np.array([constants.times_ln2(d << (2 * j), bits) for d in range(4)], dtype=np.int64)
            for j in reversed(range(engine.digits))
        ]
        # The bias 12 is the digit 3 of 4 ln 2.
        start = constants.times_ln2(engine.bias, bits)
        start += 1 << (bits - n - 1) if engine.centred else 0
        steps = []
        for shift in range(2, n + 1, 2):
            own = [constants.ln_one_plus(d, shift, bits) for d in range(4)]
            steps.append((shift, np.array(own, dtype=np.int64)))

        def power(value: np.ndarray) -> Power:
            remain, taken = start - value, np.zeros_like(value)
            for multiples in digits:
                digit = _digit(remain, multiples)
                remain = remain - multiples[digit]
                taken = 4 * taken + digit
            accumulator = np.full_like(value, (1 << engine.accumulator_bits) + engine.offset)
            for shift, multiples in steps:
                digit = _digit(remain, multiples)
                remain = remain - multiples[digit]
                accumulator = accumulator + _shifted(accumulator * digit, shift)
            if knobs.tail:
                accumulator = _with_tail(accumulator, remain, bits)
            return accumulator, taken - engine.bias

        return power


def _digit(remain: np.ndarray, multiples: np.ndarray) -> np.ndarray:
    """The number of multiples, the first of which is 0, that fit besides it."""
    return sum((remain >= m).astype(np.int64) for m in multiples[1:])


class Piecewise(Form):
    """``2^-v`` from a table of straight pieces, ``v = u log2 e``."""

    base_two = True

    def engine(self, knobs: Knobs) -> Engine:
        constant = _or(knobs.constant_bits, knobs.output_bits + 3)
        return Engine(
            accumulator_bits=_or(knobs.accumulator_bits, knobs.output_bits + 4),
            constant_bits=max(constant, self.least_constant_bits(knobs)[0]),
        )

    def least_constant_bits(self, knobs: Knobs) -> tuple[int, str]:
        least = max(knobs.format.frac_bits, self._index_bits(knobs) + 4)
        return least, "at least the input's fraction bits, and 4 beyond those that name a piece"

    @staticmethod
    def _index_bits(knobs: Knobs) -> int:
        """Bits that name a piece."""
        return max(knobs.pieces, 2).bit_length() - 1

    def rules(self, knobs: Knobs) -> list[tuple[bool, str, str, str, str]]:
        count, pipelined = knobs.pieces, str(knobs.pipelined).lower()
        most = 2 * (max(count, 1).bit_length() - 1) + 4
        own = [
            (
                count & (count - 1) == 0 and 16 <= count <= 1024,
                "exp-pieces",
                "vu.exp.pieces",
                str(count),
                "a power of two, 16 to 1024: the first bits of the power name the piece",
            ),
            (
                knobs.pipelined,
                "exp-pieces-pipelined",
                "vu.exp.pipelined",
                pipelined,
                "true: the pieces give one result a clock",
            ),
            (
                knobs.output_bits <= most,
                "exp-pieces-output-bits",
                "vu.exp.output_bits",
                str(knobs.output_bits),
                f"at most {most} with {count} pieces, whose error is then below half a unit, so "
                "that 1 - exp(0) is 0",
            ),
        ]
        unset = "left out: the pieces take no iterations"
        for kept, name, value in (
            (not knobs.tail, "tail", "true"),
            (knobs.offset is None, "offset", str(knobs.offset)),
            (not knobs.early_out, "early_out", "true"),
        ):
            own.append((kept, "exp-pieces-knobs", f"vu.exp.{name}", value, unset))
        return own

    def powers(self, knobs: Knobs) -> Powers:
        engine, index_bits = self.engine(knobs), self._index_bits(knobs)
        bits = engine.constant_bits
        slope_bits = max(engine.accumulator_bits - index_bits - 3, 1)
        table = [
            constants.piece(i, index_bits, engine.accumulator_bits, slope_bits)
            for i in range(1 << index_bits)
        ]
        starts, slopes = (np.array(column, dtype=np.int64) for column in zip(*table))
        scale_bits = bits - 2
        scale = constants.log2_e(scale_bits)
        within = bits - index_bits
        drop = slope_bits + bits - engine.accumulator_bits

        def power(value: np.ndarray) -> Power:
            v = value
            if knobs.base == "e":
                v = constants.rounded_product(v, scale, scale_bits)
            fraction = v & ((1 << bits) - 1)
            rest = fraction & ((1 << within) - 1)
            index = fraction >> within
            fall = constants.rounded_product(slopes[index], rest, drop)
            return starts[index] - fall, -(v >> bits) - 1

        return power


#: The forms by name.
FORMS: dict[str, Form] = {
    "restoring": Restoring(),
    "literal": Literal(),
    "piecewise": Piecewise(),
    "radix-4": Radix4(),
}

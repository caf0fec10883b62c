"""Knobs of the exponential engine: names, defaults and kinds of values."""

from __future__ import annotations

import re
from dataclasses import dataclass, fields
from typing import Any, NamedTuple, Optional, Sequence

#: Values of the knobs that have names.
CHOICES = {
    "form": ("restoring", "literal", "piecewise", "radix-4"),
    "output": ("alpha", "general"),
    "base": ("e", "two"),
}


class Format(NamedTuple):
    """A fixed-point format: ``U3.13`` has 3 integer and 13 fraction bits, ``S3.12`` a sign too."""

    is_signed: bool
    int_bits: int
    frac_bits: int

    @classmethod
    def parse(cls, text: str) -> Format:
        """The format that a text names.

        Raises:
            ValueError: The text names none.
        """
        found = re.fullmatch(r"([US])([0-9]{1,2})\.([0-9]{1,2})", text)
        if found:
            own = cls(found[1] == "S", int(found[2]), int(found[3]))
            if 1 <= own.int_bits + own.frac_bits + own.is_signed <= 64:
                return own
        raise ValueError(
            f"`{text}` is not a fixed-point format: write U3.13 (3 integer, 13 fraction bits) or "
            "S15.16 (a sign bit besides), 1 to 64 bits in all"
        )

    @property
    def least(self) -> int:
        """The smallest code."""
        return -(1 << (self.int_bits + self.frac_bits)) if self.is_signed else 0

    @property
    def most(self) -> int:
        """The largest code."""
        return (1 << (self.int_bits + self.frac_bits)) - 1


@dataclass(frozen=True)
class Knobs:
    """Knobs of the exponential engine, as the table ``[vu.exp]`` of a configuration has them.

    Attributes:
        form: Algorithm: ``"restoring"``, ``"literal"``, ``"piecewise"`` or ``"radix-4"``.
        output: ``"alpha"``: unsigned operand u, result ``exp(-u)`` in U0.F, 1 saturates at the
            largest code. ``"general"``: signed operand x, result ``exp(x)`` as exponent and
            mantissa: bits F..0 are a mantissa U1.F in [1, 2), the bits above a signed exponent.
        base: ``"e"``, or ``"two"`` for ``2^-u``; two in the piecewise form only.
        pieces: Pieces in the piecewise form's table, a power of two from 16 to 1024.
        iterations: Iterations n past the exponent's digits, 2 to 31; of radix 4 its digits J,
            1 to 15.
        early_out: Whether a power of exponent k takes only ``min(n, F - k + 2)`` iterations.
        tail: Whether a final multiplication by 1 + the residual follows.
        iterations_per_clock: Iterations a clock, r.
        pipelined: Whether the engine gives one result a clock. No result depends on it.
        input: Format of the operand: unsigned for alpha, signed for general.
        output_bits: Fraction bits F of the result, 4 to 24 (general: 23).
        one_minus_frac_bits: Fraction bits of the operand of another operation; no result here
            depends on it.
        accumulator_bits: Fraction bits of the mantissa's register, F to 40; None: from n, F, tail.
        constant_bits: Fraction bits of the constants, up to 40; None: from n, F and tail.
        offset: What the mantissa starts with above 1, -16 to 16 units of its last bit; None: from
            n, F and tail.
    """

    form: str = "restoring"
    output: str = "alpha"
    base: str = "e"
    pieces: int = 64
    iterations: int = 16
    early_out: bool = False
    tail: bool = False
    iterations_per_clock: int = 1
    pipelined: bool = False
    input: str = "U3.13"
    output_bits: int = 16
    one_minus_frac_bits: int = 20
    accumulator_bits: Optional[int] = None
    constant_bits: Optional[int] = None
    offset: Optional[int] = None

    @property
    def format(self) -> Format:
        """The format of the operand."""
        return Format.parse(self.input)


def checked(name: str, value: Any) -> Any:
    """The value of a knob, if it is of its kind; whole numbers may be written ``16.0``.

    Raises:
        ValueError: There is no such knob, or the value is of another kind.
    """
    kinds = {field.name: field.type for field in fields(Knobs)}
    if name not in kinds:
        names = ", ".join(kinds)
        raise ValueError(f"field `vu.exp.{name}`: no such field here: expected one of {names}")
    kind = kinds[name]
    if name in CHOICES:
        if value not in CHOICES[name]:
            expected = "one of " + ", ".join(CHOICES[name])
            near = _nearest(value, CHOICES[name]) if isinstance(value, str) else None
            raise _unexpected(name, value, expected + (f"; did you mean `{near}`?" if near else ""))
    elif kind == "bool":
        if not isinstance(value, bool):
            raise _unexpected(name, value, "true or false")
    elif kind == "str":
        if not isinstance(value, str):
            raise _unexpected(name, value, "a text in quotation marks")
        try:
            Format.parse(value)
        except ValueError as error:
            raise ValueError(f"field `vu.exp.{name}`: {error}") from None
    elif value is not None or kind == "int":
        return _whole(name, value)
    return value


def _whole(name: str, value: Any) -> int:
    least, most = (-(1 << 31), (1 << 31) - 1) if name == "offset" else (0, (1 << 32) - 1)
    expected = "a whole number"
    try:
        if not isinstance(value, (bool, str)) and int(value) == value:
            if least <= value <= most:
                return int(value)
            expected += f", {least} or more" if value < least else f", {most} at most"
    except (TypeError, ValueError, OverflowError):
        pass
    if isinstance(value, str) and _is_number(value):
        expected += ", without quotation marks"
    raise _unexpected(name, value, expected)


def _nearest(name: str, names: Sequence[str]) -> Optional[str]:
    """The name that takes the fewest edits, if a third of its letters or fewer are to be edited; a name of one
    letter is near to none."""
    best = min(names, key=lambda known: _edits(name.lower(), known))
    edits = _edits(name.lower(), best)
    return best if edits <= -(-len(best) // 3) and edits < len(best) else None


def _edits(a: str, b: str) -> int:
    """Levenshtein's distance."""
    row = list(range(len(b) + 1))
    for i, x in enumerate(a):
        before, row[0] = row[0], i + 1
        for j, y in enumerate(b):
            before, row[j + 1] = row[j + 1], min(before + (x != y), row[j] + 1, row[j + 1] + 1)
    return row[-1]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def shown(value: Any) -> str:
    """A value as a configuration file has it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return f'"{value}"' if isinstance(value, str) else str(value)


def _unexpected(name: str, value: Any, expected: str) -> ValueError:
    return ValueError(f"field `vu.exp.{name}`: found {shown(value)}, expected {expected}")

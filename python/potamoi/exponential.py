"""The operation ``exp`` of the vector unit, bit for bit."""

from __future__ import annotations

from dataclasses import dataclass, fields
from os import PathLike, fspath
from typing import Any, Union

import numpy as np

from ._forms import FORMS
from ._knobs import Knobs, checked, shown
from ._rules import broken


@dataclass(frozen=True)
class Exponential(Knobs):
    """An exponential engine: integer operands in, result codes out.

    Knobs, their defaults and their rules are those of the table ``[vu.exp]`` of a configuration.
    The rules of the list of operations do not apply, since only ``exp`` is computed here.

    >>> Exponential()([0, 8192, 65535])
    array([65535, 24109,    22], dtype=uint32)

    Raises:
        ValueError: A knob is of another kind, or breaks a rule. The text is that of the generator.
    """

    __doc__ += Knobs.__doc__[Knobs.__doc__.index("\n    Attributes:"):]

    def __post_init__(self) -> None:
        for field in fields(Knobs):
            object.__setattr__(self, field.name, checked(field.name, getattr(self, field.name)))
        breaches = broken(self)
        if breaches:
            raise ValueError("\n".join(breaches))
        object.__setattr__(self, "_engine", FORMS[self.form].engine(self))
        object.__setattr__(self, "_powers", FORMS[self.form].powers(self))

    @classmethod
    def from_toml(cls, path: Union[str, PathLike[str]]) -> Exponential:
        """The engine that a configuration file describes.

        Only the table ``[vu.exp]`` is looked at. What it leaves out has its default.

        Raises:
            ValueError: The file is not TOML, has an unknown knob, or breaks a rule.
            OSError: The file cannot be read.
            ImportError: Python is older than 3.11 and has no package ``tomli``.
        """
        origin = fspath(path)
        reader = _toml_reader()
        with open(path, "rb") as file:
            try:
                document = reader.load(file)
            except ValueError as error:
                raise ValueError(f"{origin}: field `(the file)`: invalid TOML: {error}") from None
        try:
            knobs = _section(_section(document, "vu", "vu"), "exp", "vu.exp")
            return cls(**{name: checked(name, value) for name, value in knobs.items()})
        except ValueError as error:
            raise ValueError(f"{origin}: {error}") from None

    def __call__(self, codes: Any) -> np.ndarray:
        """The result codes of operands.

        Args:
            codes: Integers of -2^31 to 2^31 - 1 in units of 2^-f, f the fraction bits of
                ``input``. An operand outside that format is clamped to it, as in the unit.

        Returns:
            An array of the same shape, of uint32. With ``output = "alpha"``, codes U0.F: the power
            in units of 2^-F, rounded half-up from the engine's mantissa, at most 2^F - 1. With
            ``"general"``, the 32 bits of {exponent, mantissa U1.F}, the exponent in two's
            complement. In the literal form, the mantissa with F fraction bits, rounded half-up.

        Raises:
            TypeError: Operands are not integers.
            ValueError: An operand does not fit 32 bits.
        """
        codes = np.asarray(codes)
        if codes.size == 0:
            return np.zeros(codes.shape, dtype=np.uint32)
        if codes.dtype.kind not in "iu":
            raise TypeError(f"operands are integer codes, not {codes.dtype}")
        if codes.min() < -(1 << 31) or codes.max() >= 1 << 31:
            raise ValueError("an operand is outside -2^31 to 2^31 - 1")
        own = self.format
        flat = np.clip(codes.astype(np.int64).reshape(-1), own.least, own.most)
        value = flat << (self._engine.constant_bits - own.frac_bits)
        is_bare = FORMS[self.form].is_bare
        # The engines take minus the exponent.
        is_signed = is_bare or self.output == "general"
        mantissa, exponent = self._powers(-value if is_signed else value)
        return self._result(mantissa, exponent, is_bare).astype(np.uint32).reshape(codes.shape)

    def _result(self, mantissa: np.ndarray, exponent: np.ndarray, is_bare: bool) -> np.ndarray:
        """Result codes of 32 bits."""
        f = self.output_bits
        drop = self._engine.accumulator_bits - f
        if is_bare:
            return _rounded(mantissa, np.full_like(mantissa, drop))
        if self.output == "alpha":
            return np.minimum(_rounded(mantissa, drop - exponent), (1 << f) - 1)
        mantissa = _rounded(mantissa, np.full_like(mantissa, drop))
        # A mantissa that is rounded up to 2 becomes 1.
        full = mantissa >= 2 << f
        mantissa = np.where(full, 1 << f, mantissa)
        return (((exponent + full) << (f + 1)) | mantissa) & 0xFFFF_FFFF


def _rounded(value: np.ndarray, drop: np.ndarray) -> np.ndarray:
    """``value / 2^drop``, to nearest, ties upwards; ``drop`` of 0 to 62."""
    return (value + ((np.int64(1) << drop) >> 1)) >> drop


def _section(document: dict[str, Any], name: str, path: str) -> dict[str, Any]:
    """A table of a document, empty where there is none."""
    section = document.get(name, {})
    if not isinstance(section, dict):
        found = shown(section)
        raise ValueError(f"field `{path}`: found {found}, expected a section of named values")
    return section


def _toml_reader() -> Any:
    """The module that reads TOML."""
    try:
        import tomllib
    except ImportError:
        try:
            import tomli as tomllib
        except ImportError:
            raise ImportError(
                "Exponential.from_toml needs Python 3.11 or the package tomli: pip install tomli"
            ) from None
    return tomllib

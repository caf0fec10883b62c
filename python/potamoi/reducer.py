"""The reducers of the gathering unit, bit for bit: weighted sums of feature codes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

_WEIGHTS = ("trusted", "any")
_SUMS = ("rounded", "exact")


@dataclass(frozen=True)
class Reducer:
    """A reducer: feature codes and weights in, feature codes or exact sums out.

    >>> Reducer()([[100, -4], [200, 3]], [1 << 14, 1 << 14])
    array([150,   0], dtype=int16)

    Attributes:
        feature_bits: Width of a feature code, 8 to 16; ``gu.feature_bits``.
        weight_bits: Fraction bits W of a weight U1.W, 4 to 15; ``gu.weight_bits``.
        weights: ``trusted``, where an entry's weights sum to 1, or ``any``; ``gu.weights``.
        sums: ``rounded`` feature codes, or ``exact`` sums in units of 2^-W; ``gu.sums``.
        registered_products: Whether products are registered, as with ``gu.pipelined = true`` and in the
            organisation ``parity``. The accumulator then has the width for any weights.

    Raises:
        ValueError: A knob is outside its range.
    """

    feature_bits: int = 16
    weight_bits: int = 15
    weights: str = "trusted"
    sums: str = "rounded"
    registered_products: bool = False

    def __post_init__(self) -> None:
        for name, least, most in (("feature_bits", 8, 16), ("weight_bits", 4, 15)):
            value = getattr(self, name)
            if not isinstance(value, int) or not least <= value <= most:
                raise ValueError(f"gu.{name} = {value}; expected {least} to {most}")
        for name, known in (("weights", _WEIGHTS), ("sums", _SUMS)):
            if getattr(self, name) not in known:
                raise ValueError(f"gu.{name} = {getattr(self, name)!r}; expected one of {', '.join(known)}")

    @property
    def accumulator_bits(self) -> int:
        """Width of the accumulator, at which sums wrap."""
        exact = self.feature_bits + self.weight_bits
        # Eight codes below 2^(W+1) add four bits.
        return exact if self.weights == "trusted" and not self.registered_products else exact + 4

    def __call__(self, codes: Any, weights: Any) -> np.ndarray:
        """Reduces vertices.

        Args:
            codes: Feature codes, ``(..., V, C)``: V vertices of C channels.
            weights: Codes U1.W, ``(..., V)``. Bits above bit W do not count, as in the unit.

        Returns:
            ``(..., C)``. Feature codes of int16, rounded half to even and saturated; with ``sums =
            "exact"`` the sums of int32.

        Raises:
            TypeError: Operands are not integers.
            ValueError: Shapes do not fit, or a code is wider than a feature.
        """
        codes, weights = _whole(codes, "feature codes"), _whole(weights, "weights")
        if codes.ndim < 2 or codes.shape[:-1] != weights.shape:
            raise ValueError(
                f"feature codes of shape {codes.shape} and weights of shape {weights.shape}; "
                "expected (..., V, C) and (..., V)"
            )
        self._check(codes)
        kept = weights & ((2 << self.weight_bits) - 1)
        return self._result(self._wrapped((kept[..., None] * codes).sum(axis=-2)))

    def gather(self, rows: Any, entry_rows: Any, entry_weights: Any, vertices: int) -> np.ndarray:
        """Reduces the entries of an MVoxel.

        Args:
            rows: The loaded feature codes, ``(R, C)``.
            entry_rows: Row of each vertex, ``(E, V)`` or wider. A row that was not loaded counts as 0.
            entry_weights: Weight of each vertex, of the same shape.
            vertices: V. With 1 an entry is a single id, whose row is not weighted.

        Returns:
            ``(E, C)``, as when the reducer is called.
        """
        rows = _whole(rows, "feature codes")
        self._check(rows)
        index = _whole(entry_rows, "rows")[:, :vertices]
        is_loaded = (index >= 0) & (index < len(rows))
        codes = np.where(is_loaded[..., None], rows[np.where(is_loaded, index, 0)], 0)
        if vertices == 1:
            own = codes[:, 0]
            return (own << self.weight_bits).astype(np.int32) if self.sums == "exact" else own.astype(np.int16)
        return self(codes, _whole(entry_weights, "weights")[:, :vertices])

    def _check(self, codes: np.ndarray) -> None:
        limit = 1 << (self.feature_bits - 1)
        if codes.size and (codes.min() < -limit or codes.max() >= limit):
            raise ValueError(f"a feature code does not fit gu.feature_bits = {self.feature_bits}")

    def _wrapped(self, total: np.ndarray) -> np.ndarray:
        spare = 64 - self.accumulator_bits
        return (total << spare) >> spare

    def _result(self, total: np.ndarray) -> np.ndarray:
        if self.sums == "exact":
            return total.astype(np.int32)
        # Half to even: below the half, at it for an odd quotient, or above it.
        floor = total >> self.weight_bits
        rest = total - (floor << self.weight_bits)
        half = 1 << (self.weight_bits - 1)
        rounded = floor + ((rest > half) | ((rest == half) & (floor & 1 == 1)))
        limit = 1 << (self.feature_bits - 1)
        return np.clip(rounded, -limit, limit - 1).astype(np.int16)


def _whole(values: Any, what: str) -> np.ndarray:
    values = np.asarray(values)
    if values.size and values.dtype.kind not in "iu":
        raise TypeError(f"{what} are integers, not {values.dtype}")
    return values.astype(np.int64)

"""Traces of ``potamoi trace`` as NumPy arrays: what goes through the units for a frame, and what must come out."""

from __future__ import annotations

import json
from dataclasses import dataclass
from os import PathLike
from typing import Any, Iterator, Union

import numpy as np

#: Version of the file format that is read.
FORMAT_VERSION = 1
#: Names of roundings, by code.
ROUNDINGS = ("floor", "half-up", "half-even")
_CODES, _EXACT = "gather_features", "gather_sums"


@dataclass(frozen=True)
class Task:
    """Work of the gathering unit for one MVoxel, whose results are ``features``.

    Attributes:
        vertices: V, the vertices of an entry: 8, 4, 2, or 1 for single ids.
        rows: Feature codes, int16 ``(R, C)``.
        slots: Destination of each entry, uint32 ``(E,)``.
        entry_rows: Row of each vertex, uint16 ``(E, V)``.
        entry_weights: Weight of each vertex as a code U1.W, uint16 ``(E, V)``.
        features: Expected features, int16 ``(E, C)``, or unrounded sums in units of 2^-W, int32.
    """

    vertices: int
    rows: np.ndarray
    slots: np.ndarray
    entry_rows: np.ndarray
    entry_weights: np.ndarray
    features: np.ndarray


@dataclass(frozen=True)
class Operation:
    """An operation of the vector unit: ``results`` of the operands ``a`` and ``b``, all int32.

    ``code`` is that of the operation in ``docs/reference/vector-unit.md``, and ``rounding`` a name of
    :data:`ROUNDINGS`.
    """

    code: int
    shift: int
    rounding: str
    a: np.ndarray
    b: np.ndarray
    results: np.ndarray


class Trace:
    """A trace. ``arrays`` has all arrays of the file by name, ``header`` what it says of itself.

    >>> trace = Trace.read("lantern.npz")                                                 # doctest: +SKIP
    >>> trace.tasks()[0].features                                                         # doctest: +SKIP
    """

    def __init__(self, header: dict[str, Any], arrays: dict[str, np.ndarray]) -> None:
        self.header, self.arrays = header, arrays

    @classmethod
    def read(cls, path: Union[str, PathLike[str]]) -> Trace:
        """Reads a file of ``potamoi trace``.

        Raises:
            ValueError: The file is no trace, is of another version, or its arrays do not fit each other.
            OSError: The file cannot be read.
        """
        try:
            with np.load(path, allow_pickle=False) as file:
                arrays = {name: file[name] for name in file.files}
            header = json.loads(bytes(arrays.pop("header")))
            version = header["format_version"]
        except OSError:
            raise
        except Exception as error:
            raise ValueError(f"{path}: expected a file of `potamoi trace`: {error}") from None
        if version != FORMAT_VERSION:
            raise ValueError(f"{path}: format_version is {version}: expected {FORMAT_VERSION}")
        for own in header["arrays"]:
            found = arrays.get(own["name"])
            if found is None or list(found.shape) != own["shape"] or found.dtype.str != own["dtype"]:
                raise ValueError(f"{path}: array `{own['name']}` is not the one of its header")
        trace = cls(header, arrays)
        try:
            trace._check()
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None
        return trace

    @property
    def is_exact(self) -> bool:
        """Whether the gathering unit's results are unrounded sums."""
        return _EXACT in self.arrays

    @property
    def weight_bits(self) -> int:
        """Fraction bits W of the weights."""
        return int(dict(self.header["formats"])["weight"].partition(".")[2])

    @property
    def feature_bits(self) -> int:
        """Width of a feature code."""
        return int(dict(self.header["formats"])["feature"].split()[1])

    def _check(self) -> None:
        """Whether lengths of the lists are those of the tasks and operations."""
        tasks = self.arrays["gather_tasks"].astype(np.int64)
        results = _EXACT if self.is_exact else _CODES
        entries = int(tasks[:, 3].sum())
        expected = {
            "gather_rows": int((tasks[:, 1] * tasks[:, 2]).sum()),
            "gather_slots": entries,
            "gather_entry_rows": entries,
            "gather_entry_weights": entries,
            results: int((tasks[:, 1] * tasks[:, 3]).sum()),
        }
        elements = int(self.arrays["vector_ops"][:, 3].astype(np.int64).sum())
        expected.update(dict.fromkeys(("vector_a", "vector_b", "vector_results"), elements))
        for name, length in expected.items():
            if len(self.arrays[name]) != length:
                raise ValueError(f"array `{name}` has length {len(self.arrays[name])}: expected {length}")

    def tasks(self) -> list[Task]:
        """Work of the gathering unit, an MVoxel each. Arrays are views."""
        own = self.arrays
        results = own[_EXACT if self.is_exact else _CODES]
        all_of, code, entry, result = [], 0, 0, 0
        for vertices, channels, rows, entries in own["gather_tasks"].tolist():
            these = slice(entry, entry + entries)
            all_of.append(
                Task(
                    vertices,
                    own["gather_rows"][code : code + rows * channels].reshape(rows, channels),
                    own["gather_slots"][these],
                    own["gather_entry_rows"][these, :vertices],
                    own["gather_entry_weights"][these, :vertices],
                    results[result : result + entries * channels].reshape(entries, channels),
                )
            )
            code, entry, result = code + rows * channels, entry + entries, result + entries * channels
        return all_of

    def operations(self) -> Iterator[Operation]:
        """Operations of the vector unit. Arrays are views."""
        at = 0
        for code, shift, rounding, elements in self.arrays["vector_ops"].tolist():
            a, b, results = (self.arrays[f"vector_{name}"][at : at + elements] for name in ("a", "b", "results"))
            yield Operation(code, shift, ROUNDINGS[rounding], a, b, results)
            at += elements

    def frame(self) -> Any:
        """The gathering unit's tasks as a pandas DataFrame: vertices, channels, rows, entries."""
        from ._pandas import pandas

        names = ["vertices", "channels", "rows", "entries"]
        return pandas().DataFrame(self.arrays["gather_tasks"], columns=names)

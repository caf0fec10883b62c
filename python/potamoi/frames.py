"""Reports and sweeps of the program as pandas DataFrames.

>>> from potamoi import frames
>>> frames.sweep("out/sweep/rows.csv")                                                    # doctest: +SKIP
>>> frames.report("model.json")["scenes.outcomes"]                                        # doctest: +SKIP
"""

from __future__ import annotations

import json
from os import PathLike
from typing import Any, Iterator, Union

from ._pandas import pandas
from ._rows import columns

#: pandas' types of columns that may lack values.
_TYPES = {"string": "string", "int64": "Int64", "float64": "Float64", "bool": "boolean"}


def sweep(path: Union[str, PathLike[str]]) -> Any:
    """The rows of a sweep, from ``rows.csv`` or a report of ``potamoi sweep --json``.

    A figure that is not known is missing. Columns have the same types in every sweep; see
    :func:`potamoi.parquet.table`.

    Raises:
        ValueError: The file holds no rows of a sweep.
    """
    own = columns(path).items()
    series = {name: pandas().array(values, dtype=_TYPES[kind]) for name, (kind, values) in own}
    return pandas().DataFrame(series)


def front(rows: Any, **directions: str) -> Any:
    """The rows that no other row beats: none is at least as good in every column and better in one.

    Args:
        rows: A DataFrame.
        directions: ``max`` or ``min`` by column, as in ``fps="max", mm2="min"``. Rows in which one of the
            columns is missing are left out.

    Raises:
        ValueError: A direction is neither, or there is no such column.
    """
    if not directions:
        raise ValueError("front: expected a column and its direction, such as fps='max'")
    for name, direction in directions.items():
        if name not in rows.columns:
            raise ValueError(f"front: there is no column {name}")
        if direction not in ("max", "min"):
            raise ValueError(f"front: {name}={direction!r}; expected 'max' or 'min'")
    known = rows.dropna(subset=list(directions))
    signed = [known[name].astype(float) * (1 if way == "max" else -1) for name, way in directions.items()]
    points = list(zip(*signed))
    is_best = [not any(_beats(other, own) for other in points) for own in points]
    return known[is_best]


def _beats(other: tuple[float, ...], own: tuple[float, ...]) -> bool:
    return other != own and all(a >= b for a, b in zip(other, own))


def report(path: Union[str, PathLike[str]]) -> dict[str, Any]:
    """The tables of a report by ``--json``, by their place in it.

    Every list of objects is a DataFrame, one object a row. Its name is its place, as ``scenes.outcomes`` for the
    outcomes of all scenes. Columns are the keys of the objects, those of objects in them after a dot. Lists of an
    object that hold no objects stay lists. Where a list lies in the rows of another, a column of that table's name
    says in which, from 0. The table of the empty name has one row: what stands in no list.

    Raises:
        ValueError: The file is no report.
        OSError: The file cannot be read.
    """
    with open(path, encoding="utf-8") as file:
        try:
            document = json.load(file)
        except ValueError as error:
            raise ValueError(f"{path}: expected a report of --json: {error}") from None
    if not isinstance(document, dict) or "format_version" not in document:
        raise ValueError(f"{path}: expected a report of --json, which has a `format_version`")
    tables: dict[str, list[dict[str, Any]]] = {}
    for place, row in _rows("", {}, document, 0):
        tables.setdefault(place, []).append(row)
    return {place: pandas().DataFrame(rows) for place, rows in tables.items()}


def _is_table(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(own, dict) for own in value)


def _rows(place: str, outer: dict[str, int], own: dict[str, Any], at: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """The row of an object, which is number ``at`` of the table ``place``, and the rows of the tables in it."""
    row: dict[str, Any] = dict(outer)
    inner: list[tuple[str, list[dict[str, Any]]]] = []
    todo = [("", own)]
    while todo:
        prefix, part = todo.pop(0)
        for key, value in part.items():
            name = f"{prefix}{key}"
            if _is_table(value):
                inner.append((f"{place}.{name}" if place else name, value))
            elif isinstance(value, dict) and value:
                todo.append((f"{name}.", value))
            else:
                row[name] = value
    yield place, row
    within = {**outer, place: at} if place else outer
    for name, items in inner:
        for number, item in enumerate(items):
            yield from _rows(name, within, item, number)

"""Rows of a sweep as typed columns, from ``rows.csv`` or a report of ``potamoi sweep --json``."""

import csv
import json

#: Columns of names. All others that a sweep writes are numbers.
TEXTS = ("key", "machine", "preset", "scene", "algorithm", "variant", "gpu", "memory", "fidelity",
         "clock_origin", "clock_bound_by", "bottleneck", "bottleneck_not_overlapped", "psnr_beside", "unknown", "refused")
#: Columns of whole numbers.
WHOLES = ("width", "height", "memory_channels")
#: Columns of Booleans, in reports with a front.
BOOLEANS = ("on_front",)
#: First and last column of the figures in rows.csv: what stands between `key` and the first is varied.
FIRST, LAST = "machine", "refused"


def _csv(path):
    """Names of the columns, how many after the first are varied fields, and rows; an empty text is unknown."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    names = rows[0] if rows else []
    if not names or names[0] != "key" or FIRST not in names or names[-1] != LAST:
        raise ValueError(f"{path}: expected the rows.csv of a sweep, whose columns begin with `key`")
    if any(len(row) != len(names) for row in rows):
        raise ValueError(f"{path}: expected {len(names)} cells in each row: it is cut off")
    return names, names.index(FIRST) - 1, [[cell or None for cell in row] for row in rows[1:]]


def _json(path):
    """The same of a report by ``potamoi sweep --json``."""
    with open(path, encoding="utf-8") as file:
        report = json.load(file)
    if not isinstance(report, dict) or report.get("command") != "sweep":
        raise ValueError(f"{path}: expected a report of `potamoi sweep --json`")
    rows = report["rows"]
    names = list(rows[0]) if rows else ["key", FIRST, LAST]
    return names, names.index(FIRST) - 1, [[row.get(name) for name in names] for row in rows]


def _field(values):
    """Type of a varied field and its values: whole numbers, numbers, Booleans, or else texts."""
    known = [value for value in values if value is not None]
    for kind, read in (("int64", int), ("float64", float), ("bool", {"true": True, "false": False}.__getitem__)):
        try:
            read_ones = {value: read(value) for value in known}
        except (ValueError, KeyError):
            continue
        return kind, [None if value is None else read_ones[value] for value in values]
    return "string", values


def _typed(name, is_varied, values):
    """Type of a column and its values."""
    if is_varied:
        return _field([None if value is None else str(value) for value in values])
    if name in TEXTS:
        return "string", values
    if name in BOOLEANS:
        return "bool", values
    read = int if name in WHOLES else float
    kind = "int64" if name in WHOLES else "float64"
    return kind, [None if value is None else read(value) for value in values]


def columns(path):
    """Types and values of the columns by name: ``string``, ``int64``, ``float64`` or ``bool``; None is unknown.

    Figures have the same types in every sweep; the type of a varied field is that of its values. A field with the
    name of a figure, such as ``clock_ghz``, is the column ``varied.clock_ghz``.
    """
    names, varied, rows = (_json if str(path).endswith(".json") else _csv)(path)
    found = {}
    for at, name in enumerate(names):
        is_varied = 1 <= at <= varied
        column = f"varied.{name}" if is_varied and name in names[varied + 1 :] else name
        found[column] = _typed(name, is_varied, [row[at] for row in rows])
    return found

"""Rows of a sweep as Parquet, with typed columns.

>>> from potamoi.parquet import write
>>> write("out/sweep/rows.csv", "rows.parquet")                                       # doctest: +SKIP

``python3 -m potamoi.parquet ROWS FILE`` is the same as a command. It needs PyArrow.
"""

import argparse
import os
import sys
import tempfile

from ._rows import columns


def table(path):
    """The rows of a sweep as a table of PyArrow.

    `path` is ``rows.csv``, or a report of ``potamoi sweep --json``. Figures have the same types in every sweep;
    the type of a varied field is that of its values. A field with the name of a figure, such as ``clock_ghz``,
    is the column ``varied.clock_ghz``. A figure that is not known is null.
    """
    import pyarrow

    arrays = {}
    for name, (kind, values) in columns(path).items():
        arrays[name] = pyarrow.array(values, type=pyarrow.type_for_alias(kind))
    return pyarrow.table(arrays)


def write(path, out):
    """Writes the rows of a sweep into a Parquet file, whole or not at all. Returns the number of rows."""
    from pyarrow import parquet

    rows = table(path)
    descriptor, unfinished = tempfile.mkstemp(prefix=".potamoi-", dir=os.path.dirname(out) or ".")
    try:
        os.fchmod(descriptor, 0o644)
        with os.fdopen(descriptor, "wb") as file:
            parquet.write_table(rows, file)
        os.replace(unfinished, out)
    except BaseException:
        os.unlink(unfinished)
        raise
    return rows.num_rows


def main(arguments=None):
    """The command."""
    parser = argparse.ArgumentParser(prog="python3 -m potamoi.parquet",
                                     description="Writes the rows of a sweep as Parquet.")
    parser.add_argument("rows", metavar="ROWS", help="rows.csv of a sweep, or the report of its --json")
    parser.add_argument("out", metavar="FILE", help="Parquet file to write")
    args = parser.parse_args(arguments)
    try:
        count = write(args.rows, args.out)
    except ImportError:
        print("error: PyArrow is missing: pip install './python[parquet]'", file=sys.stderr)
        return 3
    except (OSError, ValueError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(f"{count} rows: {args.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

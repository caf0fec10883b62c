"""Reduces what a test of another language compares.

    reduce.py FOLDER

For every NAME.task of the folder, a JSON object with ``knobs`` of the reducer, ``vertices`` and ``channels``, and
NAME.rows, NAME.entry_rows and NAME.entry_weights of 2 bytes a number, writes NAME.results of 4 bytes a number. All
bytes are in the order of little-endian machines.
"""

import json
import sys
from pathlib import Path

import numpy as np
from potamoi import Reducer


def main():
    for path in sorted(Path(sys.argv[1]).glob("*.task")):
        own = json.loads(path.read_text())
        rows = np.fromfile(path.with_suffix(".rows"), dtype="<i2").reshape(-1, own["channels"])
        entries = [np.fromfile(path.with_suffix(f".entry_{name}"), dtype="<u2").reshape(-1, 8)
                   for name in ("rows", "weights")]
        results = Reducer(**own["knobs"]).gather(rows, *entries, own["vertices"])
        results.astype("<i4").tofile(path.with_suffix(".results"))


if __name__ == "__main__":
    main()

"""Computes what a test of another language compares.

    compute.py FOLDER

For every NAME.knobs of the folder, which has lines ``knob = value`` as a TOML file has them, and
NAME.operands, which has operands of 4 bytes, writes NAME.results, which has result codes of 4 bytes,
or NAME.error, if the knobs break a rule. All bytes are in the order of little-endian machines.
"""

import json
import sys
from pathlib import Path

import numpy as np
from potamoi import Exponential
from potamoi._knobs import checked


def knobs_of(text):
    """Knobs by name. Values are read as JSON, in which they look as in TOML."""
    lines = (line.partition("=") for line in text.splitlines() if line.strip())
    pairs = ((name.strip(), json.loads(value)) for name, _, value in lines)
    return {name: checked(name, value) for name, value in pairs}


def main():
    for path in sorted(Path(sys.argv[1]).glob("*.knobs")):
        try:
            engine = Exponential(**knobs_of(path.read_text()))
        except ValueError as error:
            path.with_suffix(".error").write_text(str(error))
            continue
        operands = np.fromfile(path.with_suffix(".operands"), dtype="<i4")
        engine(operands).astype("<u4").tofile(path.with_suffix(".results"))


if __name__ == "__main__":
    main()

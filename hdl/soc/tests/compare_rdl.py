"""Compares a register map in SystemRDL, as PeakRDL's compiler reads it, with the map in JSON.

Usage: compare_rdl.py MAP.rdl MAP.json
Prints every difference. The exit status is 0 if there is none.
"""

import json
import sys

from systemrdl import RDLCompiler
from systemrdl.node import RegNode
from systemrdl.rdltypes import AccessType, OnWriteType

# What software may do (sw), what a written 1 does, and whether the field is a pulse.
ACCESSES = {
    "constant": (AccessType.r, None, False),
    "status": (AccessType.r, None, False),
    "read-write": (AccessType.rw, None, False),
    "write-one-to-clear": (AccessType.rw, OnWriteType.woclr, False),
    "pulse": (AccessType.w, None, True),
}


def differences(top, document):
    """Yields a line for each difference."""
    registers = [node for node in top.descendants() if isinstance(node, RegNode)]
    found = {node.inst_name: node for node in registers}
    listed = {own["name"]: own for own in document["registers"]}
    if top.inst_name != document["name"]:
        yield f"map: {top.inst_name} in SystemRDL, {document['name']} in JSON"
    if len(registers) != len(listed) or list(found) != list(listed):
        yield f"registers: {list(found)} in SystemRDL, {list(listed)} in JSON"
    for name, own in listed.items():
        if name in found:
            yield from of_register(found[name], own, document["word_bits"])


def of_register(node, own, bits):
    """Yields a line for each difference of a register."""
    name = own["name"]
    for what, left, right in [
        ("offset", node.absolute_address, own["offset"]),
        ("bits", node.get_property("regwidth"), bits),
        ("description", node.get_property("desc"), own["description"]),
        ("fields", [field.inst_name for field in node.fields()], [f["name"] for f in own["fields"]]),
    ]:
        if left != right:
            yield f"{name}: {what} {left} in SystemRDL, {right} in JSON"
    software, on_write, pulse = ACCESSES[own["access"]]
    for field in own["fields"]:
        inside = {f.inst_name: f for f in node.fields()}.get(field["name"])
        if inside is None:
            continue
        # A field that follows the hardware has nothing that a reset would set.
        reset = None if own["access"] == "status" else field["reset"]
        for what, left, right in [
            ("low", inside.low, field["low"]),
            ("width", inside.width, field["width"]),
            ("reset", inside.get_property("reset"), reset),
            ("description", inside.get_property("desc"), field["description"]),
            ("access", inside.get_property("sw"), software),
            ("effect of a write", inside.get_property("onwrite"), on_write),
            ("pulse", bool(inside.get_property("singlepulse")), pulse),
            ("volatile", inside.is_volatile, own["volatile"]),
        ]:
            if left != right:
                yield f"{name}.{field['name']}: {what} {left} in SystemRDL, {right} in JSON"


def main():
    """Compares the two files."""
    rdl, listed = sys.argv[1:]
    compiler = RDLCompiler()
    compiler.compile_file(rdl)
    top = compiler.elaborate().top
    with open(listed, encoding="utf-8") as file:
        document = json.load(file)
    lines = list(differences(top, document))
    print("\n".join(lines), end="\n" if lines else "")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())

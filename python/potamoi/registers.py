"""Register maps of the SoC top, from the ``registers/potamoi_npu.json`` that ``potamoi emit`` writes."""

from __future__ import annotations

import json
from dataclasses import dataclass
from os import PathLike
from typing import Any, Union

#: Version of the file that is read.
FORMAT_VERSION = 1


@dataclass(frozen=True)
class Field:
    """A field of a register, bits ``low + width - 1`` to ``low``."""

    name: str
    low: int
    width: int
    reset: int
    description: str

    @property
    def mask(self) -> int:
        """The field's bits in the register."""
        return ((1 << self.width) - 1) << self.low


@dataclass(frozen=True)
class Register:
    """A register. ``offset`` is in bytes, ``access`` how it is read and written."""

    name: str
    offset: int
    access: str
    volatile: bool
    reset: int
    description: str
    fields: tuple[Field, ...]

    def decode(self, value: int) -> dict[str, int]:
        """The fields of a value that was read."""
        if not 0 <= value < 1 << 32:
            raise ValueError(f"{self.name}: {value} does not fit 32 bits")
        return {own.name: (value & own.mask) >> own.low for own in self.fields}

    def encode(self, **fields: int) -> int:
        """The value with these fields; others have their reset values.

        Raises:
            ValueError: A field is unknown, or a value does not fit it.
        """
        known = {own.name: own for own in self.fields}
        value = self.reset
        for name, code in fields.items():
            own = known.get(name)
            if own is None:
                raise ValueError(f"{self.name} has no field {name}: expected some of {', '.join(known)}")
            if not 0 <= code < 1 << own.width:
                raise ValueError(f"{self.name}.{name}: {code} does not fit {own.width} bits")
            value = value & ~own.mask | code << own.low
        return value


class RegisterMap:
    """The registers of a block, by name.

    >>> registers = RegisterMap.read("rtl_out/paper/registers/potamoi_npu.json")          # doctest: +SKIP
    >>> registers["CONTROL"].encode(GU_START=1)                                            # doctest: +SKIP
    """

    def __init__(self, document: dict[str, Any]) -> None:
        self.name: str = document["name"]
        self.configuration: str = document["configuration"]
        self.version: str = document["version"]
        self._registers = {
            own["name"]: Register(**{**own, "fields": tuple(Field(**field) for field in own["fields"])})
            for own in document["registers"]
        }

    @classmethod
    def read(cls, path: Union[str, PathLike[str]]) -> RegisterMap:
        """Reads a map.

        Raises:
            ValueError: The file is no register map, or of another version.
            OSError: The file cannot be read.
        """
        with open(path, encoding="utf-8") as file:
            try:
                document = json.load(file)
                version = document["format_version"]
                if version != FORMAT_VERSION:
                    raise ValueError(f"format_version is {version}: expected {FORMAT_VERSION}")
                return cls(document)
            except (KeyError, TypeError, ValueError) as error:
                raise ValueError(f"{path}: expected the JSON register map of `potamoi emit`: {error}") from None

    def __getitem__(self, name: str) -> Register:
        return self._registers[name]

    def __iter__(self):
        return iter(self._registers.values())

    def __len__(self) -> int:
        return len(self._registers)

    def frame(self) -> Any:
        """The fields of all registers as a pandas DataFrame, one a row."""
        from ._pandas import pandas

        rows = [
            {"register": own.name, "offset": own.offset, "access": own.access, "field": field.name,
             "low": field.low, "width": field.width, "reset": field.reset, "description": field.description}
            for own in self
            for field in own.fields
        ]
        return pandas().DataFrame(rows)

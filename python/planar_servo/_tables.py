"""Files as Python objects: tables as structured arrays, YAML files by their keys."""

from __future__ import annotations

import os
from dataclasses import dataclass
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from . import _core

if TYPE_CHECKING:
    import numpy as np


@dataclass(frozen=True)
class Provenance:
    """What a file says of its making.

    made_from lists (role, name, SHA-256 of the content); sha256 is that of the file itself, without
    the lines in which identical runs may differ. seal is 'sound', 'changed' (after it was written),
    'edited_by_hand' (and sealed again) or 'none', where the file has no checksum.
    """

    kind: str
    maker: str
    made_from: list[tuple[str, str, str]]
    sha256: str
    seal: str


class Record(SimpleNamespace):
    """A map of a YAML file: its keys are attributes, with the units of their names.

    Lists of numbers, and lists of equally long rows of them, are arrays. vars(record) is a dict.
    """


def provenance(path: str | os.PathLike[str]) -> Provenance:
    """Returns what a file of planar-servo, YAML or table, says of its making."""
    return Provenance(**_core._provenance(path))


def read_file(path: str | os.PathLike[str]) -> Record:
    """Reads a YAML file of planar-servo as the programs do, strictly, and returns its keys.

    Raises InputError with every fault at FILE:LINE:COLUMN.
    """
    return _record(_core._read_yaml(path))


def read_table(path: str | os.PathLike[str], kind: str = "") -> np.ndarray[Any, Any]:
    """Reads a CSV table of planar-servo as a structured array with the columns' names and units.

    kind is one of table_kinds(); the table's first line names it where it is empty. Empty numbers
    are NaN, whole numbers int64, columns that the file lacks are left out. Raises InputError with
    every fault at FILE:LINE.
    """
    import numpy as np

    columns = _core._read_columns(path, kind)
    length = len(columns[0][2])
    types: list[tuple[str, Any]] = []
    for name, whole, values in columns:
        text = f"U{max([1, *map(len, values)])}" if whole is None else ""
        types.append((name, text or (np.int64 if whole else np.float64)))
    table = np.empty(length, dtype=types)
    for name, _, values in columns:
        table[name] = values
    return table


def _record(keys: dict[str, Any]) -> Record:
    return Record(**{key: _value(value) for key, value in keys.items()})


def _value(value: Any) -> Any:
    if isinstance(value, dict):
        return _record(value)
    if not isinstance(value, list):
        return value
    if value and all(_is_number(item) for item in value):
        return _array(value)
    rows = all(isinstance(item, list) and item and all(map(_is_number, item)) for item in value)
    if value and rows and len({len(item) for item in value}) == 1:
        return _array(value)
    return [_value(item) for item in value]


def _is_number(item: Any) -> bool:
    return isinstance(item, (int, float)) and not isinstance(item, bool)


def _array(value: list[Any]) -> Any:
    import numpy as np

    return np.array(value, dtype=float)

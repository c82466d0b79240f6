"""Vision of a planar arm: lamps, cameras, error maps, arms, files, and cells that move.

Lengths are metres and angles radians unless a name says otherwise; files keep their units in their
names. Pictures are uint8 arrays (rows, columns), whose memory is used as it is. See doc/api.md.
"""

from __future__ import annotations

import importlib
from typing import Any

from ._version import version as _version

try:
    from . import _core
except ImportError as _error:
    import pathlib
    import sys
    import sysconfig

    _wanted = "_core" + str(sysconfig.get_config_var("EXT_SUFFIX"))
    _found = sorted(path.name for path in pathlib.Path(__file__).parent.glob("_core*"))
    if _wanted in _found:
        raise
    raise ImportError(
        f"planar_servo in {pathlib.Path(__file__).parent} has {', '.join(_found) or 'no extension'}, "
        f"and this Python ({sys.executable}) needs {_wanted}; "
        "use the Python that it was installed for, or install it for this one (pip install .)"
    ) from _error

if _core.__version__ != _version:
    raise ImportError(
        f"planar_servo {_version} found an extension of version {_core.__version__}, "
        f"{_core.__file__}; remove the older of the two and install again"
    )

from ._core import (
    Arm,
    BoardSight,
    Camera,
    CameraFile,
    Cell,
    DiscTracker,
    ErrorMap,
    FoundArm,
    LampCenter,
    LampField,
    LampFieldFit,
    LampPair,
    LampTracker,
    MapFit,
    Move,
    Pairing,
    Registration,
    Step,
    Workplane,
    board_points,
    camera_models,
    find_board,
    fit_error_map,
    fit_lamp_field,
    pair_tracker,
    read_arm,
    read_camera,
    read_map,
    read_workplane,
    register_tracker,
    table_kinds,
    write_table,
)
from ._errors import InputError, WorkError
from ._sequences import track_lamps
from ._tables import Provenance, Record, provenance, read_file, read_table

__version__: str = _version

_LAZY = ("CameraCalibration", "calibrate_camera")  # ViSP's calibration takes a tenth of a second

__all__ = [
    "Arm", "BoardSight", "Camera", "CameraCalibration", "CameraFile", "Cell", "DiscTracker",
    "ErrorMap", "FoundArm", "InputError", "LampCenter", "LampField", "LampFieldFit", "LampPair",
    "LampTracker", "MapFit", "Move", "Pairing", "Provenance", "Record", "Registration", "Step",
    "WorkError", "Workplane", "board_points", "calibrate_camera", "camera_models", "find_board",
    "fit_error_map", "fit_lamp_field", "pair_tracker", "provenance", "read_arm", "read_camera",
    "read_file", "read_map", "read_table", "read_workplane", "register_tracker", "table_kinds",
    "track_lamps", "write_table",
]


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(importlib.import_module("planar_servo._camera"), name)
    raise AttributeError(f"module 'planar_servo' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])

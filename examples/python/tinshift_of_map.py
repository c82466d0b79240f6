"""Writes an error map for PROJ: tinshift_of_map.py GRID.npy MAP.json

GRID.npy is made by planar-export-map --format numpy. `cct -d 4 +proj=tinshift +file=MAP.json` compensates places
then, and refuses those that are not valid. PROJ goes linearly over each half of a cell, which costs about a third
more than planar-export-map says; a smaller --step-mm costs less.
"""

import json
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray


def triangulation(grid: NDArray[Any]) -> dict[str, Any]:
    """The valid nodes, and both halves of every cell as far as their corners are valid."""
    valid = grid["valid"]
    corners = [grid["x_mm"], grid["y_mm"], grid["x_mm"] - grid["dx_mm"], grid["y_mm"] - grid["dy_mm"]]
    number = np.cumsum(valid).reshape(valid.shape) - 1
    a, b, c, d = ((number[cells], valid[cells]) for cells in (
        np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, 1:], np.s_[1:, :-1]))
    halves = [np.stack([n for n, _ in half], axis=-1)[np.logical_and.reduce([v for _, v in half])]
              for half in ((a, b, c), (a, c, d))]
    return {
        "file_type": "triangulation_file",
        "format_version": "1.0",
        "name": "error map",
        "description": grid.dtype.descr[0][0][0],  # says from which map the grid was made
        "input_crs": "base frame as seen, mm",
        "output_crs": "base frame, mm",
        "transformed_components": ["horizontal"],
        "vertices_columns": ["source_x", "source_y", "target_x", "target_y"],
        "triangles_columns": ["idx_vertex1", "idx_vertex2", "idx_vertex3"],
        "vertices": np.stack([corner[valid] for corner in corners], axis=-1).round(7).tolist(),
        "triangles": np.concatenate(halves).tolist(),
    }


def main() -> None:
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        json.dump(triangulation(np.load(sys.argv[1])), file)


if __name__ == "__main__":
    main()

"""Times the module against C++, in turns: speed.py BUILD

Build both first: cmake --build BUILD --target python python_peer. Prints the medians of seven turns
and the ratio of Python to C++.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

BUILD = Path(sys.argv[1]).resolve()
sys.path.insert(0, str(BUILD / "python"))

import numpy as np  # noqa: E402

import planar_servo as ps  # noqa: E402

TURNS, REPEATS, POINTS, PAIRS = 7, 200, 100_000, 248


def lamps(rows: int, columns: int) -> np.ndarray:
    image = np.full((rows, columns), 12, np.uint8)
    v, u = np.mgrid[0:rows, 0:columns]
    for center in ((0.3 * columns, 0.5 * rows), (0.3 * columns + 130, 0.5 * rows + 20)):
        distance = np.hypot(u - center[0], v - center[1])
        image = np.maximum(image, np.clip(200 * (16.5 - distance), 12, 200).astype(np.uint8))
    return image


def seconds(work) -> float:
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def import_seconds() -> float:
    code = "import time; t = time.perf_counter(); import planar_servo; print(time.perf_counter() - t)"
    return float(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True,
                                env={**os.environ, "PYTHONPATH": str(BUILD / "python")}).stdout)


def main() -> None:
    random = np.random.default_rng(1)
    p = random.uniform(-0.4, 0.4, (PAIRS, 2))
    error = 3e-4 * np.sin(5 * p) + random.normal(0, 5e-6, p.shape)
    fit = ps.fit_error_map(p, p - error)
    points = random.uniform(-0.4, 0.4, (POINTS, 2))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "pairs.csv").write_text("x_vision_mm,y_vision_mm,x_tracker_mm,y_tracker_mm\n")
        fit.write(folder / "map.yaml", folder / "pairs.csv")
        points.tofile(folder / "points.raw")
        for rows, columns in ((512, 512), (2048, 2448)):
            image = lamps(rows, columns)
            image.tofile(folder / "image.raw")
            tracker = ps.LampTracker()
            ours, theirs = [], []
            for _ in range(TURNS):
                peer = subprocess.run(
                    [BUILD / "bin/python_peer", folder / "map.yaml", folder / "points.raw",
                     folder / "image.raw", str(columns), str(REPEATS)],
                    capture_output=True, text=True, check=True)
                theirs.append([float(word) for word in peer.stdout.split()])
                ours.append([
                    seconds(lambda: fit.map.predict(points)),
                    seconds(lambda: [tracker.locate(image) for _ in range(REPEATS)]) / REPEATS])
            (predict, locate), (predict_cpp, locate_cpp) = (
                [statistics.median(column) for column in zip(*times)] for times in (ours, theirs))
            print(f"predict {POINTS} places by {PAIRS} pairs: {predict:.3f} s, C++ {predict_cpp:.3f} s, "
                  f"ratio {predict / predict_cpp:.3f}")
            print(f"locate in {columns} x {rows} px: {1e6 * locate:.1f} us, C++ {1e6 * locate_cpp:.1f} us, "
                  f"ratio {locate / locate_cpp:.3f}")
    print(f"import: {statistics.median(import_seconds() for _ in range(TURNS)):.3f} s")


if __name__ == "__main__":
    main()

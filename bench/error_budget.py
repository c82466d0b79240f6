#!/usr/bin/env python3
"""Prints where the error of the closed loop on calib/paper comes from, before and after: with a map at the
end point and the arm of the cell file, and with the field at the lamps and the arm that was found. Both are
learned from the same recording of 200 tracker readings, and both go to the same 100 targets.

    bench/error_budget.py BIN_DIR OUT_DIR [--seed N]

Truth minus target is landing (by its own view) minus the vision error, and the vision error is a common
shift, turn and scale, the lamps' noise, and what the map or field leaves. All in mm, rms of the length."""

import argparse
import csv
import math
import pathlib
import re
import shutil
import statistics
import subprocess

CELL = pathlib.Path(__file__).resolve().parent.parent / "calib/paper"


def rows(path):
    with open(path) as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def vectors(results, name):
    return [complex(float(r[f"{name}_dx_mm"]), float(r[f"{name}_dy_mm"])) for r in results]


def rms(values):
    return math.sqrt(statistics.mean(abs(v) ** 2 for v in values))


def common_part(places, errors):
    """Returns the shift, turn and growth about the base's axis that explain errors best, at the places."""
    n, p, e = len(places), statistics.fmean, errors
    mean_p, mean_e = sum(places) / n, sum(e) / n
    spread = p([abs(q - mean_p) ** 2 for q in places])
    factor = sum((q - mean_p).conjugate() * (v - mean_e) for q, v in zip(places, e)) / n / spread
    return [mean_e + factor * (q - mean_p) for q in places]


def lamp_noise(lamps, frames):
    """Returns the noise of an end point over so many frames, by the scatter of pictures of one place."""
    places = {}
    for row in lamps:
        if row["status"] == "ok":
            places.setdefault(row["id"], []).append(
                complex(float(row["x_vision_mm"]), float(row["y_vision_mm"])))
    scatter = [abs(v - sum(vs) / len(vs)) ** 2 * len(vs) / (len(vs) - 1)
               for vs in places.values() if len(vs) > 1 for v in vs]
    return math.sqrt(statistics.mean(scatter) / frames)


def budget(name, results, noise):
    results = [r for r in results if r["after_truth_dx_mm"]]
    places = [complex(float(r["x_mm"]), float(r["y_mm"])) for r in results]
    vision = vectors(results, "vision_compensated")
    common = common_part(places, vision)
    left = rms([v - c for v, c in zip(vision, common)])
    field = math.sqrt(max(0.0, left ** 2 - noise ** 2))
    total = vectors(results, "after_truth")
    print(f"{name:<34}{statistics.fmean(map(abs, total)):>8.4f}{rms(total):>8.4f}"
          f"{rms(vectors(results, 'after_own_view')):>9.4f}{rms(vision):>8.4f}{rms(common):>9.4f}"
          f"{noise:>8.4f}{field:>8.4f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("out_dir", type=pathlib.Path)
    parser.add_argument("--seed", default="1")
    options = parser.parse_args()
    bin_dir, run = options.bin_dir.resolve(), options.out_dir.resolve() / "run"
    shutil.rmtree(run, ignore_errors=True)

    def program(name, *arguments):
        subprocess.run([bin_dir / name, "-q", *arguments], check=True, stdout=subprocess.DEVNULL)

    program("planar-experiment", "--cell", CELL / "cell.yaml", "--out", run, "--seed", options.seed,
            "--train", "200")
    ours = run / "ours"
    cell = (CELL / "cell.yaml").read_text().replace("truth.yaml", str(CELL / "truth.yaml"))
    (ours / "cell.yaml").write_text(re.sub(r"error_map: \S+", "error_map: end_point.yaml", cell))
    program("planar-fit-error-map", "-o", ours / "end_point.yaml", ours / "pairs.csv")
    targets = rows(ours / "run/results.csv")
    (ours / "targets.csv").write_text(
        "id,x_mm,y_mm\n" + "".join(f"{t['target']},{t['x_mm']},{t['y_mm']}\n" for t in targets))
    program("planar-servo", "--cell", ours / "cell.yaml", "--targets", ours / "targets.csv", "--out",
            ours / "before")
    program("planar-locate-lamps", "--cell", ours / "cell.yaml", "-o", ours / "seen.csv",
            run / "recording")
    noise = lamp_noise(rows(ours / "seen.csv"), frames=3)
    print(f"{'mm':<34}{'mean':>8}{'rms':>8}{'landing':>9}{'vision':>8}{'common':>9}{'noise':>8}{'field':>8}")
    budget("map at the end point, filed arm", rows(ours / "before/results.csv"), noise)
    budget("field at the lamps, found arm", targets, noise)
    shutil.rmtree(run / "recording")


if __name__ == "__main__":
    main()

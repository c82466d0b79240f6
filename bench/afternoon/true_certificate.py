#!/usr/bin/env python3
"""Holds the certificate of a served cell, which its tracker judged, against the log of the truth.

    true_certificate.py TRUTH_LOG CERTIFICATE_DIR

Prints AP, RP, vAP and the errors over the workspace by the tracker and by the truth, and how far both lie apart at
each move beside what the judge states. Exit status 1 where they lie farther apart than a tracker explains.
"""

import bisect
import csv
import itertools
import math
import pathlib
import statistics
import sys

# What a served cell's tracker has in common in all its readings: its bias, its registration, the reflector's offset.
MOST_APART_MM = 0.02


def rows(path):
    with open(path) as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


class TruthLog:
    def __init__(self, path):
        self.places = [(float(r["t_s"]), (float(r["x_mm"]), float(r["y_mm"]))) for r in rows(path)]
        self.times = [t for t, _ in self.places]

    def at(self, t_s):
        return self.places[bisect.bisect_right(self.times, t_s) - 1][1]


def last_looks(run):
    """Returns when the servo looked last on the way to each target. A move that was begun again after a broken run
    has a stroke to its name."""
    looks = {}
    for step in rows(run / "steps.csv"):
        looks[step["target"].rstrip("'")] = float(step["t_s"])
    return looks


def judged_moves(truth, certificate):
    """Yields each move that counts with its error by the tracker and by the truth, mm."""
    looks = last_looks(certificate)
    for move in rows(certificate / "cycles.csv"):
        if move["status"] != "reached" or not move["dx_mm"]:
            continue
        x, y = truth.at(looks[move["id"]])
        yield (move, (float(move["dx_mm"]), float(move["dy_mm"])),
               (x - float(move["x_mm"]), y - float(move["y_mm"])))


def barycentre(errors):
    return tuple(statistics.mean(axis) for axis in zip(*errors))


def accuracy_and_repeatability(errors):
    """AP and RP of ISO 9283."""
    centre = barycentre(errors)
    distances = [math.dist(error, centre) for error in errors]
    return math.hypot(*centre), statistics.mean(distances) + 3 * statistics.stdev(distances)


def variation(by_direction):
    """vAP of ISO 9283."""
    centres = [barycentre(errors) for errors in by_direction]
    return max(math.dist(a, b) for a, b in itertools.combinations(centres, 2))


def figures(moves):
    """Returns the figures by name, from pairs of a move and its error."""
    poses, directions, lengths = {}, {}, []
    for move, error in moves:
        if move["part"] == "pose":
            poses.setdefault(move["pose"], []).append(error)
        elif move["part"] == "direction":
            directions.setdefault(move["pose"], {}).setdefault(move["from"], []).append(error)
        else:
            lengths.append(math.hypot(*error))
    found = {}
    for pose, errors in sorted(poses.items()):
        found[f"AP {pose}"], found[f"RP {pose}"] = accuracy_and_repeatability(errors)
    for pose, errors in sorted(directions.items()):
        found[f"vAP {pose}"] = variation(errors.values())
    found["workspace, mean"] = statistics.mean(lengths)
    found["workspace, rms"] = math.sqrt(statistics.mean(length**2 for length in lengths))
    found["workspace, largest"] = max(lengths)
    return found


def compare(truth_log, certificate):
    """Returns the table as text, and whether tracker and truth agree."""
    moves = list(judged_moves(TruthLog(truth_log), certificate))
    tracker = figures((move, judged) for move, judged, _ in moves)
    truth = figures((move, true) for move, _, true in moves)
    apart = [(judged[0] - true[0], judged[1] - true[1]) for _, judged, true in moves]
    lines = [f"{name:20}{tracker[name]:8.4f} by the tracker {truth[name]:8.4f} true" for name in tracker]
    common = barycentre(apart)
    scatter = math.sqrt(sum(statistics.variance(axis) for axis in zip(*apart)) / 2)
    stated = max(float(move["judge_sigma_mm"]) for move, _, _ in moves)
    lines.append(f"tracker minus truth at {len(apart)} moves, mm: {common[0]:.4f}, {common[1]:.4f} in common, "
                 f"{scatter:.4f} rms per axis beside it; {stated:.4f} stated")
    return "\n".join(lines), math.hypot(*common) < MOST_APART_MM and scatter < MOST_APART_MM


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    text, agree = compare(sys.argv[1], pathlib.Path(sys.argv[2]))
    print(text)
    sys.exit(0 if agree else 1)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Holds a campaign's figures against those that were kept.

compare.py BOUNDS.json FIGURES.json           exit status 1 when a figure of a cell is more than a
                                              quarter larger than the kept one, or a cell is missing
compare.py --keep BOUNDS.json FIGURES.json    writes BOUNDS.json anew
"""
import json
import sys

TOLERANCE = 1.25
KEYS = ("after_mean_mm_truth", "after_p95_mm_truth", "predicted_mean_mm")


def figures(path):
    with open(path) as file:
        cells = json.load(file)["cells"]
    kept = {}
    for cell in cells:
        row = {key: cell[key] for key in KEYS}
        row["paper_chain_after_mean_mm_truth"] = cell["paper_chain"]["after_mean_mm_truth"]
        row["unreached"] = cell["targets"] - cell["reached"]
        kept[str(cell["seed"])] = row
    return kept


def main():
    arguments = sys.argv[1:]
    keep = arguments[:1] == ["--keep"]
    if len(arguments) != 2 + keep:
        sys.exit(__doc__)
    bounds, found = arguments[keep], figures(arguments[keep + 1])
    if keep:
        with open(bounds, "w") as file:
            json.dump(found, file, indent=2)
            file.write("\n")
        return
    with open(bounds) as file:
        kept = json.load(file)
    worse = 0
    for seed, row in kept.items():
        for key, value in row.items():
            now = found.get(seed, {}).get(key)
            bad = now is None or now > TOLERANCE * value
            worse += bad
            shown = "missing" if now is None else f"{now:.5f}"
            print(f"seed {seed} {key}: {shown}, kept {value:.5f}{'  WORSE' if bad else ''}")
    if worse:
        sys.exit(f"{worse} figures are missing or more than a quarter larger than in {bounds}")


main()

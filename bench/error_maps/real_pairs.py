"""bench/.venv/bin/python bench/error_maps/real_pairs.py BIN DATA [JSON]

Compares error maps of measured pairs.

BIN holds planar-fit-error-map. DATA holds the folders plane_error_maps and tracker_pairs. From the
grid of plane_grid_run1, 200 pairs are drawn twenty times (seeds 1 to 20). A map of them and SciPy's
interpolators, tuned by five-fold cross-validation, predict the rest of that run, and run 2. 'of any
kernel' is tuned over the kernels, too. Rows that differ by more than 0.2 mm from the median of their
eight neighbours are named and not judged on.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from scipy.spatial import cKDTree

from scipy_peer import POSITION_UNIT_MM, SETTINGS, tuned

DRAWS = range(1, 21)
PAIRS = 200
GROSS_MM = 0.2
HEADER = 'id,x_vision_mm,y_vision_mm,x_tracker_mm,y_tracker_mm\n'


def read(path):
    lines = [line.strip().split(',') for line in open(path) if line[0] != '#'][1:]
    values = np.array([[float(v) for v in line[1:5]] for line in lines])
    return [line[0] for line in lines], values[:, :2], values[:, :2] - values[:, 2:]


def write(path, ids, p, e):
    with open(path, 'w') as file:
        file.write(HEADER)
        for row in zip(ids, p, p - e):
            file.write(f'{row[0]},{row[1][0]:.9f},{row[1][1]:.9f},{row[2][0]:.9f},{row[2][1]:.9f}\n')


def gross(p, e):
    around = cKDTree(p).query(p, 9)[1][:, 1:]
    return np.linalg.norm(e - np.median(e[around], axis=1), axis=1) > GROSS_MM


def run_program(binary, arguments):
    with tempfile.NamedTemporaryFile(suffix='.json') as report:
        subprocess.run([binary, '--json', report.name, *map(str, arguments)], check=True,
                       stdout=subprocess.DEVNULL)
        return json.load(open(report.name))


def rms(misses):
    return float(np.sqrt((misses ** 2).sum(1).mean()))


def judge(binaries, folder, train, rests):
    """Returns the rms (mm) of our map and of SciPy's on each of `rests`."""
    write(folder / 'train.csv', *train)
    fitted = run_program(binaries / 'planar-fit-error-map',
                         ['-o', folder / 'map.yaml', folder / 'train.csv'])
    found = {'ours': [], 'rejected': [row['id'] for row in fitted['rejected']]}
    for rest in rests:
        write(folder / 'rest.csv', *rest)
        found['ours'].append(run_program(binaries / 'planar-check-error-map',
                                         [folder / 'map.yaml', folder / 'rest.csv'])['rms_mm'])
    for kernel, settings in {**SETTINGS, 'of any kernel': sum(SETTINGS.values(), [])}.items():
        interpolator = tuned(train[1] / POSITION_UNIT_MM, train[2], settings)
        found[f'scipy {kernel}'] = [rms(interpolator(p / POSITION_UNIT_MM) - e)
                                    for _, p, e in rests]
    return found


def plane_grid(binaries, data, folder):
    ids, p, e = read(data / 'plane_error_maps/plane_grid_run1.csv')
    other = read(data / 'plane_error_maps/plane_grid_run2.csv')
    bad, other_bad = gross(p, e), gross(*other[1:])
    print('not judged on, run 1:', *np.array(ids)[bad], ' run 2:', *np.array(other[0])[other_bad])
    second = tuple(np.array(column)[~other_bad] for column in other)
    found = []
    for seed in DRAWS:
        drawn = np.zeros(len(p), bool)
        drawn[np.random.default_rng(seed).choice(len(p), PAIRS, replace=False)] = True
        pick = lambda mask: (np.array(ids)[mask], p[mask], e[mask])
        found.append(judge(binaries, folder, pick(drawn), [pick(~drawn & ~bad), second]))
    print(f'{"median rms, mm":24}{"rest of run 1":>14}{"run 2":>10}'
          f'   (raw {rms(e[~bad]):.4f}, {rms(second[2]):.4f})')
    for method in [key for key in found[0] if key != 'rejected']:
        medians = np.median([draw[method] for draw in found], axis=0)
        better = np.sum([np.array(draw['ours']) < draw[method] for draw in found], axis=0)
        print(f'{method:24}{medians[0]:14.4f}{medians[1]:10.4f}'
              f'   ours smaller in {better[0]} and {better[1]} of {len(found)} draws')
    return found


def tracker_pairs(binaries, data, folder):
    found = {}
    for name in ['ur10_iso_cubes', 'ur5_grid', 'ur10_grid_orientations']:
        found[name] = run_program(binaries / 'planar-fit-error-map', [
            '-o', folder / 'map.yaml', data / f'tracker_pairs/{name}_pairs.csv'])
        print(f'{name:24}raw {found[name]["raw_rms_mm"]:.3f} mm, leave-one-out '
              f'{found[name]["loo_rms_mm"]:.3f} mm, worth using: {found[name]["worth_using"]}')
    return found


if __name__ == '__main__':
    binaries, data = map(pathlib.Path, sys.argv[1:3])
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        figures = {'plane_grid': plane_grid(binaries, data, folder),
                   'tracker_pairs': tracker_pairs(binaries, data, folder)}
    if len(sys.argv) > 3:
        pathlib.Path(sys.argv[3]).write_text(json.dumps(figures, indent=1))

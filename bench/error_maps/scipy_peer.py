"""bench/.venv/bin/python bench/error_maps/scipy_peer.py FOLDER

Judges SciPy's RBFInterpolator on the draws of one case.

FOLDER holds truth.csv and draw_*.csv of x, y, Ex, Ey in millimetres. Width and smoothing are chosen
by five-fold cross-validation. Prints one JSON object: kernel -> list of {error_mm, fit_s, predict_s}
by draw, error_mm being the rms per axis against the truth.
"""
import json
import pathlib
import sys
import time

import numpy as np
from scipy.interpolate import RBFInterpolator

POSITION_UNIT_MM = 100.0
FOLDS = 5
SINGLE_PREDICTIONS = 200
SMOOTHINGS = 10.0 ** np.arange(-8.0, 1.0)
EPSILONS = 100.0 / (np.sqrt(2.0) * np.geomspace(50.0, 800.0, 6))
SETTINGS = {
    'gaussian': [dict(kernel='gaussian', degree=1, epsilon=e, smoothing=s)
                 for e in EPSILONS for s in SMOOTHINGS[1::2]],
    'thin_plate_spline': [dict(kernel='thin_plate_spline', smoothing=s) for s in SMOOTHINGS],
    'cubic': [dict(kernel='cubic', smoothing=s) for s in SMOOTHINGS],
}


def read(path):
    rows = np.loadtxt(path, delimiter=',')
    return rows[:, :2] / POSITION_UNIT_MM, rows[:, 2:]


def cross_validated(p, e, setting):
    total = 0.0
    for fold in range(FOLDS):
        out = np.arange(len(p)) % FOLDS == fold
        try:
            total += ((RBFInterpolator(p[~out], e[~out], **setting)(p[out]) - e[out]) ** 2).sum()
        except np.linalg.LinAlgError:
            return np.inf
    return total


def tuned(p, e, settings):
    chosen = min(settings, key=lambda setting: cross_validated(p, e, setting))
    return RBFInterpolator(p, e, **chosen)


def run(path, settings, test, truth):
    p, e = read(path)
    begin = time.perf_counter()
    interpolator = tuned(p, e, settings)
    fitted = time.perf_counter()
    for i in range(SINGLE_PREDICTIONS):
        interpolator(test[i:i + 1])
    predicted = time.perf_counter()
    return {'error_mm': float(np.sqrt(((interpolator(test) - truth) ** 2).mean())),
            'fit_s': fitted - begin, 'predict_s': (predicted - fitted) / SINGLE_PREDICTIONS}


if __name__ == '__main__':
    folder = pathlib.Path(sys.argv[1])
    test, truth = read(folder / 'truth.csv')
    draws = sorted(folder.glob('draw_*.csv'))
    print(json.dumps({kernel: [run(path, settings, test, truth) for path in draws]
                      for kernel, settings in SETTINGS.items()}))

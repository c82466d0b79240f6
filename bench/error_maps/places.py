"""bench/.venv/bin/python bench/error_maps/places.py BIN DATA [JSON]

Compares error maps of pairs that share places, four at each, at places that no map has seen.

BIN holds planar-fit-error-map. DATA holds the folder plane_error_maps. In each case twenty draws (seeds
1 to 20):
  simulated   100 places on a disc of 480 mm, readings within 3 mm, 0.02 mm of error per axis that a
              place shares and 0.005 mm of each reading; judged on the field at 2,000 other positions
  grid        112 places evenly on the sheet of plane_grid_run1, each two by two neighbours; judged
              on the circles that are between 3 and 9 mm from the nearest of them
  random      100 places of two by two neighbours at random there, none beside another
Ours is fitted with the column `place` and without. SciPy's interpolators and polynomials are tuned by
five-fold cross-validation that leaves out whole places; the best of them is the one with the smallest
median error of the case.
"""
import json
import pathlib
import sys
import tempfile

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.spatial import cKDTree

from real_pairs import HEADER, gross, read, rms, run_program

DRAWS = range(1, 21)
FOLDS = 5
PER_PLACE = 4
PLACE_SIGMA_MM = 0.02
READING_SIGMA_MM = 0.005
DISC_MM = 480.0
SMOOTHINGS = 10.0 ** np.arange(-7.0, 3.0)
KERNELS = ['thin_plate_spline', 'cubic', 'quintic', 'linear']
SHAPED = ['gaussian', 'multiquadric', 'inverse_multiquadric']
EPSILONS = np.geomspace(0.5, 8.0, 6)
DEGREES = range(1, 8)


def field(p):
    """The vision error (mm) at positions in units of the disc: lens, tilt, and a glow with a knee."""
    x, y = p.T
    r2 = x * x + y * y
    ring = 0.08 * np.maximum(0.0, np.sqrt(r2) - 0.6)
    return np.stack([0.3 * x * r2 + 0.1 * x * y - 0.15 * y + 0.05 * np.sin(3.0 * x) + ring * x,
                     0.3 * y * r2 + 0.1 * y * y + 0.15 * x + 0.05 * np.cos(4.0 * y) + ring * y], 1)


def on_disc(random, count):
    radius = np.sqrt(random.uniform(0.0, 1.0, count))
    angle = random.uniform(0.0, 2.0 * np.pi, count)
    return DISC_MM * np.stack([radius * np.cos(angle), radius * np.sin(angle)], 1)


def simulated(seed):
    random = np.random.default_rng(seed)
    places = np.repeat(np.arange(100), PER_PLACE)
    p = on_disc(random, 100)[places] + random.uniform(-1.06, 1.06, (len(places), 2))
    e = (field(p / DISC_MM) + PLACE_SIGMA_MM * random.standard_normal((100, 2))[places]
         + READING_SIGMA_MM * random.standard_normal((len(places), 2)))
    others = on_disc(random, 2000)
    return (p, e, places), (others, field(others / DISC_MM))


class Sheet:
    """The circles of plane_grid_run1 by row and column, and which of them are no gross outliers."""

    def __init__(self, data):
        ids, self.p, self.e = read(data / 'plane_error_maps/plane_grid_run1.csv')
        self.good = ~gross(self.p, self.e)
        self.at = {tuple(map(int, name[1:].split('c'))): i for i, name in enumerate(ids)}

    def corners(self):
        return [corner for corner in self.at if all(around in self.at
                                                    for around in self.square(corner))]

    def square(self, corner):
        return [(corner[0] + i, corner[1] + j) for i in (0, 1) for j in (0, 1)]

    def case(self, corners):
        chosen = np.array([[self.at[around] for around in self.square(c)] for c in corners]).ravel()
        places = np.repeat(np.arange(len(corners)), PER_PLACE)
        nearest = cKDTree(self.p[chosen]).query(self.p)[0]
        keep = self.good[chosen]
        rest = (nearest > 3.0) & (nearest < 9.0) & self.good
        return ((self.p[chosen][keep], self.e[chosen][keep], places[keep]),
                (self.p[rest], self.e[rest]))

    def grid(self, seed):
        shift = np.random.default_rng(seed).integers(0, (4, 8))
        return self.case([c for c in self.corners()
                          if (c[0] - shift[0]) % 4 == 0 and (c[1] - shift[1]) % 8 == 0])

    def random(self, seed):
        random, taken = np.random.default_rng(seed), []
        corners = self.corners()
        for i in random.permutation(len(corners)):
            if all(max(abs(corners[i][0] - r), abs(corners[i][1] - c)) > 3 for r, c in taken):
                taken.append(corners[i])
        return self.case(taken[:100])


def powers(p, degree):
    x, y = p.T
    return np.stack([x ** i * y ** j for i in range(degree + 1) for j in range(degree + 1 - i)], 1)


def polynomial(p, e, degree):
    solution = np.linalg.lstsq(powers(p, degree), e, rcond=None)[0]
    return lambda at: powers(at, degree) @ solution


def interpolators():
    """Returns each peer's settings as functions from pairs to a function of positions."""
    def rbf(**setting):
        return lambda p, e: RBFInterpolator(p, e, **setting)
    peers = {kernel: [rbf(kernel=kernel, smoothing=s) for s in SMOOTHINGS] for kernel in KERNELS}
    for kernel in SHAPED:
        peers[kernel] = [rbf(kernel=kernel, degree=2, epsilon=epsilon, smoothing=s)
                         for epsilon in EPSILONS for s in SMOOTHINGS[::2]]
    peers['polynomial'] = [lambda p, e, degree=degree: polynomial(p, e, degree)
                           for degree in DEGREES]
    return peers


def left_out(fit, p, e, places):
    """Returns the sum of squares at places that are left out."""
    total = 0.0
    for fold in range(FOLDS):
        out = places % FOLDS == fold
        try:
            total += ((fit(p[~out], e[~out])(p[out]) - e[out]) ** 2).sum()
        except np.linalg.LinAlgError:
            return np.inf
    return total


def ours(binaries, folder, train, rest, named):
    p, e, places = train
    table = folder / 'pairs.csv'
    with open(table, 'w') as file:
        file.write(HEADER.strip() + (',place\n' if named else '\n'))
        for i, (v, t) in enumerate(zip(p, p - e)):
            place = f',q{places[i]}' if named else ''
            file.write(f'{i},{v[0]:.9f},{v[1]:.9f},{t[0]:.9f},{t[1]:.9f}{place}\n')
    fitted = run_program(binaries / 'planar-fit-error-map', ['-o', folder / 'map.yaml', table])
    with open(table, 'w') as file:
        file.write(HEADER)
        for i, (v, t) in enumerate(zip(rest[0], rest[0] - rest[1])):
            file.write(f'{i},{v[0]:.9f},{v[1]:.9f},{t[0]:.9f},{t[1]:.9f}\n')
    checked = run_program(binaries / 'planar-check-error-map', [folder / 'map.yaml', table])
    return checked['rms_mm'], fitted


def judge(binaries, folder, train, rest):
    p, e, places = train
    middle, unit = p.mean(0), 0.5 * np.ptp(p, axis=0).max()
    found = {}
    for named in (True, False):
        name = 'ours, places named' if named else 'ours, places found'
        found[name], fitted = ours(binaries, folder, train, rest, named)
        found[f'{name}: fit'] = {key: fitted[key] for key in (
            'places', 'n_places', 'loo_rms_mm', 'place_noise_mm', 'reading_noise_mm', 'worth_using')}
    at, target = (p - middle) / unit, (rest[0] - middle) / unit
    for peer, settings in interpolators().items():
        best = min(settings, key=lambda fit: left_out(fit, at, e, places))
        found[peer] = rms(best(at, e)(target) - rest[1])
    return found


def run(name, draws, binaries, folder):
    found = [judge(binaries, folder, *draws(seed)) for seed in DRAWS]
    methods = [key for key in found[0] if not key.endswith(': fit')]
    median = {key: float(np.median([draw[key] for draw in found])) for key in methods}
    best = min((key for key in methods if not key.startswith('ours')), key=median.get)
    print(f'{name}: median rms at other places, mm')
    for key in methods:
        ratio = np.median([draw[key] / draw[best] for draw in found])
        print(f'  {key:24}{median[key]:8.4f}   / {best} {ratio:6.3f}')
    for key in ('ours, places named: fit', 'ours, places found: fit'):
        fits = [draw[key] for draw in found]
        print(f'  {key:24}', *sorted({fit['places'] for fit in fits}),
              *(f'{name} {np.median([fit[name] for fit in fits if fit[name] is not None]):.4f}'
                for name in ('n_places', 'loo_rms_mm', 'place_noise_mm', 'reading_noise_mm')
                if any(fit[name] is not None for fit in fits)))
    sys.stdout.flush()
    return found


if __name__ == '__main__':
    binaries, data = map(pathlib.Path, sys.argv[1:3])
    sheet = Sheet(data)
    with tempfile.TemporaryDirectory() as name:
        figures = {case: run(case, draws, binaries, pathlib.Path(name)) for case, draws in {
            'simulated': simulated, 'grid': sheet.grid, 'random': sheet.random}.items()}
    if len(sys.argv) > 3:
        pathlib.Path(sys.argv[3]).write_text(json.dumps(figures, indent=1))

"""What the tests of planar_servo share."""

from pathlib import Path

import numpy as np

import planar_servo as ps

ROOT = Path(__file__).resolve().parents[2]
WORKSHOP = ROOT / "calib/workshop"
SEEDS = ROOT / "tests/fuzz/seeds"


def refused(test, where, call, *arguments, **named):
    """The InputError that a call raises, whose place is `where`."""
    with test.assertRaises(ps.InputError) as caught:
        call(*arguments, **named)
    test.assertEqual(caught.exception.where, where)
    test.assertIsInstance(caught.exception, ValueError)
    return caught.exception


def draw_lamps():
    v, u = (np.mgrid[0 : 8 * 120, 0 : 8 * 200] - 3.5) / 8
    fine = np.full(u.shape, 12.0)
    for center in ((50.3, 60.7), (150.9, 71.2)):
        fine[np.hypot(u - center[0], v - center[1]) < 10.0] = 200.0
    image = fine.reshape(120, 8, 200, 8).mean(axis=(1, 3))
    for axis in (0, 1):
        image = 0.5 * image + 0.25 * (np.roll(image, 1, axis) + np.roll(image, -1, axis))
    return np.round(image).astype(np.uint8)

"""Calls everything with arrays of any shape, type and order: fuzz_bindings.py [SECONDS [SEED]]

Whatever comes, a call returns or raises InputError, WorkError or TypeError; it never ends the
interpreter. Cells are left out: they move.
"""

import random
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, given, seed, settings
from hypothesis import strategies as st
from hypothesis.configuration import set_hypothesis_home_dir
from hypothesis.extra import numpy as hnp

import planar_servo as ps

ROOT = Path(__file__).resolve().parents[2]
FIELD = ps.read_map(ROOT / "tests/fuzz/seeds/map/lamp_field")
CAMERA = ps.read_camera(ROOT / "calib/workshop/camera.yaml").camera
PLANE = ps.read_workplane(ROOT / "calib/workshop/workplane.yaml", CAMERA)
ARM = ps.Arm([0.3, 0.25])
PAIRS = ps.LampTracker()
DISC = ps.DiscTracker()
DOTS = ps.LampTracker("vpdot2")
POINTS = np.random.default_rng(0).uniform(-0.4, 0.4, (30, 2))
MAP = ps.fit_error_map(POINTS, POINTS - 1e-4 * np.sin(4 * POINTS)).map
ALLOWED = (ps.InputError, ps.WorkError, TypeError)

TYPES = ["f8", "f4", "f2", ">f8", "i8", "i4", "u1", "?", "c16", "O", "U3", "M8[s]", "V4"]


def reordered(array: np.ndarray) -> st.SearchStrategy:
    """The same numbers in another order in memory, or with strides of their own."""
    ways = [lambda a: a, np.asfortranarray, lambda a: a[::-1] if a.ndim else a,
            lambda a: a[..., ::-1] if a.ndim else a, lambda a: a.T,
            lambda a: np.repeat(a, 2, axis=0)[::2] if a.ndim else a,
            lambda a: np.broadcast_to(a, (3, *a.shape)), lambda a: a.tolist()]
    return st.sampled_from(ways).map(lambda way: way(array))


SMALL = st.integers(0, 5)
NUMBERS = st.one_of(
    st.sampled_from([0.0, -0.0, np.nan, np.inf, 1e-320, 1e308, -1e308, 1.0, -0.3, 0.2]),
    st.floats(-1, 1), st.floats(width=64))


def arrays(columns: int) -> st.SearchStrategy:
    """Mostly arrays of the right shape with doubtful numbers; at times anything at all."""
    right = st.tuples(SMALL, st.just(columns)) | st.just((columns,))
    fitting = hnp.arrays("f8", right, elements=NUMBERS)
    mild = hnp.arrays("f8", right, elements=st.floats(-1, 1))
    anything = st.sampled_from(TYPES).flatmap(
        lambda kind: hnp.arrays(kind if kind not in ("O", "V4", "U3", "M8[s]") else "f8",
                                hnp.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=5))
        .map(lambda a: np.asarray(np.nan_to_num(a).clip(0, 100)).astype(kind) if kind != "V4" else np.zeros(a.shape, "V4")))
    odd = st.sampled_from([None, "text", b"x", {}, object(), [[1, 2], [3]], 3, range(4), np.float64(2)])
    return st.one_of(mild.flatmap(reordered), fitting.flatmap(reordered), anything.flatmap(reordered), odd)


IMAGES = st.one_of(
    hnp.arrays("u1", hnp.array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=90)).flatmap(reordered),
    hnp.arrays("u1", (64, 80), elements=st.sampled_from([0, 255]), fill=st.just(20)),
    st.builds(lambda u, v, r, level: np.where(
        np.hypot(*(np.mgrid[0:100, 0:140] - np.array([v, u])[:, None, None])) < r, level, 10).astype("u1"),
        st.floats(-10, 150), st.floats(-10, 110), st.floats(0, 60), st.integers(0, 255)),
    arrays(2))
FOLDER = tempfile.TemporaryDirectory()
set_hypothesis_home_dir(FOLDER.name)  # not in the checkout
TEXTS = st.lists(st.text(max_size=4), max_size=5)
WORDS = st.sampled_from(["auto", "rbf", "idw", "hand", "left", "", "none", "\0"])
KINDS = st.sampled_from([*ps.table_kinds(), ""])
CALLS = {
    "project": lambda d: CAMERA.project(d(arrays(3)), d(st.booleans())),
    "unproject": lambda d: CAMERA.unproject(d(arrays(2)), d(st.booleans())),
    "camera": lambda d: ps.Camera(d(st.sampled_from(ps.camera_models())), *d(st.tuples(*[NUMBERS] * 4)),
                                  d(st.lists(NUMBERS, max_size=16))).project([[0.1, 0.2, 1], [5, 5, 1]]),
    "plane": lambda d: PLANE.plane_from_pixel(d(arrays(2)), d(st.booleans())),
    "pixel": lambda d: PLANE.pixel_from_plane(d(arrays(2)), d(st.booleans())),
    "workplane": lambda d: ps.Workplane(CAMERA, d(arrays(4))),
    "predict": lambda d: MAP.predict(d(arrays(2)), d(st.none() | arrays(1))),
    "compensate": lambda d: FIELD.compensate(d(arrays(4))),
    "forward": lambda d: ARM.forward(d(arrays(3))),
    "inverse": lambda d: ARM.inverse(d(arrays(3)), d(WORDS), d(arrays(3))),
    "jacobian": lambda d: ARM.jacobian(d(arrays(3))),
    "arm": lambda d: ps.Arm(d(arrays(2)), d(WORDS)),
    "lamps": lambda d: PAIRS.locate(d(IMAGES), predicted_px=d(st.none() | arrays(2)),
                                    separation_px=d(st.none() | arrays(2))),
    "corner": lambda d: PAIRS.locate(d(IMAGES), corner_px=d(arrays(2))),
    "dots": lambda d: DOTS.locate(d(IMAGES)),
    "disc": lambda d: DISC.locate(d(IMAGES)),
    "start": lambda d: ps.DiscTracker("fast", d(arrays(2))).locate(d(IMAGES)),
    "board": lambda d: ps.find_board(d(IMAGES), d(st.sampled_from(
        ["circles:3x3:5mm", "chessboard:4x3:?mm", "circles:0x0", "x", "circles:99999999999x3:1mm"]))),
    "fit": lambda d: ps.fit_error_map(d(arrays(2)), d(arrays(2)), method=d(WORDS), hand_width=d(NUMBERS)),
    "refit": lambda d: ps.fit_error_map(POINTS, POINTS + d(hnp.arrays("f8", (30, 2), elements=NUMBERS)),
                                        method=d(WORDS), hand_width=d(NUMBERS), sigma=d(st.none() | arrays(1))),
    "register": lambda d: ps.register_tracker(list("abc"), d(arrays(3)), list("abc"), d(arrays(3)), d(NUMBERS)),
    "table": lambda d: ps.write_table(f"{FOLDER.name}/t.csv", d(st.dictionaries(
        st.sampled_from(["id", "x_mm", "y_mm", "z_mm", "t_s", "x", ""]), arrays(1) | TEXTS) | arrays(2)), d(KINDS)),
    "readings": lambda d: ps.write_table(f"{FOLDER.name}/t.csv", {
        "id": d(TEXTS | arrays(1)), **{name: d(arrays(1)) for name in ("t_s", "x_mm", "y_mm", "z_mm")}}, "tracker"),
    "calibrate": lambda d: ps.calibrate_camera(d(arrays(2)), d(st.lists(arrays(2), max_size=4)),
                                               d(st.integers(-2, 10**7)), 90),
}


def check(name: str, chosen_seed: int, examples: int) -> None:
    @seed(chosen_seed)
    @settings(max_examples=examples, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(st.data())
    def call(data: st.DataObject) -> None:
        try:
            CALLS[name](lambda strategy: data.draw(strategy))
        except ALLOWED:
            pass

    call()


def check_files(chosen_seed: int) -> None:
    """Sample files with bytes changed: the readers are fuzzed elsewhere, here what is made of them."""
    dice = random.Random(chosen_seed)
    with tempfile.TemporaryDirectory() as folder:
        for sample in sorted((ROOT / "calib/workshop").glob("*.yaml")):
            text = bytearray(sample.read_bytes())
            for _ in range(dice.randrange(1, 6)):
                text[dice.randrange(len(text))] = dice.randrange(256)
            path = Path(folder) / sample.name
            path.write_bytes(text)
            for read in (ps.read_file, ps.provenance, ps.read_camera, ps.read_map, ps.read_arm, ps.read_table):
                try:
                    read(path)
                except (*ALLOWED, UnicodeDecodeError):
                    pass


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    chosen_seed = int(sys.argv[2]) if len(sys.argv) > 2 else random.randrange(2**32)
    print(f"seed {chosen_seed}", flush=True)
    begin, rounds = time.monotonic(), 0
    while time.monotonic() < begin + seconds:
        for name in CALLS:
            check(name, chosen_seed + rounds, 40)
        check_files(chosen_seed + rounds)
        rounds += 1
    print(f"{rounds} rounds of {len(CALLS)} functions in {time.monotonic() - begin:.0f} s")


if __name__ == "__main__":
    main()

"""Claims about pair_tracker and fit_lamp_field: they do what the programs do with the same recording."""

import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import planar_servo as ps
from support import ROOT, WORKSHOP, refused

BIN = Path(ps.__file__).parents[2] / "bin"
OUTPUTS = ("pairs", "workplane", "tool")


def made_alike(test, ours, theirs):
    """Two files that differ only in the lines in which program, time and checksums stand."""
    ours, theirs = without_makers(ours), without_makers(theirs)
    test.assertGreater(len(theirs), 5)
    test.assertEqual(len(ours), len(theirs))
    for one, other in zip(ours, theirs):
        test.assertTrue(one == other, f"{one[:200]}\n{other[:200]}")  # a diff of such lines takes minutes


def without_makers(path):
    lines = path.read_text().splitlines()
    return [line for line in lines if not re.search(r"^(program|created|checksum|# rows): |[0-9a-f]{64}", line)]


def setUpModule():
    """Has a virtual cell drawn, recorded and calibrated by the programs."""
    folder = tempfile.TemporaryDirectory()
    unittest.addModuleCleanup(folder.cleanup)
    Recorded.made = Path(folder.name) / "made"
    script = ROOT / "tests/programs/calibrated_cell.sh"
    subprocess.run(["bash", script, BIN, Recorded.made], check=True, capture_output=True)


class Recorded(unittest.TestCase):
    made: Path

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.cell = self.made / "cell"
        self.inputs = (self.cell / "cell.yaml", self.cell / "lamps.csv", self.made / "recording")

    def outputs(self, **changed):
        names = {f"{name}_out": self.folder / f"{name}.{'csv' if name == 'pairs' else 'yaml'}" for name in OUTPUTS}
        return {**names, **changed}


class Pairs(Recorded):
    def test_are_those_of_the_program(self):
        found = ps.pair_tracker(*self.inputs, **self.outputs())
        for name in ("pairs.csv", "workplane.yaml", "tool.yaml"):
            made_alike(self, self.folder / name, self.cell / name)
        table = ps.read_table(self.cell / "pairs.csv")
        table = table[np.isfinite(table["x_tracker_mm"])]
        self.assertGreater(len(table), 40)
        self.assertEqual(found.ids, list(table["id"]))
        for side in ("vision", "tracker"):
            p_mm = np.column_stack((table[f"x_{side}_mm"], table[f"y_{side}_mm"]))
            np.testing.assert_allclose(1e3 * getattr(found, f"p_{side}"), p_mm, atol=1e-6)
        camera = ps.read_camera(self.cell / "camera.yaml").camera
        plane = ps.read_workplane(self.cell / "workplane.yaml", camera)
        np.testing.assert_allclose(found.X_WC, plane.X_WC, atol=1e-9)
        self.assertLess(found.registration.rms, 1e-4)
        self.assertEqual(ps.provenance(self.folder / "pairs.csv").kind, "pairs")

    def test_are_made_without_writing(self):
        before = sorted(self.made.rglob("*"))
        by_id, by_time = (ps.pair_tracker(*self.inputs, by=by) for by in ("id", "time"))
        self.assertEqual(sorted(self.made.rglob("*")), before)
        # A reading of the same place at nearly the same time: micrometres apart.
        np.testing.assert_allclose(by_time.p_tracker[: len(by_id.ids)], by_id.p_tracker, atol=1e-4)

    def test_of_a_table_with_a_step_are_made_once_it_is_accepted(self):
        bumped = self.folder / "bumped.csv"
        rows = [line.split(",") for line in (self.inputs[2] / "tracker.csv").read_text().splitlines()]
        for row in rows:  # the reflector is bumped by 0.4 mm midway
            if re.fullmatch("train_[23].", row[0]):
                row[2] = f"{float(row[2]) + 0.4:.5f}"
        bumped.write_text("".join(",".join(row) + "\n" for row in rows))
        with self.assertRaisesRegex(ps.InputError, "from place 'train_"):
            ps.pair_tracker(*self.inputs, tracker=bumped)
        found = ps.pair_tracker(*self.inputs, tracker=bumped, accept_step=True)
        self.assertIn("train_39", found.ids)
        self.assertRegex(" ".join(found.doubts), "from place 'train_")

    def test_refuse_wrong_inputs_and_outputs_before_any_work(self):
        pair = ps.pair_tracker
        refused(self, "by", pair, *self.inputs, by="place")
        refused(self, "pairs_out", pair, *self.inputs, pairs_out=self.folder / "pairs.csv")
        lamps = str(self.inputs[1])
        refused(self, lamps, pair, *self.inputs, **self.outputs(pairs_out=lamps))
        same = str(self.folder / "pairs.csv")
        refused(self, same, pair, *self.inputs, **self.outputs(tool_out=same))
        (self.folder / "tool.yaml").write_text("mine\n")
        refused(self, str(self.folder / "tool.yaml"), pair, *self.inputs, **self.outputs())
        self.assertEqual([path.name for path in self.folder.iterdir()], ["tool.yaml"])
        refused(self, str(self.folder), pair, *self.inputs[:2], self.folder)
        with self.assertRaisesRegex(ps.InputError, "planar-locate-lamps"):  # lamps of another camera
            pair(WORKSHOP / "cell.yaml", *self.inputs[1:])


class LampFields(Recorded):
    def test_are_those_of_the_program(self):
        inputs = (self.cell / "cell.yaml", self.cell / "pairs.csv")
        lays = self.cell / "lays.csv"
        theirs = self.folder / "theirs"
        theirs.mkdir()
        subprocess.run([BIN / "planar-fit-error-map", "--cell", inputs[0], "--lays", lays, "--arm-out",
                        theirs / "arm.yaml", "-o", theirs / "map.yaml", inputs[1]],
                       check=True, capture_output=True)
        fit = ps.fit_lamp_field(*inputs, lays=lays, map=self.folder / "map.yaml", arm=self.folder / "arm.yaml")
        for name in ("map.yaml", "arm.yaml"):
            made_alike(self, self.folder / name, theirs / name)

        table = ps.read_table(inputs[1])
        lamps = np.column_stack([table[f"{axis}_lamp{lamp}_mm"] for lamp in (1, 2) for axis in "xy"]) / 1e3
        for ours, read in zip(fit.field.compensate(lamps), ps.read_map(theirs / "map.yaml").compensate(lamps)):
            np.testing.assert_array_equal(ours, read)
        np.testing.assert_allclose(fit.arm.terms, ps.read_arm(theirs / "arm.yaml").terms, rtol=1e-14)
        np.testing.assert_allclose(fit.arm.link_lengths, [0.3, 0.25], atol=0.3)
        trained = np.isin(table["plan"], ("train", "sweep1", "sweep3")) & np.isfinite(table["x_tracker_mm"])
        self.assertEqual(fit.n_readings + len(fit.left_out), trained.sum())
        self.assertGreater(fit.landing_sigma, 0)

    def test_with_a_bar_are_those_of_the_program(self):
        folder = self.folder / "cell"
        shutil.copytree(self.cell, folder)
        cell, pairs, truth = folder / "cell.yaml", folder / "pairs.csv", folder / "truth.yaml"
        bare = truth.read_text()
        bar, seen, theirs = self.folder / "bar.csv", self.folder / "bar", self.folder / "theirs.yaml"
        bar.write_text("id,x_mm,y_mm,kind,size_mm\nA,0,0,bright_disc,5\nB,300,0,bright_disc,5\n")
        for at in ("100,150,0", "-400,150,0", "-150,-250,85"):
            truth.write_text(bare)
            for command in (["virtual-cell", "put", "--drawing", bar, "--at", at],
                            ["record", "--bar", bar, "--bar-places", "3", "--out", seen]):
                subprocess.run([f"{BIN}/planar-{command[0]}", *command[1:], "--cell", cell], check=True,
                               capture_output=True, stdin=subprocess.DEVNULL)
        files = sorted(seen.glob("*.png"))
        subprocess.run([BIN / "planar-fit-error-map", "--cell", cell, "--bar", bar, "--image", *files, "-o", theirs, pairs],
                       check=True, capture_output=True)
        pictures = [np.round(255 * plt.imread(file)).astype(np.uint8) for file in files]
        ps.fit_lamp_field(cell, pairs, bar=bar, pictures=pictures, map=self.folder / "map.yaml")
        made_alike(self, self.folder / "map.yaml", theirs)

    def test_refuse_wrong_inputs_and_outputs_before_any_work(self):
        cell, pairs = self.cell / "cell.yaml", self.cell / "pairs.csv"
        fit = ps.fit_lamp_field
        refused(self, "arm", fit, cell, pairs, arm=self.folder / "arm.yaml")
        bar = self.folder / "bar.csv"
        refused(self, "pictures", fit, cell, pairs, bar=bar)
        refused(self, "pictures", fit, cell, pairs, bar=bar, pictures=[np.zeros((4, 5), np.uint8)])
        refused(self, "bar_sigma", fit, cell, pairs, bar=bar, bar_sigma=0, pictures=[np.zeros((4, 5), np.uint8)])
        refused(self, str(pairs), fit, cell, pairs, map=pairs)
        refused(self, str(self.folder / "no/map.yaml"), fit, cell, pairs, map=self.folder / "no/map.yaml")
        with self.assertRaisesRegex(ps.InputError, "planar-pair-tracker"):  # pairs of another workplane
            fit(WORKSHOP / "cell.yaml", pairs)
        bare = self.folder / "bare.csv"
        table = ps.read_table(pairs)[["id", "x_vision_mm", "y_vision_mm", "x_tracker_mm", "y_tracker_mm"]]
        ps.write_table(bare, table, "pairs")
        with self.assertRaisesRegex(ps.InputError, "lamp"):
            fit(cell, bare)


if __name__ == "__main__":
    unittest.main()

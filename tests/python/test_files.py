"""Claims about files in planar_servo."""

import tempfile
import unittest
from pathlib import Path

import numpy as np

import planar_servo as ps
from support import SEEDS, WORKSHOP, refused


class Files(unittest.TestCase):
    def test_a_yaml_file_has_its_keys_as_attributes(self):
        cell = ps.read_file(WORKSHOP / "cell.yaml")
        self.assertEqual(cell.format, "planar-servo/cell/1")
        self.assertEqual(cell.arm.link_lengths_mm.shape, (2,))
        self.assertIsInstance(cell.drives[0].kind, str)
        self.assertEqual(ps.provenance(WORKSHOP / "map.yaml").kind, "map")

    def test_faults_of_a_file_are_all_told_with_their_places(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "cell.yaml"
            text = (WORKSHOP / "cell.yaml").read_text()
            path.write_text(text.replace("tool_orientation_deg: ", "tool_orientation_dg: "))
            with self.assertRaises(ps.InputError) as caught:
                ps.read_file(path)
            self.assertGreaterEqual(len(caught.exception.refusals), 1)
            self.assertIn("cell.yaml", str(caught.exception))

    def test_a_table_is_a_structured_array(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "targets.csv"
            path.write_text("# format: planar-servo/targets/1\nid,x_mm,y_mm,phi_deg\na,1.5,2,\nlong name,3,4,90\n")
            table = ps.read_table(path)
            self.assertEqual(list(table["id"]), ["a", "long name"])
            np.testing.assert_array_equal(table["x_mm"], [1.5, 3])
            self.assertTrue(np.isnan(table["phi_deg"][0]))
            path.write_text("id,x_mm,y_mm\na,1.5\n")
            with self.assertRaisesRegex(ps.InputError, r"targets\.csv:2"):
                ps.read_table(path, "targets")
            with self.assertRaisesRegex(ps.InputError, "what kind of table"):
                ps.read_table(path)
        with self.assertRaises(ps.InputError):
            ps.read_table("/nowhere.csv", "pairs")

    def test_every_kind_is_read_and_written_alike(self):
        for kind, seeds in (("cycles", "cycles"), ("frames", "frames"), ("lamps", "lamps"), ("lays", "lays"),
                            ("path", "path"), ("plan", "plan"), ("results", "results"),
                            ("samples", "arm_samples"), ("targets", "targets"), ("tracker", "tracker")):
            read = 0
            for sample in (SEEDS / seeds).iterdir():
                try:
                    table = ps.read_table(sample, kind)
                except ps.InputError:
                    continue  # some samples are bad on purpose
                if len(table):
                    read += 1
                    self.assert_written_as_read(table, kind)
            self.assertGreater(read, 0, kind)
        self.assertEqual(ps.table_kinds(), [
            "cycles", "error_grid", "frames", "lamps", "lays", "pairs", "path", "path_looks", "path_results",
            "plan", "results", "samples", "steps", "targets", "tracker"])

    def assert_written_as_read(self, table, kind):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "t.csv"
            ps.write_table(path, table, kind)
            back = ps.read_table(path)
            self.assertEqual(back.dtype, table.dtype)
            for name in table.dtype.names:
                np.testing.assert_array_equal(back[name], table[name])


class Writing(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = Path(folder.name) / "t.csv"
        self.targets = {"x_mm": [0.1 + 0.2, -1e-7], "id": ["a, \"b\"", "# ü"], "y_mm": np.array([3, 4])}

    def refused(self, where, changes, kind="targets"):
        error = refused(self, where, ps.write_table, self.path, {**self.targets, **changes}, kind)
        self.assertFalse(self.path.exists())
        return error

    def test_a_table_is_read_back_to_the_bit(self):
        ps.write_table(self.path, self.targets, "targets")
        self.assertEqual(self.path.read_text().splitlines()[:2], ["# format: planar-servo/targets/1", "id,x_mm,y_mm"])
        table = ps.read_table(self.path)
        self.assertEqual(list(table["id"]), self.targets["id"])
        np.testing.assert_array_equal(table["x_mm"], self.targets["x_mm"])
        self.path.unlink()
        ps.write_table(self.path, {"id": np.arange(2), "x_mm": [1, 2], "y_mm": [3, 4], "phi_deg": [90, np.nan]}, "targets")
        table = ps.read_table(self.path)
        self.assertEqual(list(table["id"]), ["0", "1"])
        np.testing.assert_array_equal(table["phi_deg"], [90, np.nan])

    def test_faults_name_row_and_column(self):
        self.assertIn("x_mm is 'inf'", self.refused("table[1]", {"x_mm": [0, np.inf]}).fault)
        self.assertIn("y_mm is ''", self.refused("table[0]", {"y_mm": [np.nan, 0]}).fault)
        self.assertEqual(self.refused("table[1]", {"id": ["a", "a"]}).cause, "exists")
        self.assertIn("grid, plane_grid", self.refused("table[0]", {"plan": ["train", "tarin"][::-1]}, "plan").remedy)
        self.assertEqual(self.refused("table['id'][1]", {"id": ["a", None]}).fault, "is None")
        self.refused("table['y_mm']", {"y_mm": [1]})
        self.refused("table['y_mm']", {"y_mm": 1})
        self.refused("table['y_mm']", {"y_mm": ["1", "2"]})
        self.assertIn("x_mm, y_mm", self.refused("table", {"colour": [1, 2]}).remedy)
        self.assertIn("phi_deg", self.refused("table", {"phi_rad": [1, 2]}).fault)
        self.refused("kind", {}, "target")
        for table in ({}, np.zeros((2, 3)), [[1, 2]], None, {"id": [1], "x_mm": [1]},
                      {"id": [], "x_mm": [], "y_mm": []}):
            refused(self, "table", ps.write_table, self.path, table, "targets")
        self.assertFalse(self.path.exists())

    def test_a_file_is_replaced_only_by_a_table_of_its_kind_and_targets_never(self):
        lamps = {"id": ["a"], "status": ["ok"], "u1_px": [1.5], "v1_px": [2]}
        ps.write_table(self.path, lamps, "lamps")
        ps.write_table(self.path, {**lamps, "v1_px": [3]}, "lamps")
        self.assertEqual(ps.read_table(self.path)["v1_px"][0], 3)
        refused(self, str(self.path), ps.write_table, self.path, self.targets, "targets")
        self.path.write_text("mine\n")
        refused(self, str(self.path), ps.write_table, self.path, lamps, "lamps")
        self.assertEqual(self.path.read_text(), "mine\n")
        self.path.unlink()
        ps.write_table(self.path, self.targets, "targets")
        refused(self, str(self.path), ps.write_table, self.path, self.targets, "targets")


if __name__ == "__main__":
    unittest.main()

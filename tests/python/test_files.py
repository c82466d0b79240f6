"""Claims about files in planar_servo."""

import tempfile
import unittest
from pathlib import Path

import numpy as np

import planar_servo as ps
from support import SEEDS, WORKSHOP


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

    def test_every_kind_is_read(self):
        for kind, seeds in (("cycles", "cycles"), ("frames", "frames"), ("lamps", "lamps"), ("lays", "lays"),
                            ("path", "path"), ("plan", "plan"), ("results", "results"),
                            ("samples", "arm_samples"), ("targets", "targets"), ("tracker", "tracker")):
            read = 0
            for sample in (SEEDS / seeds).iterdir():
                try:
                    read += len(ps.read_table(sample, kind)) > 0
                except ps.InputError:
                    pass  # some samples are bad on purpose
            self.assertGreater(read, 0, kind)
        self.assertEqual(ps.table_kinds(), [
            "cycles", "error_grid", "frames", "lamps", "lays", "pairs", "path", "path_looks", "path_results",
            "plan", "results", "samples", "steps", "targets", "tracker"])


if __name__ == "__main__":
    unittest.main()

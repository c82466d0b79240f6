"""The client of planar-console, on a virtual cell."""

import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import planar_servo as ps
from planar_servo.console import Console
from support import ROOT, WORKSHOP

sys.path.insert(0, str(ROOT / "tests/support"))
from served_console import ServedConsole

BIN = ROOT / "build/release/bin"
TARGETS = "id,x_mm,y_mm\na,150,250\nb,-200,300\n"


class ConsoleTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.cell = Path(cls.folder.name) / "cell"
        shutil.copytree(WORKSHOP, cls.cell)
        cls.server = ServedConsole(BIN / "planar-console", cls.cell / "cell.yaml")
        cls.console, cls.looker = Console(cls.server.address["operate"]), Console(cls.server.address["look on"])
        cls.console.command("enable")

    @classmethod
    def tearDownClass(cls):
        cls.server.end()
        cls.folder.cleanup()

    def refused(self, kind, call, *arguments):
        with self.assertRaises(kind) as caught:
            call(*arguments)
        return caught.exception

    def test_both_rights_see_the_cell_and_its_picture(self):
        self.assertEqual((self.console.cell()["right"], self.looker.cell()["right"]), ("operate", "read"))
        self.assertTrue(self.looker.place(200.0, 100.0)["reachable"])
        self.assertFalse(self.looker.place(2000.0, 100.0)["reachable"])
        self.assertEqual(self.looker.picture()[:3], b"\xff\xd8\xff")
        self.assertIn("next", self.looker.files())

    def test_results_come_as_targets_are_reached(self):
        self.assertEqual([target["id"] for target in self.console.set_targets(TARGETS)], ["a", "b"])
        results = list(self.console.run("two"))
        self.assertEqual([(r["target"], r["status"]) for r in results], [("a", "reached"), ("b", "reached")])
        self.assertEqual(self.console.go(100.0, 300.0)["status"], "reached")

    def test_a_run_that_is_left_stops(self):
        self.console.set_targets(TARGETS)
        for _ in self.console.run("left"):
            break
        ended = (state["job"] for kind, state in self.looker.events() if kind == "state" and state["job"]["ended"])
        job = next(ended)
        self.assertEqual((job["name"], job["done"], job["ok"]), ("left", 1, False))

    def test_a_certificate_that_is_there_is_read_again_and_a_wrong_size_is_refused(self):
        size = ("--cycles", "2", "--targets", "1", "--out", str(self.cell / "proof"))
        subprocess.run([BIN / "planar-certify", "-q", "--cell", self.cell / "cell.yaml", *size], check=True, capture_output=True)
        self.assertIn("35 of 35 moves reached and judged", self.console.certify("proof", cycles=2, targets=1))
        self.assertEqual(self.refused(ps.InputError, self.console.certify, "proof", 1).where, "cycles")
        self.assertEqual(self.refused(ps.InputError, self.console.experiment, "no/where").where, "out")

    def test_each_pass_over_a_path_is_told(self):
        places = self.console.set_path("x_mm,y_mm\n300,200\n270,200\n")
        self.assertEqual((places["length_mm"], places["places_mm"]), (30.0, [[300.0, 200.0], [270.0, 200.0]]))
        passes = list(self.console.follow("path", [30, 50]))
        self.assertEqual([(p["speed_mm_s"], p["guided_by"], p["status"]) for p in passes],
                         [(30.0, "vision", "reached"), (50.0, "vision", "reached")])
        self.assertIn("50 mm/s", self.refused(ps.InputError, lambda: list(self.console.follow("no", [60]))).fault)
        self.assertIn("the path:3", self.refused(ps.InputError, self.console.set_path, "x_mm,y_mm\n1,2\n1\n").where)

    def test_one_line_moves_the_arm_and_another_says_why_not(self):
        before = self.console.state()["arm"]["joints_deg"][2]
        self.console.command("joint 3 1")
        self.assertAlmostEqual(self.console.state()["arm"]["joints_deg"][2] - before, 1.0, places=2)
        refusal = self.refused(ps.InputError, self.console.command, "joint 3 1000")
        self.assertIn("motor 3", refusal.fault)
        self.assertEqual(refusal.cause, "unreachable")

    def test_what_is_refused_is_named(self):
        refusal = self.refused(ps.InputError, self.console.set_targets, "id,x_mm,y_mm\nA,far,1\nB,1\n")
        self.assertEqual(len(refusal.refusals), 2)
        self.assertIn("far", refusal.fault)
        self.assertIn("may read only", str(self.refused(ps.WorkError, self.looker.command, "enable")))
        self.assertEqual(self.refused(ps.InputError, Console, "127.0.0.1:8377").where, "address")
        nobody = Console("http://127.0.0.1:1/?token=0")
        self.assertIn("start planar-console", self.refused(ps.WorkError, nobody.state).remedy)


if __name__ == "__main__":
    unittest.main()

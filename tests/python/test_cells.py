"""Claims about cells that move, and about the installed module."""

import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

import numpy as np

import planar_servo as ps
from support import WORKSHOP, refused


class Cells(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        shutil.copytree(WORKSHOP, self.folder / "cell")
        self.path = self.folder / "cell/cell.yaml"
        self.target = self.a_target()

    def a_target(self):
        field = ps.read_map(WORKSHOP / "map.yaml")
        return field.hull.mean(axis=0) * 0.2 + field.hull[0] * 0.5

    def test_a_target_is_reached_and_every_step_told(self):
        steps = []
        with ps.Cell(self.path) as cell:
            move = cell.move_to(self.target, on_step=steps.append)
            self.assertEqual((move.status, move.reason), ("reached", ""))
            self.assertEqual([s.iteration for s in steps], [s.iteration for s in move.steps])
            self.assertRegex(repr(steps), r"^\[<Step 0: at \(-?0\.\d{6}, -?0\.\d{6}\) m, 0\.\d{4} mm from the target>, ")
            self.assertRegex(repr(cell), "<Cell .*cell.yaml, open>")
            self.assertLess(np.hypot(*(cell.true_position() - self.target)), 1e-4)
            self.assertEqual(cell.picture().dtype, np.uint8)
            self.assertEqual(cell.joints.shape, (3,))
        self.assertFalse(cell.is_open)
        with self.assertRaisesRegex(ps.InputError, "closed"):
            cell.move_to(self.target)

    def test_a_target_out_of_reach_is_refused_and_a_wrong_one_raises(self):
        with ps.Cell(self.path) as cell:
            move = cell.move_to([5.0, 5.0])
            self.assertEqual(move.status, "refused")
            self.assertIn("out of reach", move.reason)
            refused(self, "p", cell.move_to, [1, 2, 3])
            refused(self, "phi", cell.move_to, self.target, math.nan)
            refused(self, "phi", cell.move_to, self.target, 90)  # degrees
            refused(self, "p", cell.move_to, 1e3 * self.target)  # millimetres

    def test_an_exception_of_a_callback_ends_the_motion(self):
        def fail(step):
            raise KeyError("mine")

        with ps.Cell(self.path) as cell:
            with self.assertRaisesRegex(KeyError, "mine"):
                cell.move_to(self.target, on_step=fail)
            self.assertTrue(cell.move_to(self.target).reached)

    def test_a_callback_must_not_move_the_cell(self):
        caught = []

        def meddle(step):
            try:
                cell.move_to([0.1, 0.2])
            except ps.WorkError as error:
                caught.append(error)

        with ps.Cell(self.path) as cell:
            cell.move_to(self.target, on_step=meddle)
        self.assertEqual(caught[0].cause, "busy")

    def test_a_signal_stops_the_motion_while_it_lasts(self):
        def interrupt(*_):
            try:
                cell.joints
            except ps.WorkError:  # at work: this is called from within the motion
                raise KeyboardInterrupt

        with ps.Cell(self.path, check_health=False) as cell:
            cell.move_to(self.target)  # from now on nothing is logged, which would run Python, too
            former = signal.signal(signal.SIGALRM, interrupt)
            signal.setitimer(signal.ITIMER_REAL, 2e-3, 2e-3)
            try:
                with self.assertRaises(KeyboardInterrupt):
                    for _ in range(100):
                        cell.move_to(self.target)
                        cell.move_to([-0.2, 0.3])
            finally:
                signal.setitimer(signal.ITIMER_REAL, 0)
                signal.signal(signal.SIGALRM, former)
            self.assertTrue(cell.move_to(self.target).reached)

    def test_ctrl_c_in_a_callback_ends_the_motion(self):
        with ps.Cell(self.path) as cell:
            with self.assertRaises(KeyboardInterrupt):
                cell.move_to(self.target, on_step=lambda step: os.kill(os.getpid(), signal.SIGINT))
            self.assertTrue(cell.move_to(self.target).reached)

    def test_another_thread_stops_it(self):
        with ps.Cell(self.path, check_health=False) as cell:
            ends = []

            def work():
                try:
                    while True:
                        cell.move_to(self.target)
                        cell.move_to(-self.target)
                except ps.WorkError as error:
                    ends.append(error)

            thread = threading.Thread(target=work, daemon=True)
            thread.start()
            deadline = time.monotonic() + 20
            while thread.is_alive() and time.monotonic() < deadline:
                cell.stop()
                time.sleep(0.01)
            thread.join(1)
            self.assertEqual(len(ends), 1)

    def test_a_run_writes_what_planar_servo_writes(self):
        targets = self.folder / "targets.csv"
        x, y = 1e3 * self.target
        targets.write_text(f"id,x_mm,y_mm\na,{x},{y}\n")
        with ps.Cell(self.path) as cell:
            figures = cell.run(targets, self.folder / "run")
            with self.assertRaisesRegex(ps.InputError, "add resume=True") as caught:  # no program's option
                cell.run(targets, self.folder / "run")
            self.assertIn("resume=True", caught.exception.remedy)
        self.assertEqual(figures["reached"], 1)
        steps = ps.read_table(self.folder / "run/steps.csv")
        self.assertEqual(steps["target"][0], "a")
        self.assertTrue((self.folder / "run/report.html").exists())
        self.assertEqual(ps.read_table(self.folder / "run/results.csv")["status"][0], "reached")
        self.assertEqual(ps.read_file(self.folder / "run/run.yaml").format, "planar-servo/run/1")

    def test_python_ends_well_with_a_cell_open_and_with_one_that_a_thread_moves(self):
        begin = f"import planar_servo as ps, threading; cell = ps.Cell({str(self.path)!r}, check_health=False)\n"
        away = f"cell.move_to({self.target.tolist()!r})\n"
        forth = f"def work():\n  while True:\n    {away}    cell.move_to([-0.2, 0.3])\n"
        thread = "t = threading.Thread(target=work, daemon=True); t.start(); import time; time.sleep(0.5)\n"
        for script in (begin + away, begin + forth + thread):
            run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
            self.assertEqual(run.returncode, 0, run.stderr)

    def test_a_missing_file_names_the_program_that_makes_it(self):
        (self.folder / "cell/workplane.yaml").unlink()
        with self.assertRaisesRegex(ps.InputError, "planar-pair-tracker"):
            ps.Cell(self.path)


class Install(unittest.TestCase):
    def broken(self, change):
        """The message of importing a copy of the package that `change` has spoilt."""
        with tempfile.TemporaryDirectory() as folder:
            package = Path(folder) / "planar_servo"
            shutil.copytree(Path(ps.__file__).parent, package)
            change(package)
            run = subprocess.run([sys.executable, "-c", "import planar_servo"], capture_output=True,
                                 text=True, cwd=folder, env={**os.environ, "PYTHONPATH": folder})
            self.assertEqual(run.returncode, 1)
            return run.stderr

    def test_an_extension_of_another_version_is_named(self):
        message = self.broken(lambda package: (package / "_version.py").write_text('version = "9.8.7"\n'))
        self.assertIn("9.8.7", message)
        self.assertIn("version " + ps.__version__, message)

    def test_an_extension_for_another_python_is_named(self):
        def rename(package):
            for path in package.glob("_core*.so"):
                path.rename(package / "_core.cpython-37m-x86_64-linux-gnu.so")

        self.assertIn("cpython-37m", self.broken(rename))

    def test_an_import_loads_neither_numpy_nor_a_window(self):
        code = ("import sys, planar_servo; maps = open('/proc/self/maps').read(); "
                "assert 'numpy' not in sys.modules; "
                "assert not [n for n in ('Qt', 'gdal', 'libopencv_highgui', 'imgcodecs', 'hdf5') if n in maps]")
        subprocess.run([sys.executable, "-c", code], check=True)


if __name__ == "__main__":
    unittest.main()

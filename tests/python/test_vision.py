"""Claims about lamps, cameras, maps, arms and trackers in planar_servo."""

import math
import tempfile
import unittest
from pathlib import Path

import numpy as np

import planar_servo as ps
from support import SEEDS, draw_lamps, refused


class Lamps(unittest.TestCase):
    def test_are_found_where_they_were_drawn(self):
        pair = ps.LampTracker().locate(draw_lamps(), predicted_px=[[50, 60], [150, 70]])
        self.assertEqual(pair.status, "ok")
        np.testing.assert_allclose(pair.uv_px, [[50.3, 60.7], [150.9, 71.2]], atol=0.02)
        covariance = pair.lamps[0].covariance_px2
        self.assertTrue(0 < covariance[0, 0] < 0.01)

    def test_a_part_of_the_sensor_gives_pixels_of_the_whole(self):
        image = draw_lamps()
        part = image[10:, 20:]  # a view of the array, not a copy
        whole = ps.LampTracker().locate(image).uv_px
        np.testing.assert_allclose(ps.LampTracker().locate(part, corner_px=(20, 10)).uv_px, whole, atol=1e-3)

    def test_are_followed_in_their_order(self):
        images = [draw_lamps(), np.roll(draw_lamps(), 3, axis=1)]
        first, second = ps.track_lamps(images, predicted_px=[[151, 71], [50, 61]])
        self.assertEqual((first.status, second.status), ("ok", "ok"))
        np.testing.assert_allclose(second.uv_px - first.uv_px, [[3, 0], [3, 0]], atol=0.02)
        self.assertGreater(first.uv_px[0, 0], 100)

    def test_refuse_what_is_no_grey_picture(self):
        image = draw_lamps()
        locate = ps.LampTracker().locate
        for wrong in (image.astype(float), image[:, ::2], image[::-1], np.asfortranarray(image),
                      np.dstack([image] * 3), image[:0], [[1, 2], [3, 4]], None,
                      np.broadcast_to(image[:1], image.shape), image.astype(bool)):
            error = refused(self, "image", locate, wrong)
            self.assertIn("uint8", error.remedy)
        refused(self, "corner_px", locate, image, corner_px=(0.5, 0))
        refused(self, "predicted_px", locate, image, predicted_px=[1, 2])
        refused(self, "method", ps.LampTracker, "guess")

    def test_a_disc_is_followed(self):
        tracker = ps.DiscTracker(start_px=(150, 71))
        np.testing.assert_allclose(tracker.locate(draw_lamps()).uv_px, [150.9, 71.2], atol=0.02)
        self.assertEqual(tracker.locate(np.zeros((50, 50), np.uint8)).status, "no_lamp")


class Cameras(unittest.TestCase):
    def setUp(self):
        self.camera = ps.Camera("rational_polynomial", 1400, 1390, 640, 480, [-0.1, 0.02, 1e-3])
        self.p_C = np.random.default_rng(1).uniform([-0.3, -0.2, 1], [0.3, 0.2, 1.5], (40, 3))

    def test_unproject_undoes_project(self):
        rays = self.camera.unproject(self.camera.project(self.p_C))
        np.testing.assert_allclose(rays, self.p_C[:, :2] / self.p_C[:, 2:], atol=1e-12)

    def test_jacobians_are_the_derivatives(self):
        step = 1e-6
        uv, J = self.camera.project(self.p_C, jacobian=True)
        xy, J_ray = self.camera.unproject(uv, jacobian=True)
        for axis in range(3):
            moved = self.p_C + step * np.eye(3)[axis]
            np.testing.assert_allclose((self.camera.project(moved) - uv) / step, J[:, :, axis], rtol=1e-4, atol=1e-2)
        moved = self.camera.unproject(uv + [step, 0])
        np.testing.assert_allclose((moved - xy) / step, J_ray[:, :, 0], rtol=1e-3, atol=1e-8)

    def test_one_point_and_many_have_their_shapes(self):
        self.assertEqual(self.camera.project([0, 0, 1]).shape, (2,))
        self.assertEqual(self.camera.project(np.zeros((0, 3))).shape, (0, 2))
        strided = np.asfortranarray(np.repeat(self.p_C, 2, axis=0))[::2]
        np.testing.assert_array_equal(self.camera.project(strided), self.camera.project(self.p_C))
        self.assertTrue(np.isnan(self.camera.project([0, 0, -1])).all())

    def test_points_in_a_field_of_a_table_are_read_where_they_are(self):
        table = np.zeros(len(self.p_C), [("id", "U1"), ("p", "f8", 3), ("more", "U2")])  # 36 bytes a row
        table["p"] = self.p_C
        np.testing.assert_array_equal(self.camera.project(table["p"]), self.camera.project(self.p_C))

    def test_wrong_points_are_refused_by_name(self):
        for wrong in (np.zeros((3, 2)), np.zeros((2, 2, 3)), np.zeros(3, complex), "abc", None,
                      np.full((4, 3), np.nan), [[1, 2, math.inf]], np.zeros((3, 3), bool),
                      np.array([None] * 3), np.zeros(3, "datetime64[s]")):
            self.assertIn("needed", refused(self, "p_C", self.camera.project, wrong).remedy)
        with self.assertRaises(ps.InputError):
            ps.Camera("fish", 1, 1, 0, 0)
        with self.assertRaises(ps.InputError):
            ps.Camera("pinhole", math.nan, 1, 0, 0)
        self.assertTrue(np.isnan(self.camera.unproject([1e200, 0])).all())

    def test_masks_are_not_lost(self):
        masked = np.ma.masked_array(self.p_C, False)
        np.testing.assert_array_equal(self.camera.project(masked), self.camera.project(self.p_C))
        masked[1, 2] = np.ma.masked
        self.assertIn("filled", refused(self, "p_C", self.camera.project, masked).remedy)
        image = np.ma.masked_equal(draw_lamps(), 12)
        refused(self, "image", ps.LampTracker().locate, image)

    def test_files_hold_what_was_written(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, model in (("c.yaml", "opencv_14"), ("c.yml", "plumb_bob"), ("c.xml", "visp"),
                                ("c.yaml", "equidistant")):
                camera = ps.Camera(model, 1400, 1390, 640, 480, [-0.1, 0.02])
                path = Path(folder) / name
                ps.CameraFile(camera, 1280, 960).write(path)
                back = ps.read_camera(path)
                self.assertEqual((back.width_px, back.camera.model), (1280, model))
                np.testing.assert_allclose(back.camera.coefficients, camera.coefficients, rtol=1e-9)
            with self.assertRaisesRegex(ps.InputError, "has no model visp"):
                ps.CameraFile(ps.Camera("visp", 1, 1, 0, 0), 10, 10).write(Path(folder) / "v.yaml")

    def test_the_plane_and_its_pixels_are_inverse(self):
        pose = np.diag([1.0, -1.0, -1.0, 1.0])
        pose[2, 3] = 1.5
        plane = ps.Workplane(self.camera, pose)
        self.assertEqual(repr(plane), "<Workplane seen from (0.0000, 0.0000, 1.5000) m>")
        p_W = np.array([[0.1, 0.2], [-0.3, 0.1]])
        uv, J = plane.pixel_from_plane(p_W, jacobian=True)
        p, J_back = plane.plane_from_pixel(uv, jacobian=True)
        np.testing.assert_allclose(p, p_W, atol=1e-12)
        np.testing.assert_allclose(J @ J_back, np.broadcast_to(np.eye(2), (2, 2, 2)), atol=1e-9)
        refused(self, "X_WC", ps.Workplane, self.camera, np.ones((4, 4)))
        in_mm = np.array(pose)
        in_mm[:3, 3] *= 1e3
        self.assertIn("millimetres", refused(self, "X_WC", ps.Workplane, self.camera, in_mm).remedy)

    def test_a_calibration_finds_the_camera(self):
        points = ps.board_points("chessboard:8x6:30mm")
        board = np.column_stack((points - points.mean(axis=0), np.zeros(len(points))))
        truth = ps.Camera("plumb_bob", 1400, 1390, 640, 480, [-0.1])
        pixels = []
        for turn in range(6):
            c, s = np.cos(0.5), np.sin(0.5)
            about = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
            a = turn * np.pi / 3
            spin = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
            pixels.append(truth.project(board @ (spin @ about @ spin.T).T + [0, 0, 0.5]))
        found = ps.calibrate_camera(points, pixels, 1280, 960, model="plumb_bob_k1")
        self.assertLess(found.rms_px, 1e-3)
        self.assertAlmostEqual(found.camera.fx, 1400, delta=0.1)
        self.assertEqual(len(found.views), 6)
        self.assertEqual(repr(found), "<CameraCalibration plumb_bob_k1: 6 views, rms 0.000 px>")
        self.assertEqual(found.standard_deviations.shape, (9,))
        refused(self, "pixels[1]", ps.calibrate_camera, points, [pixels[0], pixels[1][:5]], 1280, 960)
        with self.assertRaisesRegex(ps.InputError, "view"):
            ps.calibrate_camera(points, pixels[:1], 1280, 960)


class Maps(unittest.TestCase):
    def setUp(self):
        random = np.random.default_rng(2)
        self.p = random.uniform(-0.4, 0.4, (80, 2))
        error = np.column_stack((3e-4 * np.sin(5 * self.p[:, 0]), 2e-4 * self.p[:, 1]))
        self.reference = self.p - error + random.normal(0, 2e-6, self.p.shape)

    def test_predict_what_was_taught(self):
        fit = ps.fit_error_map(self.p, self.reference)
        self.assertTrue(fit.worth_using)
        error, sigma, inside = fit.map.predict(self.p)
        np.testing.assert_allclose(error, self.p - self.reference, atol=2e-5)
        self.assertTrue((sigma > 0).all() and inside.all())
        self.assertFalse(fit.map.predict([3, 3])[2])
        self.assertEqual(fit.map.predict([0, 0])[0].shape, (2,))
        self.assertGreater(len(fit.map.hull), 3)
        self.assertRegex(repr(fit), r"^<MapFit \w+: 80 samples, rms 0\.\d{4} mm before, 0\.0\d{3} mm at places left out>$")

    def test_a_written_map_predicts_the_same_bit_for_bit(self):
        with tempfile.TemporaryDirectory() as folder:
            pairs = Path(folder) / "pairs.csv"
            np.savetxt(pairs, np.hstack((self.p, self.reference)) * 1e3, delimiter=",", comments="",
                       header="x_vision_mm,y_vision_mm,x_tracker_mm,y_tracker_mm")
            fit = ps.fit_error_map(self.p, self.reference)
            fit.write(Path(folder) / "map.yaml", pairs)
            back = ps.read_map(Path(folder) / "map.yaml")
            for ours, theirs in zip(back.predict(self.p), fit.map.predict(self.p)):
                np.testing.assert_array_equal(ours, theirs)
            told = ps.provenance(Path(folder) / "map.yaml")
            self.assertEqual((told.kind, told.seal), ("map", "sound"))
            self.assertTrue(told.maker.startswith("planar_servo " + ps.__version__))
            with open(Path(folder) / "map.yaml", "a") as file:
                file.write("# later\n")
            self.assertEqual(ps.provenance(Path(folder) / "map.yaml").seal, "changed")

    def test_wrong_pairs_are_refused_by_name(self):
        refused(self, "p_reference", ps.fit_error_map, self.p, self.reference[:5])
        refused(self, "sigma", ps.fit_error_map, self.p, self.reference, sigma=[1e-6] * 3)
        refused(self, "sigma", ps.fit_error_map, self.p, self.reference, sigma=-1e-6)
        refused(self, "phi", ps.fit_error_map, self.p, self.reference, phi=np.linspace(0, 360, len(self.p)))  # degrees
        refused(self, "method", ps.fit_error_map, self.p, self.reference, method="best")
        error = refused(self, "p_vision", ps.fit_error_map, self.p * 1e3, self.reference * 1e3)
        self.assertIn("divide millimetres by 1000", error.remedy)
        refused(self, "p_vision", ps.fit_error_map(self.p, self.reference).map.predict, self.p * 1e3)
        with self.assertRaises(ps.InputError):
            ps.fit_error_map(self.p[:2], self.reference[:2])

    def test_a_field_takes_the_error_off_lamps(self):
        field = ps.read_map(SEEDS / "map/lamp_field")
        self.assertIsInstance(field, ps.LampField)
        middle = field.hull.mean(axis=0)
        lamps = np.concatenate((middle - [0.02, 0], middle + [0.02, 0]))
        tip, covariance, inside = field.compensate(lamps)
        self.assertTrue(inside)
        self.assertLess(np.hypot(*(tip[:2] - middle)), 0.1)
        self.assertTrue((np.linalg.eigvalsh(covariance) > 0).all())
        self.assertTrue(np.isnan(field.compensate(np.zeros((1, 4)))[0]).all())


class Arms(unittest.TestCase):
    def test_inverse_undoes_forward(self):
        arm = ps.Arm([0.3, 0.25])
        theta = np.array([[0.2, 1.4, 0.3], [-0.5, 0.9, -2.0]])
        np.testing.assert_allclose(arm.inverse(arm.forward(theta), elbow="right"), theta, atol=1e-9)
        self.assertTrue(np.isnan(arm.inverse([2, 0, 0])).all())

    def test_the_jacobian_is_the_derivative(self):
        arm, theta, step = ps.Arm([0.3, 0.25], "clockwise"), np.array([0.2, 1.4, 0.3]), 1e-6
        moved = arm.forward(theta + [step, 0, 0])[:2] - arm.forward(theta)[:2]
        np.testing.assert_allclose(moved / step, arm.jacobian(theta)[:, 0], atol=1e-6)

    def test_wrong_arms_are_refused(self):
        refused(self, "link_lengths", ps.Arm, [0.3, -1])
        refused(self, "link_lengths", ps.Arm, [300, 300])  # millimetres
        refused(self, "positive_rotation", ps.Arm, [0.3, 0.3], "left")
        refused(self, "elbow", ps.Arm([0.3, 0.3]).inverse, [0.3, 0, 0], elbow="up")


class Trackers(unittest.TestCase):
    def test_are_registered_by_monuments(self):
        known = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.1]])
        turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
        read = known @ turn.T + [5, 6, 7]
        found = ps.register_tracker(list("abcd"), known, list("abcd"), read, 1e-5)
        p_B = read @ found.X_BL[:3, :3].T + found.X_BL[:3, 3]
        np.testing.assert_allclose(p_B, known, atol=1e-9)
        self.assertIsNone(found.left_out)
        refused(self, "ids", ps.register_tracker, ["a"], known, list("abcd"), read)
        refused(self, "p_known", ps.register_tracker, list("abcd"), 1e3 * np.asarray(known), list("abcd"), read)
        with self.assertRaises(ps.InputError):
            ps.register_tracker(list("abcd"), known, list("abcx"), read)


if __name__ == "__main__":
    unittest.main()

#include <catch2/catch.hpp>
#include <cmath>

#include "calibration/board_views.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/calibration/camera_calibration.h"
#include "planar_servo/geometry/lens/lens_models.h"
#include "support/refused.h"

namespace planar {
namespace {

using Catch::Contains;
using test::kBoard;
using test::kIntrinsics;
using test::problem_of;
using test::Refused;
using test::view_of_board;
using test::views_of_board;

const PlumbBob kLens{kIntrinsics, -0.15};

TEST_CASE("A calibration does not depend on the unit of the board's lengths") {
  constexpr double kOfFocalLength = 1e-5;  // single precision of points times the Jacobian
  for (const char* model : {"plumb_bob_k1", "plumb_bob", "equidistant", "visp"}) {
    const CalibrationProblem metres = views_of_board(PlumbBob{kIntrinsics, -0.02}, 8, model);
    const CameraCalibration expected = calibrate_camera(metres);
    for (const double unit : {1e-3, 1e3}) {
      INFO(model << " in units of " << unit << " m");
      CalibrationProblem problem = metres;
      for (CalibrationView& view : problem.views) {
        for (Eigen::Vector2d& p : view.points_G) p *= unit;
      }
      const CameraCalibration found = calibrate_camera(problem);
      CHECK(intrinsics(found.camera).fx ==
            Approx(intrinsics(expected.camera).fx).epsilon(kOfFocalLength));
      CHECK(intrinsics(found.camera).cy ==
            Approx(intrinsics(expected.camera).cy).epsilon(kOfFocalLength));
      CHECK(found.views[3].X_CG.translation().isApprox(unit * expected.views[3].X_CG.translation(),
                                                       10.0 * kOfFocalLength));
      CHECK(found.rms_px == Approx(expected.rms_px).epsilon(kOfFocalLength));
    }
  }
}

TEST_CASE("The same picture taken five times is one view") {
  CalibrationProblem problem = views_of_board(kLens, 1, "plumb_bob_k1");
  for (const char* name : {"b", "c", "d", "e"}) {
    problem.views.push_back(problem.views[0]);
    problem.views.back().name = name;
  }
  CHECK_THROWS_MATCHES(calibrate_camera(problem), InputError,
                       Refused(Cause::kInsufficient, "1 usable"));
  CHECK_THROWS_MATCHES(calibrate_camera(problem), InputError,
                       Refused(Cause::kInsufficient, "view0"));
}

TEST_CASE("Pictures that repeat a view but for the noise count once and are named") {
  CalibrationProblem problem = views_of_board(kLens, 8, "plumb_bob_k1");
  const CameraCalibration expected = calibrate_camera(problem);
  std::mt19937 random(11);
  for (const int i : {0, 3, 3})
    problem.views.push_back(view_of_board(kLens, test::pose_of_view(i), "again", random));
  const CameraCalibration found = calibrate_camera(problem);
  CHECK(intrinsics(found.camera).fx == intrinsics(expected.camera).fx);
  REQUIRE(found.rejected.size() == 3);
  CHECK_THAT(found.rejected[2].reason, Contains("view3") && Contains("within the noise"));
}

TEST_CASE("A view counts as a new one as soon as the board has moved beyond the noise") {
  CalibrationProblem problem = views_of_board(kLens, 8, "plumb_bob_k1");
  std::mt19937 random(12);
  Pose X_CG = test::pose_of_view(2);
  X_CG.translation().x() += 0.5e-3;  // 2 px, 28 times the noise of a distance
  problem.views.push_back(view_of_board(kLens, X_CG, "moved", random));
  CHECK(calibrate_camera(problem).rejected.empty());
}

TEST_CASE("Views that do not determine the focal length are refused") {
  const Pinhole camera{kIntrinsics};
  std::mt19937 random(13);
  for (const char* model : {"pinhole", "plumb_bob_k1", "auto"}) {
    INFO(model);
    CalibrationProblem facing = problem_of(model), at_rest = facing;
    for (int i = 0; i < 6; ++i) {
      const std::string name = "view" + std::to_string(i);
      const Pose square_on = test::board_before_camera(kBoard, 0.3 + 0.02 * i, 0.0, 0.0, 0.1 * i);
      facing.views.push_back(view_of_board(camera, square_on, name, random));
      Pose trembling = test::pose_of_view(0);
      trembling.translation().x() += 0.2e-3 * i;
      at_rest.views.push_back(view_of_board(camera, trembling, name, random));
    }
    CHECK_THROWS_AS(calibrate_camera(facing), WorkError);
    CHECK_THROWS_AS(calibrate_camera(at_rest), WorkError);
  }
}

}  // namespace
}  // namespace planar

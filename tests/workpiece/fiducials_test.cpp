#include "planar_servo/workpiece/fiducials.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <opencv2/core.hpp>

#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/lens/workplane.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/virtual_sheets.h"

namespace planar {
namespace {

/// A work of one mark in the middle of a picture of 5 px/mm, and where its centre is in it.
struct Scene {
  Scene(MarkShape shape, double size_m, double turn, double beyond_m = 0.03) {
    Truth truth;
    truth.camera.X_CB.translation().z() = 1.0;
    truth.camera.X_CB.linear() << 1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0;
    truth.camera.focal_px = {5000.0, 5000.0};
    truth.camera.center_px = {200.3, 199.6};
    WorkpieceTruth work;
    work.turn_rad = turn;
    work.p_BW = {1e-4, 2e-4, 0.0};
    work.plate_from_m = {-0.03, -0.03};
    work.plate_to_m = Eigen::Vector2d(0.002, 0.001).array() + 0.5 * size_m + beyond_m;
    work.marks.push_back({shape, {0.002, 0.001}, size_m, 7});
    truth.works.push_back(work);
    const VirtualLens lens(truth.camera);
    const VirtualWorks works(truth, lens, kSensor);
    cv::Mat1f levels(kSensor, 12.0F);
    for (const Light& light : works.render(0.0)) levels(light.window_px) += light.levels;
    cv::Mat noise(kSensor, CV_32F);
    cv::theRNG().state = 1;
    cv::randn(noise, 0.0, 1.0);
    levels += noise;
    levels.convertTo(image, CV_8U);
    const Eigen::Vector3d p_B = work.X_BW(0.0) * Eigen::Vector3d(0.002, 0.001, 0.0);
    center_px = *lens.project(p_B, 0.0);
  }

  static constexpr int kSide = 400;
  const cv::Size kSensor{kSide, kSide};
  cv::Mat image;
  Eigen::Vector2d center_px;
};

struct Case {
  MarkShape shape;
  FiducialKind kind;
  double size_mm;
  double tolerance_px;
};

const Case kCases[] = {{MarkShape::kBrightDisc, FiducialKind::kBrightDisc, 4.0, 0.03},
                       {MarkShape::kDarkDisc, FiducialKind::kDarkDisc, 4.0, 0.03},
                       {MarkShape::kRing, FiducialKind::kRing, 6.0, 0.03},
                       {MarkShape::kCross, FiducialKind::kCross, 8.0, 0.15},
                       {MarkShape::kChessCorner, FiducialKind::kChessCorner, 8.0, 0.1},
                       {MarkShape::kAprilTag, FiducialKind::kAprilTag, 12.0, 0.15}};

}  // namespace

TEST_CASE("A bright disc is found and measured in the corner of its plate") {
  for (const double size_mm : {4.0, 8.0, 10.0, 16.0})
    for (const double beyond_mm : {3.0, 5.0, 8.0}) {
      CAPTURE(size_mm, beyond_mm);
      const Scene scene(MarkShape::kBrightDisc, size_mm * kMillimetre, 0.4,
                        beyond_mm * kMillimetre);
      const auto found = find_fiducials(scene.image, FiducialKind::kBrightDisc, 5.0 * size_mm);
      REQUIRE(found.size() == 1);
      const auto measured = measure_fiducial(scene.image, FiducialKind::kBrightDisc, found[0]);
      REQUIRE(measured);
      CHECK((measured->uv_px - scene.center_px).norm() < 0.03);
    }
}

TEST_CASE("Every kind of mark is found and measured at any turn, and is no other kind") {
  for (const Case& mark : kCases)
    for (const double turn : {0.0, 0.4, 1.2, 2.7}) {
      CAPTURE(name_in(kFiducialKinds, mark.kind), turn);
      const Scene scene(mark.shape, mark.size_mm * kMillimetre, turn);
      const double size_px = 5.0 * mark.size_mm;
      const auto found = find_fiducials(scene.image, mark.kind, size_px);
      REQUIRE(found.size() == 1);
      CHECK((found[0].uv_px - scene.center_px).norm() < 2.0);
      const auto measured = measure_fiducial(scene.image, mark.kind, found[0]);
      REQUIRE(measured);
      CHECK((measured->uv_px - scene.center_px).norm() < mark.tolerance_px);
      if (is_round(mark.kind)) {
        CHECK(measured->size_px == Approx(size_px).margin(0.2));
        CHECK(std::sqrt(measured->covariance_px2.trace()) < 0.03);
      }
      if (mark.kind == FiducialKind::kAprilTag) CHECK(measured->tag == 7);
      for (const Case& other : kCases)
        if (is_round(other.kind) && other.kind != mark.kind) {
          CAPTURE(name_in(kFiducialKinds, other.kind));
          CHECK(find_fiducials(scene.image, other.kind, size_px).empty());
        }
    }
}

TEST_CASE("A mark is not measured where there is none") {
  const cv::Mat empty(400, 400, CV_8U, cv::Scalar(30));
  for (const Case& mark : kCases) {
    FiducialSight sight;
    sight.uv_px = {200.0, 200.0};
    sight.size_px = 20.0;
    CAPTURE(name_in(kFiducialKinds, mark.kind));
    CHECK(find_fiducials(empty, mark.kind, 20.0).empty());
    if (is_round(mark.kind) || mark.kind == FiducialKind::kAprilTag)
      CHECK_FALSE(measure_fiducial(empty, mark.kind, sight));
  }
}

TEST_CASE("An AprilTag's number is what its id ends with") {
  CHECK(tag_number("7") == 7);
  CHECK(tag_number("tag 12") == 12);
  CHECK_FALSE(tag_number("corner"));
  CHECK_FALSE(tag_number("A12345"));
}

TEST_CASE("A mark of the base may be a tag only where that has its number") {
  Fiducial mark{"base 12"};
  mark.kind = FiducialKind::kAprilTag;
  CHECK(may_have_tag(mark, 12));
  CHECK_FALSE(may_have_tag(mark, 7));
  CHECK_FALSE(may_have_tag(mark, std::nullopt));
  mark.kind = FiducialKind::kBrightDisc;
  CHECK(may_have_tag(mark, 7));
  CHECK(may_have_tag(mark, std::nullopt));
}

}  // namespace planar

#include "planar_servo/virtual_cell/virtual_cell.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "planar_servo/base/core/error.h"
#include "planar_servo/virtual_cell/virtual_lamps.h"
#include "planar_servo/virtual_cell/virtual_lens.h"
#include "virtual_cell/sample_cell.h"

namespace planar {
namespace {

const cv::Rect kWhole(0, 0, 5120, 5120);

bool same_bytes(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

/// Pixels brighter than the noise: how many, and their centroid on the sensor.
struct Bright {
  int count{0};
  Eigen::Vector2d center_px{0.0, 0.0};
};

Bright bright(const Frame& frame) {
  Bright found;
  double weight = 0.0;
  for (int r = 0; r < frame.image.rows; ++r)
    for (int c = 0; c < frame.image.cols; ++c) {
      const double level = frame.image.at<std::uint8_t>(r, c);
      if (level < 40.0) continue;
      ++found.count;
      weight += level;
      found.center_px += level * Eigen::Vector2d(frame.region_px.x + c, frame.region_px.y + r);
    }
  if (weight > 0.0) found.center_px /= weight;
  return found;
}

/// One even lamp, whose bright pixels have a centroid free of the other lamp's brightness.
Truth one_lamp_truth() {
  Truth truth = test::evenly_lit_truth(1);
  truth.lamps[1].peak_level = 0.0;
  return truth;
}

cv::Rect around(const Eigen::Vector2d& uv_px, int size) {
  return {static_cast<int>(uv_px.x()) - size / 2, static_cast<int>(uv_px.y()) - size / 2, size,
          size};
}

}  // namespace

TEST_CASE("The same truth and the same calls give the same bytes, another seed does not") {
  const auto run = [](std::uint32_t noise_seed) {
    Truth truth = draw_truth(1);
    truth.seed = noise_seed;
    VirtualCell cell(truth, test::sample_hardware());
    cell.camera().next_frame();
    cell.camera().set_region({2000, 2000, 800, 600});
    const Frame frame = cell.camera().next_frame().frame;
    cell.board_presenter().lay_board(0);
    const Frame board = cell.camera().next_frame().frame;
    return std::make_tuple(frame.image, board.image, cell.tracker().measure_tool("").reading.p_L);
  };
  const auto [frame, board, p_L] = run(7);
  const auto [frame_again, board_again, p_L_again] = run(7);
  CHECK(same_bytes(frame, frame_again));
  CHECK(same_bytes(board, board_again));
  CHECK(p_L == p_L_again);
  const auto [frame_other, board_other, p_L_other] = run(8);
  CHECK_FALSE(same_bytes(frame, frame_other));
  CHECK_FALSE(same_bytes(board, board_other));
  CHECK(p_L != p_L_other);
}

TEST_CASE("Frames lie on the grid of the frame period and never before the call") {
  VirtualCell cell(draw_truth(1), test::sample_hardware());
  cell.camera().set_region({0, 0, 64, 64});
  double last_s = -1.0;
  for (const double pause_s : {0.0, 0.0, 0.01, 0.2, 1.0 / 15.0, 3.3333, 0.0}) {
    cell.clock().sleep_for_s(pause_s);
    const double called_s = cell.clock().now_s();
    const FrameResult result = cell.camera().next_frame();
    REQUIRE(result.status == FrameStatus::kOk);
    const double periods = result.frame.t_s * 15.0;
    constexpr double kRoundOff = 1e-9;
    CHECK(std::abs(periods - std::round(periods)) < kRoundOff);
    CHECK(result.frame.t_s > called_s - kRoundOff);
    CHECK(result.frame.t_s < called_s + 1.0 / 15.0 + kRoundOff);
    CHECK(result.frame.t_s > last_s);
    CHECK(cell.clock().now_s() >= result.frame.t_s);
    last_s = result.frame.t_s;
  }
}

TEST_CASE("A region shows what the whole frame shows there") {
  VirtualCell cell(one_lamp_truth(), test::sample_hardware());
  const Frame whole = cell.camera().next_frame().frame;
  CHECK(whole.region_px == kWhole);
  CHECK(whole.image.type() == CV_8UC1);
  const Bright in_whole = bright(whole);
  const cv::Rect region = around(in_whole.center_px, 512);
  cell.camera().set_region(region);
  const Frame part = cell.camera().next_frame().frame;
  CHECK(part.region_px == region);
  CHECK(part.image.size() == region.size());
  const Bright in_part = bright(part);
  constexpr double kCentroidNoisePx = 0.05;  // several times that of pixels above a threshold
  CHECK((in_part.center_px - in_whole.center_px).norm() < kCentroidNoisePx);
  CHECK(std::abs(in_part.count - in_whole.count) < 0.02 * in_whole.count);

  cv::Scalar mean, deviation;
  cv::meanStdDev(part.image(cv::Rect(0, 0, 512, 100)), mean, deviation);
  CHECK(mean[0] == Approx(12.0).margin(0.05));
}

TEST_CASE("A lamp cut by the region's edge is cut, not moved") {
  VirtualCell cell(one_lamp_truth(), test::sample_hardware());
  const Frame whole = cell.camera().next_frame().frame;
  const Bright in_whole = bright(whole);
  cv::Rect half = around(in_whole.center_px, 512);
  half.width /= 2;
  cell.camera().set_region(half);
  const Bright cut = bright(cell.camera().next_frame().frame);
  const Bright expected = bright({whole.image(half), half, 0.0, 0});
  REQUIRE(expected.count > 100);
  CHECK((cut.center_px - expected.center_px).norm() < 0.1);
}

TEST_CASE("The camera refuses an empty region and one that leaves the sensor") {
  VirtualCell cell(draw_truth(1), test::sample_hardware());
  CHECK_THROWS_AS(cell.camera().set_region({0, 0, 0, 10}), std::invalid_argument);
  CHECK_THROWS_AS(cell.camera().set_region({5000, 0, 121, 10}), std::invalid_argument);
  CHECK_THROWS_AS(cell.camera().set_region({-1, 0, 10, 10}), std::invalid_argument);
  CHECK_NOTHROW(cell.camera().set_region({5000, 0, 120, 10}));
}

TEST_CASE("While the board is in view no lamps are seen") {
  VirtualCell cell(draw_truth(1), test::sample_hardware());
  const Bright lamps = bright(cell.camera().next_frame().frame);
  CHECK(lamps.count > 1000);
  CHECK(lamps.count < 3000);
  cell.board_presenter().hold_board(0);
  CHECK(bright(cell.camera().next_frame().frame).count > 1000000);
  cell.board_presenter().remove_board();
  CHECK(bright(cell.camera().next_frame().frame).count < 3000);
}

TEST_CASE("A dead lamp leaves one in the image") {
  Truth truth = draw_truth(1);
  const int both =
      bright(VirtualCell(truth, test::sample_hardware()).camera().next_frame().frame).count;
  truth.lamps[0].peak_level = 0.0;
  const int one =
      bright(VirtualCell(truth, test::sample_hardware()).camera().next_frame().frame).count;
  CHECK(one == Approx(0.5 * both).epsilon(0.05));
}

TEST_CASE("The image drifts linearly in time") {
  Truth truth = one_lamp_truth();
  truth.camera.drift_px_per_h << 3.0, -2.0;
  VirtualCell cell(truth, test::sample_hardware());
  const Bright before = bright(cell.camera().next_frame().frame);
  cell.clock().sleep_for_s(1800.0);
  const Bright after = bright(cell.camera().next_frame().frame);
  CHECK((after.center_px - before.center_px - Eigen::Vector2d(1.5, -1.0)).norm() < 0.05);
}

TEST_CASE("Lamps fixed to the base shine in whole frames and in regions, but not through a board") {
  Truth truth = test::evenly_lit_truth(1);
  for (LampTruth& lamp : truth.lamps) lamp.peak_level = 0.0;
  truth.reference_lamps = {{"R1", {0.4, 0.3, 0.006}, truth.lamps[0]},
                           {"R2", {-0.4, 0.3, 0.006}, truth.lamps[0]}};
  truth.reference_lamps[0].lamp.peak_level = 150.0;
  VirtualCell cell(truth, test::sample_hardware());
  const Eigen::Vector2d place = *VirtualLens(truth.camera).project({0.4, 0.3, 0.006}, 0.0);
  constexpr double kCenter_px = 0.05;
  CHECK((bright(cell.camera().next_frame().frame).center_px - place).norm() < kCenter_px);
  cell.camera().set_region(around(place, 100));
  CHECK((bright(cell.camera().next_frame().frame).center_px - place).norm() < kCenter_px);
  cell.camera().set_region(around(place + Eigen::Vector2d(400.0, 0.0), 100));
  CHECK(bright(cell.camera().next_frame().frame).count == 0);

  cell.camera().set_region(kWhole);
  cell.board_presenter().lay_board(0);
  const Bright with_board = bright(cell.camera().next_frame().frame);
  truth.reference_lamps.clear();
  VirtualCell without_lamps(truth, test::sample_hardware());
  for (int i = 0; i < 3; ++i) without_lamps.camera().next_frame();  // the same exposure, then
  without_lamps.board_presenter().lay_board(0);
  CHECK(bright(without_lamps.camera().next_frame().frame).center_px == with_board.center_px);
}

TEST_CASE("A fixed lamp beside the tool's is as bright as alone, in one light with them") {
  Truth truth = test::evenly_lit_truth(1);
  const VirtualLens lens(truth.camera);
  const Pose X_BT = test::tool_pose({0.2, 0.1}, 0.0);
  const Eigen::Vector3d beside =
      X_BT * Eigen::Vector3d(truth.tool.lamps_m[1].x() + 0.010, 0.0, 0.0);
  truth.reference_lamps = {{"R1", beside, truth.lamps[0]},
                           {"R2", {-0.4, 0.3, 0.0}, truth.lamps[0]}};
  const std::vector<Light> lights = VirtualLamps(truth).render_all(X_BT, lens, 0.0);
  REQUIRE(lights.size() == 2);
  const auto light_sum = [](const Light& light) { return cv::sum(light.levels)[0]; };
  truth.reference_lamps.clear();
  const double tool = light_sum(VirtualLamps(truth).render_all(X_BT, lens, 0.0).front());
  CHECK(light_sum(lights[0]) == Approx(tool + light_sum(lights[1])).epsilon(0.02));
}

TEST_CASE("Frames and true tip follow the drives") {
  Truth truth = test::evenly_lit_truth(1);
  const VirtualHardware hardware = test::sample_hardware();
  VirtualCell cell(truth, hardware);
  for (int joint = 0; joint < 3; ++joint) cell.drive(joint).energize();
  const TipPose before = cell.true_tip();
  cell.drive(0).set_target(cell.drive(0).status().position_pulses + 20000);
  cell.clock().sleep_for_s(10.0);
  const TipPose after = cell.true_tip();
  CHECK((after.p - before.p).norm() > 0.01);

  const Bright seen = bright(cell.camera().next_frame().frame);
  const Eigen::Matrix2d R = rotation2d(after.phi);
  const double height = truth.tool.lamp_height_m - truth.arm.sag_m_per_m2 * after.p.squaredNorm();
  const Eigen::Vector2d lamps = truth.tool.lamps_m[1] - truth.tool.lamps_m[0];
  const Eigen::Vector2d middle =
      after.p + R * rotation2d(-std::atan2(lamps.y(), lamps.x())) *
                    (0.5 * (truth.tool.lamps_m[0] + truth.tool.lamps_m[1]));
  const Eigen::Vector3d p_C = truth.camera.X_CB * Eigen::Vector3d(middle.x(), middle.y(), height);
  const Eigen::Vector2d pinhole =
      truth.camera.focal_px.cwiseProduct(p_C.head<2>() / p_C.z()) + truth.camera.center_px;
  constexpr double kDistortionPx = 30.0;  // lens and warp at most, over the field
  CHECK((seen.center_px - pinhole).norm() < kDistortionPx);
}

TEST_CASE("A lamp that moves while it is exposed is smeared along its way and seen in the middle") {
  constexpr double kTaken_s = 2.0 / 15.0, kExposure_s = 0.010;
  const auto moving_for = [](VirtualCell& cell, double duration_s) {
    cell.drives().energize();
    cell.drives().set_targets({100000, 0, 0});
    cell.clock().sleep_for_s(duration_s);
  };
  const auto seen_at = [&](double t_s) {
    VirtualCell cell(one_lamp_truth(), test::sample_hardware());
    moving_for(cell, t_s);
    return bright({cell.expose(kWhole, 1.0, 7), kWhole, 0.0, 0});
  };
  VirtualCell cell(one_lamp_truth(), test::sample_hardware());
  moving_for(cell, kTaken_s - 1e-3);
  const Frame frame = cell.camera().next_frame().frame;
  CHECK(frame.t_s == Approx(kTaken_s));
  CHECK(cell.clock().now_s() == Approx(kTaken_s + kExposure_s));
  const Bright smeared = bright(frame), sharp = seen_at(kTaken_s + 0.5 * kExposure_s);
  const double way_px =
      (seen_at(kTaken_s + kExposure_s).center_px - seen_at(kTaken_s).center_px).norm();
  REQUIRE(way_px > 3.0);
  CHECK((smeared.center_px - sharp.center_px).norm() < 0.1 * way_px);
  // The union of all discs grows by the way times the diameter. Its dim ends, a fifth of the way
  // each, are below the threshold, and a sharp disc is larger there by its blur.
  const double diameter_px = std::sqrt(4.0 * sharp.count / kPi);
  CHECK(smeared.count - sharp.count > 0.15 * way_px * diameter_px);
  CHECK(smeared.count - sharp.count < way_px * diameter_px);
}

TEST_CASE("VirtualCell refuses hardware that cannot be") {
  const Truth truth = draw_truth(1);
  const auto refuses = [&](void (*spoil)(VirtualHardware&)) {
    VirtualHardware hardware = test::sample_hardware();
    spoil(hardware);
    CHECK_THROWS_AS(VirtualCell(truth, hardware), std::invalid_argument);
  };
  refuses([](VirtualHardware& h) { h.frame_rate_hz = 0.0; });
  refuses([](VirtualHardware& h) { h.sensor_px = {0, 5120}; });
  refuses([](VirtualHardware& h) { h.sense = 0.5; });
  refuses([](VirtualHardware& h) { h.gear_ratios[1] = 0.0; });
  refuses([](VirtualHardware& h) { h.home_rad[0] = std::numeric_limits<double>::quiet_NaN(); });
  refuses([](VirtualHardware& h) { h.max_acceleration_rad_s2[2] = -1.0; });
}

}  // namespace planar

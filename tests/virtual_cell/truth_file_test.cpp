#include "planar_servo/virtual_cell/truth/truth.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <string>

#include "planar_servo/base/core/error.h"
#include "planar_servo/virtual_cell/virtual_lens.h"
#include "support/refused.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

using test::Refused;

constexpr double kUnits = 1e-14;  // relative: the units are multiplied and divided out

/// The line that begins with `key`, from its key on.
std::string line_of(const std::string& text, const std::string& key) {
  const std::size_t begin = text.find(key);
  REQUIRE(begin != std::string::npos);
  return text.substr(begin, text.find('\n', begin) - begin);
}

}  // namespace

TEST_CASE("A truth written and read again is the same cell") {
  const test::TemporaryFolder folder;
  Truth truth = draw_truth(4294967295U);
  write_truth(folder / "truth.yaml", truth);
  const Truth read = read_truth(folder / "truth.yaml");
  CHECK(read.seed == truth.seed);
  CHECK(read.arm.sag_m_per_m2 == Approx(truth.arm.sag_m_per_m2).epsilon(kUnits));
  CHECK(read.arm.link_lengths_m[1] == Approx(truth.arm.link_lengths_m[1]).epsilon(kUnits));
  for (std::size_t i = 0; i < 3; ++i) {
    const ReducerTruth &a = read.arm.reducers[i], &b = truth.arm.reducers[i];
    CHECK(a.zero_offset_rad == Approx(b.zero_offset_rad).epsilon(kUnits));
    CHECK(a.backlash_rad == Approx(b.backlash_rad).epsilon(kUnits));
    REQUIRE(a.eccentricity.size() == 2);
    CHECK(a.eccentricity[1].amplitude == Approx(b.eccentricity[1].amplitude).epsilon(kUnits));
    CHECK(a.eccentricity[1].phase_rad == Approx(b.eccentricity[1].phase_rad).epsilon(kUnits));
    CHECK(a.eccentricity[1].order == 2);
  }
  CHECK(read.lamps[1].rim.size() == truth.lamps[1].rim.size());
  CHECK(read.lamps[1].glow.halo_view == truth.lamps[1].glow.halo_view);
  CHECK(read.lamps[0].glow.gradient_tool == truth.lamps[0].glow.gradient_tool);
  CHECK(read.tool.reflector_m.isApprox(truth.tool.reflector_m, kUnits));
  CHECK(read.tool.lamp_height_m == Approx(truth.tool.lamp_height_m).epsilon(kUnits));
  CHECK(read.tracker.X_LB.isApprox(truth.tracker.X_LB, 1e-12));
  CHECK(read.tracker.bias_wavelength_m == Approx(truth.tracker.bias_wavelength_m));
  CHECK(read.board.columns == 11);
  CHECK(read.noise.gain_e_per_level == truth.noise.gain_e_per_level);
  CHECK(read.camera.drift_px_per_h == truth.camera.drift_px_per_h);

  const Eigen::Vector3d p_B(0.31, -0.42, 0.005);
  constexpr double kPixels = 1e-8;  // quaternion and matrix
  CHECK(
      (*VirtualLens(read.camera).project(p_B, 60.0) - *VirtualLens(truth.camera).project(p_B, 60.0))
          .norm() < kPixels);
}

TEST_CASE("A truth says how the machine is built only where it says so") {
  const test::TemporaryFolder folder;
  Truth truth = draw_truth(1);
  CHECK(truth_text(truth).find("gear_ratios") == std::string::npos);
  truth.build = {-1.0,
                 std::array<bool, 2>{true, false},
                 Eigen::Vector3d(100.5, 100.0, 50.0),
                 Eigen::Vector3d(1.0, -1.0, 1.0),
                 Eigen::Vector3d(0.0, 1.0, -1.0),
                 {{"datum1", {-0.45, -0.45, 0.001}}}};
  write_truth(folder / "truth.yaml", truth);
  const BuildTruth read = read_truth(folder / "truth.yaml").build;
  CHECK(read.sense == -1.0);
  CHECK(read.relative == std::array<bool, 2>{true, false});
  CHECK(read.gear_ratios == truth.build.gear_ratios);
  CHECK(read.directions == truth.build.directions);
  CHECK(read.home_rad->isApprox(*truth.build.home_rad, kUnits));
  REQUIRE(read.monuments_B.size() == 1);
  CHECK(read.monuments_B[0].first == "datum1");
  CHECK(read.monuments_B[0].second.isApprox(truth.build.monuments_B[0].second, kUnits));

  const std::string good = truth_text(truth);
  const auto refused = [&](const std::string& key, const std::string& wrong, const char* name) {
    CHECK_THROWS_MATCHES(
        read_truth(folder.write("bad.yaml", test::replaced(good, line_of(good, key), wrong))),
        InputError, Refused(Cause::kInvalid, name));
  };
  refused("directions:", "directions: [1, 0.5, 1]", "arm.directions");
  refused("gear_ratios:", "gear_ratios: [0, 100, 50]", "gear_ratios");
  refused("positive_rotation:", "positive_rotation: right", "positive_rotation is 'right'");
  refused("coupling:", "coupling: [relative]", "coupling");
}

TEST_CASE("A truth holds fixed lamps and warming only where it has them") {
  const test::TemporaryFolder folder;
  const std::string paper = truth_text(draw_truth(1));
  CHECK(paper.find("reference_lamps") == std::string::npos);
  CHECK(paper.find("warming") == std::string::npos);
  const Truth truth = draw_workshop_truth(1);
  write_truth(folder / "truth.yaml", truth);
  const Truth read = read_truth(folder / "truth.yaml");
  REQUIRE(read.reference_lamps.size() == workshop_lamps().size());
  const ReferenceLampTruth &a = read.reference_lamps[7], &b = truth.reference_lamps[7];
  CHECK(a.id == "R8");
  CHECK(a.p_B.isApprox(b.p_B, kUnits));
  CHECK(a.lamp.peak_level == b.lamp.peak_level);
  CHECK(a.lamp.rim.size() == b.lamp.rim.size());
  REQUIRE(read.camera.warming.has_value());
  CHECK(read.camera.warming->shift_px == truth.camera.warming->shift_px);
  CHECK(read.camera.warming->turn_rad == Approx(truth.camera.warming->turn_rad).epsilon(kUnits));
  CHECK(read.camera.warming->growth == truth.camera.warming->growth);
  CHECK(read.camera.warming->time_constant_s ==
        Approx(truth.camera.warming->time_constant_s).epsilon(kUnits));
}

TEST_CASE("A truth holds beam, leans, outliers and mixed-up readings only where it has them") {
  const test::TemporaryFolder folder;
  const std::string paper = truth_text(draw_truth(1));
  for (const char* key : {"beam_sag", "axis_leans_deg", "outliers", "mispaired_share",
                          "base_motion", "creep", "backlash_variation"})
    CHECK(paper.find(key) == std::string::npos);
  Truth truth = draw_rough_truth(1);
  truth.tracker.mispaired_share = 0.02;
  truth.arm.base_motion = BaseMotionTruth{10.0 * kMicrometre, 1080.0, 0.5};
  truth.arm.creep = CreepTruth{12.0 * kMicrometre, 2.5};
  truth.arm.reducers[1].backlash_variation = 0.3;
  write_truth(folder / "truth.yaml", truth);
  const Truth read = read_truth(folder / "truth.yaml");
  CHECK(read.tracker.mispaired_share == truth.tracker.mispaired_share);
  CHECK(read.arm.reducers[2].eccentricity[2].order == 3);
  CHECK(read.arm.beam_sag->bending_m_per_m2 ==
        Approx(truth.arm.beam_sag->bending_m_per_m2).epsilon(kUnits));
  CHECK(read.arm.beam_sag->twisting_m_per_m2 ==
        Approx(truth.arm.beam_sag->twisting_m_per_m2).epsilon(kUnits));
  for (std::size_t i = 0; i < 3; ++i)
    CHECK((*read.arm.axis_leans_rad)[i].isApprox((*truth.arm.axis_leans_rad)[i], kUnits));
  CHECK(read.outliers->share == truth.outliers->share);
  CHECK(read.arm.base_motion->largest_m == Approx(10.0 * kMicrometre).epsilon(kUnits));
  CHECK(read.arm.base_motion->period_s == Approx(1080.0).epsilon(kUnits));
  CHECK(read.arm.creep->time_s == Approx(2.5).epsilon(kUnits));
  CHECK(read.arm.reducers[1].backlash_variation == Approx(0.3).epsilon(kUnits));
  CHECK(read.outliers->to_m == Approx(truth.outliers->to_m).epsilon(kUnits));

  const std::string good = truth_text(truth);
  const auto refused = [&](const std::string& key, const std::string& wrong, const char* name) {
    CHECK_THROWS_MATCHES(
        read_truth(folder.write("bad.yaml", test::replaced(good, line_of(good, key), wrong))),
        InputError, Refused(Cause::kInvalid, name));
  };
  refused("share:", "share: 1.5", "share");
  refused("from_mm:", "from_mm: 4", "outliers.from_mm");
  refused("twisting_mm_per_m2:", "twist: 4", "'arm.beam_sag.twist'");
}

TEST_CASE("A workshop is a cell of the paper's kind with lamps in view beyond the tool's reach") {
  const Truth truth = draw_workshop_truth(3), paper = draw_truth(3);
  CHECK(truth.camera.X_CB.isApprox(paper.camera.X_CB, 0.0));
  CHECK(truth.camera.drift_px_per_h.norm() == Approx(0.4).epsilon(0.06));
  const VirtualLens lens(truth.camera);
  constexpr double kReach_m = 0.54 + 0.02 + 0.004, kBeside_m = 0.065, kHalo_px = 60.0;
  for (const ReferenceLampTruth& lamp : truth.reference_lamps) {
    CHECK(lamp.p_B.head<2>().norm() > kReach_m + kBeside_m);
    const Eigen::Vector2d uv_px = *lens.project(lamp.p_B, 8.0 * 3600.0);
    CHECK(uv_px.minCoeff() > kHalo_px);
    CHECK(uv_px.maxCoeff() < 5120.0 - kHalo_px);
  }
}

TEST_CASE("The same seed draws the same text, another seed another") {
  const auto body = [](std::uint32_t seed) {
    const std::string text = truth_text(draw_truth(seed));
    return text.substr(text.find("arm:"));
  };
  CHECK(body(1) == body(1));
  CHECK(body(1) != body(2));
}

TEST_CASE("A truth file's faults are named all at once, with their lines") {
  const test::TemporaryFolder folder;
  const std::string good = truth_text(draw_truth(1));
  const auto read = [&](const std::string& text) { read_truth(folder.write("truth.yaml", text)); };
  const auto with = [&](const char* key, const char* line) {
    return test::replaced(good, line_of(good, key), line);
  };
  CHECK_NOTHROW(read(good));
  const auto below = std::to_string(std::count(good.begin(), good.end(), '\n') + 1);
  CHECK_THROWS_MATCHES(read(good + "colour: red\n"), InputError,
                       Refused(Cause::kInvalid, "truth.yaml:" + below + ":1: "));
  CHECK_THROWS_MATCHES(read(with("sag_mm_per_m2:", "")), InputError,
                       Refused(Cause::kMissing, "'sag_mm_per_m2'"));
  CHECK_THROWS_MATCHES(read(with("sigma_mm:", "sigma_mm: .nan")), InputError,
                       Refused(Cause::kInvalid, "sigma_mm is '.nan'"));
  CHECK_THROWS_MATCHES(read(with("diameter_mm:", "diameter_mm: -8")), InputError,
                       Refused(Cause::kInvalid, "lamp1.diameter_mm is -8"));
  CHECK_THROWS_MATCHES(read(with("quaternion_wxyz:", "quaternion_wxyz: [1, 1, 0, 0]")), InputError,
                       Refused(Cause::kInvalid, "quaternion_wxyz"));
  CHECK_THROWS_MATCHES(read(with("backlash_deg:", "backlash_deg: [0, -1, 0]")), InputError,
                       Refused(Cause::kInvalid, "backlash_deg"));

  const std::string twice = with("focal_px:", "focal_px: [6400]") + "colour: red\n";
  CHECK_THROWS_MATCHES(read(twice), InputError, Refused(Cause::kInvalid, "focal_px"));
  CHECK_THROWS_MATCHES(read(twice), InputError, Refused(Cause::kInvalid, "'colour'"));
}

}  // namespace planar

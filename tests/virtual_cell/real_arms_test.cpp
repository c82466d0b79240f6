#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/virtual_cell/truth/truth.h"
#include "support/refused.h"
#include "support/temporary_folder.h"
#include "virtual_cell/sample_cell.h"

namespace planar {
namespace {

using test::Refused;

const char* const kRealKeys[] = {
    "ripple:",       "microsteps:", "hysteresis:",          "runout:",
    "wobble:",       "scatter:",    "growth_um_per_m",      "height_wave:",
    "bending:",      "air:",        "azimuth_errors_urad:", "elevation_errors_urad:",
    "station_drift:"};

/// Checks that a drawn number lies within 30 % of its median.
void check_near(double drawn, double median) {
  CHECK(std::abs(drawn) >= 0.7 * median * (1.0 - 1e-12));
  CHECK(std::abs(drawn) <= 1.3 * median * (1.0 + 1e-12));
}

struct Medians {
  double ripple_deg, runout_um, scatter_um, growth_um, height_um, bending_um;
};

void check_real_arm(const Truth& truth, const Medians& medians) {
  for (int i = 0; i < 3; ++i) {
    const ReducerTruth& reducer = truth.arm.reducers[static_cast<std::size_t>(i)];
    check_near(reducer.ripple[0].amplitude, medians.ripple_deg * kDegree);
    check_near(reducer.ripple[1].amplitude, 0.5 * medians.ripple_deg * kDegree);
    CHECK(reducer.ripple[0].order == 1);
    CHECK(reducer.ripple[1].order == 2);
    check_near(truth.arm.runout->sizes[i], medians.runout_um * kMicrometre);
  }
  check_near(truth.arm.scatter->sigma_m, medians.scatter_um * kMicrometre);
  CHECK(truth.arm.scatter->short_move_factor >= 0.4);
  CHECK(truth.arm.scatter->short_move_factor <= 0.6);
  check_near(truth.arm.warming->growth, medians.growth_um * kMicrometre);
  check_near(truth.arm.height_wave->amplitude_m, medians.height_um * kMicrometre);
  check_near(truth.arm.bending->largest_m, medians.bending_um * kMicrometre);
}

std::string body_of(const Truth& truth) {
  const std::string text = truth_text(truth);
  return text.substr(text.find("arm:"));
}

}  // namespace

TEST_CASE("Ordinary and cheap arms are drawn within 30 % of their medians") {
  for (std::uint32_t seed = 1; seed <= 30; ++seed) {
    check_real_arm(draw_ordinary_truth(seed), {0.008, 8.0, 20.0, 60.0, 60.0, 20.0});
    check_real_arm(draw_cheap_truth(seed), {0.020, 10.0, 40.0, 100.0, 100.0, 50.0});
    CHECK(draw_ordinary_truth(seed).arm.reducers[0].ripple.size() == 2);
    CHECK(draw_cheap_truth(seed).arm.reducers[0].ripple[2].order == 20);
  }
}

TEST_CASE(
    "A cell with a real arm has the rest of the paper's kind, and other kinds have no key of it") {
  for (const DrawTruth draw : {draw_truth, draw_rough_truth, draw_workshop_truth})
    for (const char* key : kRealKeys) CHECK(body_of(draw(3)).find(key) == std::string::npos);
  for (const char* key : kRealKeys)
    CHECK(body_of(draw_ordinary_truth(3)).find(key) != std::string::npos);
  Truth bare = draw_ordinary_truth(3);
  const Truth paper = draw_truth(3);
  bare.arm = paper.arm;
  bare.camera.air.reset();
  bare.tracker = paper.tracker;
  CHECK(body_of(bare) == body_of(paper));
}

TEST_CASE("A truth with a real arm written and read again is the same cell") {
  const test::TemporaryFolder folder;
  const Truth truth = draw_cheap_truth(4);
  write_truth(folder / "truth.yaml", truth);
  const Truth read = read_truth(folder / "truth.yaml");
  constexpr double kTwice = 1e-12;  // degrees and back
  const ReducerTruth &a = read.arm.reducers[2], &b = truth.arm.reducers[2];
  CHECK(a.ripple[2].amplitude == Approx(b.ripple[2].amplitude).epsilon(kTwice));
  CHECK(a.ripple_modulation == b.ripple_modulation);
  CHECK(a.ripple_skew == b.ripple_skew);
  CHECK(a.microsteps[1].amplitude == Approx(b.microsteps[1].amplitude).epsilon(kTwice));
  CHECK(a.hysteresis_rad == Approx(b.hysteresis_rad).epsilon(kTwice));
  CHECK(a.forgetting_rad == Approx(b.forgetting_rad).epsilon(kTwice));
  CHECK(read.arm.runout->sizes.isApprox(truth.arm.runout->sizes, kTwice));
  CHECK(read.arm.wobble->phases_rad.isApprox(truth.arm.wobble->phases_rad, kTwice));
  CHECK(read.arm.scatter->sigma_m == Approx(truth.arm.scatter->sigma_m).epsilon(kTwice));
  CHECK(read.arm.scatter->negative_factor == truth.arm.scatter->negative_factor);
  CHECK(read.arm.warming->growth == Approx(truth.arm.warming->growth).epsilon(kTwice));
  CHECK(read.arm.warming->link_time_s == Approx(truth.arm.warming->link_time_s).epsilon(kTwice));
  CHECK(read.arm.height_wave->center_m.isApprox(truth.arm.height_wave->center_m, kTwice));
  CHECK(read.arm.bending->slack_rad == Approx(truth.arm.bending->slack_rad).epsilon(kTwice));
  CHECK(read.camera.air->sigma_px == truth.camera.air->sigma_px);
  CHECK(read.tracker.elevation_errors[1].phase_rad ==
        Approx(truth.tracker.elevation_errors[1].phase_rad).epsilon(kTwice));
  CHECK(read.tracker.drift->velocity_m_s.isApprox(truth.tracker.drift->velocity_m_s, kTwice));
}

TEST_CASE("A truth whose real arm cannot be is refused") {
  const test::TemporaryFolder folder;
  Truth truth = draw_cheap_truth(4);
  truth.arm.warming->link_time_s = truth.arm.warming->motor_time_s;
  truth.arm.reducers[1].microsteps[0].amplitude = kFullStep;
  write_truth(folder / "truth.yaml", truth);
  CHECK_THROWS_MATCHES(read_truth(folder / "truth.yaml"), InputError,
                       Refused(Cause::kInvalid, "arm.warming"));
  CHECK_THROWS_MATCHES(read_truth(folder / "truth.yaml"), InputError,
                       Refused(Cause::kInvalid, "arm.microsteps"));
}

}  // namespace planar

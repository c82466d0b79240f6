#include "planar_servo/machine/rehearsal/live_cell.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/csv_table.h"
#include "planar_servo/hardware/cameras/aravis_camera.h"
#include "planar_servo/lamps/lamp_tracker.h"
#include "planar_servo/machine/rehearsal/gige_camera.h"
#include "support/eventually.h"
#include "support/temporary_folder.h"
#include "virtual_cell/sample_cell.h"

namespace planar {
namespace {

// A lamp's centre scatters by 0.02 px from frame to frame; the drift of some seconds is nothing.
constexpr double kSameCenter_px = 0.15;

LampPair lamps_in(const Frame& frame) {
  return LampTracker(CenterMethod::kAuto).locate(frame, {});
}

struct TrueRow {
  double t_s, x_mm, y_mm, phi_deg;
};

std::vector<TrueRow> rows_of(const std::filesystem::path& file) {
  CsvFile table(file, "truth-log", {"t_s", "x_mm", "y_mm", "phi_deg"});
  std::vector<TrueRow> rows;
  while (table.next_row())
    rows.push_back(
        {table.number("t_s"), table.number("x_mm"), table.number("y_mm"), table.number("phi_deg")});
  return rows;
}

TEST_CASE("A served camera shows the lamps where the cell's own camera sees them") {
  const Truth truth = draw_truth(3);
  const VirtualHardware hardware = test::sample_hardware();
  VirtualCell own(truth, hardware);
  LiveCell live(truth, hardware);
  const GigeCamera server("127.0.0.1", "cell", hardware.sensor_px, hardware.frame_rate_hz,
                          [&](const cv::Rect& region_px, double brightness) {
                            return live.expose(region_px, brightness);
                          });
  AravisSettings settings;
  settings.address = "127.0.0.1";
  settings.sensor_px = hardware.sensor_px;
  settings.frame_rate_hz = hardware.frame_rate_hz;
  settings.exposure_s = 1e-6 * kUsualExposure_us;
  settings.trigger = CameraTrigger::kSoftware;
  settings.packet_size = 9000;
  settings.timeout_s = 5.0;
  const auto opened = open_aravis_camera(settings);
  FrameSource& camera = *opened;
  const LampPair seen = lamps_in(own.camera().next_frame().frame);
  REQUIRE(seen.status == LampStatus::kAmbiguous);  // equal lamps, nothing says which is which
  const Eigen::Vector2d middle = (seen.lamps[0].uv_px + seen.lamps[1].uv_px) / 2.0;
  const cv::Rect region(static_cast<int>(middle.x()) - 256, static_cast<int>(middle.y()) - 256, 512,
                        512);
  for (const cv::Rect& shown : {cv::Rect({}, hardware.sensor_px), region}) {
    camera.set_region(shown);
    const FrameResult result = camera.next_frame();
    REQUIRE(result.status == FrameStatus::kOk);
    const LampPair served = lamps_in(result.frame);
    REQUIRE(served.status == LampStatus::kAmbiguous);
    for (std::size_t i = 0; i < 2; ++i) {
      const double nearest = std::min((served.lamps[i].uv_px - seen.lamps[0].uv_px).norm(),
                                      (served.lamps[i].uv_px - seen.lamps[1].uv_px).norm());
      CHECK(nearest < kSameCenter_px);
    }
  }
}

TEST_CASE("A live cell's arm follows the motors that are turned from outside") {
  const VirtualHardware hardware = test::sample_hardware();
  LiveCell live(draw_truth(3), hardware);
  const TipPose before = live.true_tip();
  const auto motor1 = static_cast<std::int32_t>(hardware.pulses_per_rad()[0] * 0.3);
  const auto half_turn = static_cast<std::int32_t>(hardware.pulses_per_rad()[0] * kPi);
  live.set_mover([&](VirtualCell& cell) { cell.turn_motor(0, motor1 + half_turn); });
  // The first joint's zero and eccentricity are off by less than a degree.
  CHECK((live.true_tip().p + before.p).norm() < 0.02 * before.p.norm());
}

TEST_CASE("What a region shows beyond the sensor is black") {
  const VirtualHardware hardware = test::sample_hardware();
  LiveCell live(draw_truth(3), hardware);
  const cv::Mat image =
      live.expose({hardware.sensor_px.width - 8, hardware.sensor_px.height - 8, 16, 16}, 1.0);
  CHECK(image.size() == cv::Size(16, 16));
  CHECK(cv::countNonZero(image) == cv::countNonZero(image(cv::Rect(0, 0, 8, 8))));
  CHECK(cv::countNonZero(image) > 0);
}

TEST_CASE("The truth's log has a row whenever the tool has moved, and none while it rests") {
  const test::TemporaryFolder folder;
  const VirtualHardware hardware = test::sample_hardware();
  LiveCell live(draw_truth(3), hardware);
  const std::filesystem::path file = folder / "truth.csv";
  const TruthLog log(file, live);
  const auto n_rows = [&] { return rows_of(file).size(); };
  REQUIRE(test::eventually([&] { return n_rows() == 1; }));
  SteadyClock clock;
  clock.sleep_for_s(0.2);
  CHECK(n_rows() == 1);
  const double moved_s = clock.now_s();
  live.now([&](VirtualCell& cell) { cell.turn_motor(0, hardware.home_pulses()[0] + 50000); });
  REQUIRE(test::eventually([&] { return n_rows() == 2; }));
  const TrueRow row = rows_of(file).back();
  const TipPose tip = live.true_tip();
  CHECK(row.t_s >= moved_s);
  CHECK(row.x_mm == Approx(tip.p.x() / kMillimetre).margin(1e-6));
  CHECK(row.y_mm == Approx(tip.p.y() / kMillimetre).margin(1e-6));
  CHECK(row.phi_deg == Approx(tip.phi / kDegree).margin(1e-6));
  log.require_well();
}

}  // namespace
}  // namespace planar

#include "planar_servo/machine/rehearsal/served_motors.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <optional>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/machine/rehearsal/served_cell.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "support/eventually.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

/// A drawn cell in a folder of its own, and the cell file of what would serve it.
struct DrawnCell {
  DrawnCell() {
    std::filesystem::copy_file(test::paper_cell_file(), folder / "cell.yaml");
    write_truth(folder / "truth.yaml", draw_truth(3));
    cell = read_cell(folder / "cell.yaml");
  }
  std::string text(const TrackerOutlet& tracker, bool decimal_comma = false) const {
    return live_cell_text(cell, {"127.0.0.1", "CAMERA1", folder / "port", tracker, decimal_comma});
  }
  CellSettings live() const {
    write_file(folder / "live.yaml", text(TrackerPort{"127.0.0.1", 7701}));
    return read_cell(folder / "live.yaml");
  }

  test::TemporaryFolder folder;
  CellSettings cell;
};

bool at_rest(DriveGroup& drives) {
  for (const DriveStatus& status : drives.status())
    if (!status.answers || status.moving || status.homing) return false;
  return true;
}

/// Moves like the robot does: status() hands the way over in pieces.
void go(DriveGroup& drives, const Pulses& targets) {
  drives.set_targets({targets[0], targets[1], targets[2]});
  REQUIRE(test::eventually([&] { return at_rest(drives); }));
}

TEST_CASE("A live cell file states real devices and of the rest what the virtual cell states") {
  const DrawnCell drawn;
  const CellSettings live = drawn.live();
  CHECK(live.camera.kind->name() == "aravis");
  CHECK(live.tracker.kind->name() == "tcp");
  CHECK_FALSE(live.truth);
  CHECK(live.arm.geometry.link_lengths_m == drawn.cell.arm.geometry.link_lengths_m);
  CHECK(live.datum.size() == drawn.cell.datum.size());
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(live.drives[i].kind->name() == "grbl");
    const MotorDrive& motor = live.transmission.drives[i];
    const MotorDrive& stated = drawn.cell.transmission.drives[i];
    CHECK(motor.gear_ratio == stated.gear_ratio);
    CHECK(motor.home_rad == Approx(stated.home_rad).margin(1e-9));
    CHECK(motor.max_speed_rad_s ==
          Approx(std::min(stated.max_speed_rad_s, 0.15 * motor.max_acceleration_rad_s2)));
  }
  for (const TrackerOutlet& outlet :
       {TrackerOutlet(TrackerPort{"127.0.0.1", 7701}), TrackerOutlet("tracker.txt")}) {
    const std::string text = drawn.text(outlet, true);
    for (const char* word : {"virtual", "truth", "simul"})
      CHECK(text.find(word) == std::string::npos);
  }
}

TEST_CASE("Pulses of a served board turn the arm by the truth's gears, whatever the cell states") {
  const DrawnCell drawn;
  Truth truth = draw_truth(3);
  VirtualHardware hardware = virtual_hardware(drawn.cell);
  truth.build = build_as_stated(hardware);
  truth.build.gear_ratios->x() *= 0.5;
  truth.build.directions->x() *= -1.0;
  LiveCell live(truth, hardware);
  const ServedMotors motors(drawn.cell, drawn.folder / "port", live);
  const CellSettings cell = drawn.live();
  const auto drives = cell.drives[0].kind->open(cell);
  drives->energize();
  for (int joint = 0; joint < 3; ++joint) {
    drives->start_homing(joint, HomeDirection::kReverse);
    REQUIRE(test::eventually([&] { return at_rest(*drives); }));
  }
  const Transmission transmission(cell.transmission);
  const Pulses home = transmission.pulses_from_joints(cell.arm.home);
  for (int i = 0; i < 3; ++i) drives->set_position(i, home[i]);
  const TipPose before = live.true_tip();
  Joints there = cell.arm.home;
  there[0] += 0.1;  // motors 2 and 3 ride on link 1
  there[1] += 0.1;
  there[2] += 0.1;
  go(*drives, transmission.pulses_from_joints(there));
  const TipPose after = live.true_tip();
  const auto angle = [](const TipPose& tip) { return std::atan2(tip.p.y(), tip.p.x()); };
  // Twice as far, the other way than a clockwise arm should; eccentricity is below 0.01 rad.
  CHECK(angle(after) - angle(before) == Approx(0.2).margin(0.01));
}

/// Two that serve at one place, the second later.
template <typename Served, typename... More>
void check_leaves_other(const More&... more) {
  const test::TemporaryFolder folder;
  const auto place = folder / "place";
  {
    std::optional<Served> first(std::in_place, place, more...);
    const Served second(place, more...);
    first.reset();
    CHECK(std::filesystem::exists(place));
  }
  CHECK_FALSE(std::filesystem::exists(std::filesystem::symlink_status(place)));
}

TEST_CASE("A pipe or port that ends leaves what has taken its place, and removes its own") {
  check_leaves_other<PtyPort>();
  check_leaves_other<ShaftPipe>([](const EmulatedGrbl::Pulses&) {});
}

TEST_CASE("A trail of motors keeps every turn and forgets the steps between") {
  MotorTrail trail;
  CHECK(trail.take().empty());
  for (int i = 0; i <= 100; ++i) trail.add({i, 0, 0});
  for (int i = 0; i <= 50; ++i) trail.add({100 - i, 2 * i, 0});
  const auto way = trail.take();
  REQUIRE(way.size() < 8);
  CHECK(way.front() == MotorTrail::Pulses(0, 0, 0));
  CHECK(std::find(way.begin(), way.end(), MotorTrail::Pulses(100, 0, 0)) != way.end());
  CHECK(way.back() == MotorTrail::Pulses(50, 100, 0));
  trail.add({40, 100, 0});
  CHECK(trail.take() == std::vector<MotorTrail::Pulses>{{50, 100, 0}, {40, 100, 0}});
}

}  // namespace
}  // namespace planar

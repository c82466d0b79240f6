#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/hardware/drives/drive_kinds.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

constexpr const char* kKeys =
    "port: /dev/serial/by-id/board, baud: 115200, pulses_per_mm: 250, "
    "home: {reference: reverse_switch, at_deg: -170},";

/// A cell whose joints are the axes X, Y and Z of a board.
struct GrblCell {
  GrblCell() {
    for (const char* axis : {"X", "Y", "Z"})
      replace("{kind: virtual,", std::string("{kind: grbl, axis: ") + axis + ", " + kKeys);
    for (int i = 0; i < 2; ++i) replace("max_speed_deg_s: 60", "max_speed_deg_s: 45");
    replace("max_speed_deg_s: 120", "max_speed_deg_s: 90");
  }

  GrblCell& replace(const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    text.replace(at, from.size(), to);
    return *this;
  }

  CellSettings read() const {
    const test::TemporaryFolder folder;
    folder.write("truth.yaml", read_file(test::paper_cell_file().parent_path() / "truth.yaml"));
    return read_cell(folder.write("cell.yaml", text));
  }

  std::string text{read_file(test::paper_cell_file())};
};

TEST_CASE("A cell may have a Grbl board, whose axes make the cell's speeds") {
  const CellSettings cell = GrblCell().read();
  const GrblSettings settings = grbl_settings(cell);
  CHECK(settings.port == "/dev/serial/by-id/board");
  CHECK(settings.baud == 115200);
  CHECK(settings.axes[2].letter == 'Z');
  CHECK(settings.axes[0].home == HomeReference::kReverseSwitch);
  const MotorDrive& motor = cell.transmission.drives[0];
  CHECK(settings.axes[0].speed_pulses_s ==
        Approx(motor.pulses_per_motor_turn * motor.gear_ratio * 45.0 / 360.0));
}

TEST_CASE("What a Grbl board cannot do is refused when the cell is read") {
  const auto refuses = [](const std::string& from, const std::string& to, Cause cause,
                          const std::string& name) {
    CAPTURE(to);
    GrblCell cell;
    cell.replace(from, to);
    CHECK_THROWS_MATCHES(cell.read(), InputError, test::Refused(cause, name));
  };
  refuses("pulses_per_mm: 250", "pulses_per_mm: 80", Cause::kInvalid, "pulses_per_mm is 80");
  CHECK_NOTHROW(GrblCell().replace("at_deg: -170", "at_deg: -719").read());
  for (const char* angle : {"1e6", "-721"})
    refuses("at_deg: -170", std::string("at_deg: ") + angle, Cause::kInvalid,
            "a turn beyond joint_limits_deg [-360, 360]");
  refuses("baud: 115200", "baud: 115000", Cause::kInvalid, "baud is 115000");
  refuses("port: /dev/serial/by-id/board", "port: /dev/ttyUSB0", Cause::kContradiction,
          "port or baud");
  refuses("axis: Y", "axis: X", Cause::kExists, "axis X");
  refuses("axis: Y", "axis: A", Cause::kInvalid, "drives[1].axis");
  refuses("reference: reverse_switch", "reference: taught", Cause::kContradiction,
          "drives[1] and drives[0]");
  refuses("max_speed_deg_s: 45", "max_speed_deg_s: 46", Cause::kInvalid, "at most 45");
}

}  // namespace
}  // namespace planar

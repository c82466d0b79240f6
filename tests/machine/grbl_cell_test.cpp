#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/hardware/drives/drive_kinds.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;

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
  const auto refusal = [](const std::string& from, const std::string& to) {
    try {
      GrblCell().replace(from, to).read();
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK_THAT(refusal("pulses_per_mm: 250", "pulses_per_mm: 80"),
             Contains("pulses_per_mm is 80; it must divide 1000"));
  CHECK_THAT(refusal("baud: 115200", "baud: 115000"),
             Contains("baud is 115000; one of") && Contains("115200"));
  CHECK_THAT(refusal("port: /dev/serial/by-id/board", "port: /dev/ttyUSB0"),
             Contains("another port or baud than drives[0]"));
  CHECK_THAT(refusal("axis: Y", "axis: X"), Contains("each joint needs an axis of its own"));
  CHECK_THAT(refusal("axis: Y", "axis: A"), Contains("axis"));
  CHECK_THAT(refusal("reference: reverse_switch", "reference: taught"),
             Contains("must both be taught or both have a home switch"));
  CHECK_THAT(refusal("max_speed_deg_s: 45", "max_speed_deg_s: 46"),
             Contains("it may be at most 45") && Contains("must rest within 0.2 s"));
}

}  // namespace
}  // namespace planar

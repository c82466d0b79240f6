#include "planar_servo/hardware/drives/tic_bus.h"

#include <catch2/catch.hpp>
#include <limits>

#include "planar_servo/base/core/error.h"
#include "support/refused.h"

namespace planar::tic {
namespace {

/// A drive at 1000 pulses, ready and at rest.
StatusBlock::Bytes at_rest() {
  StatusBlock::Bytes bytes{};
  bytes[0x00] = 10;
  bytes[0x01] = 1;
  bytes[0x22] = 0xe8;
  bytes[0x23] = 0x03;
  return bytes;
}

/// The same on its way down to 768 pulses.
StatusBlock::Bytes going_down() {
  StatusBlock::Bytes bytes = at_rest();
  bytes[0x09] = 1;
  bytes[0x0b] = 0x03;
  return bytes;
}

}  // namespace

TEST_CASE("Speeds and accelerations are converted to a Tic's units, within its bounds") {
  CHECK(speed_units(1.0) == 10000);
  CHECK(speed_units(50e3) == 500000000);
  CHECK(acceleration_units(1.0) == 100);
  CHECK_THROWS_MATCHES(speed_units(166667.0), InputError, test::Refused(Cause::kInvalid, "166667"));
  CHECK_THROWS_AS(speed_units(0.0), InputError);
  CHECK_THROWS_AS(acceleration_units(0.5), InputError);
  CHECK_THROWS_AS(acceleration_units(std::numeric_limits<double>::quiet_NaN()), InputError);
}

TEST_CASE("A status block tells where the drive stands and where it goes") {
  CHECK(StatusBlock(at_rest()).position() == 1000);
  CHECK(StatusBlock(at_rest()).target() == 1000);
  CHECK_FALSE(StatusBlock(at_rest()).moving());
  CHECK(StatusBlock(at_rest()).ready());
  CHECK(StatusBlock(going_down()).target() == 768);
  CHECK(StatusBlock(going_down()).moving());
  auto negative = at_rest();
  for (std::size_t i = 0x22; i < 0x26; ++i) negative[i] = 0xff;
  CHECK(StatusBlock(negative).position() == -1);
}

TEST_CASE("Error bits are explained in words, and being switched off is no error") {
  auto bytes = at_rest();
  bytes[0x00] = 4;
  bytes[0x02] = 0x45;
  CHECK(StatusBlock(bytes).faults() ==
        std::vector<std::string>{"low supply voltage", "command timeout"});
  CHECK_FALSE(StatusBlock(bytes).ready());
  bytes[0x02] = 0x01;
  CHECK(StatusBlock(bytes).faults().empty());
  bytes[0x02] = 0x00;
  bytes[0x03] = 0x01;
  CHECK(StatusBlock(bytes).faults() == std::vector<std::string>{"its ERR line is high"});
}

TEST_CASE("A stop by hand that has passed is a fault until errors are cleared, no other error is") {
  auto bytes = at_rest();
  bytes[0x04] = 0xfe;
  const DriveStatus status = StatusBlock(bytes).drive_status();
  CHECK(status.stopped_by_hand);
  CHECK(status.faults == std::vector<std::string>{"low supply voltage for a moment",
                                                  "kill switch active for a moment"});
  CHECK(StatusBlock(bytes).standing_faults().empty());
  bytes[0x04] = 0xf2;
  CHECK_FALSE(StatusBlock(bytes).drive_status().stopped_by_hand);
  CHECK(StatusBlock(bytes).faults().empty());
}

TEST_CASE("A limit switch is a fault only where it stands in the way") {
  auto away = going_down();
  away[0x01] |= 4;
  CHECK(StatusBlock(away).faults().empty());
  CHECK(StatusBlock(away).moving());
  auto into = going_down();
  into[0x01] |= 8;
  CHECK(StatusBlock(into).faults() ==
        std::vector<std::string>{"it stands on its reverse limit switch"});
  CHECK_FALSE(StatusBlock(into).moving());
  auto homing = into;
  homing[0x01] |= 16;
  CHECK(StatusBlock(homing).faults().empty());
  CHECK(StatusBlock(homing).moving());
}

}  // namespace planar::tic

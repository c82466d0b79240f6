#include "planar_servo/hardware/drives/drive_kinds.h"

#include <catch2/catch.hpp>

#include "support/tic_bench.h"

namespace planar {
namespace {

using Catch::Contains;
using Catch::EndsWith;
using Catch::StartsWith;
using test::TicBench;

}  // namespace

TEST_CASE("An inspection reads what a drive says of itself, and changes nothing") {
  TicBench bench;
  TicBus bus;
  const std::uint8_t timeout = bench.tics[0].setting(0x09);
  const TicInspection tic = inspect_tic(bus, TicBench::kSerials[0]);
  CHECK_FALSE(tic.refusal);
  CHECK(tic::product_name(tic.listing.product_id) == "Tic 36v4");
  CHECK(tic::firmware_name(tic.listing.firmware) == "1.09");
  CHECK(tic.supply_v == Approx(24.0));
  CHECK_FALSE(tic.position_certain);
  CHECK(tic.faults.empty());  // safe start and being off are how a drive waits
  CHECK(bench.tics[0].setting(0x09) == timeout);
}

TEST_CASE("An inspection tells what stands in the way apart from what mends it") {
  TicBench bench;
  TicBus bus;
  bench.tics[0].store_setting(0x01, 3);
  const auto deaf = inspect_tic(bus, TicBench::kSerials[0]).refusal;
  REQUIRE(deaf);
  CHECK(deaf->fault == "its control mode is 3, in which it ignores this program");
  CHECK(deaf->remedy == "set it to 'Serial / I2C / USB' in Pololu's Tic Control Center");
  bench.tics[1].set_supply(2.0);
  CHECK(inspect_tic(bus, TicBench::kSerials[1]).faults ==
        std::vector<std::string>{"low supply voltage"});
  const auto absent = inspect_tic(bus, "0").refusal;
  REQUIRE(absent);
  CHECK(absent->cause == Cause::kMissing);
  CHECK_THAT(absent->fault, Contains("'0'") && EndsWith(")"));
  CHECK_THAT(absent->remedy, StartsWith("plug it in"));
}

TEST_CASE("A Tic in the hands of another program is refused with all of its words") {
  TicBench bench;
  TicBus bus, other;
  Refusal why;
  const auto port = other.open(TicBench::kSerials[0], why);
  REQUIRE(port);
  CHECK_FALSE(bus.open(TicBench::kSerials[0], why));
  CHECK(why.cause == Cause::kBusy);
  CHECK_THAT(why.fault, EndsWith(")"));
  CHECK(why.remedy == "end that program");
}

}  // namespace planar

#include "planar_servo/drives/tic/tic_inspection.h"

#include <catch2/catch.hpp>

#include "support/tic_bench.h"

namespace planar {
namespace {

using Catch::Contains;
using test::TicBench;

}  // namespace

TEST_CASE("An inspection reads what a drive says of itself, and changes nothing") {
  TicBench bench;
  TicBus bus;
  const std::uint8_t timeout = bench.tics[0].setting(0x09);
  const TicInspection tic = inspect_tic(bus, TicBench::kSerials[0]);
  CHECK(tic.refusal.empty());
  CHECK(tic::product_name(tic.listing.product_id) == "Tic 36v4");
  CHECK(tic::firmware_name(tic.listing.firmware) == "1.09");
  CHECK(tic.supply_v == Approx(24.0));
  CHECK_FALSE(tic.position_certain);
  CHECK(tic.faults.empty());  // safe start and being off are how a drive waits
  CHECK(bench.tics[0].setting(0x09) == timeout);
}

TEST_CASE("An inspection names what stands in the way") {
  TicBench bench;
  TicBus bus;
  bench.tics[0].store_setting(0x01, 3);
  CHECK_THAT(inspect_tic(bus, TicBench::kSerials[0]).refusal, Contains("control mode is 3"));
  bench.tics[1].set_supply(2.0);
  CHECK(inspect_tic(bus, TicBench::kSerials[1]).faults ==
        std::vector<std::string>{"low supply voltage"});
  CHECK_THAT(inspect_tic(bus, "0").refusal, Contains("no Tic with the serial number '0'"));
}

TEST_CASE("The bus lists its Tics") {
  TicBench bench;
  TicBus bus;
  CHECK(bus.list().size() == 3);
  bench.devices[1].unplug();
  TicBus later;
  CHECK(later.list().size() == 2);
}

}  // namespace planar

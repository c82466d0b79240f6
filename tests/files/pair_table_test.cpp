#include "planar_servo/files/tables/pair_table.h"

#include <catch2/catch.hpp>

#include "support/refused.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

using test::Refused;

TEST_CASE("Pairs come back as they were written") {
  PairRow row;
  row.id = "p1";
  row.p_vision = {0.1234567, -0.3};
  row.p_tracker = Eigen::Vector2d(0.1230, -0.2999);
  row.phi = 0.5;
  row.plan = Purpose::kTrain;
  row.p_reflector = Eigen::Vector2d(0.13, -0.31);
  row.z_reflector = 0.0812345;
  const test::TemporaryFolder folder;
  const PairRow back = read_pairs(folder.write("pairs.csv", pairs_text({row}))).at(0);
  CHECK(back.id == "p1");
  CHECK((back.error() - row.error()).norm() < test::kWrittenNanometre);
  CHECK(*back.phi == Approx(0.5).margin(1e-8));
  CHECK_FALSE(back.sigma_vision.has_value());
  CHECK(back.plan == Purpose::kTrain);
  CHECK(back.z_reflector.value() == Approx(0.0812345).margin(test::kWrittenNanometre));
}

TEST_CASE("A row without the tracker's word is an unattended pose") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("pairs.csv",
                                 "id,x_vision_mm,y_vision_mm,x_tracker_mm,y_tracker_mm\n"
                                 "a,1,2,1,2\nb,3,4,,\n");
  const std::vector<PairRow> rows = read_pairs(file);
  REQUIRE(rows.size() == 2);
  CHECK(rows[0].is_attended());
  CHECK_FALSE(rows[1].is_attended());
  CHECK_FALSE(rows[1].lamps_B.has_value());
}

TEST_CASE("Half a point, half a pair of lamps and half a pose are refused by line and column") {
  const test::TemporaryFolder folder;
  const auto file = folder.write(
      "pairs.csv",
      "id,x_vision_mm,y_vision_mm,x_tracker_mm,y_tracker_mm,x_lamp1_mm,y_lamp1_mm,x_lamp2_mm,"
      "y_lamp2_mm,theta1_deg,theta2_deg,theta3_deg\n"
      "a,1,2,1,,,,,,,,\nb,1,2,1,2,3,4,,,,,\nc,1,2,1,2,,,,,10,,30\n");
  for (const char* place : {":2: y_tracker_mm", "pairs.csv:3", ":4: theta2_deg"})
    CHECK_THROWS_MATCHES(read_pairs(file), InputError, Refused(Cause::kInvalid, place));
}

TEST_CASE("Lays come back as they were written") {
  const LayRow row{"plane_grid_00_0", {0.05, -0.1}, {0.1234567, -0.3}, 1.5e-6, false};
  const test::TemporaryFolder folder;
  const LayRow back = read_lays(folder.write("lays.csv", lays_text({row}))).at(0);
  CHECK(back.lay == row.lay);
  CHECK((back.p_board - row.p_board).norm() < test::kWrittenNanometre);
  CHECK((back.p_seen - row.p_seen).norm() < test::kWrittenNanometre);
  CHECK(back.sigma == Approx(row.sigma).margin(test::kWrittenNanometre));
  CHECK_FALSE(back.pitch_known);
}

TEST_CASE("A board's pitch is known unless the table says otherwise, in one of two words") {
  const std::string columns = "lay,x_board_mm,y_board_mm,x_seen_mm,y_seen_mm,sigma_mm";
  const test::TemporaryFolder folder;
  CHECK(read_lays(folder.write("lays.csv", columns + "\na,0,0,1,2,0.001\n")).at(0).pitch_known);
  const auto bad =
      folder.write("bad.csv", columns + ",pitch\na,0,0,1,2,0.001,50\na,0,0,1,2,-0.001,known\n");
  for (const char* place : {"bad.csv:2: pitch", "bad.csv:3: sigma_mm"})
    CHECK_THROWS_MATCHES(read_lays(bad), InputError, Refused(Cause::kInvalid, place));
}

}  // namespace
}  // namespace planar

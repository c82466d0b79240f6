#include "planar_servo/files/tables/tables.h"

#include <catch2/catch.hpp>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;

constexpr double kWrittenNanometre = 1e-9;

TEST_CASE("Pairs come back as they were written") {
  PairRow row;
  row.id = "p1";
  row.p_vision = {0.1234567, -0.3};
  row.p_tracker = {0.1230, -0.2999};
  row.phi = 0.5;
  row.plan = "train";
  const test::TemporaryFolder folder;
  const PairRow back = read_pairs(folder.write("pairs.csv", pairs_text({row}))).at(0);
  CHECK(back.id == "p1");
  CHECK((back.error() - row.error()).norm() < kWrittenNanometre);
  CHECK(*back.phi == Approx(0.5).margin(1e-8));
  CHECK_FALSE(back.sigma_vision.has_value());
  CHECK(back.plan == "train");
}

TEST_CASE("A plan asks for positions by point or by joints, and for board views by neither") {
  const std::vector<PlanRow> rows{{"g", "grid", {}},
                                  {"t", "train", TipPose{{0.1, 0.2}, 0.0}},
                                  {"s", "sweep3", Joints(0.1, 0.2, 0.3)}};
  const test::TemporaryFolder folder;
  const auto back = read_plan(folder.write("plan.csv", plan_text(rows)), 0.0);
  REQUIRE(back.size() == 3);
  CHECK(std::holds_alternative<std::monostate>(back[0].where));
  CHECK((std::get<TipPose>(back[1].where).p - Eigen::Vector2d(0.1, 0.2)).norm() <
        kWrittenNanometre);
  CHECK((std::get<Joints>(back[2].where) - Joints(0.1, 0.2, 0.3)).norm() < 1e-7);
}

TEST_CASE("Plan rows without a place or with a plan that does not exist are named") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_WITH(
      read_plan(folder.write("plan.csv", "id,plan,x_mm,y_mm\na,trian,1,2\nb,train,,\n"), 0.0),
      Contains("plan.csv:2: plan is 'trian'; allowed are grid") &&
          Contains("plan.csv:3: has no position"));
}

TEST_CASE("A plan row without a direction keeps the tool as the cell has it") {
  const test::TemporaryFolder folder;
  const auto rows = read_plan(
      folder.write("plan.csv", "id,plan,x_mm,y_mm,phi_deg\na,train,1,2,\nb,train,1,2,90\n"), 0.5);
  CHECK(std::get<TipPose>(rows.at(0).where).phi == 0.5);
  CHECK(std::get<TipPose>(rows.at(1).where).phi == 90.0 * kDegree);
}

TEST_CASE("A plan row whose id would leave the folder of images is refused") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_WITH(read_plan(folder.write("plan.csv", "id,plan,x_mm,y_mm\n../a,train,1,2\n"), 0.0),
                    Contains("plan.csv:2: id is '../a'"));
}

}  // namespace
}  // namespace planar

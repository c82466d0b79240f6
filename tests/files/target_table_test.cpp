#include "planar_servo/files/tables/target_table.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "support/refused.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

TEST_CASE("Targets are found by column name, ids must differ") {
  const test::TemporaryFolder folder;
  const auto targets = read_targets(folder.write("t.csv", "x_mm,id,y_mm\n200,a,-100\n"));
  CHECK((targets.at(0).p_d - Eigen::Vector2d(0.2, -0.1)).norm() < test::kWrittenNanometre);
  CHECK_FALSE(targets[0].phi_d.has_value());
  const auto bad = folder.write("bad.csv", "id,x_mm,y_mm\na,1,2\na,3,NaN\n");
  CHECK_THROWS_MATCHES(read_targets(bad), InputError,
                       Refused(Cause::kExists, "bad.csv:3: the id 'a'"));
  CHECK_THROWS_MATCHES(read_targets(bad), InputError, Refused(Cause::kInvalid, "bad.csv:3: y_mm"));
  CHECK_THROWS_MATCHES(read_targets(folder.write("t.csv", "id,x_m,y_m\n")), InputError,
                       Refused(Cause::kMissing, "x_mm, y_mm"));
  CHECK_THROWS_MATCHES(read_targets(folder.write("t.csv", "id,x_mm,y_mm\n")), InputError,
                       Refused(Cause::kMissing, "t.csv"));
}

TEST_CASE("Directions in radians or without a unit are refused, other columns are ignored") {
  const test::TemporaryFolder folder;
  for (const std::string column : {"phi_rad", "phi", "Phi_deg", "ph_deg"}) {
    const std::string text = "id,x_mm,y_mm," + column + "\na,1,2,1.5\n";
    const Refused misnamed(Cause::kInvalid, "column " + column + " is probably phi_deg");
    CHECK_THROWS_MATCHES(read_targets(folder.write("t.csv", text)), InputError, misnamed);
    TargetLines lines("stdin");
    CHECK_THROWS_MATCHES(lines.next(text.substr(0, text.find('\n'))), InputError, misnamed);
  }
  CHECK_THROWS_WITH(read_targets(folder.write("t.csv", "id,x,Y_mm\na,1,2\n")),
                    Contains("x is probably x_mm (in millimetres), Y_mm is probably y_mm"));
  CHECK(read_targets(folder.write("t.csv", "id,x_mm,y_mm,z_mm,part\na,1,2,3,lid\n")).size() == 1);
}

TEST_CASE("A plan that is given as targets is told in one sentence") {
  const test::TemporaryFolder folder;
  const auto plan =
      folder.write("plan.csv", "id,plan,x_mm,y_mm\ng1,grid,,\ng2,grid,,\nt1,train,200,100\n");
  CHECK_THROWS_MATCHES(read_targets(plan), InputError, Refused(Cause::kForeign, "plan.csv"));
  CHECK_THROWS_WITH(read_targets(plan), !Contains("\n"));
  CHECK(read_targets(folder.write("p.csv", "id,plan,x_mm,y_mm\nt1,train,200,100\n")).size() == 1);
}

TEST_CASE("Only a plan without places is called a plan, other faults are told as they are") {
  const test::TemporaryFolder folder;
  const auto read = [&](const std::string& text) { read_targets(folder.write("p.csv", text)); };
  CHECK_THROWS_MATCHES(read("id,plan,x_mm,y_mm\nt1,train,200,l00\n"), InputError,
                       Refused(Cause::kInvalid, "p.csv:2: y_mm"));
  CHECK_THROWS_MATCHES(read("id,plan,x_mm,y_mm\nt1,train,2,1\nt1,train,2,2\n"), InputError,
                       Refused(Cause::kExists, "p.csv:3: the id 't1'"));
  CHECK_THROWS_MATCHES(read("id,plan,x_m,y_m\nt1,train,0.2,0.1\n"), InputError,
                       Refused(Cause::kMissing, "x_mm, y_mm"));
  CHECK_THROWS_MATCHES(read("id,plan,theta1_deg,theta2_deg,theta3_deg\nt1,sweep1,1,2,3\n"),
                       InputError, Refused(Cause::kForeign, "p.csv"));
}

TEST_CASE("A table of targets whose last line is torn is refused") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_MATCHES(read_targets(folder.write("t.csv", "id,x_mm,y_mm\nA,200,100\nB,150,29")),
                       InputError, Refused(Cause::kInvalid, "t.csv:3"));
}

TEST_CASE("Lines without a header are id, x_mm, y_mm and perhaps phi_deg") {
  TargetLines lines("stdin");
  const auto a = lines.next("a,200,100");
  const auto b = lines.next(" b , -1.5 , 2 , 90 \r");
  REQUIRE((a && b));
  CHECK((a->p_d - Eigen::Vector2d(0.2, 0.1)).norm() < test::kWrittenNanometre);
  CHECK_FALSE(a->phi_d);
  CHECK(b->id == "b");
  CHECK(*b->phi_d == Approx(kPi / 2.0));
  CHECK_THROWS_MATCHES(lines.next("c,1,2,3,4"), InputError,
                       Refused(Cause::kInvalid, "stdin:3: has 5 fields"));
}

TEST_CASE("A header orders the columns of the lines after it") {
  TargetLines lines("stdin");
  CHECK_FALSE(lines.next("# format: planar-servo/targets/1"));
  CHECK_FALSE(lines.next("y_mm,x_mm,id"));
  const auto target = lines.next("1,2,a");
  REQUIRE(target);
  CHECK((target->p_d - Eigen::Vector2d(2e-3, 1e-3)).norm() < test::kWrittenNanometre);
}

TEST_CASE("After a header that cannot be used no line is a target") {
  TargetLines lines("stdin");
  CHECK_THROWS_AS(lines.next("Id,y_mm,x_mm"), InputError);
  CHECK_FALSE(lines.has_columns());
}

TEST_CASE("Ids that are taken are refused, a refused line does not take its id") {
  TargetLines lines("stdin", {"old"});
  CHECK_THROWS_MATCHES(lines.next("old,1,2"), InputError, Refused(Cause::kExists, "'old'"));
  CHECK_THROWS_AS(lines.next("new,1,two"), InputError);
  CHECK(lines.next("new,1,2"));
}

TEST_CASE("A written target comes back") {
  const test::TemporaryFolder folder;
  const auto back =
      read_targets(folder.write("t.csv", targets_header() + target_line({"a", {0.2, -0.1}, 1.0}) +
                                             target_line({"b", {0.3, 0.1}, std::nullopt})));
  REQUIRE(back.size() == 2);
  CHECK((back[0].p_d - Eigen::Vector2d(0.2, -0.1)).norm() < test::kWrittenNanometre);
  CHECK(*back[0].phi_d == Approx(1.0));
  CHECK_FALSE(back[1].phi_d);
}

}  // namespace
}  // namespace planar

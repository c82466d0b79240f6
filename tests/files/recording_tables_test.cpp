#include "planar_servo/files/tables/recording_tables.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "support/refused.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

using test::Refused;

TEST_CASE("A plan asks for positions by point or by joints, and for board views by neither") {
  const std::vector<PlanRow> rows{{"g", Purpose::kHeldBoard, {}},
                                  {"t", Purpose::kTrain, TipPose{{0.1, 0.2}, 0.0}},
                                  {"s", Purpose::kSweep3, Joints(0.1, 0.2, 0.3)}};
  const test::TemporaryFolder folder;
  const auto back = read_plan(folder.write("plan.csv", plan_text(rows)), 0.0);
  REQUIRE(back.size() == 3);
  CHECK(std::holds_alternative<std::monostate>(back[0].where));
  CHECK((std::get<TipPose>(back[1].where).p - Eigen::Vector2d(0.1, 0.2)).norm() <
        test::kWrittenNanometre);
  CHECK((std::get<Joints>(back[2].where) - Joints(0.1, 0.2, 0.3)).norm() < 1e-7);
}

TEST_CASE("Plan rows without a place or with a plan that does not exist are named") {
  const test::TemporaryFolder folder;
  const auto plan = folder.write("plan.csv", "id,plan,x_mm,y_mm\na,trian,1,2\nb,train,,\n");
  CHECK_THROWS_MATCHES(read_plan(plan, 0.0), InputError,
                       Refused(Cause::kInvalid, "plan.csv:2: plan is 'trian'"));
  CHECK_THROWS_MATCHES(read_plan(plan, 0.0), InputError, Refused(Cause::kMissing, "plan.csv:3"));
}

TEST_CASE("A plan whose last line is torn is refused") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_MATCHES(
      read_plan(folder.write("plan.csv", "id,plan,x_mm,y_mm\na,train,200,10"), 0.0), InputError,
      Refused(Cause::kInvalid, "plan.csv:2"));
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
  CHECK_THROWS_MATCHES(
      read_plan(folder.write("plan.csv", "id,plan,x_mm,y_mm\n../a,train,1,2\n"), 0.0), InputError,
      Refused(Cause::kInvalid, "plan.csv:2: id is '../a'"));
}

TEST_CASE("Half a place, or both kinds of place, is a fault of its row") {
  const test::TemporaryFolder folder;
  const auto read = [&](const std::string& row) {
    const std::string header = "id,plan,x_mm,y_mm,phi_deg,theta1_deg,theta2_deg,theta3_deg\n";
    read_plan(folder.write("plan.csv", header + row), 0.0);
  };
  CHECK_THROWS_MATCHES(read("a,train,1,,,,,\n"), InputError,
                       Refused(Cause::kInvalid, "plan.csv:2: y_mm"));
  CHECK_THROWS_MATCHES(read("a,train,,2,,,,\n"), InputError,
                       Refused(Cause::kInvalid, "plan.csv:2: x_mm"));
  CHECK_THROWS_MATCHES(read("a,train,,,,1,,3\n"), InputError,
                       Refused(Cause::kInvalid, "plan.csv:2: theta2_deg"));
  CHECK_THROWS_MATCHES(read("a,train,1,2,,1,2,3\n"), InputError,
                       Refused(Cause::kContradiction, "plan.csv:2"));
}

TEST_CASE("A frame comes back as it was written") {
  const test::TemporaryFolder folder;
  const FrameRow frame{"t1",          "images/t1.pgm",     1.5, Purpose::kTrain, {0.1, -0.2, 0.3},
                       {10, -20, 30}, {100, 200, 512, 512}};
  folder.write("frames.csv", frames_header() + frame_line(frame));
  const FrameRow back = read_frames(folder.path()).at(0);
  CHECK(back.image == frame.image);
  CHECK((back.theta - frame.theta).norm() < 1e-10);
  CHECK(back.pulses == frame.pulses);
  CHECK(back.region_px == frame.region_px);
}

TEST_CASE("A recording that is no folder, empty or of an unknown plan is refused") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_MATCHES(read_frames(folder / "absent"), InputError,
                       Refused(Cause::kMissing, "absent"));
  folder.write("frames.csv", frames_header());
  CHECK_THROWS_MATCHES(read_frames(folder.path()), InputError,
                       Refused(Cause::kMissing, "frames.csv: "));
  folder.write("frames.csv", frames_header() + "a,a.pgm,0,traning,0,0,0,0,0,0,0,0,8,8\n");
  CHECK_THROWS_MATCHES(read_frames(folder.path()), InputError,
                       Refused(Cause::kInvalid, "frames.csv:3: plan"));
}

}  // namespace
}  // namespace planar

#include "planar_servo/files/tables/result_table.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "support/refused.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

using test::Refused;

JudgedMove judged_sample() {
  JudgedMove move;
  move.move = {"v01.P4-y", CertificatePart::kDirection, "P4", "-y", 1, {0.2, -0.1}, {}};
  move.status = ServoStatus::kReached;
  move.utc = "2026-11-23T02:00:00Z";
  move.error = Eigen::Vector2d(3e-6, -4e-6);
  move.judge_sigma = 10e-6;
  move.sigma_vision = 1e-6;
  return move;
}

std::vector<JudgedMove> back_from(const std::string& lines) {
  const test::TemporaryFolder folder;
  return read_cycles(folder.write("cycles.csv", cycles_header({"# cycles: 30"}) + lines));
}

TEST_CASE("A judged move comes back as it was written, what was not judged stays so") {
  JudgedMove unjudged = judged_sample();
  unjudged.move.id = "w001";
  unjudged.move.part = CertificatePart::kWorkspace;
  unjudged.move.pose.clear();
  unjudged.error.reset();
  const auto back = back_from(cycle_line(judged_sample()) + cycle_line(unjudged));
  REQUIRE(back.size() == 2);
  CHECK(back[0].move.part == CertificatePart::kDirection);
  CHECK(back[0].move.pose == "P4");
  CHECK(back[0].move.from == "-y");
  CHECK(back[0].counts());
  CHECK((*back[0].error - Eigen::Vector2d(3e-6, -4e-6)).norm() < test::kWrittenNanometre);
  CHECK(back[0].judge_sigma == Approx(10e-6));
  CHECK_FALSE(back[0].turn_error);
  CHECK_FALSE(back[1].counts());
}

TEST_CASE("A pose that does not exist and an id twice are named with their lines") {
  JudgedMove move = judged_sample();
  move.move.pose = "P6";
  CHECK_THROWS_MATCHES(back_from(cycle_line(judged_sample()) + cycle_line(move)), InputError,
                       Refused(Cause::kInvalid, "cycles.csv:5: pose"));
  CHECK_THROWS_MATCHES(back_from(cycle_line(judged_sample()) + cycle_line(judged_sample())),
                       InputError, Refused(Cause::kExists, "cycles.csv:5: "));
}

}  // namespace
}  // namespace planar

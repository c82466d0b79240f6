#include "planar_servo/machine/judge/cell_judge.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

/// The tool is seen at the base.
const Standing kAtBase{{}, TipPose{}};

ToolOffsets sample_tool() {
  ToolOffsets tool;
  tool.p_TS = {30e-3, -10e-3, 5e-3};
  return tool;
}

/// An exact tracker in a frame of its own, on a tool that rests at `tip`.
class ExactTracker final : public Tracker {
 public:
  explicit ExactTracker(const std::vector<Monument>& datum) : datum_(datum) {}

  TipPose tip;
  TrackerStatus answer{TrackerStatus::kOk};
  int failures{0};  ///< so many answers fail first
  int asked{0}, tool_awaited{0};

  std::function<bool()> stop;

  void await_tool() override { ++tool_awaited; }
  void stop_when(const std::function<bool()>& asked_to_stop) override { stop = asked_to_stop; }
  TrackerAnswer measure_tool(const std::string& /*place*/) override {
    ++asked;
    if (failures-- > 0) return TrackerAnswer::failed("the beam is broken");
    Eigen::Vector3d p(tip.p.x(), tip.p.y(), 0.0);
    const ToolOffsets tool = sample_tool();
    p.head<2>() += rotation2d(tip.phi) * tool.p_TS.head<2>();
    p.z() += tool.p_TS.z();
    return reading(p);
  }
  TrackerAnswer measure_monument(const std::string& id) override {
    for (const Monument& monument : datum_)
      if (monument.id == id) return reading(monument.p_B);
    return TrackerAnswer::failed("no such monument");
  }

 private:
  TrackerAnswer reading(const Eigen::Vector3d& p_B) const {
    Pose X_LB = Pose::Identity();
    X_LB.linear() = rotation_from_vector({0.1, -0.2, 1.3});
    X_LB.translation() = Eigen::Vector3d(2.0, -1.0, 0.7);
    TrackerAnswer given = TrackerAnswer::of({0.0, X_LB * p_B});
    given.status = answer;
    return given;
  }

  std::vector<Monument> datum_;
};

class KnownTruth final : public Judge {
 public:
  JudgeKind kind() const override { return JudgeKind::kTruth; }
  JudgedTip judge(const std::string& /*id*/, const Standing& /*standing*/) override {
    return {Eigen::Vector2d(0.25, 0.125), 0.0, "", 0.5};
  }
  double common_sigma() const override { return 0.0; }
};

/// A cell of which a judge may only ask tracker and truth.
class JudgedCell final : public CellDevices {
 public:
  explicit JudgedCell(const std::vector<Monument>& datum) : exact(datum) {}

  ExactTracker exact;

  Clock& clock() override { throw WorkError("no clock", Cause::kMissing); }
  FrameSource& camera() override { throw WorkError("no camera", Cause::kMissing); }
  DriveGroup& drives() override { throw WorkError("no drives", Cause::kMissing); }
  Tracker& tracker() override { return exact; }
  BoardPresenter* board_presenter() override { return nullptr; }
  std::shared_ptr<Judge> truth() override { return std::make_shared<KnownTruth>(); }
};

CellSettings real_cell() {
  CellSettings cell = read_cell(test::workshop_cell_file());
  cell.truth.reset();
  return cell;
}

TEST_CASE("A tracker judges the end point by the reflector and the tool's supposed direction") {
  const test::TemporaryFolder folder;
  const CellSettings cell = real_cell();
  JudgedCell devices(cell.datum);
  const auto judge = make_judge(judge_of(cell, sample_tool()), cell, sample_tool(), devices,
                                folder / "tracker.csv", {});
  CHECK(devices.exact.tool_awaited == 1);
  for (const double phi : {0.0, 1.0, -2.5}) {
    devices.exact.tip = {{0.3, -0.1}, phi};
    const JudgedTip tip = judge->judge("a", {{}, devices.exact.tip});
    REQUIRE(tip.p);
    CHECK((*tip.p - devices.exact.tip.p).norm() < 1e-9);
    CHECK_FALSE(tip.phi);
    CHECK(tip.sigma >= cell.tracker.sigma_m);
  }
  CHECK(judge->common_sigma() == 0.0);
}

TEST_CASE("The reflector's place on the tool is what a tracker's answers have in common") {
  const test::TemporaryFolder folder;
  const CellSettings cell = real_cell();
  JudgedCell devices(cell.datum);
  ToolOffsets tool = sample_tool();
  tool.covariance(2, 2) = 1e-12;
  tool.covariance(3, 3) = 4e-12;
  const auto judge =
      make_judge(JudgeKind::kTracker, cell, tool, devices, folder / "tracker.csv", {});
  CHECK(judge->common_sigma() == Approx(2e-6));
}

TEST_CASE("A tracker that fails is asked three times, and then says why nothing was judged") {
  const test::TemporaryFolder folder;
  const CellSettings cell = real_cell();
  JudgedCell devices(cell.datum);
  ExactTracker& tracker = devices.exact;
  const auto judge =
      make_judge(JudgeKind::kTracker, cell, sample_tool(), devices, folder / "tracker.csv", {});
  SECTION("twice") {
    tracker.failures = 2;
    CHECK(judge->judge("a", kAtBase).p);
  }
  SECTION("every time") {
    tracker.failures = 3;
    CHECK(judge->judge("a", kAtBase).fault == "the beam is broken");
  }
  SECTION("because its readings stand elsewhere") {
    tracker.answer = TrackerStatus::kElsewhere;
    CHECK_THAT(judge->judge("a", kAtBase).fault, Catch::Contains("a table of the tracker's own"));
  }
  SECTION("because the reflector is not on the tool") {
    tracker.tip.p.x() = 0.3;
    CHECK_THAT(judge->judge("a", kAtBase).fault, Catch::Contains("300.0 mm"));
  }
  CHECK(tracker.asked == 3);
}

TEST_CASE("Whoever stops the program ends the round over the monuments and the tracker's waits") {
  const test::TemporaryFolder folder;
  const CellSettings cell = real_cell();
  JudgedCell devices(cell.datum);
  const auto stop = [] { return true; };
  CHECK_THROWS_MATCHES(
      make_judge(JudgeKind::kTracker, cell, sample_tool(), devices, folder / "tracker.csv", stop),
      WorkError, Refused(Cause::kStopped));
  CHECK(devices.exact.stop());
  CHECK(devices.exact.tool_awaited == 0);
}

TEST_CASE("Somebody who chooses to do without a reading is not asked for it again") {
  const test::TemporaryFolder folder;
  const CellSettings cell = real_cell();
  JudgedCell devices(cell.datum);
  const auto judge =
      make_judge(JudgeKind::kTracker, cell, sample_tool(), devices, folder / "tracker.csv", {});
  devices.exact.answer = TrackerStatus::kSkipped;
  CHECK_THAT(judge->judge("a", kAtBase).fault, Catch::Contains("left its reading out"));
  CHECK(devices.exact.asked == 1);
}

TEST_CASE("The truth judges a virtual cell, and no tracker is read") {
  const test::TemporaryFolder folder;
  const CellSettings cell = read_cell(test::workshop_cell_file());
  REQUIRE(judge_of(cell, sample_tool()) == JudgeKind::kTruth);
  JudgedCell devices(cell.datum);
  const auto judge =
      make_judge(JudgeKind::kTruth, cell, sample_tool(), devices, folder / "tracker.csv", {});
  CHECK(judge->kind() == JudgeKind::kTruth);
  CHECK(judge->judge("a", {}).p == Eigen::Vector2d(0.25, 0.125));
  CHECK(devices.exact.asked == 0);
}

TEST_CASE("A tracker judges a tool that is not seen only by an arm that it may suppose") {
  const test::TemporaryFolder folder;
  const CellSettings cell = real_cell();
  JudgedCell devices(cell.datum);
  TrackerJudge judge(cell, sample_tool(), devices.tracker(), folder / "tracker.csv", {});
  CHECK_THAT(judge.judge("a", {}).fault, Catch::Contains("does not see the tool's direction"));
  CHECK(devices.exact.tool_awaited == 0);
  devices.exact.tip = {{0.3, -0.1}, 1.0};
  judge.suppose([&](const Eigen::Vector3d& /*theta_c*/) { return devices.exact.tip; });
  const JudgedTip tip = judge.judge("a", {});
  REQUIRE(tip.p);
  CHECK((*tip.p - devices.exact.tip.p).norm() < 1e-9);
  CHECK(devices.exact.tool_awaited == 1);  // after the monuments
}

TEST_CASE("A cell that nobody can judge is refused by what it lacks") {
  CellSettings cell = real_cell();
  ToolOffsets unseen;
  unseen.reflector_known = false;
  CHECK_THROWS_MATCHES(judge_of(cell, unseen), InputError,
                       Refused(Cause::kMissing, cell.tool.string()));
  const Eigen::Vector3d corner = cell.datum.back().p_B;
  cell.datum.back().p_B = 0.5 * (cell.datum[0].p_B + cell.datum[1].p_B);
  CHECK_THROWS_MATCHES(judge_of(cell, sample_tool()), InputError,
                       Refused(Cause::kMissing, "one line"));
  cell.datum.back().p_B = corner;
  cell.datum.pop_back();
  CHECK_THROWS_MATCHES(judge_of(cell, sample_tool()), InputError,
                       Refused(Cause::kMissing, "2 monuments"));
  cell.tracker.kind = test::named(device_kinds().trackers, "none");
  CHECK_THROWS_MATCHES(judge_of(cell, sample_tool()), InputError,
                       Refused(Cause::kMissing, "tracker.source"));
}

}  // namespace
}  // namespace planar

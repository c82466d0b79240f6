#include <catch2/catch.hpp>
#include <map>
#include <nlohmann/json.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/experiment/experiment.h"
#include "planar_servo/experiment/experiment_report.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/run/servo_report.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/silent_cell.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

/// The tracker of a virtual cell, whose beam can be broken, and which notes the truth for the test.
class WatchedTracker final : public Tracker {
 public:
  explicit WatchedTracker(CellDevices& cell) : cell_(cell) {}

  std::string broken_at, carried_off_at, dead_at;  ///< names of places
  std::map<std::string, Eigen::Vector2d> truth;    ///< where the end point was at each reading
  int rounds{0}, tool_awaited{0}, tool_readings{0};

  TrackerAnswer measure_tool(const std::string& place) override {
    if (place == dead_at) throw WorkError("the computer has lost its power", Cause::kDevice);
    ++tool_readings;
    if (place == broken_at) return TrackerAnswer::failed("no reading came (a broken beam?)");
    truth[place] = *cell_.truth()->judge("", {}).p;
    TrackerAnswer answer = cell_.tracker().measure_tool(place);
    if (place == carried_off_at) answer.reading.p_L.x() += 0.3;
    return answer;
  }
  TrackerAnswer measure_monument(const std::string& id) override {
    if (id != last_monument_ && id == "datum1") ++rounds;
    last_monument_ = id;
    return cell_.tracker().measure_monument(id);
  }
  void await_tool() override {
    ++tool_awaited;
    last_monument_.clear();
  }

 private:
  CellDevices& cell_;
  std::string last_monument_;
};

/// Passes for a real cell, although its board is shown by itself.
class RealDevices final : public test::SilentCell {
 public:
  using SilentCell::SilentCell;

  WatchedTracker& tracker() override { return tracker_; }
  BoardPresenter* board_presenter() override { return virtual_devices().board_presenter(); }

 private:
  WatchedTracker tracker_{virtual_devices()};
};

/// On a cell whose pictures are a thirteenth of those of the paper's.
ExperimentRequest short_experiment(const test::TemporaryFolder& folder) {
  const auto small = test::paper_cell_file().parent_path().parent_path() / "small/cell.yaml";
  ExperimentRequest request{read_cell(small), parse_board("circles:11x11:25mm"), 1, folder / "run"};
  request.size = with_loop_only(with_readings({}, 30), 2);
  request.size.board_views = 6;
  return request;
}

/// Returns the mean square of judged minus true error per axis over the tracker's variance.
double judging_error(const std::vector<TargetResult>& results, const std::string& loop,
                     const std::map<std::string, Eigen::Vector2d>& truth) {
  double sum = 0.0;
  for (const TargetResult& result : results) {
    if (!result.after_judged) continue;
    const Eigen::Vector2d error = truth.at(loop + " " + result.id) - result.p_d;
    sum += (*result.after_judged - error).squaredNorm() / 2.0 / std::pow(*result.sigma_judged_m, 2);
  }
  return sum / static_cast<double>(figures_of(results).tracker->judged);
}

TEST_CASE("Where there is no truth the tracker judges every target, through a broken experiment") {
  const test::TemporaryFolder folder;
  const ExperimentRequest request = short_experiment(folder);
  RealDevices devices(request.cell);
  WatchedTracker& tracker = devices.tracker();
  tracker.broken_at = "train_003";
  tracker.dead_at = "ours run c3_01";
  CHECK_THROWS_AS(run_experiment(request, devices), WorkError);
  CHECK(tracker.rounds == 2);  // before and after the recording; the second ties the judge

  tracker.dead_at.clear();
  tracker.broken_at = "paper run c1_00";
  tracker.carried_off_at = "paper run c2_01";
  const std::string recorded = read_file(request.out / "recording/tracker.csv");
  CHECK_THAT(recorded, !Contains("train_003"));
  const ExperimentReport report = run_experiment(request, devices);
  CHECK(read_file(request.out / "recording/tracker.csv") == recorded);
  CHECK(tracker.rounds == 3);  // nobody knows what happened to the tracker meanwhile
  CHECK(tracker.tool_awaited == 3);

  const ServoFigures ours = figures_of(report.ours), paper = figures_of(report.paper);
  REQUIRE(ours.tracker);
  CHECK(ours.tracker->judged == 8);
  CHECK(ours.tracker->sigma > request.cell.tracker.sigma_m);
  CHECK(ours.tracker->sigma < 1.5 * request.cell.tracker.sigma_m);
  // 12 to 16 components know a mean square to 40 %.
  CHECK(judging_error(report.ours, "ours run", tracker.truth) == Approx(1.0).margin(0.9));
  CHECK(judging_error(report.paper, "paper run", tracker.truth) == Approx(1.0).margin(0.9));

  REQUIRE(paper.tracker->not_judged.size() == 2);
  CHECK(paper.tracker->judged == 6);
  CHECK_THAT(paper.tracker->not_judged[0].second, Contains("a broken beam"));
  CHECK_THAT(paper.tracker->not_judged[1].second, Contains("is the reflector on the tool?"));
  const nlohmann::json json = experiment_list(report).json();
  CHECK(json["paper_chain"]["not_judged"][0]["target"] == "c1_00");
  CHECK(json["sigma_mm_truth"].get<double>() == Approx(ours.tracker->sigma / kMillimetre));
  CHECK(json["reflector_offset_sigma_mm"].get<double>() > 0.0);
  CHECK_THAT(experiment_text(report), Contains("8 of 8 targets with our chain, 6 of 8"));

  const int readings = tracker.tool_readings;
  CHECK(experiment_text(run_experiment(request, devices)) == experiment_text(report));
  CHECK(tracker.tool_readings == readings);
  CHECK(tracker.tool_awaited == 3);
}

TEST_CASE("A cell that its tracker cannot judge is refused before anything is made") {
  const test::TemporaryFolder folder;
  ExperimentRequest request = short_experiment(folder);
  RealDevices devices(request.cell);
  SECTION("too few monuments") {
    request.cell.datum.pop_back();
    CHECK_THROWS_MATCHES(run_experiment(request, devices), InputError,
                         Refused(Cause::kMissing, "2 monuments"));
  }
  SECTION("no reading to learn from") {
    request.uses_tracker = false;
    request.dots_height = 0.0;
    CHECK_THROWS_MATCHES(run_experiment(request, devices), InputError,
                         Refused(Cause::kInvalid, "--train 0"));
  }
  CHECK_FALSE(std::filesystem::exists(request.out));
}

}  // namespace
}  // namespace planar

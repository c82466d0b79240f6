#include "planar_servo/certificate/judge.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "planar_servo/calibration/tracker_registration.h"
#include "planar_servo/core/error.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/io/growing_file.h"

namespace planar {
namespace {

constexpr std::size_t kLeastMonumentsToJudge = 3;
constexpr int kAttemptsToRead = 3;

class TruthJudge final : public Judge {
 public:
  explicit TruthJudge(std::function<TipPose()> true_tip) : true_tip_(std::move(true_tip)) {}

  std::optional<JudgedTip> judge(const std::string& /*id*/, const TipPose& /*seen*/) override {
    const TipPose tip = true_tip_();
    return JudgedTip{tip.p, tip.phi};
  }
  double sigma() const override { return 0.0; }

 private:
  std::function<TipPose()> true_tip_;
};

/// Reads the reflector and moves the reading to the end point: p = reflector - R(phi) p_TS, with
/// the direction of the cell's own view.
class TrackerJudge final : public Judge {
 public:
  TrackerJudge(const CellSettings& cell, ToolOffsets tool, Tracker& tracker,
               const std::filesystem::path& readings, std::function<bool()> stop)
      : settings_(cell.tracker),
        tool_(std::move(tool)),
        tracker_(tracker),
        table_(readings, tracker_header()),
        stop_(std::move(stop)) {
    tracker_.stop_when(stop_);
    register_to(cell.datum);
    tracker_.await_tool();
  }

  std::optional<JudgedTip> judge(const std::string& id, const TipPose& seen) override {
    const std::optional<TrackerReading> reading =
        read(id, [&] { return tracker_.measure_tool(id); });
    if (!reading) return std::nullopt;
    range_ = std::max(range_, reading->p_L.norm());
    const Eigen::Vector2d offset = tool_.p_TS.head<2>();
    return JudgedTip{(X_BL_ * reading->p_L).head<2>() - rotation2d(seen.phi) * offset, {}};
  }

  /// A reading at the greatest distance so far, and where the reflector sits on the tool.
  double sigma() const override {
    return std::hypot(settings_.sigma_at(range_),
                      std::sqrt(0.5 * tool_.covariance.block<2, 2>(2, 2).trace()));
  }

 private:
  void register_to(const std::vector<Monument>& monuments) {
    std::vector<MonumentReading> readings;
    for (const Monument& monument : monuments)
      for (int i = 0; i < tracker_.readings_per_monument(); ++i) {
        const auto reading =
            read(monument.id, [&] { return tracker_.measure_monument(monument.id); });
        if (!reading)
          throw WorkError(fmt::format(
              "the tracker gives no reading of the monument '{}', and without it nobody judges; "
              "clear its view, then start again to go on",
              monument.id));
        readings.push_back({monument.id, reading->p_L, settings_.sigma_at(reading->p_L.norm())});
      }
    const DatumRegistration datum = register_datum(monuments, readings);
    if (!datum.doubt.empty()) spdlog::warn(datum.doubt);
    X_BL_ = datum.X_BL;
  }

  /// Asks up to three times. Throws WorkError when the readings do not come here.
  template <typename Ask>
  std::optional<TrackerReading> read(const std::string& id, const Ask& ask) {
    for (int attempt = 0; attempt < kAttemptsToRead; ++attempt) {
      if (stop_ && stop_()) throw WorkError("stopped while the tracker was read");
      const TrackerAnswer answer = ask();
      if (answer.status == TrackerStatus::kElsewhere)
        throw WorkError(
            "the tracker's readings stand in a table of its own, but a certificate judges every "
            "move at once; let the tracker's program write to a file or a port (tracker.source)");
      if (answer.status == TrackerStatus::kSkipped) return std::nullopt;
      if (answer.status == TrackerStatus::kOk) {
        table_.append(tracker_line({id, answer.reading.t_s, answer.reading.p_L}));
        return answer.reading;
      }
      spdlog::warn(fmt::format("{}: {}", id, answer.fault));
    }
    return std::nullopt;
  }

  TrackerSettings settings_;
  ToolOffsets tool_;
  Tracker& tracker_;
  GrowingFile table_;
  std::function<bool()> stop_;
  Pose X_BL_{Pose::Identity()};
  double range_{0.0};  ///< the greatest distance of the reflector, metres
};

}  // namespace

JudgeKind judge_of(const CellSettings& cell, const ToolOffsets& tool) {
  if (cell.truth) return JudgeKind::kTruth;
  const auto refuse = [&](const std::string& why, const std::string& remedy) {
    throw InputError(
        fmt::format("{}: nobody can judge this cell: {}; {}", cell.file.string(), why, remedy));
  };
  if (!cell.tracker.kind || !cell.tracker.kind->measures())
    refuse("it is real and has no tracker",
           "set up the tracker and describe it under 'tracker', see doc/tracker.md");
  if (cell.datum.size() < kLeastMonumentsToJudge)
    refuse(fmt::format("it has {} monuments to tie its tracker to the base", cell.datum.size()),
           "measure three that are not on one line and write them under 'datum'");
  if (!tool.reflector_known)
    refuse(cell.tool.filename().string() + " does not know where the reflector sits on the tool",
           "calibrate with the tracker: planar-record, planar-pair-tracker");
  return JudgeKind::kTracker;
}

std::unique_ptr<Judge> make_judge(JudgeKind kind, const CellSettings& cell, const ToolOffsets& tool,
                                  CellDevices& devices, const std::filesystem::path& readings,
                                  std::function<bool()> stop) {
  if (kind == JudgeKind::kTruth) return std::make_unique<TruthJudge>(devices.true_tip());
  return std::make_unique<TrackerJudge>(cell, tool, devices.tracker(), readings, std::move(stop));
}

}  // namespace planar

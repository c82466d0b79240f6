#include "planar_servo/machine/judge/cell_judge.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <map>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/tables/tracker_table.h"

namespace planar {
namespace {

using MotionJacobian = Eigen::Matrix<double, 3, 6>;

/// Returns how a place in the base frame follows a small shift and turn of the registration.
MotionJacobian motion_jacobian(const Eigen::Vector3d& p_B) {
  MotionJacobian J;
  J << Eigen::Matrix3d::Identity(), -cross_matrix(p_B);
  return J;
}

/// An arm whose loop is closed ends within fractions of a millimetre of where it is supposed to be.
constexpr double kElsewhere = 20.0 * kMillimetre;
constexpr int kAttemptsToJudge = 3;

JudgedTip not_judged(const std::string& fault) {
  return {std::nullopt, 0.0, fault};
}

/// Returns why an answer without a reading does not judge.
std::string fault_of(const TrackerAnswer& answer) {
  if (answer.status == TrackerStatus::kFailed) return answer.fault;
  if (answer.status == TrackerStatus::kElsewhere)
    return "its reading stands in a table of the tracker's own; three numbers are judged";
  return "somebody left its reading out";
}

}  // namespace

RegisteredTracker::RegisteredTracker(const CellSettings& cell,
                                     const std::vector<MonumentSeen>& seen)
    : tracker_(cell.tracker), datum_(register_datum(cell.datum, monument_readings(cell, seen))) {
  std::map<std::string, double> information;  // of each monument's mean, per m^2
  for (const MonumentSeen& monument : seen)
    information[monument.id] += 1.0 / variance_of(monument.reading);
  // The fit weighs all monuments alike: cov = M^-1 (sum variance J^T J) M^-1, M = sum J^T J.
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero(), noise = normal;
  for (const Monument& monument : cell.datum) {
    const auto found = information.find(monument.id);
    if (found == information.end() || monument.id == datum_.left_out) continue;
    const MotionJacobian J = motion_jacobian(monument.p_B);
    normal += J.transpose() * J;
    noise += J.transpose() * J / found->second;
  }
  covariance_ = solve_symmetric(normal, solve_symmetric(normal, noise).transpose());
}

double RegisteredTracker::variance_of(const TrackerReading& reading) const {
  const double sigma = tracker_.sigma_at(reading.p_L.norm());
  return sigma * sigma / reading.averaged;
}

double RegisteredTracker::sigma(const TrackerReading& reading) const {
  const Eigen::Matrix<double, 2, 6> J = motion_jacobian(place(reading)).topRows<2>();
  return std::sqrt(variance_of(reading) + 0.5 * (J * covariance_ * J.transpose()).trace());
}

TrackerJudge::TrackerJudge(const CellSettings& cell, const ToolOffsets& tool, Tracker& tracker,
                           const std::filesystem::path& file, const std::function<bool()>& stop)
    : cell_(cell), tool_(tool), tracker_(tracker), file_(file), stop_(stop) {}

void TrackerJudge::make_ready(const std::vector<MonumentSeen>& seen) {
  table_.emplace(file_, tracker_header());
  readings_.emplace(cell_, tracker_, *table_, stop_);
  std::vector<MonumentSeen> monuments = seen;
  for (const MonumentSeen& monument : seen)
    table_->append(tracker_line({monument.id, monument.reading.t_s, monument.reading.p_L}));
  if (monuments.empty()) monuments = readings_->read_monuments();
  registered_.emplace(cell_, monuments);
  if (!seen.empty() && !registered_->doubt().fault.empty())
    spdlog::warn(registered_->doubt().text());
  tracker_.await_tool();
}

JudgedTip TrackerJudge::judge(const std::string& id, const Standing& standing) {
  const std::optional<TipPose> supposed = forward_ ? forward_(standing.theta_c) : standing.seen;
  if (!supposed) return not_judged("the camera does not see the tool's direction");
  if (!registered_) make_ready();
  std::string fault;
  for (int attempt = 0; attempt < kAttemptsToJudge; ++attempt) {
    const TrackerAnswer answer = readings_->take_tool(loop_ + id, *supposed);
    JudgedTip tip = answer.status == TrackerStatus::kOk ? tip_of(answer.reading, *supposed)
                                                        : not_judged(fault_of(answer));
    if (tip.p || answer.status == TrackerStatus::kSkipped) return tip;
    spdlog::warn(fmt::format("{}{}: {}", loop_, id, tip.fault));
    fault = tip.fault;
  }
  return not_judged(fault);
}

JudgedTip TrackerJudge::tip_of(const TrackerReading& reading, const TipPose& supposed) const {
  const Eigen::Vector2d reflector = registered_.value().place(reading).head<2>();
  const Eigen::Vector2d p = reflector - rotation2d(supposed.phi) * tool_.p_TS.head<2>();
  const double off = (p - supposed.p).norm();
  if (off > kElsewhere)
    return not_judged(
        fmt::format("the reading lies {:.1f} mm from where the tool is supposed to be; is the "
                    "reflector on the tool?",
                    off / kMillimetre));
  return {p, registered_->sigma(reading), ""};
}

double TrackerJudge::common_sigma() const {
  return std::sqrt(tool_.covariance.diagonal().segment<2>(2).maxCoeff());
}

void require_judging_tracker(const CellSettings& cell) {
  const auto refuse = [&](const std::string& why, const std::string& remedy) {
    throw InputError({"nobody can judge this cell, which has no virtual truth: " + why, remedy,
                      cell.file, Cause::kMissing});
  };
  if (!cell.tracker.kind->measures())
    refuse("tracker.source is none",
           "set up the tracker and name its source (file, tcp or ask), see doc/tracker.md");
  if (cell.datum.size() < kLeastMonuments)
    refuse(fmt::format("datum has {} monument{}, but at least {} that are not on one line tie the "
                       "tracker to the base",
                       cell.datum.size(), cell.datum.size() == 1 ? "" : "s", kLeastMonuments),
           "measure them and write them there");
}

JudgeKind judge_of(const CellSettings& cell, const ToolOffsets& tool) {
  if (cell.truth) return JudgeKind::kTruth;
  require_judging_tracker(cell);
  if (!tool.reflector_known)
    throw InputError(
        {"does not say where the reflector sits on the tool, so the tracker cannot judge the end "
         "point",
         "calibrate with the tracker (planar-record, planar-pair-tracker)", cell.tool,
         Cause::kMissing});
  return JudgeKind::kTracker;
}

std::shared_ptr<Judge> make_judge(JudgeKind kind, const CellSettings& cell, const ToolOffsets& tool,
                                  CellDevices& devices, const std::filesystem::path& readings,
                                  const std::function<bool()>& stop) {
  if (kind == JudgeKind::kTruth) return devices.truth();
  auto judge = std::make_shared<TrackerJudge>(cell, tool, devices.tracker(), readings, stop);
  judge->make_ready();
  return judge;
}

}  // namespace planar

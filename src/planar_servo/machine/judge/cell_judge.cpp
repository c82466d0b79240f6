#include "planar_servo/machine/judge/cell_judge.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/tables/tracker_table.h"

namespace planar {
namespace {

bool contradicts(const MonumentVerdict& verdict) {
  return verdict.refused || verdict.moved;
}

/// Returns the scatter per axis of readings about their mean, metres; of a single one that of what
/// it is the mean of. Zero where nothing is known of it.
double scatter_of(const std::vector<MonumentSeen>& readings, const Eigen::Vector3d& mean) {
  if (readings.size() == 1) return readings.front().reading.scatter;
  double square = 0.0;
  for (const MonumentSeen& seen : readings) square += (seen.reading.p_L - mean).squaredNorm();
  return std::sqrt(square / (3.0 * static_cast<double>(readings.size() - 1)));
}

std::string signed_mm(double length) {
  const std::string text = fixed(mm(length), 3);
  return text.front() == '-' ? text : "+" + text;
}

constexpr int kAttempts = 3;
// Moves from which on a reading must have followed the tool, which is not turned meanwhile.
constexpr double kMoved = 1.0 * kMillimetre;
constexpr double kUnturned = 0.1 * kDegree;

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

std::vector<MonumentReading> monument_readings(const CellSettings& cell,
                                               const std::vector<MonumentSeen>& seen) {
  std::vector<MonumentReading> readings;
  readings.reserve(seen.size());
  for (const MonumentSeen& monument : seen)
    readings.push_back(
        {monument.id, monument.reading.p_L, cell.tracker.sigma_at(monument.reading.p_L.norm())});
  return readings;
}

MonumentRound::MonumentRound(const CellSettings& cell, const std::vector<MonumentSeen>& before,
                             std::vector<MonumentSeen> seen)
    : cell_(cell), seen_(std::move(seen)), before_(sights(before)) {}

void MonumentRound::add(const std::vector<MonumentSeen>& readings) {
  seen_.insert(seen_.end(), readings.begin(), readings.end());
}

std::vector<MonumentSight> MonumentRound::sights(const std::vector<MonumentSeen>& seen) const {
  return monument_sights(cell_.datum, monument_readings(cell_, seen));
}

MonumentVerdict MonumentRound::verdict(const std::vector<MonumentSeen>& seen) const {
  return before_.empty() ? check_monuments(sights(seen)) : check_drift(before_, sights(seen));
}

Refusal MonumentRound::contradiction(const std::vector<MonumentSeen>& readings) const {
  if (contradicts(verdict(seen_))) return {};
  std::vector<MonumentSeen> with = seen_;
  with.insert(with.end(), readings.begin(), readings.end());
  const MonumentVerdict found = verdict(with);
  return contradicts(found) ? found.doubt : Refusal{};
}

std::string MonumentRound::words(const std::vector<MonumentSeen>& readings) const {
  const MonumentSight sight = sights(readings).front();
  int count = 0;
  for (const MonumentSeen& seen : readings) count += seen.reading.averaged;
  std::string text = fmt::format("monument '{}': {} reading{} at ({}) mm", sight.id, count,
                                 count == 1 ? "" : "s", fixed(sight.p_read / kMillimetre, 3, ", "));
  if (count > 1)
    text += fmt::format(", scatter {:.3f} mm per axis", mm(scatter_of(readings, sight.p_read)));
  if (const MonumentSight* first = reference(sight.id); first != nullptr && !before_.empty())
    text += fmt::format("; {:.3f} mm from where it was at the beginning",
                        mm((sight.p_read - first->p_read).norm()));
  return text + distance_words(sight);
}

const MonumentSight* MonumentRound::reference(const std::string& id) const {
  const auto found = std::find_if(before_.begin(), before_.end(),
                                  [&](const MonumentSight& first) { return first.id == id; });
  return found == before_.end() ? nullptr : &*found;
}

std::string MonumentRound::distance_words(const MonumentSight& monument) const {
  std::string text;
  for (const MonumentSight& other : sights(seen_)) {
    if (other.id == monument.id) continue;
    const MonumentSight *here = reference(monument.id), *there = reference(other.id);
    double known = (monument.p_known - other.p_known).norm();
    if (here != nullptr && there != nullptr) known = (here->p_read - there->p_read).norm();
    text += fmt::format("{} '{}' {}", text.empty() ? "; distance to" : ", to", other.id,
                        signed_mm((monument.p_read - other.p_read).norm() - known));
  }
  if (text.empty()) return text;
  return text + fmt::format(" mm against the {}", before_.empty() ? "cell file" : "beginning");
}

WorkError no_reading_of(const std::string& what, const std::string& fault) {
  return WorkError(
      fmt::format("the tracker gives no reading of the {}: {}; clear the tracker's view and look "
                  "at its program, then start again to continue",
                  what, fault),
      Cause::kDevice);
}

ReflectorReadings::ReflectorReadings(const CellSettings& cell, Tracker& tracker, GrowingFile& table,
                                     std::function<bool()> stop)
    : cell_(cell), tracker_(tracker), table_(table), stop_(std::move(stop)) {
  tracker_.stop_when(stop_);
}

std::vector<MonumentSeen> ReflectorReadings::read_monuments(std::vector<MonumentSeen> seen,
                                                            std::vector<MonumentSeen> before) {
  MonumentRound round(cell_, std::move(before), std::move(seen));
  std::size_t read = 0;
  for (const Monument& monument : cell_.datum)
    if (read_monument(monument.id, round)) ++read;
  const std::size_t needed = std::min(kLeastMonuments, cell_.datum.size());
  if (read < needed)
    throw WorkError(
        {fmt::format("{} of {} monuments were read; at least {} tie the tracker to the base", read,
                     cell_.datum.size(), needed),
         "read the others, too", "", Cause::kInsufficient});
  if (const Refusal doubt = round.doubt(); !doubt.fault.empty()) spdlog::warn(doubt.text());
  return round.seen();
}

bool ReflectorReadings::read_monument(const std::string& id, MonumentRound& round) {
  const auto present = std::count_if(round.seen().begin(), round.seen().end(),
                                     [&](const MonumentSeen& reading) { return reading.id == id; });
  const int missing = tracker_.readings_per_monument() - static_cast<int>(present);
  while (true) {
    const auto readings = take_monument(id, missing);
    if (!readings) return false;
    if (readings->empty()) return true;
    spdlog::info(round.words(*readings));
    if (!is_kept(id, round.contradiction(*readings))) continue;
    for (const auto& [of, reading] : *readings)
      table_.append(tracker_line({of, reading.t_s, reading.p_L}));
    round.add(*readings);
    return true;
  }
}

bool ReflectorReadings::is_kept(const std::string& id, const Refusal& contradiction) {
  if (contradiction.fault.empty()) return true;
  spdlog::warn(contradiction.text());
  const std::optional<bool> keeps = tracker_.keeps(id);
  if (!keeps) spdlog::warn(fmt::format("the reading of '{}' is kept: nobody can be asked", id));
  return keeps.value_or(true);
}

std::optional<std::vector<MonumentSeen>> ReflectorReadings::take_monument(const std::string& id,
                                                                          int count) {
  std::vector<MonumentSeen> readings;
  for (int left = count, failures = 0; left > 0;) {
    if (stop_ && stop_()) throw WorkError("stopped while the monuments were read", Cause::kStopped);
    const TrackerAnswer answer = tracker_.measure_monument(id);
    switch (answer.status) {
      case TrackerStatus::kOk:
        readings.push_back({id, answer.reading});
        [[fallthrough]];
      case TrackerStatus::kElsewhere:
        --left;
        break;
      case TrackerStatus::kSkipped:
        return std::nullopt;
      case TrackerStatus::kRepeat:
        break;
      case TrackerStatus::kFailed:
        spdlog::warn(fmt::format("monument '{}': {}", id, answer.fault));
        if (++failures == kAttempts)
          throw no_reading_of(fmt::format("monument '{}'", id), answer.fault);
    }
  }
  return readings;
}

TrackerAnswer ReflectorReadings::take_tool(const std::string& id, const TipPose& tip) {
  TrackerAnswer answer = tracker_.measure_tool(id);
  if (answer.status != TrackerStatus::kOk) return answer;
  const std::string fault = fault_of(answer.reading, tip);
  if (!fault.empty()) return TrackerAnswer::failed(fault);
  table_.append(tracker_line({id, answer.reading.t_s, answer.reading.p_L}));
  last_ = {id, answer.reading, tip};
  return answer;
}

std::string ReflectorReadings::fault_of(const TrackerReading& reading, const TipPose& tip) const {
  if (!last_) return "";
  const double moved = (tip.p - last_->tip.p).norm();
  const double followed = (reading.p_L - last_->reading.p_L).norm();
  const bool is_turned = std::abs(wrap_angle(tip.phi - last_->tip.phi)) > kUnturned;
  if (moved < kMoved || is_turned || followed > 0.5 * moved) return "";
  return fmt::format(
      "the reading repeats that of '{}': it lies {:.3f} mm from it, while the tool moved {:.1f} mm",
      last_->id, mm(followed), mm(moved));
}

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
                    mm(off)));
  return {p, registered_->sigma(reading), ""};
}

double TrackerJudge::common_sigma() const {
  return std::sqrt(tool_.covariance.diagonal().segment<2>(2).maxCoeff());
}

std::string fault_of_datum(const std::vector<Monument>& datum) {
  constexpr char kNeeded[] = "at least three that are not on one line tie the tracker to the base";
  if (datum.size() < kLeastMonuments)
    return fmt::format("datum has {} monument{}, but {}", datum.size(),
                       datum.size() == 1 ? "" : "s", kNeeded);
  std::vector<MonumentReading> exact;
  for (const Monument& monument : datum) exact.push_back({monument.id, monument.p_B});
  try {
    register_datum(datum, exact);
    return "";
  } catch (const InputError& error) {
    return fmt::format("datum: {}, but {}", error.refusal().fault, kNeeded);
  }
}

void require_judging_tracker(const CellSettings& cell) {
  const auto refuse = [&](const std::string& why, const std::string& remedy) {
    throw InputError({"nobody can judge this cell, which has no virtual truth: " + why, remedy,
                      cell.file, Cause::kMissing});
  };
  if (!cell.tracker.kind->measures())
    refuse("tracker.source is none",
           "set up the tracker and name its source (file, tcp or ask), see doc/tracker.md");
  if (const std::string fault = fault_of_datum(cell.datum); !fault.empty())
    refuse(fault, "measure them and write them there");
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

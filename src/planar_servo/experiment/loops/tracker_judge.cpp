#include "planar_servo/experiment/loops/tracker_judge.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/field/arm/arm_terms.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/files/tables/tracker_table.h"

namespace planar {
namespace {

/// An arm that was found ends within fractions of a millimetre of where it is sent.
constexpr double kElsewhere = 20.0 * kMillimetre;
constexpr std::size_t kLeastMonuments = 3;

double offset_sigma(const JointEstimate& estimate) {
  double sigma = 0.0;
  for (const ArmTerm& term : arm_terms(estimate))
    if (term.key.rfind("p_TS_", 0) == 0) sigma = std::max(sigma, term.sigma);
  return sigma;
}

JudgedPoint not_judged(const std::string& fault) {
  return {std::nullopt, 0.0, fault};
}

std::string fault_of(const TrackerAnswer& answer) {
  switch (answer.status) {
    case TrackerStatus::kElsewhere:
      return "its reading stands in a table of the tracker's own; three numbers are judged";
    case TrackerStatus::kSkipped:
    case TrackerStatus::kRepeat:
      return "somebody left its reading out";
    case TrackerStatus::kFailed:
    case TrackerStatus::kOk:
      break;
  }
  return answer.fault;
}

}  // namespace

TrackerJudge::TrackerJudge(const CalibratedChain& ours, Tracker& tracker,
                           const std::filesystem::path& file, const std::function<bool()>& stop)
    : cell_(ours.cell),
      tracker_(tracker),
      planner_(servo_planner(cell_)),
      p_TS_(ours.field.value().field.tool.p_TS.head<2>()),
      reflector_sigma_(offset_sigma(ours.field.value().estimate)),
      table_(file, tracker_header()),
      readings_(cell_, tracker, table_, BadReading::kSkip, stop) {}

void TrackerJudge::make_ready(const std::vector<MonumentSeen>& seen) {
  std::vector<MonumentSeen> monuments = seen;
  for (const MonumentSeen& monument : seen)
    table_.append(tracker_line({monument.id, monument.reading.t_s, monument.reading.p_L}));
  if (monuments.empty()) monuments = readings_.read_monuments();
  registered_.emplace(cell_, monuments);
  if (!registered_->doubt().empty()) spdlog::warn(registered_->doubt());
  tracker_.await_tool();
}

TrackerAnswer TrackerJudge::read(const std::string& place, const TipPose& sent) {
  const TrackerAnswer answer = readings_.take_tool(place, sent);
  if (answer.status != TrackerStatus::kFailed && answer.status != TrackerStatus::kRepeat)
    return answer;
  if (!answer.fault.empty()) spdlog::warn(fmt::format("{}: {}", place, answer.fault));
  return readings_.take_tool(place, sent);
}

JudgedPoint TrackerJudge::judge(const std::string& place, const Joints& commanded) {
  const TipPose sent = planner_.reached(commanded);
  const TrackerAnswer answer = read(place, sent);
  if (answer.status != TrackerStatus::kOk) return not_judged(fault_of(answer));
  const Eigen::Vector2d reflector = registered_.value().place(answer.reading).head<2>();
  const Eigen::Vector2d p = reflector - rotation2d(sent.phi) * p_TS_;
  const double off = (p - sent.p).norm();
  if (off > kElsewhere)
    return not_judged(
        fmt::format("the reading lies {:.1f} mm from where the arm was sent; is the reflector on "
                    "the tool?",
                    off / kMillimetre));
  return {p, registered_->sigma(answer.reading), ""};
}

void require_judging_tracker(const CellSettings& cell) {
  if (!cell.tracker.kind->measures())
    throw InputError(
        cell.file.string() +
        ": tracker.source is none, but without a virtual cell's truth the tracker judges this "
        "experiment at every control target; name the tracker's source (file, tcp or ask)");
  if (cell.datum.size() < kLeastMonuments)
    throw InputError(fmt::format(
        "{}: datum has {} monument{}; at least {} that are not on one line tie the tracker, which "
        "judges this experiment, to the base",
        cell.file.string(), cell.datum.size(), cell.datum.size() == 1 ? "" : "s", kLeastMonuments));
}

}  // namespace planar

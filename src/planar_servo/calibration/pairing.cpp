#include "planar_servo/calibration/pairing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

// Differences above these, far beyond the noise of lamps and tracker, are motion.
constexpr double kMotionPx = 1.0;
constexpr double kMotion = 0.2 * kMillimetre;
constexpr double kTimeWindow = 0.5;  // s
constexpr double kSameJoint = 1e-6;  // rad; files round angles

/// Collects everything that was recorded at one id.
struct Place {
  std::vector<const LampSight*> frames;
  std::vector<const LampSight*> failed;
  std::vector<const ToolReading*> readings;

  Purpose plan() const { return (frames.empty() ? failed : frames).front()->plan; }
};

void require_finite(const std::vector<LampSight>& frames,
                    const std::vector<ToolReading>& readings) {
  Faults faults;
  for (const LampSight& frame : frames) {
    if (!std::isfinite(frame.t_s) || !frame.theta.allFinite() ||
        (frame.fault.empty() && !(frame.lamps_px[0].allFinite() && frame.lamps_px[1].allFinite())))
      faults.add({"a frame of '" + frame.id + "' has a value that is not finite", "", "pairing"});
  }
  for (const ToolReading& reading : readings) {
    if (!std::isfinite(reading.t_s) || !reading.p_B.allFinite())
      faults.add(
          {"a reading of '" + reading.id + "' has a value that is not finite", "", "pairing"});
  }
  faults.throw_if_any();
}

using Places = std::map<std::string, Place>;

/// Sorts frames by their id. Returns the ids in the order of the frames.
std::vector<std::string> sort_frames(const std::vector<LampSight>& frames, Places& places) {
  std::vector<std::string> order;
  for (const LampSight& frame : frames) {
    const auto [place, is_new] = places.try_emplace(frame.id);
    if (is_new) order.push_back(frame.id);
    (frame.fault.empty() ? place->second.frames : place->second.failed).push_back(&frame);
  }
  return order;
}

/// Returns the id whose frames are nearest in time; empty beyond the window.
std::string nearest_in_time(const std::vector<LampSight>& frames, double t_s) {
  double least = kTimeWindow;
  std::string id;
  for (const LampSight& frame : frames) {
    const double gap = std::abs(frame.t_s - t_s);
    if (gap > least) continue;
    least = gap;
    id = frame.id;
  }
  return id;
}

template <typename T, typename Value>
auto mean_of(const std::vector<const T*>& items, const Value& value) {
  auto sum = value(*items.front());
  for (std::size_t i = 1; i < items.size(); ++i) sum += value(*items[i]);
  return decltype(sum)(sum / static_cast<double>(items.size()));
}

template <typename T, typename Value>
double farthest_from_mean(const std::vector<const T*>& items, const Value& value) {
  const auto centre = mean_of(items, value);
  double farthest = 0.0;
  for (const T* item : items) farthest = std::max(farthest, (value(*item) - centre).norm());
  return farthest;
}

/// These return why something cannot be used; empty when it can.
std::string fault_of_frames(const Place& place) {
  if (place.frames.empty()) return "no frame with both lamps: " + place.failed.front()->fault;
  for (std::size_t k = 0; k < 2; ++k) {
    const double far =
        farthest_from_mean(place.frames, [k](const LampSight& f) { return f.lamps_px[k]; });
    if (far > kMotionPx) {
      return fmt::format("not at rest: its frames disagree by {:.2f} px on lamp {}", far, k + 1);
    }
  }
  return "";
}

std::string fault_of_readings(const Place& place) {
  if (place.readings.empty()) return "no tracker reading";
  const double far = farthest_from_mean(place.readings, [](const ToolReading& r) { return r.p_B; });
  if (far > kMotion)
    return fmt::format("not at rest: its tracker readings disagree by {:.3f} mm", mm(far));
  return "";
}

std::string fault_of(const Place& place) {
  const std::string fault = fault_of_frames(place);
  return fault.empty() && place.plan() != Purpose::kPose ? fault_of_readings(place) : fault;
}

PoseSight mean_frame(const Place& place) {
  const LampSight& first = *place.frames.front();
  std::vector<Observation> seen;
  seen.reserve(place.frames.size());
  for (const LampSight* frame : place.frames) seen.push_back(*frame);
  return {mean_of(seen), first.id, first.plan, first.theta};
}

ToolSight average(const Place& place) {
  ToolSight sight{mean_frame(place)};
  sight.p_reflector_B = mean_of(place.readings, [](const ToolReading& r) { return r.p_B; });
  // A tracker's stated deviation is in part systematic, so repeated readings do not reduce it.
  sight.sigma_tracker = mean_of(place.readings, [](const ToolReading& r) { return r.sigma; });
  return sight;
}

/// Returns the number of the sweep with these angles of joints 1 and 2; new angles begin a new
/// sweep.
int sweep_number(const Eigen::Vector2d& theta12, std::vector<Eigen::Vector2d>& sweeps) {
  const auto same = std::find_if(sweeps.begin(), sweeps.end(), [&](const Eigen::Vector2d& known) {
    const Eigen::Vector2d turn = (known - theta12).unaryExpr(&wrap_angle);
    return turn.cwiseAbs().maxCoeff() < kSameJoint;
  });
  const auto number = static_cast<int>(same - sweeps.begin());
  if (same == sweeps.end()) sweeps.push_back(theta12);
  return number;
}

void add_by_id(const std::vector<ToolReading>& readings, Places& places,
               std::vector<Rejection>& rejected) {
  for (const ToolReading& reading : readings) {
    const auto place = places.find(reading.id);
    if (place != places.end())
      place->second.readings.push_back(&reading);
    else
      rejected.push_back({reading.id, "tracker reading without a frame of this id"});
  }
}

Rejection far_from_frames(const std::vector<const ToolReading*>& stretch) {
  const ToolReading& first = *stretch.front();
  if (stretch.size() == 1)
    return {first.id, fmt::format("no frame within {} s of the tracker reading at {:.3f} s",
                                  kTimeWindow, first.t_s)};
  return {first.id,
          fmt::format("no frame within {} s of the {} tracker readings from {:.3f} s to {:.3f} s",
                      kTimeWindow, stretch.size(), first.t_s, stretch.back()->t_s)};
}

/// Adds readings to the places nearest in time. Readings of a tracker that measures continuously
/// come in long stretches without a frame; each stretch is reported once.
void add_by_time(const std::vector<ToolReading>& readings, const std::vector<LampSight>& frames,
                 Places& places, std::vector<Rejection>& rejected) {
  std::vector<const ToolReading*> stretch;
  const auto end_stretch = [&] {
    if (!stretch.empty()) rejected.push_back(far_from_frames(stretch));
    stretch.clear();
  };
  for (const ToolReading& reading : readings) {
    const auto place = places.find(nearest_in_time(frames, reading.t_s));
    if (place == places.end()) {
      stretch.push_back(&reading);
    } else {
      end_stretch();
      place->second.readings.push_back(&reading);
    }
  }
  end_stretch();
}

}  // namespace

Pairing pair_sights(const std::vector<LampSight>& frames, const std::vector<ToolReading>& readings,
                    PairBy by) {
  require_finite(frames, readings);
  Pairing pairing;
  Places places;
  const std::vector<std::string> order = sort_frames(frames, places);
  if (by == PairBy::kId)
    add_by_id(readings, places, pairing.rejected);
  else
    add_by_time(readings, frames, places, pairing.rejected);
  std::vector<Eigen::Vector2d> sweeps;
  for (const std::string& id : order) {
    const Place& place = places.at(id);
    const std::string fault = fault_of(place);
    if (!fault.empty()) {
      pairing.rejected.push_back({id, fault});
      continue;
    }
    if (place.plan() == Purpose::kPose) {
      pairing.unattended.push_back(mean_frame(place));
      continue;
    }
    pairing.sights.push_back(average(place));
    if (place.plan() == Purpose::kSweep3)
      pairing.sights.back().sweep = sweep_number(place.frames.front()->theta.head<2>(), sweeps);
  }
  return pairing;
}

Pairing unattended_sights(const std::vector<LampSight>& frames) {
  require_finite(frames, {});
  Pairing pairing;
  Places places;
  for (const std::string& id : sort_frames(frames, places)) {
    const Place& place = places.at(id);
    if (const std::string fault = fault_of_frames(place); fault.empty())
      pairing.unattended.push_back(mean_frame(place));
    else
      pairing.rejected.push_back({id, fault});
  }
  return pairing;
}

Eigen::Vector2d end_point_by_tracker(const ToolOffsets& tool, const ToolSight& sight, double phi) {
  return sight.p_reflector_B.head<2>() - rotation2d(phi) * tool.p_TS.head<2>();
}

namespace {

constexpr Eigen::Index kViewTerms = 12;
constexpr Eigen::Index kLeastPlaces = 2 * kViewTerms;
constexpr double kUnrelatedShare = 0.25;
constexpr double kRelatedShare = 0.02;
constexpr int kMostRows = 3;
constexpr double kMovedLampsPx = 1.0;

/// Returns the terms of a smooth view: a cubic of the lamps' middle, and the tool's direction.
Eigen::Matrix<double, 1, kViewTerms> view_terms(const ToolSight& sight,
                                                const Eigen::Vector2d& centre_px, double size_px) {
  const Eigen::Vector2d axis = (sight.lamps_px[1] - sight.lamps_px[0]).normalized();
  const Eigen::Vector2d m = (0.5 * (sight.lamps_px[0] + sight.lamps_px[1]) - centre_px) / size_px;
  const double u = m.x(), v = m.y();
  Eigen::Matrix<double, 1, kViewTerms> terms;
  terms << 1.0, u, v, u * u, u * v, v * v, u * u * u, u * u * v, u * v * v, v * v * v, axis.x(),
      axis.y();
  return terms;
}

Eigen::MatrixXd view_matrix(const std::vector<ToolSight>& sights) {
  Eigen::Matrix2Xd middles(2, sights.size());
  for (std::size_t i = 0; i < sights.size(); ++i)
    middles.col(static_cast<Eigen::Index>(i)) =
        0.5 * (sights[i].lamps_px[0] + sights[i].lamps_px[1]);
  const Eigen::Vector2d centre = middles.rowwise().mean();
  const double size = std::sqrt((middles.colwise() - centre).colwise().squaredNorm().mean());
  Eigen::MatrixXd terms(static_cast<Eigen::Index>(sights.size()), kViewTerms);
  for (std::size_t i = 0; i < sights.size(); ++i)
    terms.row(static_cast<Eigen::Index>(i)) = view_terms(sights[i], centre, size);
  return terms;
}

/// Returns the median residual of a smooth view, as a share of the readings' spread.
double share_left(const Eigen::MatrixXd& terms, const Eigen::MatrixX2d& readings) {
  Eigen::MatrixX2d left = readings;
  for (int axis = 0; axis < 2; ++axis)
    left.col(axis) -= terms * solve_least_squares(terms, readings.col(axis));
  const Eigen::MatrixX2d centred = readings.rowwise() - readings.colwise().mean();
  const double spread = std::sqrt(centred.rowwise().squaredNorm().mean());
  const Eigen::VectorXd lengths = left.rowwise().norm();
  return median({lengths.begin(), lengths.end()}) / spread;
}

Eigen::MatrixX2d reflectors(const std::vector<ToolSight>& sights) {
  Eigen::MatrixX2d points(static_cast<Eigen::Index>(sights.size()), 2);
  for (std::size_t i = 0; i < sights.size(); ++i)
    points.row(static_cast<Eigen::Index>(i)) = sights[i].p_reflector_B.head<2>().transpose();
  return points;
}

/// Returns by how many rows the readings come late, if with that shift they follow the lamps.
std::optional<int> late_rows(const std::vector<ToolSight>& sights) {
  const Eigen::MatrixXd terms = view_matrix(sights);
  const Eigen::MatrixX2d points = reflectors(sights);
  for (int rows = 1; rows <= kMostRows; ++rows) {
    const Eigen::Index n = points.rows() - rows;
    if (n < kLeastPlaces) break;
    if (share_left(terms.topRows(n), points.bottomRows(n)) < kRelatedShare) return rows;
    if (share_left(terms.bottomRows(n), points.topRows(n)) < kRelatedShare) return -rows;
  }
  return std::nullopt;
}

void require_rows_in_order(const std::vector<ToolSight>& sights) {
  const auto rows = late_rows(sights);
  if (!rows) return;
  throw InputError({fmt::format("its readings are shifted by {} row{} against their ids: each fits "
                                "the place {} its own",
                                std::abs(*rows), std::abs(*rows) == 1 ? "" : "s",
                                *rows > 0 ? "before" : "after"),
                    "restore the order of the rows in the tracker's table", "tracker",
                    Cause::kContradiction});
}

}  // namespace

void require_reading_order(const std::vector<ToolSight>& sights, PairBy by) {
  if (static_cast<Eigen::Index>(sights.size()) <= kLeastPlaces) return;
  const double share = share_left(view_matrix(sights), reflectors(sights));
  if (share < kRelatedShare) return;
  if (by == PairBy::kId) require_rows_in_order(sights);
  if (share < kUnrelatedShare) return;
  throw InputError({fmt::format("its readings do not follow the lamps: the best smooth view of {} "
                                "places misses them by {:.0f} % of the field",
                                sights.size(), 100.0 * share),
                    "check that ids, times and order belong to this recording", "tracker",
                    Cause::kContradiction});
}

std::vector<Rejection> take_out_frozen(std::vector<ToolSight>& sights) {
  std::vector<Rejection> frozen;
  std::vector<ToolSight> alive;
  for (ToolSight& sight : sights) {
    const bool repeated = !alive.empty() && sight.p_reflector_B == alive.back().p_reflector_B &&
                          (sight.lamps_px[0] - alive.back().lamps_px[0]).norm() > kMovedLampsPx;
    if (repeated)
      frozen.push_back({sight.id, "frozen: the tracker repeated the reading of '" +
                                      alive.back().id +
                                      "' to the last digit, although the lamps had moved"});
    else
      alive.push_back(std::move(sight));
  }
  sights = std::move(alive);
  return frozen;
}

}  // namespace planar

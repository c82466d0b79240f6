#include "planar_servo/offline/map/learn_lamp_field.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/devices/tracker.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/files/work_file.h"
#include "planar_servo/geometry/arm/transmission.h"
#include "planar_servo/hardware/cell/device_kinds.h"
#include "planar_servo/offline/calibrate_arm.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"
#include "planar_servo/workpiece/find_work.h"

namespace planar {
namespace {

bool tells_field(const PairRow& pair) {
  constexpr Purpose kTelling[] = {Purpose::kTrain, Purpose::kSweep1, Purpose::kSweep3,
                                  Purpose::kPose};
  return !pair.plan || std::count(std::begin(kTelling), std::end(kTelling), *pair.plan) > 0;
}

PoseSample pose_sample(const Transmission& transmission, const PairRow& pair, double now_s) {
  if (!pair.lamps_B || !pair.theta || !pair.sigma_vision || (pair.p_tracker && !pair.p_reflector) ||
      (pair.p_reflector && !pair.sigma_tracker))
    throw InputError({fmt::format("pair '{}' lacks its lamps, its joints or a standard deviation, "
                                  "from which field and arm are learned",
                                  pair.id),
                      "make the pairs with planar-pair-tracker, or leave --cell out", "",
                      Cause::kMissing});
  PoseSample sample;
  sample.id = pair.id;
  sample.place = pair.place;
  sample.t_h = (pair.t_s.value_or(now_s) - now_s) / kHour;
  sample.motors = transmission.motors_from_joints(*pair.theta);
  sample.lamps_B = *pair.lamps_B;
  // The end point lies about midway between the lamps.
  sample.sigma_lamp = *pair.sigma_vision * std::sqrt(2.0);
  sample.reflector_B = pair.p_reflector;
  sample.reflector_z = pair.z_reflector;
  sample.sigma_reflector = pair.sigma_tracker.value_or(0.0);
  return sample;
}

/// Sets the error that all readings have in common: the tracker's registration to the monuments,
/// and its systematic error. What data sheets state (15 um + 6 um/m, ISO 10360-10) is mostly
/// systematic; the registration takes up most of it, and a third still differs over a field.
void set_tracker(ArmNominal& nominal, const CellSettings& cell) {
  constexpr double kLeftOfStated = 1.0 / 3.0;
  constexpr double kNone = 1e-9;  // metres; an error that cannot be is no prior that can be weighed
  nominal.tracker_bias =
      std::max(cell.tracker.bias_m.value_or(kLeftOfStated * cell.tracker.sigma_m), kNone);
  if (cell.datum.size() < 2) return;  // one does not determine the turn
  const auto n = static_cast<double>(cell.datum.size());
  Eigen::Vector2d center(0.0, 0.0);
  for (const Monument& monument : cell.datum) center += monument.p_B.head<2>() / n;
  double spread = 0.0;
  for (const Monument& monument : cell.datum)
    spread += (monument.p_B.head<2>() - center).squaredNorm();
  const double readings = cell.tracker.kind->by_hand() ? 1.0 : kMonumentReadings;
  const double sigma = cell.tracker.sigma_m / std::sqrt(readings);
  nominal.registration_shift = sigma / std::sqrt(n);
  nominal.registration_turn = sigma / std::sqrt(spread);
}

BoardLay lay_of(const std::string& id, const std::vector<const LayRow*>& rows) {
  const auto n = static_cast<Eigen::Index>(rows.size());
  BoardLay lay{id, Eigen::Matrix2Xd(2, n), Eigen::Matrix2Xd(2, n), Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const LayRow& row = *rows[static_cast<std::size_t>(i)];
    lay.p_board.col(i) = row.p_board;
    lay.seen_B.col(i) = row.p_seen;
    lay.sigma[i] = row.sigma;
  }
  return lay;
}

/// Returns the marks without the doubts about their heights, which are common to all pictures.
std::vector<Fiducial> at_height(std::vector<Fiducial> marks) {
  for (Fiducial& mark : marks) mark.sigma_z = 0.0;
  return marks;
}

void warn_of_beyond(const std::filesystem::path& file, const std::string& what, double radius) {
  spdlog::warn(
      fmt::format("{}: {} lies farther from the base's axis than lamps were seen, {:.0f} mm, and "
                  "is left out",
                  file.string(), what, mm(radius)));
}

/// Returns the sights of a bar in a picture, which may show the base's marks alone.
std::vector<BarSight> bars_in(const std::vector<Frame>& frames,
                              const VisionCalibration& uncompensated,
                              const std::vector<Fiducial>& bar) {
  try {
    return see_bars(frames, uncompensated, bar);
  } catch (const WorkError& error) {
    spdlog::warn(fmt::format("a picture without the bar: {}", error.what()));
    return {};
  }
}

/// Adds each sight of the bar within the radius. Its length is certified, so that a board's pitch
/// no longer counts.
void add_bar(const LampFieldFiles& files, const VisionCalibration& uncompensated, double radius,
             LaidDots& laid) {
  const std::vector<Fiducial> bar = read_bar(files.bar);
  laid.length = (bar[1].p_W - bar[0].p_W).norm();
  const double by_height =
      std::max(bar[0].sigma_z, bar[1].sigma_z) / uncompensated.workplane.X_WC().translation().z();
  laid.length_sigma = std::hypot(files.bar_sigma, laid.length * by_height);
  for (const auto& frames_of_picture : files.pictures)
    for (const BarSight& seen : bars_in(frames_of_picture(), uncompensated, at_height(bar))) {
      const auto& [first, second] = seen.p_B;
      if (std::max(first.norm(), second.norm()) <= radius)
        laid.lengths.push_back({seen.p_B, seen.sigma});
      else
        warn_of_beyond(files.bar, "an end of the bar about " + place_mm(0.5 * (first + second)),
                       radius);
    }
  if (laid.lengths.empty())
    throw InputError({fmt::format("the bar is seen in none of {} pictures with both ends within "
                                  "{:.0f} mm of the base's axis, as far as lamps were seen",
                                  files.pictures.size(), mm(radius)),
                      "lay it nearer to the base, with both marks uncovered", files.bar,
                      Cause::kInsufficient});
  laid.pitch_known = false;
}

/// Returns a mark where its sights together show it. A height that is wrong shifts them all along
/// the line from the camera's foot.
MarkSight mark_sight(const Fiducial& mark, const std::vector<FoundFiducial>& sights,
                     double place_sigma, const Eigen::Vector3d& p_camera_B) {
  const auto n = static_cast<double>(sights.size());
  const double from_foot = (mark.p_W - p_camera_B.head<2>()).norm();
  MarkSight together{mark.p_W,
                     {0.0, 0.0},
                     std::hypot(place_sigma, sights.front().sigma / std::sqrt(n),
                                mark.sigma_z * from_foot / p_camera_B.z() / std::sqrt(2.0))};
  for (const FoundFiducial& sight : sights) together.seen_B += sight.p_B / n;
  return together;
}

/// Adds each mark of the base within the radius where the pictures together show it.
void add_marks(const LampFieldFiles& files, const VisionCalibration& uncompensated, double radius,
               LaidDots& laid) {
  const std::vector<Fiducial> marks = read_work_drawing(files.marks);
  std::map<std::string, std::vector<FoundFiducial>> sights;
  for (const auto& frames_of_picture : files.pictures)
    for (FoundFiducial& seen : see_marks(frames_of_picture(), uncompensated, at_height(marks)))
      sights[seen.fiducial.id].push_back(std::move(seen));
  for (const Fiducial& mark : marks) {
    if (sights[mark.id].empty()) continue;
    const MarkSight seen = mark_sight(mark, sights[mark.id], files.marks_sigma,
                                      uncompensated.workplane.X_WC().translation());
    if (seen.seen_B.norm() <= radius)
      laid.marks.push_back(seen);
    else
      warn_of_beyond(files.marks, "mark " + mark.id, radius);
  }
  if (laid.marks.empty())
    throw InputError({fmt::format("none of the {} marks of the base is seen near its place in {} "
                                  "pictures, within {:.0f} mm of the axis, as far as lamps were "
                                  "seen",
                                  marks.size(), files.pictures.size(), mm(radius)),
                      "compare x_mm and y_mm with the base frame, and uncover them", files.marks,
                      Cause::kInsufficient});
}

}  // namespace

ArmNominal nominal_arm(const CellSettings& cell, const VisionCalibration& vision) {
  ArmNominal nominal = arm_of_cell(cell);
  nominal.p_camera_B = vision.workplane.X_WC().translation();
  nominal.tool = vision.tool;
  set_tracker(nominal, cell);
  if (!vision.tool.reflector_known) nominal.reflector_sigma = kSomewhereOnTool;
  return nominal;
}

void spread_registration(ArmNominal& nominal, const CellSettings& cell,
                         const std::vector<PoseSample>& samples) {
  std::vector<double> sigmas;
  for (const PoseSample& sample : samples)
    if (sample.reflector_B) sigmas.push_back(sample.sigma_reflector);
  if (sigmas.empty() || !(cell.tracker.sigma_m > 0.0)) return;
  const double growth = std::max(1.0, median(sigmas) / cell.tracker.sigma_m);
  nominal.registration_shift *= growth;
  nominal.registration_turn *= growth;
}

std::vector<PoseSample> pose_samples(const CellSettings& cell, const std::vector<PairRow>& pairs) {
  const Transmission transmission(cell.transmission);
  double now_s = 0.0;  // when the last pair was seen; the field is to hold from then on
  for (const PairRow& pair : pairs) now_s = std::max(now_s, pair.t_s.value_or(0.0));
  std::vector<PoseSample> samples;
  for (const PairRow& pair : pairs)
    if (tells_field(pair)) samples.push_back(pose_sample(transmission, pair, now_s));
  return samples;
}

LaidDots laid_dots(const std::vector<LayRow>& rows) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<const LayRow*>> lays;
  for (const LayRow& row : rows) {
    if (!(row.sigma > 0.0))
      throw InputError({"a dot of '" + row.lay + "' has sigma_mm 0",
                        "make the table with planar-pair-tracker --lays-out", "lays"});
    if (row.pitch_known != rows.front().pitch_known)
      throw InputError({"the pitch is known for some lays only", "all must be of one board", "lays",
                        Cause::kContradiction});
    const auto [lay, is_new] = lays.try_emplace(row.lay);
    if (is_new) order.push_back(row.lay);
    lay->second.push_back(&row);
  }
  LaidDots board;
  for (const std::string& id : order) board.lays.push_back(lay_of(id, lays.at(id)));
  board.pitch_known = rows.empty() || rows.front().pitch_known;
  return board;
}

LaidDots laid_things(const LampFieldFiles& files, const VisionCalibration& vision, double radius) {
  LaidDots laid = files.lays.empty() ? LaidDots() : laid_dots(read_lays(files.lays));
  VisionCalibration uncompensated = vision;
  uncompensated.error_map.reset();
  laid.foot_B = uncompensated.workplane.X_WC().translation().head<2>();
  laid.lamps_shift_sigma = lamps_shift_sigma(uncompensated.workplane, laid.foot_B);
  if (!files.bar.empty()) add_bar(files, uncompensated, radius, laid);
  if (!files.marks.empty()) add_marks(files, uncompensated, radius, laid);
  return laid;
}

std::vector<MadeFile> LampFieldFiles::inputs() const {
  std::vector<MadeFile> files{{Role::kPairs, pairs}};
  for (const MadeFile& more :
       {MadeFile{Role::kLays, lays}, MadeFile{Role::kBar, bar}, MadeFile{Role::kMarks, marks}})
    if (!more.path.empty()) files.push_back(more);
  return files;
}

LampFieldFit learn_lamp_field(const LampFieldFiles& files, const CellSettings& cell,
                              const VisionCalibration& vision, const Progress& progress) {
  warn_of_changed_rows(files.pairs);
  const std::vector<PoseSample> samples = pose_samples(cell, read_pairs(files.pairs));
  ArmNominal nominal = nominal_arm(cell, vision);
  spread_registration(nominal, cell, samples);
  return fit_lamp_field(nominal, samples, laid_things(files, vision, seen_radius(samples)),
                        progress);
}

void write_lamp_field(const LampFieldFiles& files, const LampFieldFit& fit,
                      const CellSettings& cell, const std::string& program) {
  std::vector<Origin> origins;
  for (const MadeFile& input : files.inputs()) origins.push_back(origin_of(input));
  origins = with_origins_of(std::move(origins), files.pairs);
  const std::string map = fit.end_point_map ? map_text(*fit.end_point_map, origins, program)
                                            : lamp_field_text(fit, origins, program);
  if (!files.arm.empty()) {
    origins.push_back(arm_origin(cell));
    write_file(files.arm, found_arm_text(fit.arm, arm_terms(fit.estimate), origins, program));
  }
  write_file(files.map, map);
}

}  // namespace planar

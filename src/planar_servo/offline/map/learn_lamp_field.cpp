#include "planar_servo/offline/map/learn_lamp_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/devices/tracker.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/files/work_file.h"
#include "planar_servo/geometry/arm/transmission.h"
#include "planar_servo/hardware/cell/device_kinds.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"
#include "planar_servo/workpiece/find_work.h"

namespace planar {
namespace {

bool tells_field(const PairRow& pair) {
  constexpr Purpose kTelling[] = {Purpose::kTrain, Purpose::kSweep1, Purpose::kSweep3,
                                  Purpose::kPose};
  return !pair.plan || std::count(std::begin(kTelling), std::end(kTelling), *pair.plan) > 0;
}

/// Returns when the last pair was seen; the field is to hold from then on.
double last_s(const std::vector<PairRow>& pairs) {
  double last = 0.0;
  for (const PairRow& pair : pairs) last = std::max(last, pair.t_s.value_or(0.0));
  return last;
}

PoseSample pose_sample(const Transmission& transmission, const PairRow& pair, double now_s) {
  if (!pair.lamps_B || !pair.theta || !pair.sigma_vision || (pair.p_tracker && !pair.p_reflector) ||
      (pair.p_reflector && !pair.sigma_tracker))
    throw InputError({fmt::format("pair '{}' lacks its lamps, its joints or a standard deviation, "
                                  "from which field and arm are learned",
                                  pair.id),
                      "make the pairs with planar-pair-tracker, or leave --cell out"});
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

/// Adds each sight of the bar. Its length is certified, so that a board's pitch no longer counts.
void add_bar(const LampFieldFiles& files, const VisionCalibration& uncompensated, LaidDots& laid) {
  const std::vector<Fiducial> bar = read_bar(files.bar);
  laid.length = (bar[1].p_W - bar[0].p_W).norm();
  laid.length_sigma = files.bar_sigma;
  for (const auto& frames_of_picture : files.pictures)
    for (const BarSight& seen : see_bars(frames_of_picture(), uncompensated, bar))
      laid.lengths.push_back({seen.p_B, seen.sigma});
  laid.pitch_known = false;
}

/// Adds each mark of the base where the pictures together show it.
void add_marks(const LampFieldFiles& files, const VisionCalibration& uncompensated,
               LaidDots& laid) {
  const std::vector<Fiducial> marks = read_work_drawing(files.marks);
  std::map<std::string, std::vector<FoundFiducial>> sights;
  for (const auto& frames_of_picture : files.pictures)
    for (FoundFiducial& seen : see_marks(frames_of_picture(), uncompensated, marks))
      sights[seen.fiducial.id].push_back(std::move(seen));
  for (const auto& [id, seen] : sights) {
    const auto n = static_cast<double>(seen.size());
    MarkSight mark{seen.front().fiducial.p_W,
                   {0.0, 0.0},
                   std::hypot(files.marks_sigma, seen.front().sigma / std::sqrt(n))};
    for (const FoundFiducial& one : seen) mark.seen_B += one.p_B / n;
    laid.marks.push_back(mark);
  }
  if (laid.marks.empty())
    throw InputError({fmt::format("none of the {} marks of the base is seen near its place in {} "
                                  "pictures",
                                  marks.size(), files.pictures.size()),
                      "compare x_mm and y_mm with the base frame, and uncover them", files.marks});
}

}  // namespace

ArmNominal nominal_arm(const CellSettings& cell, const VisionCalibration& vision) {
  ArmNominal nominal;
  nominal.geometry = cell.arm.geometry;
  nominal.joints_per_motor = Transmission(cell.transmission).coupling_matrix().inverse();
  for (int i = 0; i < 3; ++i)
    nominal.gear_ratios[i] = cell.transmission.drives[static_cast<std::size_t>(i)].gear_ratio;
  nominal.p_camera_B = vision.workplane.X_WC().translation();
  nominal.separation = cell.lamps.layout.separation_m;
  nominal.tool = vision.tool;
  set_tracker(nominal, cell);
  if (!vision.tool.reflector_known) nominal.reflector_sigma = kSomewhereOnTool;
  return nominal;
}

std::vector<PoseSample> pose_samples(const CellSettings& cell, const std::vector<PairRow>& pairs) {
  const Transmission transmission(cell.transmission);
  const double now_s = last_s(pairs);
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
      throw InputError(
          {"the pitch is known for some lays only", "all must be of one board", "lays"});
    const auto [lay, is_new] = lays.try_emplace(row.lay);
    if (is_new) order.push_back(row.lay);
    lay->second.push_back(&row);
  }
  LaidDots board;
  for (const std::string& id : order) board.lays.push_back(lay_of(id, lays.at(id)));
  board.pitch_known = rows.empty() || rows.front().pitch_known;
  return board;
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
  LaidDots laid = files.lays.empty() ? LaidDots() : laid_dots(read_lays(files.lays));
  VisionCalibration uncompensated = vision;
  uncompensated.error_map.reset();
  if (!files.bar.empty()) add_bar(files, uncompensated, laid);
  if (!files.marks.empty()) add_marks(files, uncompensated, laid);
  return fit_lamp_field(nominal_arm(cell, vision), pose_samples(cell, read_pairs(files.pairs)),
                        laid, progress);
}

void write_lamp_field(const LampFieldFiles& files, const LampFieldFit& fit,
                      const CellSettings& cell, const std::string& program) {
  std::vector<Origin> origins;
  for (const MadeFile& input : files.inputs()) origins.push_back(origin_of(input));
  origins = with_origins_of(std::move(origins), files.pairs);
  const std::string map = fit.end_point_map ? map_text(*fit.end_point_map, files.pairs, program)
                                            : lamp_field_text(fit, origins, program);
  if (!files.arm.empty()) {
    origins.push_back(arm_origin(cell));
    write_file(files.arm, found_arm_text(fit.arm, arm_terms(fit.estimate), origins, program));
  }
  write_file(files.map, map);
}

}  // namespace planar

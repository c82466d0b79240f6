#include "planar_servo/workpiece/find_work.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/lamps/lamp_center.h"
#include "planar_servo/learn/error_map/error_map.h"
#include "planar_servo/learn/field/lamp_field.h"
#include "planar_servo/loop/vision/reference_lamps.h"

namespace planar {
namespace {

using Points = std::vector<Eigen::Vector2d>;
using MarkForm = std::tuple<FiducialKind, double, double>;  ///< kind, size and height

/// What the field says of the lens where the lamps' plane is seen at some places.
struct LensError {
  Eigen::Matrix2Xd error;  ///< a column for each place, metres
  Eigen::MatrixXd factor;  ///< of the covariance of all, x and y of each place in turn
};

LensError lens_error(const LampField& field, const Points& seen_B) {
  const Eigen::Index nb = field.basis.terms();
  const auto n = static_cast<Eigen::Index>(seen_B.size());
  LensError lens{Eigen::Matrix2Xd(2, n), Eigen::MatrixXd(2 * n, field.factor.cols())};
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::RowVectorXd basis = field.basis.at(seen_B[static_cast<std::size_t>(i)]);
    lens.error.col(i) = (basis * field.weights).transpose();
    lens.factor.row(2 * i) = basis * field.factor.topRows(nb);
    lens.factor.row(2 * i + 1) = basis * field.factor.middleRows(nb, nb);
  }
  return lens;
}

/// A map at the end point does not tell the lens from the lamps: nothing is taken off. All of its
/// error may be the lens's. Beyond that the lamps may hide an error of the lens: the camera sees
/// their halos obliquely, which shifts them along the ray, as a shift and a scale of the picture
/// would. Each of these may be as large as the map's error at the rim of its region.
LensError lens_error(const ErrorMap& map, const Points& seen_B) {
  const std::vector<Eigen::Vector2d>& rim = valid_region(map).hull;
  const double corners = static_cast<double>(rim.size());
  Eigen::Vector2d middle(0.0, 0.0);
  for (const Eigen::Vector2d& corner : rim) middle += corner / corners;
  double variance = 0.0, radius2 = 0.0;
  for (const Eigen::Vector2d& corner : rim) {
    variance += 0.5 * predict_error(map, corner, 0.0).squaredNorm() / corners;
    radius2 += (corner - middle).squaredNorm() / corners;
  }
  const double sigma = std::sqrt(variance);
  const auto n = static_cast<Eigen::Index>(seen_B.size());
  LensError lens{Eigen::Matrix2Xd::Zero(2, n), Eigen::MatrixXd(2 * n, 4)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector2d& s = seen_B[static_cast<std::size_t>(i)];
    lens.factor.middleRows<2>(2 * i) << predict_error(map, s, 0.0),
        sigma * Eigen::Matrix2d::Identity(), sigma / std::sqrt(radius2) * (s - middle);
  }
  return lens;
}

LensError lens_error(const VisionCalibration& vision, const Points& seen_B) {
  if (vision.error_map)
    return std::visit([&](const auto& map) { return lens_error(map, seen_B); }, *vision.error_map);
  const auto n = static_cast<Eigen::Index>(seen_B.size());
  return {Eigen::Matrix2Xd::Zero(2, n), Eigen::MatrixXd::Zero(2 * n, 1)};
}

/// Returns the plane of marks at this height over the lamps' plane.
Workplane plane_at(const Workplane& lamps, double z) {
  Pose X_WC = lamps.X_WC();
  X_WC.translation().z() -= z;
  return {lamps.camera(), X_WC};
}

[[noreturn]] void refuse_outside(const Fiducial& mark) {
  throw WorkError({fmt::format("{} is seen where the camera's model has no ray that meets its "
                               "plane, {:g} mm over that of the lamps",
                               mark.id, mm(mark.z)),
                   "correct z_mm", "", Cause::kContradiction});
}

/// Where vision sees marks at these pixels, as seen at calibration, at their heights over the
/// lamps' plane: only what the lens does is taken off (theory section 20). The covariance has the
/// marks' own noise `own_px2`, the doubt about the height, and that about the lens.
WorkMarks marks_on_plane(const VisionCalibration& vision, const std::vector<Fiducial>& fiducials,
                         const std::vector<Eigen::Vector2d>& uv_px,
                         const std::vector<Eigen::Matrix2d>& own_px2) {
  const auto n = static_cast<Eigen::Index>(fiducials.size());
  const Eigen::Vector3d p_WC = vision.workplane.X_WC().translation();
  Points seen(fiducials.size());
  std::vector<Eigen::Matrix2d> slopes(fiducials.size());
  for (std::size_t i = 0; i < fiducials.size(); ++i) {
    const auto s = vision.workplane.plane_from_pixel(uv_px[i], &slopes[i]);
    if (!s) refuse_outside(fiducials[i]);
    seen[i] = *s;
  }
  const LensError lens = lens_error(vision, seen);
  WorkMarks marks{
      {}, Eigen::Matrix2Xd(2, n), Eigen::Matrix2Xd(2, n), Eigen::MatrixXd::Zero(2 * n, 2 * n), {}};
  Eigen::MatrixXd shared(2 * n, lens.factor.cols() + 1);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double left = 1.0 - fiducials[k].z / p_WC.z();
    const Eigen::Vector2d s = seen[k] - lens.error.col(i);
    const Eigen::Vector2d raised = (s - p_WC.head<2>()) / p_WC.z();
    marks.ids.push_back(fiducials[k].id);
    marks.p_W.col(i) = fiducials[k].p_W;
    marks.p_B.col(i) = s - fiducials[k].z * raised;
    marks.own.block<2, 2>(2 * i, 2 * i) =
        left * left * slopes[k] * own_px2[k] * slopes[k].transpose();
    shared.middleRows<2>(2 * i) << left * lens.factor.middleRows<2>(2 * i),
        -fiducials[k].sigma_z * raised;
  }
  marks.shared = shared * shared.transpose();
  return marks;
}

/// The marks of a picture, and the light that moves them.
struct Picture {
  cv::Mat image;
  ImageMotion motion;
};

/// Returns the frames with the image's motion since the calibration, by each of them or by one of
/// the lamps. Throws WorkError when that cannot be known.
std::vector<Picture> pictures_of(const std::vector<Frame>& frames, const VisionCalibration& vision,
                                 const std::optional<Frame>& of_lamps = {}) {
  std::vector<Picture> pictures;
  pictures.reserve(frames.size());
  ReferenceWatch watch(vision.reference_lamps, CenterMethod::kAuto);
  for (const Frame& frame : frames) {
    if (pictures.empty() || !of_lamps) watch.look(of_lamps.value_or(frame));
    if (watch.objection()) throw WorkError(*watch.objection());
    pictures.push_back({frame.image, watch.motion()});
  }
  return pictures;
}

/// A mark's mean over pictures, as seen at calibration.
struct MeanFiducial {
  Eigen::Vector2d uv_px{0.0, 0.0};
  Eigen::Matrix2d covariance_px2{Eigen::Matrix2d::Zero()};
  Points each_px;  ///< in each picture
  double size_px{0.0};
};

std::optional<MeanFiducial> measure_in(const std::vector<Picture>& pictures, FiducialKind kind,
                                       const FiducialSight& found) {
  MeanFiducial mean;
  const double n = static_cast<double>(pictures.size());
  for (const Picture& picture : pictures) {
    const auto seen = measure_fiducial(picture.image, kind, found);
    if (!seen) return std::nullopt;
    mean.each_px.push_back(picture.motion.then(seen->uv_px));
    mean.uv_px += mean.each_px.back() / n;
    mean.covariance_px2 += seen->covariance_px2 / (n * n);
    mean.size_px += seen->size_px / n;
  }
  return mean;
}

/// Gives the marks without a covariance of their own that of their scatter from picture to
/// picture, pooled over them. One picture has none; OpenCV's corners are good to a tenth of a pixel
/// then.
void take_scatter(const std::vector<Fiducial>& fiducials, std::vector<MeanFiducial>& means) {
  constexpr double kUnknown_px = 0.1;
  double square = 0.0;
  double freedom = 0.0;
  for (std::size_t i = 0; i < means.size(); ++i) {
    if (is_round(fiducials[i].kind)) continue;
    for (const Eigen::Vector2d& uv_px : means[i].each_px)
      square += (uv_px - means[i].uv_px).squaredNorm();
    freedom += 2.0 * (static_cast<double>(means[i].each_px.size()) - 1.0);
  }
  for (std::size_t i = 0; i < means.size(); ++i) {
    if (is_round(fiducials[i].kind)) continue;
    const double variance = freedom > 0.0 ? square / freedom : kUnknown_px * kUnknown_px;
    means[i].covariance_px2 =
        Eigen::Matrix2d::Identity() * variance / static_cast<double>(means[i].each_px.size());
  }
}

/// Takes off that the centre of a disc's image is not the image of its centre.
void take_off_eccentricity(const VisionCalibration& vision, const Fiducial& fiducial,
                           MeanFiducial& mean) {
  if (!is_round(fiducial.kind)) return;
  const Workplane plane = plane_at(vision.workplane, fiducial.z);
  const auto p = plane.plane_from_pixel(mean.uv_px);
  if (!p) refuse_outside(fiducial);
  if (const auto shift = eccentricity_px(plane.camera(), plane.X_WC().inverse(), *p, fiducial.size))
    mean.uv_px -= *shift;
}

double px_per_m(const Workplane& plane, const Eigen::Vector2d& p) {
  Eigen::Matrix2d slope;
  if (!plane.pixel_from_plane(p, &slope)) return 0.0;
  return std::sqrt(std::abs(slope(0, 0) * slope(1, 1) - slope(0, 1) * slope(1, 0)));
}

/// Returns whether a candidate of this kind and height is known at this place: discs of two sizes
/// may both be looked for there.
bool is_among(const std::vector<MarkCandidate>& candidates, const MarkCandidate& candidate) {
  return std::any_of(candidates.begin(), candidates.end(), [&](const MarkCandidate& other) {
    return other.kind == candidate.kind && other.z == candidate.z &&
           (other.p_B - candidate.p_B).norm() < 0.25 * candidate.size;
  });
}

/// Finds what looks like one of the drawing's marks, everywhere in a picture.
std::vector<MarkCandidate> candidates_in(const Picture& picture, const VisionCalibration& vision,
                                         const std::vector<Fiducial>& drawing) {
  std::map<MarkForm, Fiducial> forms;
  for (const Fiducial& mark : drawing)
    forms.try_emplace(MarkForm{mark.kind, mark.size, mark.z}, mark);
  std::vector<MarkCandidate> candidates;
  for (const auto& [form, mark] : forms) {
    const auto& [kind, size, z] = form;
    const Workplane plane = plane_at(vision.workplane, z);
    const Eigen::Vector2d middle_px(0.5 * picture.image.cols, 0.5 * picture.image.rows);
    const auto middle = plane.plane_from_pixel(middle_px);
    const double scale = middle ? px_per_m(plane, *middle) : 0.0;
    if (scale == 0.0) refuse_outside(mark);
    for (const FiducialSight& sight : find_fiducials(picture.image, kind, size * scale)) {
      const auto p_B = plane.plane_from_pixel(picture.motion.then(sight.uv_px));
      if (!p_B) continue;
      const double here = px_per_m(plane, *p_B);
      const MarkCandidate candidate{sight, kind, sight.size_px / here, *p_B, z};
      if (here > 0.0 && !is_among(candidates, candidate)) candidates.push_back(candidate);
    }
  }
  return candidates;
}

/// Returns the covariance of a mark's mean with what uneven light and rims shift a centre by, which
/// the rim's own noise does not show: the least of doc/lamps.md.
Eigen::Matrix2d own_px2(const MeanFiducial& mean) {
  constexpr double kLight_px = 0.01;
  return mean.covariance_px2 + kLight_px * kLight_px * Eigen::Matrix2d::Identity();
}

/// Returns the standard deviation of the distance between the first two marks.
double distance_sigma(const WorkMarks& marks) {
  const Eigen::Vector2d along = (marks.p_B.col(1) - marks.p_B.col(0)).normalized();
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(marks.p_B.size());
  slope.head<4>() << -along, along;
  return std::sqrt(slope.dot(marks.covariance() * slope));
}

/// Throws WorkError for a mark that is not where it was from picture to picture: the mean of them
/// is no place of it.
void require_rest(const Fiducial& mark, const MeanFiducial& mean) {
  // 1 K/m across 2 m of air bends light by 2 to 4 um, here of 10 px/mm. Sub-pixel corners of the
  // library repeat to a tenth of a pixel.
  constexpr double kAir_px = 0.04, kCorner_px = 0.1, kSigmas = 5.0;
  const double n = static_cast<double>(mean.each_px.size());
  const double own_px = is_round(mark.kind) ? per_axis(n * mean.covariance_px2) : kCorner_px;
  const double allowed_px = kSigmas * std::hypot(own_px, kAir_px);
  double farthest_px = 0.0;
  for (const Eigen::Vector2d& uv_px : mean.each_px)
    farthest_px = std::max(farthest_px, (uv_px - mean.uv_px).norm());
  if (farthest_px > allowed_px)
    throw WorkError({fmt::format("{} moves from picture to picture, by {:.2f} px from their mean, "
                                 "where {:.2f} px would be noise",
                                 mark.id, farthest_px, allowed_px),
                     "let the work lie still, and give pictures of one place only", "",
                     Cause::kContradiction});
}

/// The marks of a place, as seen at calibration and on their plane.
struct MeasuredMarks {
  std::vector<MeanFiducial> means;
  WorkMarks marks;
};

MeasuredMarks measure_marks(const Constellation& constellation,
                            const std::vector<MarkCandidate>& candidates,
                            const std::vector<Picture>& pictures, const VisionCalibration& vision,
                            const std::vector<Fiducial>& drawing) {
  std::vector<MeanFiducial> means;
  for (std::size_t i = 0; i < drawing.size(); ++i) {
    const FiducialSight& sight = candidates[constellation.candidates[i]].sight;
    const auto mean = measure_in(pictures, drawing[i].kind, sight);
    if (!mean)
      throw WorkError({fmt::format("{} is seen at ({}) px, but its outline cannot be measured",
                                   drawing[i].id, fixed(sight.uv_px, 1, ", ")),
                       "clean it, see that nothing touches it, and expose the picture so that it "
                       "stands out",
                       "", Cause::kInsufficient});
    require_rest(drawing[i], *mean);
    means.push_back(*mean);
    take_off_eccentricity(vision, drawing[i], means.back());
  }
  take_scatter(drawing, means);
  Points uv_px;
  std::vector<Eigen::Matrix2d> all_px2;
  for (const MeanFiducial& mean : means) {
    uv_px.push_back(mean.uv_px);
    all_px2.push_back(own_px2(mean));
  }
  return {means, marks_on_plane(vision, drawing, uv_px, all_px2)};
}

/// Adds to all marks in common what the map has of the lamps instead of the lens. Boards do not
/// tell it, whose place is free.
void add_lamps_share(WorkMarks& marks, const VisionCalibration& vision) {
  const auto n = marks.p_B.cols();
  const double sigma = lamps_shift_sigma(vision.workplane, marks.p_B.rowwise().mean());
  marks.shared += (sigma * sigma * Eigen::Matrix2d::Identity()).replicate(n, n);
}

/// Says how far the marks' scale is from the drawing's, and which height would explain it.
[[noreturn]] void refuse_scale(const WorkFit& similarity, const VisionCalibration& vision,
                               double z) {
  const double scale = similarity.pose.scale();
  const double H = vision.workplane.X_WC().translation().z();
  throw WorkError(
      {fmt::format("the marks are {:.3f} times as far apart as in the drawing, which is beyond "
                   "what drawing and picture allow: the print is not to scale, the drawing has "
                   "another unit or pitch, or the marks lie {:.1f} mm {} than z_mm = {:g} says",
                   scale, mm(std::abs((scale - 1.0) * (H - z))), scale > 1.0 ? "higher" : "lower",
                   mm(z)),
       "measure their height, or allow a scale with --map similarity", "", Cause::kContradiction});
}

[[noreturn]] void refuse_misfit(const WorkMarks& marks, const WorkFit& fit) {
  Eigen::Index worst = 0;
  fit.residuals.colwise().norm().maxCoeff(&worst);
  throw WorkError(
      {fmt::format("the marks do not fit the drawing; {} is off by {:.3f} mm, and no single one "
                   "can be told to be wrong",
                   marks.ids[static_cast<std::size_t>(worst)], mm(fit.residuals.col(worst).norm())),
       "compare the drawing with the work, see that it lies flat, or state a larger deviation of "
       "the drawing with --drawing-sigma-mm",
       "", Cause::kContradiction});
}

/// Fits the most general map that is allowed and that the marks demand. Throws WorkError naming a
/// mark that contradicts the others, a scale that only a wrong height or another drawing explains,
/// or marks that do not fit the drawing. `sigma` is WorkSettings::drawing_sigma.
WorkFit fit_to_drawing(const WorkMarks& marks, double sigma, WorkMap allowed,
                       const VisionCalibration& vision, double z) {
  WorkMarks doubted = marks;
  doubted.own.diagonal().array() += sigma * sigma;
  const std::optional<WorkFit> rigid = fit_work(doubted, WorkMap::kRigid);
  if (!rigid)
    throw WorkError({"the marks do not determine where the work lies",
                     "they must not all be in one place", "", Cause::kInsufficient});
  const bool may_scale = marks.size() > 2;  // two marks alone cannot tell a scale from a fault
  const auto similarity = may_scale ? fit_work(doubted, WorkMap::kSimilarity) : std::nullopt;
  const bool has_other_scale =
      similarity && chi_square_tail(std::max(0.0, rigid->chi2 - similarity->chi2), 1) < kFalseAlarm;
  // A map is stretched only where a rigid one leaves too much, and only as far as that helps.
  if (rigid->chance() >= kFalseAlarm && !has_other_scale) return *rigid;
  if (similarity && similarity->chance() >= kFalseAlarm) {
    if (allowed != WorkMap::kRigid) return *similarity;
    if (!contradicting_mark(doubted, WorkMap::kRigid)) refuse_scale(*similarity, vision, z);
  }
  const auto affine = marks.size() > 3 ? fit_work(doubted, WorkMap::kAffine) : std::nullopt;
  if (allowed == WorkMap::kAffine && affine && affine->chance() >= kFalseAlarm) return *affine;
  if (const auto odd = contradicting_mark(doubted, WorkMap::kRigid))
    throw WorkError({fmt::format("{} is {:.3f} mm from where the other marks put it",
                                 marks.ids[odd->mark], mm(odd->distance_m)),
                     "compare it with the drawing, look for a reflection or a mark of another "
                     "work there, or leave its row out",
                     "", Cause::kContradiction});
  if (!may_scale) {
    const double drawn = (marks.p_W.col(1) - marks.p_W.col(0)).norm();
    const double seen = (marks.p_B.col(1) - marks.p_B.col(0)).norm();
    throw WorkError(
        {fmt::format("{} and {} are {:.3f} mm apart, and {:.3f} mm in the drawing: one is not the "
                     "mark, the print is not to scale, or they lie at another height than z_mm",
                     marks.ids[0], marks.ids[1], mm(seen), mm(drawn)),
         "measure their distance and height; a third mark would tell which", "",
         Cause::kContradiction});
  }
  refuse_misfit(marks, *rigid);
}

void add_remarks(const WorkMarks& marks, const WorkSettings& settings,
                 const VisionCalibration& vision, FoundWork& work) {
  if (marks.size() == 2) {
    const double power =
        4.0 * std::hypot(std::sqrt(2.0) * settings.drawing_sigma, distance_sigma(marks));
    work.remarks.push_back(fmt::format(
        "two marks have one check, their distance: a mark that is off by less than {:.3f} mm along "
        "their line, or by anything across it, is not noticed",
        mm(power)));
  }
  constexpr double kSeldom = 0.01;
  if (work.chance < kSeldom)
    work.remarks.push_back(fmt::format(
        "of {:.0f} works like their drawing one fits as badly as this: compare distances "
        "of the marks, and their height with z_mm",
        1.0 / work.chance));
  if (!vision.error_map)
    work.remarks.emplace_back(
        "vision is not compensated; what the lens model leaves is not in the uncertainty");
  else if (std::holds_alternative<ErrorMap>(*vision.error_map))
    work.remarks.emplace_back(
        "the error map does not tell the lens from the lamps: nothing is taken off the marks, and "
        "its error stands in their uncertainty");
  else
    work.remarks.emplace_back(
        "a shift common to all marks, of what the error map has of the lamps instead of the lens, "
        "stands in the uncertainty");
}

FoundWork work_at(const Constellation& constellation, const std::vector<MarkCandidate>& candidates,
                  const std::vector<Picture>& pictures, const VisionCalibration& vision,
                  const std::vector<Fiducial>& drawing, const WorkSettings& settings) {
  auto [means, marks] = measure_marks(constellation, candidates, pictures, vision, drawing);
  add_lamps_share(marks, vision);
  const WorkFit fit =
      fit_to_drawing(marks, settings.drawing_sigma, settings.allowed, vision, drawing.front().z);
  FoundWork work;
  work.pose = fit.pose;
  work.chance = fit.chance();
  for (std::size_t i = 0; i < drawing.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const double scale = px_per_m(plane_at(vision.workplane, drawing[i].z), marks.p_B.col(at));
    work.fiducials.push_back({drawing[i], means[i].uv_px, marks.p_B.col(at), fit.residuals.col(at),
                              per_axis(marks.covariance().block<2, 2>(2 * at, 2 * at)),
                              is_round(drawing[i].kind) ? means[i].size_px / scale : 0.0});
  }
  add_remarks(marks, settings, vision, work);
  return work;
}

[[noreturn]] void refuse_ambiguous(const std::vector<Constellation>& found) {
  std::string places;
  for (const Constellation& place : found)
    places += fmt::format("{}{} turned by {:.1f} deg", places.empty() ? "" : "; ",
                          place_mm(place.X_BW.translation()),
                          std::atan2(place.X_BW(1, 0), place.X_BW(0, 0)) / kDegree);
  throw WorkError(
      {fmt::format("the drawing fits in {} ways; its origin would be at {}", found.size(), places),
       "say with --near X,Y,TURN which one is meant, take --all where each is a work "
       "of its own, or give the drawing a mark that breaks its symmetry",
       "", Cause::kInsufficient});
}

/// Returns whether two of these places share a mark, so that not each can be a work of its own.
bool share_marks(const std::vector<Constellation>& found) {
  std::vector<std::size_t> all;
  for (const Constellation& place : found)
    all.insert(all.end(), place.candidates.begin(), place.candidates.end());
  std::sort(all.begin(), all.end());
  return std::adjacent_find(all.begin(), all.end()) != all.end();
}

}  // namespace

void number_works(std::vector<FoundWork>& works, const std::vector<Fiducial>& drawing) {
  if (works.size() == 1) return;
  Eigen::AlignedBox2d drawn;
  for (const Fiducial& mark : drawing)
    drawn.extend(Eigen::AlignedBox2d(mark.p_W.array() - mark.size, mark.p_W.array() + mark.size));
  const double same_column = 0.5 * drawn.sizes().minCoeff();
  const auto x = [](const FoundWork& work) { return work.pose.t.x(); };
  const auto y = [](const FoundWork& work) { return work.pose.t.y(); };
  std::sort(works.begin(), works.end(),
            [&](const FoundWork& a, const FoundWork& b) { return x(a) < x(b); });
  for (auto first = works.begin(), last = first; first != works.end(); first = last) {
    while (++last != works.end() && x(*last) - x(*(last - 1)) < same_column) {
    }
    std::sort(first, last, [&](const FoundWork& a, const FoundWork& b) { return y(a) < y(b); });
  }
  for (std::size_t i = 0; i < works.size(); ++i) works[i].id = std::to_string(i + 1);
}

double lamps_shift_sigma(const Workplane& plane, const Eigen::Vector2d& p_B) {
  constexpr double kLamps_px = 0.03;
  const double scale = px_per_m(plane, p_B);
  return scale > 0.0 ? kLamps_px / scale : 0.0;
}

std::vector<FoundWork> find_work(const std::vector<Frame>& frames, const VisionCalibration& vision,
                                 const std::vector<Fiducial>& drawing, const WorkSettings& settings,
                                 const std::optional<Frame>& of_lamps) {
  const std::vector<Picture> pictures = pictures_of(frames, vision, of_lamps);
  const std::vector<MarkCandidate> candidates = candidates_in(pictures.front(), vision, drawing);
  const std::vector<Constellation> found = match_constellation(drawing, candidates, settings.place);
  if (found.size() > 1 && (!settings.all || share_marks(found))) refuse_ambiguous(found);
  std::vector<FoundWork> works;
  for (const Constellation& constellation : found)
    works.push_back(work_at(constellation, candidates, pictures, vision, drawing, settings));
  number_works(works, drawing);
  return works;
}

std::vector<BarSight> see_bars(const std::vector<Frame>& frames, const VisionCalibration& vision,
                               const std::vector<Fiducial>& bar) {
  const std::vector<Picture> pictures = pictures_of(frames, vision);
  const std::vector<MarkCandidate> candidates = candidates_in(pictures.front(), vision, bar);
  std::vector<BarSight> bars;
  std::map<std::size_t, std::set<std::size_t>> partners;  // a bar with two like ends fits twice
  for (const Constellation& found : match_constellation(bar, candidates, {})) {
    const std::size_t first = found.candidates[0], second = found.candidates[1];
    partners[second].insert(first);
    if (!partners[first].insert(second).second) continue;
    const WorkMarks marks = measure_marks(found, candidates, pictures, vision, bar).marks;
    bars.push_back({{marks.p_B.col(0), marks.p_B.col(1)},
                    (marks.p_B.col(1) - marks.p_B.col(0)).norm(),
                    distance_sigma(marks)});
  }
  for (const auto& [mark, others] : partners)
    if (others.size() > 1)
      throw WorkError(
          {fmt::format("the mark at {} is about the bar's length from {} others, so that "
                       "nobody knows which is the bar's other end",
                       place_mm(candidates[mark].p_B), others.size()),
           "lay one bar at a time, and clear away what looks like its marks", "",
           Cause::kInsufficient});
  return bars;
}

std::vector<FoundFiducial> see_like(const std::vector<Frame>& frames,
                                    const VisionCalibration& vision, const Fiducial& form) {
  const std::vector<Picture> pictures = pictures_of(frames, vision);
  std::vector<FoundFiducial> found;
  for (const MarkCandidate& candidate : candidates_in(pictures.front(), vision, {form})) {
    const auto mean = measure_in(pictures, form.kind, candidate.sight);
    if (!mean) continue;
    std::vector<MeanFiducial> means{*mean};
    take_off_eccentricity(vision, form, means.front());
    take_scatter({form}, means);
    const WorkMarks marks = marks_on_plane(vision, {form}, {means[0].uv_px}, {own_px2(means[0])});
    found.push_back({form, means[0].uv_px, marks.p_B.col(0), Eigen::Vector2d::Zero(),
                     per_axis(marks.covariance()), candidate.size});
    if (form.kind == FiducialKind::kAprilTag)
      found.back().fiducial.id = std::to_string(candidate.sight.tag);
  }
  return found;
}

std::vector<FoundFiducial> see_marks(const std::vector<Frame>& frames,
                                     const VisionCalibration& vision,
                                     const std::vector<Fiducial>& marks_B) {
  constexpr double kNear = 5e-3;  // metres; what a base frame by cell file and poses is off
  std::map<MarkForm, std::vector<FoundFiducial>> alike;
  std::vector<FoundFiducial> found;
  for (const Fiducial& mark : marks_B) {
    const auto [seen, is_new] = alike.try_emplace(MarkForm{mark.kind, mark.size, mark.z});
    if (is_new) seen->second = see_like(frames, vision, mark);
    std::vector<FoundFiducial> near;
    for (const FoundFiducial& one : seen->second)
      if ((one.p_B - mark.p_W).norm() < kNear && may_have_tag(mark, tag_number(one.fiducial.id)))
        near.push_back(one);
    if (near.size() > 1)
      throw WorkError({fmt::format("{} of the base could be any of {} marks within {:g} mm of {}",
                                   mark.id, near.size(), mm(kNear), place_mm(mark.p_W)),
                       "cover what looks like it", "", Cause::kInsufficient});
    if (near.empty()) continue;
    found.push_back(near.front());
    found.back().fiducial = mark;
  }
  return found;
}

WorkMotion look_again(const std::vector<Frame>& frames, const VisionCalibration& vision,
                      const FoundWork& work, const std::optional<Frame>& of_lamps) {
  const std::vector<Picture> pictures = pictures_of(frames, vision, of_lamps);
  WorkMotion motion;
  std::vector<Fiducial> seen;
  std::vector<MeanFiducial> means;
  Points before_px;
  for (const FoundFiducial& found : work.fiducials) {
    const Workplane plane = plane_at(vision.workplane, found.fiducial.z);
    const double size_px = found.fiducial.size * px_per_m(plane, found.p_B);
    const FiducialSight place{pictures.front().motion.now(found.uv_px), Eigen::Matrix2d::Zero(),
                              size_px, tag_number(found.fiducial.id).value_or(-1)};
    auto mean = measure_in(pictures, found.fiducial.kind, place);
    if (!mean) {
      motion.hidden.push_back(found.fiducial.id);
      continue;
    }
    take_off_eccentricity(vision, found.fiducial, *mean);
    means.push_back(*mean);
    seen.push_back(found.fiducial);
    before_px.push_back(found.uv_px);
  }
  if (seen.empty()) return motion;
  take_scatter(seen, means);
  Points now_px;
  std::vector<Eigen::Matrix2d> own_px2;
  for (const MeanFiducial& mean : means) {
    now_px.push_back(mean.uv_px);
    own_px2.push_back(2.0 * mean.covariance_px2);  // of now and of then
  }
  const WorkMarks now = marks_on_plane(vision, seen, now_px, own_px2);
  const WorkMarks then = marks_on_plane(vision, seen, before_px, own_px2);
  motion.shift = (now.p_B - then.p_B).rowwise().mean();
  if (seen.size() > 1) {
    const Eigen::Isometry2d turned = fit_rigid_2d(now.p_B, then.p_B);
    motion.turn = std::atan2(turned(1, 0), turned(0, 0));
  }
  // What lens and height do cancels between looks at one place; what is left is noise, and the
  // image's motion between looks, a few hundredths of a pixel in moving air.
  constexpr double kLeastMove_m = 20e-6, kSigmas = 5.0;
  double farthest = 0.0, allowed = kLeastMove_m;
  for (Eigen::Index i = 0; i < now.p_B.cols(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double scale = px_per_m(plane_at(vision.workplane, seen[k].z), now.p_B.col(i));
    farthest = std::max(farthest, (now.p_B.col(i) - then.p_B.col(i)).norm());
    allowed = std::max(allowed, kSigmas * per_axis(own_px2[k]) / scale);
  }
  if (farthest > allowed)
    motion.moved = fmt::format(
        "the work{} has moved since it was found, by {:.3f} mm, and turned by {:.3f} deg; its "
        "marks moved by up to {:.3f} mm, where {:.3f} mm would be noise",
        work.id.empty() ? "" : " " + work.id, mm(motion.shift.norm()), motion.turn / kDegree,
        mm(farthest), mm(allowed));
  return motion;
}

}  // namespace planar

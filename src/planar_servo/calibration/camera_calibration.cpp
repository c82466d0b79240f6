#include "planar_servo/calibration/camera_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/threads.h"
#include "planar_servo/calibration/board.h"
#include "planar_servo/calibration/camera/lens_fit.h"
#include "planar_servo/geometry/lens/workplane.h"

namespace planar {
namespace {

constexpr std::size_t kFewestViews = 3;
constexpr std::size_t kFolds = 5;
/// A view is left out when its rms is this many times the median of all views' ...
constexpr double kOutlyingView = 3.0;
/// ... and more than any detector's own error.
constexpr double kDetectorError_px = 0.05;
constexpr int kEccentricityRounds = 2;

constexpr char kAuto[] = "auto";

/// A focal length or a coordinate of the principal point counts as unknown when its standard
/// deviation exceeds this share of the focal length.
constexpr double kMostUncertain = 0.1;

const CalibrationModel& model_named(const std::string& name, const CalibrationModels& models) {
  return *std::find_if(models.begin(), models.end(),
                       [&](const CalibrationModel& model) { return model.name == name; });
}

bool is_fitted_by_visp(const CalibrationModel& model) {
  return model.sample.as<VispModel>() != nullptr;
}

[[noreturn]] void refuse(const CalibrationModel& model) {
  throw WorkError({"the views do not determine a camera of the model " + model.name,
                   "take more of them, tilted in different directions, or use a simpler model", "",
                   Cause::kInsufficient});
}

/// Returns how uncertain fx, fy, cx, cy and the distortion coefficients that are estimated are,
/// from the fit's residuals and Jacobian, with the poses eliminated by their Schur complement, and
/// from the scatter over views. Throws WorkError when the views do not determine the camera: when
/// some combination of its parameters can change without any effect, or when a focal length or the
/// principal point is uncertain by a tenth of the focal length.
CameraUncertainty uncertainty_of(const LensFit& fit, const std::vector<CalibrationView>& views,
                                 const CalibrationModel& model) {
  constexpr std::size_t kCoefficientsOfVisp = 1;
  const bool by_visp = is_fitted_by_visp(model);
  const auto information =
      fit_information(fit, views, by_visp ? kCoefficientsOfVisp : model.free_coefficients);
  if (!information) refuse(model);
  const auto covariance =
      by_visp ? visp_covariance(fit, views) : covariance_from(information->jacobians);
  if (!covariance) refuse(model);
  CameraUncertainty uncertainty{*covariance * (information->squares / information->freedom),
                                scatter_over_views(*information)};
  const Eigen::VectorXd sigma = deviations(uncertainty, fit.camera);
  const Intrinsics k = intrinsics(fit.camera);
  if (!sigma.allFinite() || sigma.head<4>().maxCoeff() > kMostUncertain * std::min(k.fx, k.fy))
    refuse(model);
  return uncertainty;
}

void check(const CalibrationProblem& problem, const CalibrationModels& models) {
  const std::vector<std::string> names = calibration_model_names(models);
  if (std::find(names.begin(), names.end(), problem.model) == names.end())
    throw InputError({"unknown camera model '" + problem.model + "'",
                      fmt::format("allowed are {}", fmt::join(names, ", "))});
  Faults faults;
  for (const CalibrationView& view : problem.views) {
    const std::size_t dots = view.dot_areas_px2.size();
    if (view.points_G.size() != view.pixels.size() || (dots != 0 && dots != view.pixels.size())) {
      faults.add({"the numbers of points, pixels and dots differ", "", view.name});
    } else if (view.pixels.size() < 6) {
      faults.add({std::to_string(view.pixels.size()) + " points", "at least 6 are needed",
                  view.name, Cause::kInsufficient});
    }
    for (std::size_t i = 0; i < std::min(view.points_G.size(), view.pixels.size()); ++i) {
      if (!view.points_G[i].allFinite() || !view.pixels[i].allFinite()) {
        faults.add({"a number that is not finite", "", view.name});
        break;
      }
    }
  }
  faults.throw_if_any();
}

/// The state of one calibration: the views in use, and the fit to them.
class Calibrator {
 public:
  Calibrator(const CalibrationProblem& problem, const CalibrationModel& model,
             const std::vector<Rejection>& rejected)
      : views_(problem.views), problem_(problem), model_(model), rejected_(rejected) {
    fit();
    reject_outlying_views();
    correct_eccentricity();
  }

  /// Throws WorkError unless the fit has converged and determines the camera.
  CameraUncertainty uncertainty() const {
    if (!lens_.converged)
      throw WorkError({"the fit of a camera of the model " + model_.name + " did not converge",
                       "take more views, tilted in different directions, or use a simpler model",
                       "", Cause::kInsufficient});
    return uncertainty_of(lens_, views_, model_);
  }

  const std::vector<CalibrationView>& views() const { return views_; }
  const LensFit& lens() const { return lens_; }
  const std::vector<Rejection>& rejected() const { return rejected_; }
  double dot_diameter() const { return dot_diameter_; }

  /// Returns the mean square distance in each view when the camera was fitted without it; empty
  /// when such a fit failed.
  std::optional<std::vector<double>> held_out_squares() const {
    const std::size_t folds = std::min(kFolds, views_.size());
    std::vector<double> squares(views_.size(), 0.0);
    for (std::size_t fold = 0; fold < folds; ++fold) {
      std::vector<CalibrationView> used;
      for (std::size_t i = 0; i < views_.size(); ++i)
        if (i % folds != fold) used.push_back(views_[i]);
      const auto lens = fit_to(used);
      if (!lens) return std::nullopt;
      for (std::size_t i = fold; i < views_.size(); i += folds) {
        const auto pose = estimate_board_pose(lens->camera, views_[i].points_G, views_[i].pixels);
        if (!pose) return std::nullopt;
        squares[i] = pose->rms_px * pose->rms_px;
      }
    }
    return squares;
  }

 private:
  std::optional<LensFit> fit_to(const std::vector<CalibrationView>& views) const {
    return is_fitted_by_visp(model_)
               ? fit_by_visp(views, problem_.width_px, problem_.height_px)
               : fit_by_bundle(views, problem_.width_px, problem_.height_px, model_);
  }

  void fit() {
    if (views_.size() < kFewestViews) {
      std::vector<Refusal> refusals{{fmt::format("{} usable views of the board", views_.size()),
                                     fmt::format("at least {} are needed", kFewestViews), "",
                                     Cause::kInsufficient}};
      for (const auto& [name, reason] : rejected_)
        refusals.push_back({reason, "", name, Cause::kInsufficient});
      throw InputError(refusals, 0);
    }
    auto lens = fit_to(views_);
    if (!lens)
      throw WorkError({"the fit of a camera of the model " + model_.name + " failed",
                       "take more views, tilted in different directions, or use a simpler model",
                       "", Cause::kInsufficient});
    lens_ = std::move(*lens);
  }

  void reject_outlying_views() {
    for (;;) {
      const auto& rms = lens_.view_rms_px;
      const auto worst = std::max_element(rms.begin(), rms.end());
      const double limit = std::max(kDetectorError_px, kOutlyingView * median(rms));
      if (*worst <= limit) return;
      const auto index = worst - rms.begin();
      rejected_.push_back({views_[index].name, "its points lie " + std::to_string(*worst) +
                                                   " px rms off, more than " +
                                                   std::to_string(limit) + " px"});
      views_.erase(views_.begin() + index);
      fit();
    }
  }

  void correct_eccentricity() {
    const std::vector<CalibrationView> measured = views_;
    for (int round = 0; round < kEccentricityRounds; ++round) {
      std::vector<double> diameters;
      for_each_dot(measured, [&](std::size_t view, std::size_t i) {
        const auto diameter =
            disc_diameter(lens_.camera, lens_.X_CG[view], measured[view].points_G[i],
                          measured[view].dot_areas_px2[i]);
        if (diameter) diameters.push_back(*diameter);
      });
      if (diameters.empty()) return;
      dot_diameter_ = median(diameters);
      for_each_dot(measured, [&](std::size_t view, std::size_t i) {
        const auto shift = eccentricity_px(lens_.camera, lens_.X_CG[view],
                                           measured[view].points_G[i], dot_diameter_);
        if (shift) views_[view].pixels[i] = measured[view].pixels[i] - *shift;
      });
      fit();
    }
  }

  template <typename Action>
  static void for_each_dot(const std::vector<CalibrationView>& views, const Action& action) {
    for (std::size_t view = 0; view < views.size(); ++view) {
      for (std::size_t i = 0; i < views[view].dot_areas_px2.size(); ++i) action(view, i);
    }
  }

  std::vector<CalibrationView> views_;
  const CalibrationProblem& problem_;
  const CalibrationModel& model_;
  std::vector<Rejection> rejected_;
  LensFit lens_;
  double dot_diameter_{0.0};
};

/// Within the first of these numbers of standard errors a model counts as good as the best; beyond
/// the second it is ruled out.
constexpr double kTakenFor = 1.0, kRuledOut = 2.0;

/// Returns whether a model's held-out squares exceed the best model's by more than so many standard
/// errors of the mean difference, taken view by view.
bool clearly_worse(const std::vector<double>& squares, const std::vector<double>& best,
                   double standard_errors) {
  std::vector<double> excess(best.size());
  for (std::size_t i = 0; i < best.size(); ++i) excess[i] = squares[i] - best[i];
  const double root_n = std::sqrt(static_cast<double>(best.size()));
  return mean(excess) > standard_errors * standard_deviation(excess) / root_n;
}

/// The model that `auto` chose, and the cameras of others that predict held-out views as well: the
/// views do not tell which lens it is.
struct ChosenModel {
  std::string name;
  std::vector<CameraModel> as_good{};
};

ChosenModel choose_model(const CalibrationProblem& problem, const std::vector<Rejection>& rejected,
                         const CalibrationModels& models) {
  // Views are judged once, by a model that fits most lenses, so that all models are compared on the
  // same ones.
  CalibrationProblem common = problem;
  common.views = Calibrator(problem, model_named("plumb_bob", models), rejected).views();
  for (CalibrationView& view : common.views) view.dot_areas_px2.clear();  // eccentricity is off
  struct Candidate {
    std::string model;
    std::vector<double> squares;
    CameraModel camera;
  };
  std::vector<const CalibrationModel*> tried;
  for (const CalibrationModel& model : models)
    if (model.auto_order > 0) tried.push_back(&model);
  std::sort(tried.begin(), tried.end(), [](const CalibrationModel* a, const CalibrationModel* b) {
    return a->auto_order < b->auto_order;
  });
  std::vector<std::optional<Candidate>> fitted(tried.size());
  parallel_for(
      tried.size(), static_cast<unsigned>(tried.size()), [] { return 0; },
      [&](std::size_t i, int) {
        // The richest model takes longest and is begun first.
        const std::size_t k = tried.size() - 1 - i;
        try {
          const Calibrator calibrator(common, *tried[k], {});
          calibrator.uncertainty();
          auto squares = calibrator.held_out_squares();
          if (squares && squares->size() == common.views.size())
            fitted[k] = {tried[k]->name, std::move(*squares), calibrator.lens().camera};
        } catch (const WorkError&) {
          return;  // these views do not determine this model
        }
      });
  std::vector<Candidate> candidates;
  for (std::optional<Candidate>& candidate : fitted)
    if (candidate) candidates.push_back(std::move(*candidate));
  if (candidates.empty())
    throw WorkError(Refusal{"the views determine no camera, whatever the model",
                            "take more of them, tilted in different directions", "",
                            Cause::kInsufficient});
  const auto best = std::min_element(
      candidates.begin(), candidates.end(),
      [](const Candidate& a, const Candidate& b) { return mean(a.squares) < mean(b.squares); });
  const auto simplest =
      std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& candidate) {
        return !clearly_worse(candidate.squares, best->squares, kTakenFor);
      });
  ChosenModel chosen{simplest->model};
  for (const Candidate& candidate : candidates)
    if (candidate.model != chosen.name &&
        !clearly_worse(candidate.squares, best->squares, kRuledOut))
      chosen.as_good.push_back(candidate.camera);
  return chosen;
}

void describe_views(const Calibrator& calibrator, CameraCalibration& result) {
  double squares = 0.0;
  double points = 0.0;
  for (std::size_t i = 0; i < calibrator.views().size(); ++i) {
    const CalibrationView& view = calibrator.views()[i];
    const double rms_px = calibrator.lens().view_rms_px[i];
    const Pose& X_CG = calibrator.lens().X_CG[i];
    result.views.push_back(
        {view.name, X_CG, rms_px, view.pixels,
         board_residuals(result.camera, X_CG, view.points_G, view.pixels).value()});
    squares += rms_px * rms_px * static_cast<double>(view.pixels.size());
    points += static_cast<double>(view.pixels.size());
  }
  result.rms_px = std::sqrt(squares / points);
}

std::vector<Eigen::Vector2d> pixels_of(const std::vector<CalibratedView>& views) {
  std::vector<Eigen::Vector2d> pixels;
  for (const CalibratedView& view : views)
    pixels.insert(pixels.end(), view.pixels.begin(), view.pixels.end());
  return pixels;
}

double median_distance(const CameraCalibration& calibration) {
  std::vector<double> distances;
  for (const CalibratedView& view : calibration.views)
    distances.push_back(view.X_CG.translation().z());
  return median(distances);
}

void judge_held_out(const Calibrator& calibrator, CameraCalibration& result) {
  const auto squares = calibrator.held_out_squares();
  if (!squares) return;
  const Intrinsics k = intrinsics(result.camera);
  result.held_out_rms_px = std::sqrt(mean(*squares));
  result.expected_error =
      *result.held_out_rms_px * median_distance(result) / std::sqrt(k.fx * k.fy);
}

}  // namespace

std::vector<std::string> calibration_model_names(const CalibrationModels& models) {
  std::vector<std::string> names;
  for (const CalibrationModel& model : models) names.push_back(model.name);
  names.emplace_back(kAuto);
  return names;
}

CameraCalibration calibrate_camera(const CalibrationProblem& problem,
                                   const std::vector<Rejection>& without_board,
                                   const CalibrationModels& models) {
  check(problem, models);
  CalibrationProblem distinct = problem;
  std::vector<Rejection> rejected = without_board;
  drop_repeated_views(distinct.views, rejected);
  CameraCalibration result;
  const ChosenModel chosen = problem.model == kAuto ? choose_model(distinct, rejected, models)
                                                    : ChosenModel{problem.model};
  result.model = chosen.name;
  result.is_auto = problem.model == kAuto;
  const CalibrationModel& model = model_named(result.model, models);
  const Calibrator calibrator(distinct, model, rejected);
  result.camera = calibrator.lens().camera;
  result.width_px = problem.width_px;
  result.height_px = problem.height_px;
  CameraUncertainty uncertainty = calibrator.uncertainty();
  uncertainty.as_good = chosen.as_good;
  if (!is_fitted_by_visp(model))  // which minimises other squares
    uncertainty.traded_off =
        traded_off(calibrator.lens(), calibrator.views(), model.free_coefficients);
  const Eigen::VectorXd sigma = deviations(uncertainty, result.camera);
  result.standard_deviations.assign(sigma.begin(), sigma.end());
  result.standard_deviations.resize(4 + distortion_coefficients(result.camera).size(), 0.0);
  result.rejected = calibrator.rejected();
  result.dot_diameter = calibrator.dot_diameter();
  describe_views(calibrator, result);
  if (problem.leaves_views_out) judge_held_out(calibrator, result);
  result.plane_error =
      plane_error(result.camera, uncertainty, pixels_of(result.views), median_distance(result));
  return result;
}

}  // namespace planar

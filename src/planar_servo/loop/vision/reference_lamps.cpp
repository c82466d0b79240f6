#include "planar_servo/loop/vision/reference_lamps.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/lamps/lamp_center.h"

namespace planar {
namespace {

using Design = Eigen::Matrix<double, 2, 6>;

constexpr std::size_t kLeastForAffine = 4;  // three leave no residual
constexpr double kLeastRcond = 1e-14;       // of normal equations in scaled unknowns

/// Returns d(now) / dp at a place of then.
Design design_at(const Eigen::Vector2d& r) {
  Design J = Design::Zero();
  J.leftCols<2>().setIdentity();
  J.block<1, 2>(0, 2) = r.transpose();
  J.block<1, 2>(1, 4) = r.transpose();
  return J;
}

/// Returns dp / dq for q = (t_u, t_v, scale, turn), M = scale I + turn [[0, -1], [1, 0]].
Eigen::MatrixXd similarity_basis() {
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(6, 4);
  basis(0, 0) = basis(1, 1) = 1.0;
  basis(2, 2) = basis(5, 2) = 1.0;
  basis(3, 3) = -1.0;
  basis(4, 3) = 1.0;
  return basis;
}

/// Returns the length of the farthest place, by which the unknowns of M are scaled.
double reach_px(const std::vector<LampMove>& moves) {
  double reach = 1.0;
  for (const LampMove& move : moves) reach = std::max(reach, move.then_px.norm());
  return reach;
}

/// Fits p = basis q. The first two unknowns of q are the shift.
std::optional<MotionFit> fit_motion(const std::vector<LampMove>& moves, Eigen::MatrixXd basis) {
  const auto n = static_cast<Eigen::Index>(moves.size()), unknowns = basis.cols();
  if (2 * n < unknowns) return std::nullopt;
  basis.rightCols(unknowns - 2) /= reach_px(moves);
  Eigen::MatrixXd N = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(unknowns);
  for (const LampMove& move : moves) {
    const Eigen::MatrixXd A = design_at(move.then_px) * basis;
    const Eigen::MatrixXd weighted = A.transpose() * move.covariance_px2.inverse();
    N += weighted * A;
    rhs += weighted * (move.now_px - move.then_px);
  }
  const auto cofactors =
      solve_positive(N, Eigen::MatrixXd::Identity(unknowns, unknowns), kLeastRcond);
  if (!cofactors) return std::nullopt;
  MotionFit result;
  result.motion = {basis * *cofactors * rhs, basis * *cofactors * basis.transpose()};
  for (const LampMove& move : moves) {
    const Eigen::Vector2d residual = move.now_px - result.motion.now(move.then_px);
    result.residuals_px.push_back(residual);
    result.chi2 += residual.dot(move.covariance_px2.inverse() * residual);
  }
  result.freedom = static_cast<int>(2 * n - unknowns);
  return result;
}

/// Half the side of the window searched for a lamp, round its last place: two diameters of 30 px.
constexpr int kHalfWindow_px = 64;
/// With fewer, a knocked lamp cannot be told from a camera that moved.
constexpr std::size_t kLeastLamps = 3;
/// With so many, the others still check one another when one is left out.
constexpr std::size_t kLeastToLeaveOut = 5;

cv::Rect window_round(const Eigen::Vector2d& place_px) {
  return {static_cast<int>(std::lround(place_px.x())) - kHalfWindow_px,
          static_cast<int>(std::lround(place_px.y())) - kHalfWindow_px, 2 * kHalfWindow_px,
          2 * kHalfWindow_px};
}

std::vector<LampMove> moves_without(const std::vector<LampMove>& moves, std::size_t left_out) {
  std::vector<LampMove> others = moves;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(left_out));
  return others;
}

double farthest_px(const MotionFit& fit) {
  double farthest = 0.0;
  for (const Eigen::Vector2d& residual : fit.residuals_px)
    farthest = std::max(farthest, residual.norm());
  return farthest;
}

/// Returns the move without which the others hold; of several the one they contradict most.
std::optional<std::size_t> odd_one(const std::vector<LampMove>& moves) {
  std::optional<std::size_t> odd;
  double least = 0.0;
  if (moves.size() < kLeastToLeaveOut) return odd;
  for (std::size_t i = 0; i < moves.size(); ++i) {
    const auto fit = fit_image_motion(moves_without(moves, i));
    if (!fit || !fit->holds() || (odd && fit->chi2 >= least)) continue;
    odd = i;
    least = fit->chi2;
  }
  return odd;
}

}  // namespace

Eigen::Vector2d ImageMotion::now(const Eigen::Vector2d& then_px) const {
  return then_px + design_at(then_px) * p_;
}

Eigen::Vector2d ImageMotion::then(const Eigen::Vector2d& now_px) const {
  Eigen::Matrix2d A;
  A << 1.0 + p_[2], p_[3], p_[4], 1.0 + p_[5];
  return A.inverse() * (now_px - p_.head<2>());
}

Eigen::Matrix2d ImageMotion::covariance_px2(const Eigen::Vector2d& then_px) const {
  const Design J = design_at(then_px);
  return J * covariance_ * J.transpose();
}

ImageMotion ImageMotion::towards(const ImageMotion& other, double part) const {
  const double rest = 1.0 - part;
  return {rest * p_ + part * other.p_, rest * rest * covariance_ + part * part * other.covariance_};
}

bool MotionFit::holds() const {
  return chi2 <= greatest_chi2(freedom);
}

std::optional<MotionFit> fit_similarity(const std::vector<LampMove>& moves) {
  return fit_motion(moves, similarity_basis());
}

std::optional<MotionFit> fit_affine(const std::vector<LampMove>& moves) {
  return fit_motion(moves, Eigen::MatrixXd::Identity(6, 6));
}

std::optional<MotionFit> fit_image_motion(const std::vector<LampMove>& moves) {
  auto similarity = fit_similarity(moves);
  if (!similarity || similarity->holds() || moves.size() < kLeastForAffine) return similarity;
  auto affine = fit_affine(moves);
  return affine && affine->holds() ? affine : similarity;
}

double greatest_chi2(int freedom) {
  if (freedom == 0) return std::numeric_limits<double>::infinity();
  const double part = 2.0 / (9.0 * freedom);
  return freedom * std::pow(1.0 - part + kMotionSigmas * std::sqrt(part), 3);
}

std::vector<Eigen::Vector2d> places_px(const std::vector<ReferenceLamp>& lamps) {
  std::vector<Eigen::Vector2d> places;
  places.reserve(lamps.size());
  for (const ReferenceLamp& lamp : lamps) places.push_back(lamp.uv_px);
  return places;
}

std::optional<LampCenter> find_fixed_light(const Frame& frame, const Eigen::Vector2d& place_px,
                                           LampDetector& detector, CenterMethod method) {
  const Eigen::Vector2d corner(frame.region_px.x, frame.region_px.y);
  const Eigen::Vector2d place = place_px - corner;
  const std::vector<Blob>& blobs = detector.detect(frame.image, window_round(place));
  const auto distance = [&](const Blob& blob) { return (blob.uv_px - place).squaredNorm(); };
  const auto nearest =
      std::min_element(blobs.begin(), blobs.end(),
                       [&](const Blob& a, const Blob& b) { return distance(a) < distance(b); });
  if (nearest == blobs.end()) return std::nullopt;
  LampCenter center = measure_lamp(frame.image, *nearest, method);
  if (center.status != LampStatus::kOk) return std::nullopt;
  center.uv_px += corner;
  return center;
}

cv::Mat ReferenceWatch::without_lamps(const cv::Mat& image) const {
  if (lamps_.empty()) return image;
  cv::Mat blackened = image.clone();
  const cv::Rect whole({}, image.size());
  for (const ReferenceLamp& lamp : lamps_)
    blackened(window_round(motion_.now(lamp.uv_px)) & whole).setTo(0);
  return blackened;
}

bool ReferenceWatch::is_due(double t_s) const {
  if (lamps_.empty()) return false;
  return !looked_s_ || objection_ || t_s - *looked_s_ >= kReferencePeriod_s;
}

void ReferenceWatch::look(const Frame& frame) {
  if (lamps_.empty()) return;
  looked_s_ = frame.t_s;
  const std::vector<Sight> sights = find(frame);
  if (sights.size() < kLeastLamps) {
    objection_ = {fmt::format("{} of {} reference lamps are seen, fewer than {}", sights.size(),
                              lamps_.size(), kLeastLamps),
                  "uncover them, or calibrate again if the camera was moved", "",
                  Cause::kInsufficient};
    return;
  }
  take_motion(sights);
}

std::vector<ReferenceWatch::Sight> ReferenceWatch::find(const Frame& frame) {
  std::vector<Sight> sights;
  for (std::size_t i = 0; i < lamps_.size(); ++i) {
    const ReferenceLamp& lamp = lamps_[i];
    const auto center = find_fixed_light(frame, motion_.now(lamp.uv_px), detector_, method_);
    if (!center) continue;
    const Eigen::Matrix2d then_px2 = lamp.sigma_px * lamp.sigma_px * Eigen::Matrix2d::Identity();
    sights.push_back({i, {lamp.uv_px, center->uv_px, center->covariance_px2 + then_px2}});
  }
  return sights;
}

void ReferenceWatch::take_motion(const std::vector<Sight>& sights) {
  std::vector<LampMove> moves;
  moves.reserve(sights.size());
  for (const Sight& sight : sights) moves.push_back(sight.move);
  auto fit = fit_image_motion(moves);
  if (fit && !fit->holds()) {
    if (const auto odd = odd_one(moves)) {
      fit = fit_image_motion(moves_without(moves, *odd));
      const LampMove& move = moves[*odd];
      name_knocked(lamps_[sights[*odd].lamp], {fit->motion.now(move.then_px), move.now_px, {}});
    }
  }
  if (!fit || !fit->holds()) {
    objection_ = {
        fmt::format("the reference lamps disagree by up to {:.3f} px, more than noise explains",
                    fit ? farthest_px(*fit) : 0.0),
        "lens or lamps have moved and the calibration is void: record and calibrate again", "",
        Cause::kContradiction};
    return;
  }
  motion_ = fit->motion;
  objection_.reset();
  spdlog::debug(fmt::format("reference lamps: {} seen, chi squared {:.1f} of {}, up to {:.4f} px",
                            sights.size(), fit->chi2, fit->freedom, farthest_px(*fit)));
}

void ReferenceWatch::name_knocked(const ReferenceLamp& lamp, const LampMove& move) {
  if (knocked_ == lamp.id) return;
  knocked_ = lamp.id;
  spdlog::warn(fmt::format(
      "reference lamp {} is {:.3f} px from where the others predict it and is left out; was it "
      "knocked?",
      lamp.id, (move.now_px - move.then_px).norm()));
}

}  // namespace planar

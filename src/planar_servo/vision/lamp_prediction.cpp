#include "planar_servo/vision/lamp_prediction.h"

namespace planar {
namespace {

/// A coarse view, which has no lens model, is good to several per cent.
constexpr double kCoarseShare = 0.10;

}  // namespace

LampPrediction::LampPrediction(const LampScene& scene, std::optional<CoarseView> view)
    : scene_(scene), view_(std::move(view)) {}

std::optional<PairExpectation> LampPrediction::by_view(const TipPose& commanded) const {
  if (!view_) return std::nullopt;
  const Eigen::Vector2d half =
      rotation2d(commanded.phi) * Eigen::Vector2d(scene_.lamps.separation_m / 2.0, 0.0);
  const auto first = view_->pixel(commanded.p - half), second = view_->pixel(commanded.p + half);
  if (!first || !second) return std::nullopt;
  return expect_lamps(scene_.lamps, {*first, *second}, kCoarseShare);
}

PairExpectation LampPrediction::of(const std::optional<TipPose>& commanded) const {
  std::optional<PairExpectation> expectation;
  if (commanded)
    expectation = scene_.vision ? expect_tool(*scene_.vision, *commanded) : by_view(*commanded);
  if (!expectation) {
    expectation.emplace();
    expectation->diameter_over_separation = scene_.lamps.diameter_over_separation();
  }
  expectation->fixed_px = scene_.fixed_px;
  return *expectation;
}

}  // namespace planar

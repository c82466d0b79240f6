#include "planar_servo/experiment/plots/plot_data.h"

#include <algorithm>
#include <map>
#include <optional>

#include "planar_servo/experiment/paper_tables.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/lamps/lamp_detector.h"
#include "planar_servo/offline/grey_image.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"

namespace planar {
namespace {

constexpr int kAboutLamp_px = 6;  // shown beyond a lamp's box

struct SeenFrame {
  const FrameRow* frame{nullptr};
  LampRow lamps;
};

/// Returns the smallest image of a check place that shows both lamps, the first of several.
std::optional<SeenFrame> frame_to_show(const std::vector<FrameRow>& frames,
                                       std::vector<LampRow> lamps) {
  std::map<std::string, const FrameRow*> by_image;
  for (const FrameRow& frame : frames)
    if (frame.plan == Purpose::kCheck) by_image.emplace(frame.image, &frame);
  std::optional<SeenFrame> best;
  for (LampRow& row : lamps) {
    const auto frame = by_image.find(row.image);
    if (frame == by_image.end() || row.status != LampStatus::kOk || row.uv_px.size() != 2) continue;
    if (best && frame->second->region_px.area() >= best->frame->region_px.area()) continue;
    best = SeenFrame{frame->second, std::move(row)};
  }
  return best;
}

/// Measures the lamp nearest to `uv_px` (sensor) as the paper does.
std::optional<LampEdges> edges_of(const cv::Mat& image, const std::vector<Blob>& blobs,
                                  const FrameRow& frame, const Eigen::Vector2d& uv_px) {
  const Eigen::Vector2d origin(frame.region_px.x, frame.region_px.y);
  const auto distance = [&](const Blob& blob) { return (blob.uv_px + origin - uv_px).norm(); };
  const auto blob = std::min_element(blobs.begin(), blobs.end(), [&](const Blob& a, const Blob& b) {
    return distance(a) < distance(b);
  });
  if (blob == blobs.end()) return std::nullopt;
  LampEdges lamp;
  lamp.image = frame.image;
  lamp.edges_px = canny_edges(image, *blob);
  const std::optional<Circle> circle = kasa_circle(lamp.edges_px);
  if (!circle) return std::nullopt;
  const cv::Rect about(blob->box_px.tl() - cv::Point(kAboutLamp_px, kAboutLamp_px),
                       blob->box_px.size() + cv::Size(2 * kAboutLamp_px, 2 * kAboutLamp_px));
  const cv::Rect part = about & cv::Rect({}, image.size());
  lamp.grey = image(part).clone();
  lamp.origin_px = part.tl() + frame.region_px.tl();
  lamp.circle = {circle->center + origin, circle->radius};
  for (Eigen::Vector2d& edge : lamp.edges_px) edge += origin;
  return lamp;
}

std::vector<LampEdges> lamp_edges(const CalibratedChain& paper, const RecordedCell& recording) {
  const auto shown = frame_to_show(recording.frames, read_lamps(paper.folder / "lamps.csv"));
  if (!shown) return {};
  const cv::Mat image = read_grey_image(recording.folder / shown->frame->image);
  if (image.empty()) return {};
  LampDetector detector;
  const std::vector<Blob>& blobs = detector.detect(image);
  std::vector<LampEdges> lamps;
  for (const Eigen::Vector2d& uv_px : shown->lamps.uv_px)
    if (auto lamp = edges_of(image, blobs, *shown->frame, uv_px)) lamps.push_back(std::move(*lamp));
  return lamps;
}

}  // namespace

PlotData plot_data(const CalibratedChain& paper, const ExperimentPlan& plan,
                   const RecordedCell& recording) {
  PlotData data{lamp_edges(paper, recording),
                {},
                {},
                {},
                fit_error_map_to_pairs(paper.pairs, {MapMethod::kIdw, 0.0}).result.map,
                paper.map.value().map};
  std::map<std::string, Eigen::Vector2d> planned;
  for (const PlanRow& row : plan.rows)
    if (const auto* tip = std::get_if<TipPose>(&row.where)) planned.emplace(row.id, tip->p);
  const PairsOnCircles pairs(paper.pairs, plan.circle_points);
  for (const CirclePoint& point : plan.circle_points) {
    const PairRow* pair = pairs.pair_at(point);
    if (!pair) continue;
    if (point.run > 0)
      data.circles.push_back({point.radius_mm, point.run, point.index, planned.at(point.id),
                              pair->p_vision, pair->p_tracker.value()});
    else
      data.checks.push_back({point.radius_mm, point.index, pair->p_vision, pair->error(),
                             predict_error(data.idw, pair->p_vision, pair->phi),
                             predict_error(data.rbf, pair->p_vision, pair->phi)});
  }
  for (const PairRow& pair : paper.pairs)
    if (pair.plan == Purpose::kTrain && pair.is_attended()) data.training.push_back(pair);
  return data;
}

}  // namespace planar

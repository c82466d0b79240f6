#include "planar_servo/report/view_picture.h"

#include <fmt/format.h>
#include <visp3/core/vpImageDraw.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr unsigned kRing = 26;  // radius about a lamp
constexpr unsigned kTextHeight = 15;
constexpr double kTextRise = 4.0;  // baseline below the top of a line of text
const cv::Rect2d kFramePanel(16, 48, 512, 512);
const cv::Rect2d kTargetPanel(560, 72, 230, 230);
const cv::Rect2d kStepsPanel(624, 350, 352, 190);

const vpColor kInk(230, 230, 230);
const vpColor kFaint(110, 110, 110);
const vpColor kSeen(60, 220, 90);
const vpColor kWanted(255, 150, 40);
const vpColor kAlarm(255, 80, 80);
const vpRGBa kPaper(24, 26, 30);

// Errors are drawn between these limits, on a logarithmic scale.
constexpr double kLeastError_mm = 1e-4;
constexpr double kMostError_mm = 10.0;
constexpr int kDecades = 5;

/// Returns 0 at the least error and 1 at the most.
double share_of_scale(double error_m) {
  const double error_mm = std::clamp(error_m / kMillimetre, kLeastError_mm, kMostError_mm);
  return std::log10(error_mm / kLeastError_mm) / kDecades;
}

vpImagePoint point(double x, double y) {
  return {y, x};
}

void frame_panel(vpImage<vpRGBa>& picture, const cv::Rect2d& panel) {
  vpImageDraw::drawRectangle(picture, vpRect(panel.x, panel.y, panel.width, panel.height), kFaint);
}

}  // namespace

ViewPainter::ViewPainter() : font_(kTextHeight, vpFont::GENERIC_MONOSPACE) {}

void ViewPainter::paint(const ServoView& view, vpImage<vpRGBa>& picture) const {
  picture.resize(kViewHeight, kViewWidth, kPaper);
  write(picture, kFramePanel.x, 16, view.title, view.measured ? kInk : kAlarm);
  paint_frame(view, picture);
  paint_target(view, picture);
  paint_steps(view, picture);
}

void ViewPainter::write(vpImage<vpRGBa>& picture, double x, double y, const std::string& text,
                        const vpColor& color) const {
  font_.drawText(picture, text, point(x, y - kTextRise), color);
}

void ViewPainter::paint_frame(const ServoView& view, vpImage<vpRGBa>& picture) const {
  frame_panel(picture, kFramePanel);
  const cv::Size size = view.frame.image.size();
  if (size.empty()) return;
  const double scale = kFramePanel.width / std::max(size.width, size.height);
  cv::Mat shown;
  cv::resize(view.frame.image, shown, {}, scale, scale, cv::INTER_AREA);
  for (int row = 0; row < shown.rows; ++row)
    for (int column = 0; column < shown.cols; ++column) {
      const unsigned char grey = shown.at<unsigned char>(row, column);
      picture[static_cast<unsigned>(kFramePanel.y + row)]
             [static_cast<unsigned>(kFramePanel.x + column)] = vpRGBa(grey, grey, grey);
    }
  const auto mark = [&](const std::vector<Eigen::Vector2d>& pixels, const auto& draw) {
    for (const Eigen::Vector2d& uv : pixels) {
      const Eigen::Vector2d at(scale * (uv.x() - view.frame.region_px.x + 0.5),
                               scale * (uv.y() - view.frame.region_px.y + 0.5));
      if (at.minCoeff() >= 0.0 && at.maxCoeff() < kFramePanel.width)
        draw(point(kFramePanel.x + at.x(), kFramePanel.y + at.y()));
    }
  };
  mark(view.wanted_px,
       [&](const vpImagePoint& at) { vpImageDraw::drawCircle(picture, at, kRing, kWanted); });
  mark(view.lamps_px,
       [&](const vpImagePoint& at) { vpImageDraw::drawCross(picture, at, 13, kSeen, 1); });
}

void ViewPainter::paint_target(const ServoView& view, vpImage<vpRGBa>& picture) const {
  const double radius = kTargetPanel.width / 2.0;
  const double x = kTargetPanel.x + radius;
  const double y = kTargetPanel.y + radius;
  const auto ring = [&](double error_m, const vpColor& color) {
    vpImageDraw::drawCircle(picture, point(x, y),
                            static_cast<unsigned>(radius * share_of_scale(error_m)), color);
  };
  write(picture, kTargetPanel.x, 48, "end point about the target", kInk);
  for (int decade = 1; decade <= kDecades; ++decade)
    ring(kLeastError_mm * std::pow(10.0, decade) * kMillimetre, kFaint);
  if (view.stop_below_m > 0.0) ring(view.stop_below_m, kSeen);
  std::optional<vpImagePoint> before;
  for (const Eigen::Vector2d& error : view.errors_m) {
    const double length = error.norm();
    const Eigen::Vector2d drawn =
        length > 0.0 ? Eigen::Vector2d(error / length * radius * share_of_scale(length))
                     : Eigen::Vector2d(0.0, 0.0);
    const vpImagePoint at = point(x + drawn.x(), y - drawn.y());
    if (before) vpImageDraw::drawLine(picture, *before, at, kWanted);
    vpImageDraw::drawCross(picture, at, 9, kInk, 2);
    before = at;
  }
  write(picture, kTargetPanel.x + kTargetPanel.width + 12, kTargetPanel.y + 16, "x right, y up",
        kFaint);
  write(picture, kTargetPanel.x + kTargetPanel.width + 12, kTargetPanel.y + 40, "rings: 10, 1,",
        kFaint);
  write(picture, kTargetPanel.x + kTargetPanel.width + 12, kTargetPanel.y + 60, "0.1 ... mm",
        kFaint);
  write(picture, kTargetPanel.x + kTargetPanel.width + 12, kTargetPanel.y + 84, "green: content",
        kSeen);
}

void ViewPainter::paint_steps(const ServoView& view, vpImage<vpRGBa>& picture) const {
  const cv::Rect2d& panel = kStepsPanel;
  write(picture, kTargetPanel.x, panel.y - 24, "error over the steps, mm", kInk);
  frame_panel(picture, panel);
  const auto height = [&](double error_m) {
    return panel.y + panel.height * (1.0 - share_of_scale(error_m));
  };
  for (int decade = 0; decade <= kDecades; ++decade) {
    const double error_mm = kLeastError_mm * std::pow(10.0, decade);
    const double y = height(error_mm * kMillimetre);
    vpImageDraw::drawLine(picture, point(panel.x, y), point(panel.x + panel.width, y), kFaint);
    write(picture, kTargetPanel.x, y - 4, fmt::format("{:g}", error_mm), kFaint);
  }
  if (view.stop_below_m > 0.0)
    vpImageDraw::drawLine(picture, point(panel.x, height(view.stop_below_m)),
                          point(panel.x + panel.width, height(view.stop_below_m)), kSeen);
  const double spacing =
      panel.width / static_cast<double>(std::max<std::size_t>(6, view.errors_m.size() + 1));
  std::optional<vpImagePoint> before;
  for (std::size_t i = 0; i < view.errors_m.size(); ++i) {
    const double x = panel.x + spacing * static_cast<double>(i + 1);
    const vpImagePoint at = point(x, height(view.errors_m[i].norm()));
    if (before) vpImageDraw::drawLine(picture, *before, at, kWanted, 2);
    vpImageDraw::drawCross(picture, at, 9, kInk, 2);
    write(picture, x - 4, panel.y + panel.height + 8, fmt::format("{}", i), kFaint);
    before = at;
  }
}

}  // namespace planar

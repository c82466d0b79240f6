#include "planar_servo/report/live/live_view.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <visp3/core/vpImage.h>
#include <visp3/core/vpImageDraw.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr unsigned kTextHeight = 15;
constexpr double kTextRise = 4.0;  // baseline below the top of a line of text
const vpRGBa kPaper(24, 26, 30);

/// Returns the picture's pixels, not a copy of them.
cv::Mat rgba_of(const vpImage<vpRGBa>& picture) {
  return {static_cast<int>(picture.getHeight()), static_cast<int>(picture.getWidth()), CV_8UC4,
          picture.bitmap};
}

void save(const vpImage<vpRGBa>& picture, const std::filesystem::path& file) {
  std::filesystem::path fresh = file;
  fresh.replace_extension(".new.png");
  cv::Mat bgr;
  cv::cvtColor(rgba_of(picture), bgr, cv::COLOR_RGBA2BGR);
  if (!cv::imwrite(fresh.string(), bgr))
    throw WorkError(fmt::format("{}: cannot be written", fresh.string()), Cause::kSystem);
  std::filesystem::rename(fresh, file);
}

constexpr unsigned kLampRing = 26;  // radius about a lamp
const cv::Rect2d kTargetPanel(560, 72, 230, 230);
const cv::Rect2d kStepsPanel(624, 350, 352, 190);

// Errors are drawn between these limits, on a logarithmic scale.
constexpr double kLeastError_mm = 1e-4;
constexpr double kMostError_mm = 10.0;
constexpr int kDecades = 5;

/// Returns 0 at the least error and 1 at the most.
double share_of_scale(double error_m) {
  const double error_mm = std::clamp(mm(error_m), kLeastError_mm, kMostError_mm);
  return std::log10(error_mm / kLeastError_mm) / kDecades;
}

void draw_frame(const ServoView& view, Canvas& canvas) {
  canvas.frame(kFramePanel);
  const double scale = canvas.show(view.frame.image, kFramePanel);
  if (scale == 0.0) return;
  const auto mark = [&](const std::vector<Eigen::Vector2d>& pixels, const auto& draw) {
    for (const Eigen::Vector2d& uv : pixels) {
      const Eigen::Vector2d at(scale * (uv.x() - view.frame.region_px.x + 0.5),
                               scale * (uv.y() - view.frame.region_px.y + 0.5));
      if (at.minCoeff() >= 0.0 && at.maxCoeff() < kFramePanel.width)
        draw(Canvas::at(kFramePanel.x + at.x(), kFramePanel.y + at.y()));
    }
  };
  mark(view.wanted_px, [&](const vpImagePoint& at) {
    vpImageDraw::drawCircle(canvas.picture(), at, kLampRing, kWanted);
  });
  mark(view.lamps_px,
       [&](const vpImagePoint& at) { vpImageDraw::drawCross(canvas.picture(), at, 13, kSeen, 1); });
}

void draw_target(const ServoView& view, Canvas& canvas) {
  const double radius = kTargetPanel.width / 2.0;
  const double x = kTargetPanel.x + radius;
  const double y = kTargetPanel.y + radius;
  const auto ring = [&](double error_m, const vpColor& color) {
    vpImageDraw::drawCircle(canvas.picture(), Canvas::at(x, y),
                            static_cast<unsigned>(radius * share_of_scale(error_m)), color);
  };
  canvas.write(kTargetPanel.x, 48, "end point about the target", kInk);
  for (int decade = 1; decade <= kDecades; ++decade)
    ring(kLeastError_mm * std::pow(10.0, decade) * kMillimetre, kFaint);
  if (view.stop_below_m > 0.0) ring(view.stop_below_m, kSeen);
  std::optional<vpImagePoint> before;
  for (const Eigen::Vector2d& error : view.errors_m) {
    const double length = error.norm();
    const Eigen::Vector2d drawn =
        length > 0.0 ? Eigen::Vector2d(error / length * radius * share_of_scale(length))
                     : Eigen::Vector2d(0.0, 0.0);
    const vpImagePoint at = Canvas::at(x + drawn.x(), y - drawn.y());
    if (before) vpImageDraw::drawLine(canvas.picture(), *before, at, kWanted);
    vpImageDraw::drawCross(canvas.picture(), at, 9, kInk, 2);
    before = at;
  }
  const double beside = kTargetPanel.x + kTargetPanel.width + 12;
  canvas.write(beside, kTargetPanel.y + 16, "x right, y up", kFaint);
  canvas.write(beside, kTargetPanel.y + 40, "rings: 10, 1,", kFaint);
  canvas.write(beside, kTargetPanel.y + 60, "0.1 ... mm", kFaint);
  canvas.write(beside, kTargetPanel.y + 84, "green: content", kSeen);
}

void draw_steps(const ServoView& view, Canvas& canvas) {
  const cv::Rect2d& panel = kStepsPanel;
  canvas.write(kTargetPanel.x, panel.y - 24, "error over the steps, mm", kInk);
  canvas.frame(panel);
  const auto height = [&](double error_m) {
    return panel.y + panel.height * (1.0 - share_of_scale(error_m));
  };
  for (int decade = 0; decade <= kDecades; ++decade) {
    const double error_mm = kLeastError_mm * std::pow(10.0, decade);
    const double y = height(error_mm * kMillimetre);
    vpImageDraw::drawLine(canvas.picture(), Canvas::at(panel.x, y),
                          Canvas::at(panel.x + panel.width, y), kFaint);
    canvas.write(kTargetPanel.x, y - 4, fmt::format("{:g}", error_mm), kFaint);
  }
  if (view.stop_below_m > 0.0)
    vpImageDraw::drawLine(canvas.picture(), Canvas::at(panel.x, height(view.stop_below_m)),
                          Canvas::at(panel.x + panel.width, height(view.stop_below_m)), kSeen);
  const double spacing =
      panel.width / static_cast<double>(std::max<std::size_t>(6, view.errors_m.size() + 1));
  std::optional<vpImagePoint> before;
  for (std::size_t i = 0; i < view.errors_m.size(); ++i) {
    const double x = panel.x + spacing * static_cast<double>(i + 1);
    const vpImagePoint at = Canvas::at(x, height(view.errors_m[i].norm()));
    if (before) vpImageDraw::drawLine(canvas.picture(), *before, at, kWanted, 2);
    vpImageDraw::drawCross(canvas.picture(), at, 9, kInk, 2);
    canvas.write(x - 4, panel.y + panel.height + 8, fmt::format("{}", i), kFaint);
    before = at;
  }
}

}  // namespace

Canvas::Canvas(vpImage<vpRGBa>& picture)
    : picture_(picture), font_(kTextHeight, vpFont::GENERIC_MONOSPACE) {
  picture_.resize(kViewHeight, kViewWidth, kPaper);
}

void Canvas::write(double x, double y, const std::string& text, const vpColor& color) {
  font_.drawText(picture_, text, Canvas::at(x, y - kTextRise), color);
}

void Canvas::frame(const cv::Rect2d& panel) {
  vpImageDraw::drawRectangle(picture_, vpRect(panel.x, panel.y, panel.width, panel.height), kFaint);
}

double Canvas::show(const cv::Mat& image, const cv::Rect2d& panel) {
  if (image.empty()) return 0.0;
  const double scale = std::min(panel.width / image.cols, panel.height / image.rows);
  cv::Mat shown;
  cv::resize(image, shown, {}, scale, scale, cv::INTER_AREA);
  const cv::Rect place(cv::Point(panel.tl()), shown.size());
  cv::cvtColor(shown, rgba_of(picture_)(place), cv::COLOR_GRAY2RGBA);
  return scale;
}

LiveView::LiveView(std::filesystem::path picture)
    : file_(std::move(picture)), thread_([this] { draw_views(); }) {}

LiveView::~LiveView() {
  close();
}

void LiveView::draw_views() {
  try {
    vpImage<vpRGBa> picture(kViewHeight, kViewWidth);
    while (const ViewPlot draw = wait_for_plot()) {
      draw(picture);
      save(picture, file_);
    }
  } catch (const std::exception& e) {
    failure_ = e.what();
  }
}

ViewPlot LiveView::wait_for_plot() {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [&] { return newest_ || closing_; });
  return std::exchange(newest_, nullptr);
}

void LiveView::show(ViewPlot plot) {
  const std::lock_guard<std::mutex> lock(mutex_);
  newest_ = std::move(plot);
  changed_.notify_one();
}

std::optional<std::string> LiveView::close() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    closing_ = true;
  }
  changed_.notify_one();
  if (thread_.joinable()) thread_.join();
  return failure_;
}

std::unique_ptr<LiveView> open_display(DisplayPolicy policy, const std::filesystem::path& picture) {
  return policy == DisplayPolicy::kNone ? nullptr : std::make_unique<LiveView>(picture);
}

void close_display(LiveView* view) {
  if (view == nullptr) return;
  if (const auto failure = view->close())
    spdlog::warn(fmt::format("the display failed: {}", *failure));
}

ViewPlot plot_of(ServoView view) {
  return [view = std::move(view)](vpImage<vpRGBa>& picture) {
    Canvas canvas(picture);
    canvas.write(kFramePanel.x, 16, view.title, view.measured ? kInk : kAlarm);
    draw_frame(view, canvas);
    draw_target(view, canvas);
    draw_steps(view, canvas);
  };
}

}  // namespace planar

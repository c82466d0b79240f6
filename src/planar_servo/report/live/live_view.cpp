#include "planar_servo/report/live/live_view.h"
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <visp3/core/vpImage.h>
#include <visp3/core/vpImageDraw.h>
#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include "planar_servo/base/core/error.h"

namespace planar {
namespace {

constexpr unsigned kTextHeight = 15;
constexpr double kTextRise = 4.0;  // baseline below the top of a line of text
const vpRGBa kPaper(24, 26, 30);

void save(const vpImage<vpRGBa>& picture, const std::filesystem::path& file) {
  std::filesystem::path fresh = file;
  fresh.replace_extension(".new.png");
  const cv::Mat rgba(static_cast<int>(picture.getHeight()), static_cast<int>(picture.getWidth()),
                     CV_8UC4, picture.bitmap);
  cv::Mat bgr;
  cv::cvtColor(rgba, bgr, cv::COLOR_RGBA2BGR);
  if (!cv::imwrite(fresh.string(), bgr))
    throw WorkError(fmt::format("{}: cannot be written", fresh.string()));
  std::filesystem::rename(fresh, file);
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
  for (int row = 0; row < shown.rows; ++row)
    for (int column = 0; column < shown.cols; ++column) {
      const unsigned char grey = shown.at<unsigned char>(row, column);
      picture_[static_cast<unsigned>(panel.y + row)][static_cast<unsigned>(panel.x + column)] =
          vpRGBa(grey, grey, grey);
    }
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
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    newest_ = std::move(plot);
  }
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

}  // namespace planar

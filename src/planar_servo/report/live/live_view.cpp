#include "planar_servo/report/live/live_view.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <visp3/core/vpImage.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

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

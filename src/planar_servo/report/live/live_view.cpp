#include "planar_servo/report/live/live_view.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <condition_variable>
#include <mutex>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <thread>
#include <utility>

#include "planar_servo/core/error.h"

namespace planar {

struct LiveView::Impl {
  explicit Impl(std::filesystem::path picture)
      : file(std::move(picture)), thread([this] { run(); }) {}

  void run() {
    try {
      draw_views();
    } catch (const std::exception& e) {
      failure = e.what();
    }
  }

  void draw_views() {
    vpImage<vpRGBa> picture(kViewHeight, kViewWidth);
    while (const ViewPlot draw = wait_for_plot()) {
      draw(picture);
      save(picture);
    }
  }

  /// Waits for the next view; empty when there will be none.
  ViewPlot wait_for_plot() {
    std::unique_lock<std::mutex> lock(mutex);
    changed.wait(lock, [&] { return newest || closing; });
    return std::exchange(newest, nullptr);
  }

  void save(const vpImage<vpRGBa>& picture) const {
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

  std::filesystem::path file;
  std::mutex mutex;
  std::condition_variable changed;
  ViewPlot newest;
  bool closing{false};
  std::optional<std::string> failure;  ///< read only after the thread has ended
  std::thread thread;                  ///< declared last, because it uses all other members
};

LiveView::LiveView(std::filesystem::path picture)
    : impl_(std::make_unique<Impl>(std::move(picture))) {}

LiveView::~LiveView() {
  close();
}

void LiveView::show(ViewPlot plot) {
  {
    const std::lock_guard<std::mutex> lock(impl_->mutex);
    impl_->newest = std::move(plot);
  }
  impl_->changed.notify_one();
}

std::optional<std::string> LiveView::close() {
  {
    const std::lock_guard<std::mutex> lock(impl_->mutex);
    impl_->closing = true;
  }
  impl_->changed.notify_one();
  if (impl_->thread.joinable()) impl_->thread.join();
  return impl_->failure;
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

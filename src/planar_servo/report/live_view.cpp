#include "planar_servo/report/live_view.h"

#include <visp3/io/vpImageIo.h>

#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "planar_servo/report/view_picture.h"
#include "planar_servo/report/x_window.h"

namespace planar {

bool x_server_answers() {
  return XWindow::server_answers();
}

struct LiveView::Impl {
  Impl(std::filesystem::path picture, bool with_window)
      : file(std::move(picture)), windowed(with_window), thread([this] { run(); }) {}

  void run() {
    try {
      draw_views();
    } catch (const std::exception& e) {
      failure = e.what();
    }
  }

  void draw_views() {
    const ViewPainter painter;
    vpImage<vpRGBa> picture(kViewHeight, kViewWidth);
    std::optional<XWindow> window;
    if (windowed) window.emplace("planar-servo", kViewWidth, kViewHeight);
    while (const std::optional<ServoView> view = wait_for_view()) {
      painter.paint(*view, picture);
      save(picture);
      if (window) window->show(picture);
    }
  }

  /// Waits for the next view; empty when there will be none.
  std::optional<ServoView> wait_for_view() {
    std::unique_lock<std::mutex> lock(mutex);
    changed.wait(lock, [&] { return newest || closing; });
    return std::exchange(newest, std::nullopt);
  }

  void save(const vpImage<vpRGBa>& picture) const {
    std::filesystem::path fresh = file;
    fresh.replace_extension(".new.png");
    vpImageIo::write(picture, fresh.string());
    std::filesystem::rename(fresh, file);
  }

  std::filesystem::path file;
  bool windowed;
  std::mutex mutex;
  std::condition_variable changed;
  std::optional<ServoView> newest;
  bool closing{false};
  std::optional<std::string> failure;  ///< read only after the thread has ended
  std::thread thread;                  ///< declared last, because it uses all other members
};

LiveView::LiveView(std::filesystem::path picture, bool with_window)
    : impl_(std::make_unique<Impl>(std::move(picture), with_window)) {}

LiveView::~LiveView() {
  close();
}

void LiveView::show(ServoView view) {
  {
    const std::lock_guard<std::mutex> lock(impl_->mutex);
    impl_->newest = std::move(view);
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

}  // namespace planar

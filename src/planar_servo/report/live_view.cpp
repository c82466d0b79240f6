#include "planar_servo/report/live_view.h"

#include <visp3/gui/vpDisplayX.h>
#include <visp3/io/vpImageIo.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "planar_servo/report/view_picture.h"

// This comes after ViSP because it defines macros.
#include <X11/Xlib.h>

namespace planar {
namespace {

struct WindowLost {};

std::atomic<bool> window_is_broken{false};

/// The display of a dead connection. It must not be touched again, not even to be freed.
std::atomic<const vpDisplayX*> abandoned_display{nullptr};

/// Leaves by an exception, so that only the window is given up; if it returned, Xlib would end the
/// process.
int leave_lost_server(::Display* /*display*/) {
  throw WindowLost();
}

int note_broken_window(::Display* /*display*/, XErrorEvent* /*error*/) {
  window_is_broken = true;
  return 0;
}

/// Shows one picture in a window, always from the same thread.
class Window {
 public:
  explicit Window(vpImage<vpRGBa>& picture) : picture_(picture) {
    XSetIOErrorHandler(leave_lost_server);
    XSetErrorHandler(note_broken_window);
    guarded([&] {
      display_ =
          std::make_unique<vpDisplayX>(picture_, -1, -1, "planar-servo", vpDisplay::SCALE_DEFAULT);
    });
  }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;
  ~Window() {
    guarded([&] { vpDisplay::close(picture_); });
  }

  void show_picture() {
    guarded([&] {
      vpDisplay::display(picture_);
      vpDisplay::flush(picture_);
    });
  }

 private:
  template <typename Work>
  void guarded(const Work& work) {
    if (given_up_) return;
    try {
      work();
    } catch (const WindowLost&) {
      given_up_ = true;
    }
    given_up_ = given_up_ || window_is_broken;
    if (given_up_) abandoned_display = display_.release();
  }

  vpImage<vpRGBa>& picture_;
  std::unique_ptr<vpDisplayX> display_;
  bool given_up_{false};
};

}  // namespace

bool x_server_answers() {
  ::Display* const display = XOpenDisplay(nullptr);
  if (display == nullptr) return false;
  XCloseDisplay(display);
  return true;
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
    std::optional<Window> window;
    if (windowed) window.emplace(picture);
    while (const std::optional<ServoView> view = wait_for_view()) {
      painter.paint(*view, picture);
      save(picture);
      if (window) window->show_picture();
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

#include "planar_servo/report/live/x_window.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <vector>

// These come after ViSP because they define macros.
#include <X11/Xlib.h>
#include <X11/Xutil.h>

namespace planar {
namespace {

std::atomic<bool> request_failed{false};

// Xlib calls these handlers from C, so they must not throw and only note what happened.

int note_failed_request(::Display* /*display*/, XErrorEvent* /*error*/) {
  request_failed = true;
  return 0;
}

/// Replaces the default handler, which prints a message of its own.
int say_nothing(::Display* /*display*/) {
  return 0;
}

/// Replaces the default handler, which ends the process. When this returns, Xlib ignores all later
/// requests.
void note_lost_server(::Display* /*display*/, void* lost) {
  *static_cast<bool*>(lost) = true;
}

/// Returns a colour's share of a pixel.
unsigned long under_mask(unsigned char level, unsigned long mask) {
  return mask == 0 ? 0 : (level * (mask >> __builtin_ctzl(mask)) / 255) << __builtin_ctzl(mask);
}

}  // namespace

bool XWindow::server_answers() {
  ::Display* const display = XOpenDisplay(nullptr);
  if (display == nullptr) return false;
  XCloseDisplay(display);
  return true;
}

XWindow::XWindow(const std::string& title, unsigned width, unsigned height) {
  request_failed = false;
  XSetErrorHandler(note_failed_request);
  XSetIOErrorHandler(say_nothing);
  display_ = XOpenDisplay(nullptr);
  if (display_ == nullptr) return;
  XSetIOErrorExitHandler(display_, note_lost_server, &server_lost_);
  const int screen = XDefaultScreen(display_);
  window_ = XCreateSimpleWindow(display_, XRootWindow(display_, screen), 0, 0, width, height, 0, 0,
                                XBlackPixel(display_, screen));
  const auto depth = static_cast<unsigned>(XDefaultDepth(display_, screen));
  pixmap_ = XCreatePixmap(display_, window_, width, height, depth);
  XStoreName(display_, window_, title.c_str());
  XMapWindow(display_, window_);
  give_up_if_lost();
}

XWindow::~XWindow() {
  if (display_ != nullptr) XCloseDisplay(display_);
}

void XWindow::show(const vpImage<vpRGBa>& picture) {
  if (display_ == nullptr) return;
  put(picture);
  XSetWindowBackgroundPixmap(display_, window_, pixmap_);
  XClearWindow(display_, window_);
  give_up_if_lost();
}

void XWindow::put(const vpImage<vpRGBa>& picture) {
  const int screen = XDefaultScreen(display_);
  Visual* visual = XDefaultVisual(display_, screen);
  const auto depth = static_cast<unsigned>(XDefaultDepth(display_, screen));
  XImage* image = XCreateImage(display_, visual, depth, ZPixmap, 0, nullptr, picture.getWidth(),
                               picture.getHeight(), BitmapPad(display_), 0);
  if (image == nullptr) return;
  std::vector<char> data(static_cast<std::size_t>(image->bytes_per_line) * picture.getHeight());
  image->data = data.data();
  for (unsigned y = 0; y < picture.getHeight(); ++y)
    for (unsigned x = 0; x < picture.getWidth(); ++x) {
      const vpRGBa& color = picture[y][x];
      XPutPixel(image, static_cast<int>(x), static_cast<int>(y),
                under_mask(color.R, visual->red_mask) | under_mask(color.G, visual->green_mask) |
                    under_mask(color.B, visual->blue_mask));
    }
  XPutImage(display_, pixmap_, XDefaultGC(display_, screen), image, 0, 0, 0, 0, picture.getWidth(),
            picture.getHeight());
  image->data = nullptr;  // XDestroyImage() would free it
  XDestroyImage(image);
}

void XWindow::give_up_if_lost() {
  XSync(display_, False);
  if (!server_lost_ && !request_failed) return;
  spdlog::debug(
      fmt::format("the window is given up: {}", server_lost_ ? "it was closed or the X server ended"
                                                             : "the X server refuses it"));
  XCloseDisplay(display_);
  display_ = nullptr;
}

}  // namespace planar

#pragma once

#include <visp3/core/vpImage.h>

#include <string>

struct _XDisplay;  // NOLINT(bugprone-reserved-identifier): Display of <X11/Xlib.h>

namespace planar {

/// Shows pictures in a window of the X server at DISPLAY. When the window is closed or its server
/// dies, the window is given up: show() then does nothing. All calls come from the same thread, and
/// only one such window is open at a time.
class XWindow {
 public:
  /// Returns whether an X server answers at DISPLAY.
  static bool server_answers();

  XWindow(const std::string& title, unsigned width, unsigned height);
  ~XWindow();
  XWindow(const XWindow&) = delete;
  XWindow& operator=(const XWindow&) = delete;

  /// Shows a picture of the window's size.
  void show(const vpImage<vpRGBa>& picture);

 private:
  void put(const vpImage<vpRGBa>& picture);
  void give_up_if_lost();

  _XDisplay* display_{nullptr};  ///< null once the window is given up
  unsigned long window_{0};
  unsigned long pixmap_{0};  ///< the window's background, so that the server repaints it alone
  bool server_lost_{false};
};

}  // namespace planar

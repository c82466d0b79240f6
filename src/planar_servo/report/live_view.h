#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "planar_servo/report/servo_view.h"

namespace planar {

/// Whether an X server answers where DISPLAY points.
bool x_server_answers();

/// Shows the newest view in a picture file and, when asked for, in a window. Drawing happens on a
/// thread of its own: whoever calls show() never waits for it, and views that come faster than they
/// can be drawn are skipped. A window that is closed or whose server dies is given up; the file
/// goes on.
class LiveView {
 public:
  /// `picture` (.png) is replaced whole, never seen half written.
  LiveView(std::filesystem::path picture, bool with_window);
  /// The newest view is drawn before this ends.
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  void show(ServoView view);

  /// Draws what has not been drawn yet and ends; tells what went wrong, if anything did.
  std::optional<std::string> close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar

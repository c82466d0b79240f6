#include "planar_servo/report/live/display.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cstdlib>

#include "planar_servo/core/error.h"
#include "planar_servo/report/live/x_window.h"

namespace planar {

std::unique_ptr<LiveView> open_display(DisplayPolicy policy, const std::filesystem::path& picture,
                                       const std::string& title) {
  if (policy == DisplayPolicy::kNone) return nullptr;
  const bool window = XWindow::server_answers();
  if (!window && policy == DisplayPolicy::kX) {
    const char* display = std::getenv("DISPLAY");
    throw InputError(fmt::format(
        "--display x: no X server answers at DISPLAY '{}'; start one, or use --display auto",
        display == nullptr ? "" : display));
  }
  return std::make_unique<LiveView>(picture, window, title);
}

void close_display(LiveView* view) {
  if (view == nullptr) return;
  if (const auto failure = view->close())
    spdlog::warn(fmt::format("the display failed: {}", *failure));
}

}  // namespace planar

#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "planar_servo/core/names.h"
#include "planar_servo/report/live/live_view.h"

namespace planar {

/// Says what `--display` asks for.
enum class DisplayPolicy {
  kAuto,  ///< a picture file, and a window where an X server answers
  kX,     ///< both; it is an error when no X server answers
  kNone,  ///< nothing is drawn
};

constexpr Named<DisplayPolicy> kDisplayPolicies[] = {
    {DisplayPolicy::kAuto, "auto"}, {DisplayPolicy::kX, "x"}, {DisplayPolicy::kNone, "none"}};

/// Opens what the policy asks for; null when nothing is to be drawn. `picture` is the file that is
/// drawn, `title` the window's. Throws InputError when a window is asked for and no X server
/// answers.
std::unique_ptr<LiveView> open_display(DisplayPolicy policy, const std::filesystem::path& picture,
                                       const std::string& title);

/// Ends a display, which may be null, and warns of what went wrong.
void close_display(LiveView* view);

}  // namespace planar

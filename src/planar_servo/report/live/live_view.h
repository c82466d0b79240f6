#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "planar_servo/core/names.h"

template <class Type>
class vpImage;
class vpRGBa;

namespace planar {

constexpr unsigned kViewWidth = 1000;
constexpr unsigned kViewHeight = 580;

/// Draws a view on a picture of kViewWidth x kViewHeight pixels.
using ViewPlot = std::function<void(vpImage<vpRGBa>& picture)>;

/// Shows the newest view in a picture file and, on request, in a window. A thread of its own draws:
/// show() never waits for it, and views that come faster than they can be drawn are skipped. A
/// window that is closed or whose server dies is given up; the file is written on.
class LiveView {
 public:
  /// `picture` (.png) is replaced as a whole, so that it is never half written.
  LiveView(std::filesystem::path picture, bool with_window, std::string title);
  /// Draws the newest view before it ends.
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  /// `plot` is called by the thread that draws.
  void show(ViewPlot plot);

  /// Draws the newest view and ends. Returns what went wrong, if anything did.
  std::optional<std::string> close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

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

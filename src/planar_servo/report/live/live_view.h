#pragma once

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "planar_servo/core/names.h"

template <class Type>
class vpImage;
class vpRGBa;

namespace planar {

constexpr unsigned kViewWidth = 1000;
constexpr unsigned kViewHeight = 580;

/// Draws a view on a picture of kViewWidth x kViewHeight pixels.
using ViewPlot = std::function<void(vpImage<vpRGBa>& picture)>;

/// Shows the newest view in a picture file. A thread of its own draws: show() never waits for it,
/// and views that come faster than they can be drawn are skipped.
class LiveView {
 public:
  /// `picture` (.png) is replaced as a whole, so that it is never half written.
  explicit LiveView(std::filesystem::path picture);
  /// Draws the newest view before it ends.
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  /// `plot` is called by the thread that draws.
  void show(ViewPlot plot);

  /// Draws the newest view and ends. Returns what went wrong, if anything did.
  std::optional<std::string> close();

 private:
  void draw_views();
  /// Waits for the next view; empty when there will be none.
  ViewPlot wait_for_plot();

  std::filesystem::path file_;
  std::mutex mutex_;
  std::condition_variable changed_;
  ViewPlot newest_;
  bool closing_{false};
  std::optional<std::string> failure_;  ///< read only after the thread has ended
  std::thread thread_;                  ///< declared last, because it uses all other members
};

/// Says what `--display` asks for.
enum class DisplayPolicy { kAuto, kNone };

constexpr Named<DisplayPolicy> kDisplayPolicies[] = {{DisplayPolicy::kAuto, "auto"},
                                                     {DisplayPolicy::kNone, "none"}};

/// Begins to draw into the file `picture`; null when nothing is to be drawn.
std::unique_ptr<LiveView> open_display(DisplayPolicy policy, const std::filesystem::path& picture);

/// Ends a display, which may be null, and warns of what went wrong.
void close_display(LiveView* view);

}  // namespace planar

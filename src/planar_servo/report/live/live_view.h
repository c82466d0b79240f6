#pragma once

#include <visp3/core/vpFont.h>
#include <visp3/core/vpImage.h>
#include <visp3/core/vpImagePoint.h>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <thread>
#include "planar_servo/base/core/names.h"

template <class Type>
class vpImage;
class vpRGBa;

namespace planar {

const vpColor kInk(230, 230, 230);
const vpColor kFaint(110, 110, 110);
const vpColor kSeen(60, 220, 90);
const vpColor kWanted(255, 150, 40);
const vpColor kAlarm(255, 80, 80);

/// The panel that shows the camera's picture in a view.
const cv::Rect2d kFramePanel(16, 48, 512, 512);

/// What a view is drawn on: a picture of kViewWidth x kViewHeight pixels. x counts to the right, y
/// down.
class Canvas {
 public:
  /// Clears `picture`.
  explicit Canvas(vpImage<vpRGBa>& picture);

  static vpImagePoint at(double x, double y) { return {y, x}; }

  vpImage<vpRGBa>& picture() { return picture_; }
  void write(double x, double y, const std::string& text, const vpColor& color);
  void frame(const cv::Rect2d& panel);
  /// Draws an 8-bit grey image as large as it fits into a panel. Returns the panel's pixels per
  /// pixel of it; 0 for an empty image.
  double show(const cv::Mat& image, const cv::Rect2d& panel);

 private:
  vpImage<vpRGBa>& picture_;
  vpFont font_;
};

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

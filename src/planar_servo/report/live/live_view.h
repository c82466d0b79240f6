#pragma once

#include <visp3/core/vpFont.h>
#include <visp3/core/vpImage.h>
#include <visp3/core/vpImagePoint.h>

#include <Eigen/Core>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/devices/frame_source.h"

namespace planar {

const vpColor kInk(230, 230, 230);
const vpColor kFaint(110, 110, 110);
const vpColor kSeen(60, 220, 90);
const vpColor kWanted(255, 150, 40);
const vpColor kAlarm(255, 80, 80);

/// The panel that shows the camera's picture in a view.
const cv::Rect2d kFramePanel(16, 48, 512, 512);

/// What a view is drawn on: kViewWidth x kViewHeight pixels, x counted to the right, y down.
class Canvas {
 public:
  /// Clears `picture`.
  explicit Canvas(vpImage<vpRGBa>& picture);

  static vpImagePoint at(double x, double y) { return {y, x}; }

  vpImage<vpRGBa>& picture() { return picture_; }
  void write(double x, double y, const std::string& text, const vpColor& color);
  void frame(const cv::Rect2d& panel);
  /// Draws an 8-bit grey image as large as it fits into a panel. Returns the scale; 0 for no image.
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

/// The view of a servo at work: one measurement of the tool and the errors of its target so far.
struct ServoView {
  std::string title;                       ///< target, step and error in one line
  bool measured{true};                     ///< if false, the title says why not
  Frame frame;                             ///< shared, not copied
  std::vector<Eigen::Vector2d> lamps_px;   ///< measured, on the sensor
  std::vector<Eigen::Vector2d> wanted_px;  ///< where the lamps belong
  std::vector<Eigen::Vector2d> errors_m;   ///< from target to end point, one per step
  double stop_below_m{0.0};                ///< the error below which the servo stops
};

/// Draws a view: the frame with the lamps (crosses) and their wanted positions (rings), the errors
/// as points about the target with a logarithmic radius, and their lengths over the steps.
ViewPlot plot_of(ServoView view);

}  // namespace planar

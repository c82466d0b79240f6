#include "planar_servo/run/servo_display.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cstdlib>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

std::string title_of(const ServoSight& sight) {
  const ServoStep& step = sight.step;
  const std::string what = fmt::format("{}   step {}", sight.target_id, step.iteration);
  if (!step.measurement.ok())
    return fmt::format("{}   not measured: {}", what, step.measurement.word);
  return fmt::format("{}   {:.4f} mm from the target, +- {:.4f} mm{}", what,
                     step.error.norm() / kMillimetre, step.measurement.uncertainty_m / kMillimetre,
                     step.measurement.inside_map ? "" : "   outside the error map");
}

}  // namespace

DisplayPolicy display_policy_named(const std::string& name) {
  if (name == "none") return DisplayPolicy::kNone;
  if (name == "auto") return DisplayPolicy::kAuto;
  if (name == "x") return DisplayPolicy::kX;
  throw InputError("--display is '" + name + "'; allowed are auto, x, none");
}

ServoDisplay::ServoDisplay(DisplayPolicy policy, const std::filesystem::path& picture) {
  if (policy == DisplayPolicy::kNone) return;
  const bool window = x_server_answers();
  if (!window && policy == DisplayPolicy::kX) {
    const char* display = std::getenv("DISPLAY");
    throw InputError(fmt::format(
        "--display x: no X server answers at DISPLAY '{}'; start one, or use --display auto",
        display == nullptr ? "" : display));
  }
  view_ = std::make_unique<LiveView>(picture, window);
}

void ServoDisplay::show(const ServoSight& sight) {
  if (!view_) return;
  if (sight.step.iteration == 0) errors_m_.clear();
  ServoView view;
  view.title = title_of(sight);
  view.measured = sight.step.measurement.ok();
  if (view.measured) {
    errors_m_.emplace_back(-sight.step.error);
    const auto& lamps_px = sight.step.measurement.lamps_px;
    view.lamps_px.assign(lamps_px.begin(), lamps_px.end());
  }
  if (sight.wanted_px) view.wanted_px.assign(sight.wanted_px->begin(), sight.wanted_px->end());
  view.frame = sight.frame;
  view.errors_m = errors_m_;
  view.stop_below_m = sight.step.stop_below_m;
  view_->show(std::move(view));
}

void ServoDisplay::close() {
  if (!view_) return;
  if (const auto failure = view_->close())
    spdlog::warn(fmt::format("the display failed: {}", *failure));
}

}  // namespace planar

#include "planar_servo/run/servo_display.h"

#include <fmt/format.h>

#include "planar_servo/core/units.h"
#include "planar_servo/report/live/servo_view.h"

namespace planar {
namespace {

std::string title_of(const ServoSight& sight) {
  const ServoStep& step = sight.step;
  const std::string what = fmt::format("{}   step {}", sight.target_id, step.iteration);
  if (!step.measurement.ok())
    return fmt::format("{}   not measured: {}", what, step.measurement.word);
  return fmt::format("{}   {:.4f} mm from the target, +- {:.4f} mm{}", what, mm(step.miss_m()),
                     mm(step.uncertainty_m()),
                     step.measurement.inside_map ? "" : "   outside the error map");
}

}  // namespace

ServoDisplay::ServoDisplay(DisplayPolicy policy, const std::filesystem::path& picture)
    : view_(open_display(policy, picture, "planar-servo")) {}

void ServoDisplay::show(const ServoSight& sight) {
  if (!view_) return;
  if (sight.step.iteration == 0) errors_m_.clear();
  ServoView view;
  view.title = title_of(sight);
  view.measured = sight.step.measurement.ok();
  if (view.measured) {
    errors_m_.emplace_back(sight.step.believed_p() - sight.step.target.p);
    const auto& lamps_px = sight.step.measurement.lamps_px;
    view.lamps_px.assign(lamps_px.begin(), lamps_px.end());
  }
  if (sight.wanted_px) view.wanted_px.assign(sight.wanted_px->begin(), sight.wanted_px->end());
  view.frame = sight.frame;
  view.errors_m = errors_m_;
  view.stop_below_m = sight.step.stop_below_m;
  view_->show(plot_of(std::move(view)));
}

void ServoDisplay::close() {
  close_display(view_.get());
}

}  // namespace planar

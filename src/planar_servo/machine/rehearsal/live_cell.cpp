#include "planar_servo/machine/rehearsal/live_cell.h"

#include <fmt/format.h>

#include <algorithm>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr char kTool[] = "tool";
constexpr double kLookPeriod_s = 0.02;
constexpr char kTruthLogHeader[] = "# format: planar-servo/truth-log/1\nt_s,x_mm,y_mm,phi_deg\n";

GrowingFile log_file(const std::filesystem::path& path) {
  require_header(path, kTruthLogHeader);
  return {path, kTruthLogHeader};
}

}  // namespace

LiveCell::LiveCell(const Truth& truth, const VirtualHardware& hardware, double age_s)
    : cell_(truth, hardware),
      sensor_px_(hardware.sensor_px),
      offset_s_(age_s - steady_.now_s()),
      reflector_places_{kTool},
      reflector_(kTool) {
  for (const auto& monument : hardware.monuments_B) reflector_places_.push_back(monument.first);
}

void LiveCell::set_mover(std::function<void(VirtualCell&)> mover) {
  const std::lock_guard<std::mutex> lock(mutex_);
  mover_ = std::move(mover);
}

cv::Mat LiveCell::expose(const cv::Rect& region_px, double brightness) {
  const std::lock_guard<std::mutex> lock(mutex_);
  catch_up();
  const cv::Rect seen_px = region_px & cv::Rect(cv::Point(), sensor_px_);
  if (seen_px == region_px) return cell_.expose(region_px, brightness, exposures_++);
  cv::Mat image(region_px.size(), CV_8UC1, cv::Scalar(0));
  if (!seen_px.empty())
    cell_.expose(seen_px, brightness, exposures_++).copyTo(image(seen_px - region_px.tl()));
  return image;
}

TipPose LiveCell::true_tip() {
  return now([](VirtualCell& cell) { return cell.true_tip(); });
}

bool LiveCell::place_reflector(const std::string& where) {
  const auto& places = reflector_places_;
  if (std::find(places.begin(), places.end(), where) == places.end()) return false;
  now([&](VirtualCell& /*cell*/) { reflector_ = where; });
  return true;
}

TrackerReading LiveCell::read_reflector() {
  return now([this](VirtualCell& cell) {
    Tracker& tracker = cell.tracker();
    return (reflector_ == kTool ? tracker.measure_tool("") : tracker.measure_monument(reflector_))
        .reading;
  });
}

void LiveCell::catch_up() {
  Clock& clock = cell_.clock();
  clock.sleep_for_s(std::max(0.0, steady_.now_s() + offset_s_ - clock.now_s()));
  if (mover_) mover_(cell_);
}

TruthLog::TruthLog(const std::filesystem::path& file, LiveCell& live)
    : live_(live), file_(log_file(file)), repeater_(kLookPeriod_s, [this] { look(); }) {}

void TruthLog::look() {
  const TipPose tip = live_.true_tip();
  if (written_ && tip.p == written_->p && tip.phi == written_->phi) return;
  file_.append(fmt::format("{:.6f},{:.6f},{:.6f},{:.7f}\n", clock_.now_s(), mm(tip.p.x()),
                           mm(tip.p.y()), tip.phi / kDegree));
  written_ = tip;
}

}  // namespace planar

#include "planar_servo/served_cell/truth_log.h"

#include <fmt/format.h>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr double kLookPeriod_s = 0.02;
constexpr char kTruthLogHeader[] = "# format: planar-servo/truth-log/1\nt_s,x_mm,y_mm,phi_deg\n";

GrowingFile log_file(const std::filesystem::path& path) {
  require_header(path, kTruthLogHeader);
  return {path, kTruthLogHeader};
}

}  // namespace

TruthLog::TruthLog(const std::filesystem::path& file, LiveCell& live)
    : live_(live), file_(log_file(file)), repeater_(kLookPeriod_s, [this] { look(); }) {}

void TruthLog::look() {
  const TipPose tip = live_.true_tip();
  if (written_ && tip.p == written_->p && tip.phi == written_->phi) return;
  file_.append(fmt::format("{:.6f},{:.6f},{:.6f},{:.7f}\n", clock_.now_s(), tip.p.x() / kMillimetre,
                           tip.p.y() / kMillimetre, tip.phi / kDegree));
  written_ = tip;
}

}  // namespace planar

#include "planar_servo/served_cell/serve_cell.h"

#include <fmt/format.h>

#include "planar_servo/core/clock.h"
#include "planar_servo/core/error.h"
#include "planar_servo/machine/virtual_kinds.h"
#include "planar_servo/served_cell/aravis_gige_camera.h"
#include "planar_servo/served_cell/live_cell.h"
#include "planar_servo/virtual_cell/truth/truth_file.h"

namespace planar {
namespace {

constexpr char kSerial[] = "virtual-cell";
constexpr double kAskPeriod_s = 0.1;

}  // namespace

void serve_cell(const CellSettings& cell, const std::string& address,
                const std::function<void()>& started, const std::function<bool()>& should_stop) {
  if (!cell.truth)
    throw InputError(
        fmt::format("{}: is no virtual cell: it lacks the key 'virtual'", cell.file.string()));
  LiveCell live(read_truth(*cell.truth), virtual_hardware(cell));
  const GigeCamera camera(address, kSerial, {cell.camera.width_px, cell.camera.height_px},
                          cell.camera.frame_rate_hz,
                          [&](const cv::Rect& region_px, double brightness) {
                            return live.expose(region_px, brightness);
                          });
  started();
  SteadyClock clock;
  while (!should_stop()) clock.sleep_for_s(kAskPeriod_s);
}

}  // namespace planar

#include "planar_servo/served_cell/served_cell.h"

#include <fmt/format.h>

#include "planar_servo/core/error.h"
#include "planar_servo/io/folder_lock.h"
#include "planar_servo/machine/cell_devices.h"
#include "planar_servo/machine/virtual_kinds.h"
#include "planar_servo/served_cell/aravis_gige_camera.h"
#include "planar_servo/served_cell/cell_commands.h"
#include "planar_servo/served_cell/drives/grbl_motors.h"
#include "planar_servo/served_cell/live_cell.h"
#include "planar_servo/served_cell/live_cell_file.h"
#include "planar_servo/served_cell/tracker/served_tracker.h"
#include "planar_servo/served_cell/truth_log.h"
#include "planar_servo/virtual_cell/truth/truth_file.h"

namespace planar {
namespace {

constexpr char kCameraSerial[] = "SERVED1";
constexpr int kTrackerPort = 7701;

const CellSettings& checked(const CellSettings& cell) {
  require_devices(cell);
  if (!cell.camera.kind->is_virtual())
    throw InputError(cell.file.string() + ": is no virtual cell: its devices are real ones");
  return cell;
}

ServedPlaces places_of(const ServeRequest& request) {
  ServedPlaces places{request.address,
                      kCameraSerial,
                      request.grbl_port,
                      TrackerPort{request.address, kTrackerPort},
                      request.tracker.decimal_comma,
                      request.grbl_firmware.has_value()};
  if (request.tracker_file) places.tracker = *request.tracker_file;
  return places;
}

std::string described(const TrackerPort& port) {
  return fmt::format("on {}:{}", port.host, port.port);
}

std::string described(const std::filesystem::path& file) {
  return fmt::format("appending to {}", file.string());
}

}  // namespace

struct ServedCell::Impl {
  explicit Impl(const ServeRequest& request)
      : cell(checked(request.cell)),
        places(places_of(request)),
        lock(places.grbl_port.parent_path()),
        truth(read_truth(*cell.truth)),
        live(truth, virtual_hardware(cell)),
        camera(places.address, places.camera_id, {cell.camera.width_px, cell.camera.height_px},
               cell.camera.frame_rate_hz,
               [this](const cv::Rect& region_px, double brightness) {
                 return live.expose(region_px, brightness);
               }),
        motors(cell, places.grbl_port, live, request.grbl_firmware),
        tracker(places.tracker, request.tracker, truth.seed, live) {
    if (request.truth_log) truth_log.emplace(*request.truth_log, live);
  }

  CellSettings cell;
  ServedPlaces places;
  FolderLock lock;
  Truth truth;
  LiveCell live;
  GigeCamera camera;
  GrblMotors motors;
  ServedTracker tracker;
  std::optional<TruthLog> truth_log;
};

ServedCell::ServedCell(const ServeRequest& request) : impl_(std::make_unique<Impl>(request)) {}

ServedCell::~ServedCell() = default;

std::string ServedCell::description() const {
  const ServedPlaces& places = impl_->places;
  return fmt::format(
      "camera   GigE Vision on {}\ndrives   Grbl at {}\ntracker  {}", places.address,
      places.grbl_port.string(),
      std::visit([](const auto& where) { return described(where); }, places.tracker));
}

std::string ServedCell::live_text() const {
  return live_cell_text(impl_->cell, impl_->places);
}

std::string ServedCell::obey(const std::string& line) {
  return obey_command(line, impl_->live, [this] { return impl_->motors.put_at_marks(); });
}

void ServedCell::require_well() const {
  impl_->motors.require_well();
  impl_->tracker.require_well();
  if (impl_->truth_log) impl_->truth_log->require_well();
}

}  // namespace planar

#include "planar_servo/rehearsal/served_cell.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/machine/cell_devices.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/rehearsal/cell_commands.h"
#include "planar_servo/rehearsal/gige_camera.h"
#include "planar_servo/rehearsal/grbl_motors.h"
#include "planar_servo/rehearsal/live_cell.h"
#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {
namespace {

constexpr char kCameraSerial[] = "SERVED1";
constexpr int kTrackerPort = 7701;
constexpr int kJumboPacket_bytes = 9000;

const CellSettings& checked(const CellSettings& cell) {
  require_devices(cell);
  if (!cell.camera.kind->is_virtual())
    throw InputError({"is no virtual cell: its devices are real ones", "", cell.file});
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

YAML::Node flow_map() {
  YAML::Node node(YAML::NodeType::Map);
  node.SetStyle(YAML::EmitterStyle::Flow);
  return node;
}

/// Writes a number with the fewest digits that it needs.
std::string shortest(double value) {
  return fmt::format("{:.10g}", value);
}

void make_real(YAML::Node camera, const ServedPlaces& places) {
  camera["source"] = "aravis";
  camera["address"] = places.address;
  camera["id"] = places.camera_id;
  camera["exposure_us"] = kUsualExposure_us;
  camera["gain_db"] = 0;
  camera["pixel_format"] = "Mono8";
  camera["trigger"] = "software";
  camera["packet_size"] = kJumboPacket_bytes;
}

void make_real(YAML::Node drive, const MotorDrive& motor, char axis, const ServedPlaces& places) {
  drive["kind"] = "grbl";
  drive["port"] = places.grbl_port.string();
  drive["baud"] = 115200;
  drive["axis"] = axis;
  drive["pulses_per_mm"] = shortest(kServedPulsesPerMm);
  drive["home"] = flow_map();
  drive["home"]["reference"] = places.firmware ? "taught" : "reverse_switch";
  drive["home"]["at_deg"] = shortest(motor.home_rad / kDegree);
  drive["max_speed_deg_s"] = shortest(served_speed_deg_s(motor, places.firmware));
}

void make_real_tracker(YAML::Node tracker, const ServedPlaces& places) {
  if (const auto* port = std::get_if<TrackerPort>(&places.tracker)) {
    tracker["source"] = "tcp";
    tracker["address"] = fmt::format("{}:{}", port->host, port->port);
  } else {
    tracker["source"] = "file";
    tracker["path"] = std::get<std::filesystem::path>(places.tracker).string();
  }
  tracker["columns"] = flow_map();
  tracker["columns"]["t"] = "t_s";
  if (places.decimal_comma) tracker["decimal_comma"] = true;
}

}  // namespace

std::string live_cell_text(const CellSettings& cell, const ServedPlaces& places) {
  YAML::Node root = YAML::LoadFile(cell.file.string());
  root.remove("virtual");
  make_real(root["camera"], places);
  for (std::size_t i = 0; i < cell.transmission.drives.size(); ++i)
    make_real(root["drives"][i], cell.transmission.drives[i], static_cast<char>('X' + i), places);
  make_real_tracker(root["tracker"], places);
  return YAML::Dump(root) + "\n";
}

struct ServedCell::Impl {
  explicit Impl(const ServeRequest& request)
      : cell(checked(request.cell)),
        places(places_of(request)),
        lock(places.grbl_port.parent_path()),
        truth(read_truth(*cell.truth)),
        live(truth, virtual_hardware(cell)),
        motors(cell, places.grbl_port, live, request.grbl_firmware),
        tracker(places.tracker, request.tracker, truth.seed, live) {
    power_camera(true);
    if (request.truth_log) truth_log.emplace(*request.truth_log, live);
  }

  void power_camera(bool on) {
    if (!on) return camera.reset();
    if (camera) return;
    camera.emplace(places.address, places.camera_id,
                   cv::Size(cell.camera.width_px, cell.camera.height_px), cell.camera.frame_rate_hz,
                   [this](const cv::Rect& region_px, double brightness) {
                     return live.expose(region_px, brightness);
                   });
  }

  CellSettings cell;
  ServedPlaces places;
  FolderLock lock;
  Truth truth;
  LiveCell live;
  GrblMotors motors;
  ServedTracker tracker;
  std::optional<GigeCamera> camera;
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
  return obey_command(line, impl_->live,
                      {[this] { return impl_->motors.put_at_marks(); },
                       [this](bool on) { impl_->power_camera(on); }});
}

void ServedCell::require_well() const {
  impl_->motors.require_well();
  impl_->tracker.require_well();
  if (impl_->truth_log) impl_->truth_log->require_well();
}

}  // namespace planar

#include "planar_servo/served_cell/live_cell_file.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "planar_servo/core/units.h"
#include "planar_servo/served_cell/drives/grbl_motors.h"
#include "planar_servo/served_cell/exposure.h"

namespace planar {
namespace {

constexpr int kJumboPacket_bytes = 9000;

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

}  // namespace planar

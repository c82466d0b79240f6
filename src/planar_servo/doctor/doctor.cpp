#include "planar_servo/doctor/doctor.h"

#include <fmt/format.h>

#include <fstream>

#include "planar_servo/cameras/aravis/aravis_settings.h"
#include "planar_servo/core/error.h"
#include "planar_servo/doctor/camera_doctor.h"
#include "planar_servo/drives/tic/tic_inspection.h"
#include "planar_servo/machine/cell_camera.h"
#include "planar_servo/machine/cell_devices.h"

namespace planar {
namespace {

/// Frames of 26 MB in flight do not fit into the kernel's usual 16 MB.
constexpr int kEnoughUsbMemory_mb = 64;

constexpr char kVirtual[] = "is virtual; there is no device to examine";

using Verdict = Finding::Verdict;

Finding examine_tic(TicBus& bus, const std::string& subject, const std::string& serial) {
  const TicInspection tic = inspect_tic(bus, serial);
  if (tic.refusal)
    return {Verdict::kFaulty, subject, tic.refusal->fault,
            tic.refusal->remedy.empty() ? "see doc/drives.md" : tic.refusal->remedy};
  const std::string what = fmt::format(
      "{} {} at {}, firmware {}, supply {:.1f} V", tic::product_name(tic.listing.product_id),
      serial, tic.listing.device, tic::firmware_name(tic.listing.firmware), tic.supply_v);
  if (!tic.faults.empty())
    return {Verdict::kFaulty, subject, fmt::format("{}: {}", what, fmt::join(tic.faults, ", ")),
            "remove the cause, then enable the drives with planar-jog"};
  if (!tic.position_certain)
    return {Verdict::kDoubtful, subject, what + "; it does not know where it stands",
            "home it with planar-jog"};
  return {Verdict::kWell, subject, what};
}

/// Empty when a Tic can turn as fast as the file asks.
std::string excess_of(const MotorDrive& motor, double pulses_per_rad) {
  try {
    tic::speed_units(std::abs(pulses_per_rad) * motor.max_speed_rad_s);
    tic::acceleration_units(std::abs(pulses_per_rad) * motor.max_acceleration_rad_s2);
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

}  // namespace

std::vector<Finding> examine_cell(const std::filesystem::path& cell_file) {
  const CellSettings cell = read_cell(cell_file);
  require_devices(cell);
  std::vector<Finding> findings{{Verdict::kWell, "cell file", cell_file.string() + " is in order"}};
  for (Finding& finding : examine_drives(cell)) findings.push_back(std::move(finding));
  if (cell.camera.source == "virtual") {
    findings.push_back({Verdict::kWell, "camera", kVirtual});
    return findings;
  }
  for (Finding& finding : examine_camera(cell.camera, aravis_settings(cell)))
    findings.push_back(std::move(finding));
  if (cell.camera.connection.address.empty()) findings.push_back(examine_usb_memory());
  return findings;
}

std::vector<Finding> examine_drives(const CellSettings& cell) {
  std::vector<Finding> findings;
  const Transmission transmission(cell.transmission);
  TicBus bus;
  for (int i = 0; i < 3; ++i) {
    const auto joint = static_cast<std::size_t>(i);
    const std::string subject = fmt::format("drive {}", i + 1);
    if (cell.drives[joint].kind != "tic") {
      findings.push_back({Verdict::kWell, subject, kVirtual});
      continue;
    }
    findings.push_back(examine_tic(bus, subject, cell.drives[joint].serial));
    const std::string excess =
        excess_of(cell.transmission.drives[joint], transmission.pulses_per_rad()[i]);
    if (!excess.empty())
      findings.push_back({Verdict::kFaulty, subject, excess,
                          "lower max_speed_deg_s and max_acceleration_deg_s2 in the cell file, or "
                          "set fewer microsteps"});
  }
  return findings;
}

Finding examine_usb_memory(const std::filesystem::path& parameter) {
  int memory_mb = 0;
  if (!(std::ifstream(parameter) >> memory_mb))
    return {Verdict::kDoubtful, "USB memory", parameter.string() + " cannot be read",
            "load the kernel module usbcore"};
  const std::string what = fmt::format("the kernel lends USB {} MB", memory_mb);
  if (memory_mb == 0 || memory_mb >= kEnoughUsbMemory_mb)  // 0: as much as there is
    return {Verdict::kWell, "USB memory", what};
  return {Verdict::kDoubtful, "USB memory",
          fmt::format("{}; a USB3 camera needs {} MB", what, kEnoughUsbMemory_mb),
          fmt::format("echo 1000 | sudo tee {} (for good: kernel argument "
                      "usbcore.usbfs_memory_mb=1000)",
                      parameter.string())};
}

}  // namespace planar

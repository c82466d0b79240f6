#include "app/cell_devices.h"

#include <fmt/format.h>

#include "core/error.h"
#include "virtual_cell/truth_file.h"
#include "virtual_cell/virtual_cell.h"

namespace planar {
namespace {

class VirtualDevices final : public CellDevices {
 public:
  VirtualDevices(const Truth& truth, const VirtualHardware& hardware) : cell_(truth, hardware) {}

  Clock& clock() override { return cell_.clock(); }
  FrameSource& camera() override { return cell_.camera(); }
  DriveGroup& drives() override { return cell_.drives(); }
  Tracker& tracker() override { return cell_.tracker(); }
  BoardPresenter& board_presenter() override { return cell_.board_presenter(); }
  std::function<TipPose()> true_tip() override {
    return [this] { return cell_.true_tip(); };
  }

 private:
  VirtualCell cell_;
};

}  // namespace

VirtualHardware virtual_hardware(const CellSettings& cell) {
  const Transmission transmission(cell.transmission);
  VirtualHardware hardware;
  hardware.sensor_px = {cell.camera.width_px, cell.camera.height_px};
  hardware.frame_rate_hz = cell.camera.frame_rate_hz;
  hardware.sense = cell.arm.geometry.positive_rotation == Rotation::kCounterclockwise ? 1.0 : -1.0;
  for (std::size_t i = 0; i < 2; ++i)
    hardware.relative[i] = cell.transmission.coupling[i] == Coupling::kRelative;
  hardware.pulses_per_rad = transmission.pulses_per_rad();
  for (int i = 0; i < 3; ++i) {
    const MotorDrive& drive = cell.transmission.drives[static_cast<std::size_t>(i)];
    hardware.max_speed_rad_s[i] = drive.max_speed_rad_s;
    hardware.max_acceleration_rad_s2[i] = drive.max_acceleration_rad_s2;
  }
  hardware.home_rad = cell.arm.home;
  for (const Monument& monument : cell.datum)
    hardware.monuments_B.emplace_back(monument.id, monument.p_B);
  return hardware;
}

void require_devices(const CellSettings& cell) {
  Faults faults;
  if (cell.camera.source != "virtual")
    faults.add(fmt::format("{}: camera.source is {}; this version drives virtual cells only",
                           cell.file.string(), cell.camera.source));
  for (const DriveSettings& drive : cell.drives)
    if (drive.kind != "virtual")
      faults.add(fmt::format("{}: drives have the kind {}; this version drives virtual cells only",
                             cell.file.string(), drive.kind));
  if (!cell.truth)
    faults.add(fmt::format("{}: lacks the key 'virtual'; a virtual cell needs its truth file",
                           cell.file.string()));
  faults.throw_if_any();
}

std::unique_ptr<CellDevices> open_cell(const CellSettings& cell) {
  require_devices(cell);
  return std::make_unique<VirtualDevices>(read_truth(*cell.truth), virtual_hardware(cell));
}

}  // namespace planar

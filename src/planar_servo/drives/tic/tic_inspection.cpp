#include "planar_servo/drives/tic/tic_inspection.h"

#include <algorithm>

namespace planar {
namespace {

constexpr double kTimeout_s = 1.6;

}  // namespace

TicInspection inspect_tic(TicBus& bus, const std::string& serial) {
  TicInspection inspection;
  Refusal why;
  const auto port = bus.open(serial, why);
  if (port == nullptr) {
    inspection.refusal = why;
    return inspection;
  }
  inspection.listing = port->listing();
  std::vector<TicTransfer> transfers(2);
  transfers[0] = {port.get(), tic::Command::kGetSettings};
  transfers[0].data.resize(tic::kSettingsBytes);
  transfers[1] = {port.get(), tic::Command::kGetVariables};
  transfers[1].data.resize(tic::StatusBlock::kBytes);
  bus.exchange(transfers, kTimeout_s);
  for (const TicTransfer& transfer : transfers)
    if (!transfer.error.empty())
      inspection.refusal = Refusal{transfer.error, "plug it in again, with another cable or hub"};
  if (inspection.refusal) return inspection;
  inspection.refusal = tic::unfitness(inspection.listing.firmware, transfers[0].data);
  tic::StatusBlock::Bytes bytes{};
  std::copy(transfers[1].data.begin(), transfers[1].data.end(), bytes.begin());
  const tic::StatusBlock status(bytes);
  inspection.supply_v = status.supply_v();
  inspection.position_certain = status.position_certain();
  inspection.faults = status.standing_faults();
  return inspection;
}

}  // namespace planar

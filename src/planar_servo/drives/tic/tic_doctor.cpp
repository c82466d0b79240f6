#include "planar_servo/drives/tic/tic_doctor.h"

#include <fmt/format.h>

#include "planar_servo/core/error.h"
#include "planar_servo/drives/tic/tic_inspection.h"

namespace planar {
namespace {

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

/// Why a Tic cannot turn as fast as the cell asks; empty when it can.
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

std::vector<Finding> examine_tics(const TransmissionSettings& transmission,
                                  const std::array<TicSettings, 3>& tics) {
  std::vector<Finding> findings;
  const Eigen::Vector3d pulses_per_rad = Transmission(transmission).pulses_per_rad();
  TicBus bus;
  for (int i = 0; i < 3; ++i) {
    const auto joint = static_cast<std::size_t>(i);
    const std::string subject = fmt::format("drive {}", i + 1);
    findings.push_back(examine_tic(bus, subject, tics[joint].serial));
    const std::string excess = excess_of(transmission.drives[joint], pulses_per_rad[i]);
    if (!excess.empty())
      findings.push_back({Verdict::kFaulty, subject, excess,
                          "lower max_speed_deg_s and max_acceleration_deg_s2 in the cell file, or "
                          "set fewer microsteps"});
  }
  return findings;
}

}  // namespace planar

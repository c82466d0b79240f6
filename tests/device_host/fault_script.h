#pragma once

#include <cstddef>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "device_host/hosted_arm.h"

namespace planar::test {

/// A fault of a device: how it begins, and how its cause goes away.
struct HostedFault {
  std::function<void()> begin, end;
};

/// Lets a device fail in the middle of a move, and tells what followed on the drives' wires.
class FaultScript {
 public:
  /// The fault comes 0.3 s into the first long move from the `at_command`-th command to drive 1 on,
  /// and stays for `for_s`.
  FaultScript(HostedFault fault, HostedArm& arm, std::size_t at_command, double for_s);

  /// To be called every few milliseconds.
  void poll();

  /// The time from the fault to the first command to each drive after it; null before the fault.
  nlohmann::json report() const;

 private:
  bool under_way();

  HostedFault fault_;
  HostedArm& arm_;
  std::size_t at_command_;
  double for_s_;
  SteadyClock clock_;
  std::optional<double> began_s_;
  bool ended_{false};
};

}  // namespace planar::test

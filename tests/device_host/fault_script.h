#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "device_host/hosted_arm.h"

namespace planar::test {

/// A fault of a device: how it begins, and how its cause goes away.
struct HostedFault {
  std::string name;
  std::function<void()> begin, end;
  bool blinds{false};  ///< a camera that dies slowly may take a last picture: it begins with that
};

/// Lets devices fail in the middle of moves, and tells what followed on the drives' wires.
class FaultScript {
 public:
  /// Each fault comes 0.3 s into a long move, after the cause of the one before is gone, and stays
  /// for `for_s`.
  FaultScript(std::vector<HostedFault> faults, HostedArm& arm, double for_s);

  /// To be called every few milliseconds.
  void poll();

  /// For each fault that came, the time from it to the first command to each drive after it.
  nlohmann::json report() const;

 private:
  bool under_way();

  std::vector<HostedFault> faults_;
  HostedArm& arm_;
  double for_s_;
  SteadyClock clock_;
  std::vector<double> began_s_;  ///< of those that came
  bool present_{false};
};

}  // namespace planar::test

#include "device_host/fault_script.h"

#include <algorithm>

namespace planar::test {
namespace {

/// A long move is under way for sure so long after its command; a correction is over.
constexpr double kUnderWay_s = 0.3;

}  // namespace

FaultScript::FaultScript(HostedFault fault, HostedArm& arm, std::size_t at_command, double for_s)
    : fault_(std::move(fault)), arm_(arm), at_command_(at_command), for_s_(for_s) {}

void FaultScript::poll() {
  if (!began_s_ && under_way()) {
    const double now_s = clock_.now_s();
    fault_.begin();
    // What dies slowly may take a last picture.
    const std::vector<TrueTip> tips = arm_.true_tips();
    began_s_ = tips.empty() ? now_s : std::max(now_s, tips.back().t_s);
  }
  if (began_s_ && !ended_ && clock_.now_s() > *began_s_ + for_s_) {
    ended_ = true;
    fault_.end();
  }
}

nlohmann::json FaultScript::report() const {
  if (!began_s_) return nullptr;
  nlohmann::json stops_ms = nlohmann::json::array();
  for (std::size_t joint = 0; joint < 3; ++joint)
    for (const double t_s : arm_.drive(joint).commands_s())
      if (t_s > *began_s_) {
        stops_ms.push_back(1e3 * (t_s - *began_s_));
        break;
      }
  return {{"first_command_ms", stops_ms}};
}

bool FaultScript::under_way() {
  const std::vector<double> commands_s = arm_.drive(0).commands_s();
  return commands_s.size() >= at_command_ && clock_.now_s() > commands_s.back() + kUnderWay_s &&
         arm_.moving();
}

}  // namespace planar::test

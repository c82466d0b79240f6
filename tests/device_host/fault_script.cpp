#include "device_host/fault_script.h"

#include <algorithm>
#include <utility>

namespace planar::test {
namespace {

/// A long move is under way for sure so long after its command; a correction is over.
constexpr double kUnderWay_s = 0.3;

}  // namespace

FaultScript::FaultScript(std::vector<HostedFault> faults, HostedArm& arm, double for_s)
    : faults_(std::move(faults)), arm_(arm), for_s_(for_s) {}

void FaultScript::poll() {
  if (present_ && clock_.now_s() > began_s_.back() + for_s_) {
    present_ = false;
    faults_[began_s_.size() - 1].end();
  }
  if (present_ || began_s_.size() == faults_.size() || !under_way()) return;
  const HostedFault& fault = faults_[began_s_.size()];
  began_s_.push_back(clock_.now_s());
  present_ = true;
  fault.begin();
  const std::vector<TrueTip> tips = arm_.true_tips();
  if (fault.blinds && !tips.empty()) began_s_.back() = std::max(began_s_.back(), tips.back().t_s);
}

nlohmann::json FaultScript::report() const {
  nlohmann::json faults = nlohmann::json::array();
  for (std::size_t i = 0; i < began_s_.size(); ++i) {
    nlohmann::json first_ms = nlohmann::json::array();
    for (std::size_t joint = 0; joint < 3; ++joint)
      for (const double t_s : arm_.drive(joint).commands_s())
        if (t_s > began_s_[i]) {
          first_ms.push_back(1e3 * (t_s - began_s_[i]));
          break;
        }
    faults.push_back({{"fault", faults_[i].name}, {"first_command_ms", first_ms}});
  }
  return faults;
}

bool FaultScript::under_way() {
  const auto sent_s = arm_.drive(0).sent_s();
  return sent_s && clock_.now_s() > *sent_s + kUnderWay_s && arm_.moving();
}

}  // namespace planar::test

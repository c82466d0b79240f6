#include "planar_servo/field/arm/arm_terms.h"

#include <fmt/format.h>

#include <cmath>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

struct Unit {
  double value;
  const char* text;
  const char* suffix;
};
constexpr Unit kLength{kMillimetre, "mm", "_mm"}, kAngle{kDegree, "deg", "_deg"},
    kBend{1e-3, "1e-3 / m", "_per_km"};

/// Lists names of the model's unknowns in their order.
class TermList {
 public:
  explicit TermList(const JointEstimate& estimate)
      : estimate_(estimate), prior_(estimate.model().prior_sigma()) {
    sigma_ = estimate.fit.covariance.diagonal().tail(prior_.size()).cwiseSqrt();
  }

  void add(const std::string& key, const std::string& label, const Unit& unit) {
    constexpr double kMuchBetter = 0.5;
    const auto i = static_cast<Eigen::Index>(terms_.size());
    terms_.push_back({key + unit.suffix, label, estimate_.fit.arm[i], sigma_[i], unit.value,
                      unit.text, sigma_[i] < kMuchBetter * prior_[i]});
  }

  std::vector<ArmTerm> take() { return std::move(terms_); }

 private:
  const JointEstimate& estimate_;
  Eigen::VectorXd prior_, sigma_;
  std::vector<ArmTerm> terms_;
};

}  // namespace

std::vector<ArmTerm> arm_terms(const JointEstimate& estimate) {
  TermList list(estimate);
  for (int i = 1; i <= 2; ++i)
    list.add(fmt::format("link_length_{}", i), fmt::format("link {}", i), kLength);
  for (int i = 1; i <= 3; ++i)
    list.add(fmt::format("zero_offset_{}", i), fmt::format("zero of motor {}", i), kAngle);
  for (int h = 1; h <= estimate.size.harmonics; ++h)
    for (const char* wave : {"sine", "cosine"})
      for (int i = 1; i <= 3; ++i)
        list.add(fmt::format("harmonic_{}_{}_{}", h, wave, i),
                 fmt::format("motor {}, {} {}", i, h, wave), kAngle);
  list.add("height_1", "height with |P|^2", kBend);
  list.add("height_2", "height with |P|^4", kBend);
  list.add("height_difference", "lamp 2 above lamp 1", kLength);
  list.add("separation", "lamps apart", kLength);
  for (const char* axis : {"x", "y"})
    list.add(fmt::format("p_TP_{}", axis), fmt::format("end point {}", axis), kLength);
  for (const char* axis : {"x", "y"})
    list.add(fmt::format("p_TS_{}", axis), fmt::format("reflector {}", axis), kLength);
  return list.take();
}

FoundArm found_arm(const JointEstimate& estimate) {
  const Eigen::VectorXd& x = estimate.fit.arm;
  FoundArm arm{x.head<2>(), x.segment<3>(2), {}};
  for (int h = 1; h <= estimate.size.harmonics; ++h) {
    const Eigen::Index first = 6 * h - 1;
    arm.harmonics.push_back({x.segment<3>(first), x.segment<3>(first + 3)});
  }
  return arm;
}

}  // namespace planar

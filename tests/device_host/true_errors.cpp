#include "device_host/true_errors.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/csv_table.h"
#include "planar_servo/files/tables/target_table.h"

namespace planar::test {
namespace {

/// When each target was looked at last; the exposure that counts is the nearest one.
std::map<std::string, double> last_looks_s(const std::filesystem::path& steps_file) {
  CsvFile steps(steps_file, "steps", {"target", "t_s"});
  std::map<std::string, double> looks_s;
  while (steps.next_row()) {
    const double t_s = steps.number("t_s");
    double& last_s = looks_s[std::string(steps.text("target"))];
    last_s = std::max(last_s, t_s);
  }
  steps.throw_if_faulty_or_empty();
  return looks_s;
}

const TipPose& tip_at(const std::vector<TrueTip>& tips, double t_s) {
  if (tips.empty()) throw InputError("the camera never took a picture", Cause::kMissing);
  return std::min_element(tips.begin(), tips.end(),
                          [t_s](const TrueTip& a, const TrueTip& b) {
                            return std::abs(a.t_s - t_s) < std::abs(b.t_s - t_s);
                          })
      ->tip;
}

}  // namespace

std::vector<double> true_errors(const std::filesystem::path& targets,
                                const std::filesystem::path& run,
                                const std::vector<TrueTip>& tips) {
  const auto looks_s = last_looks_s(run / "steps.csv");
  std::vector<double> errors;
  for (const TargetRow& target : read_targets(targets)) {
    const auto look = looks_s.find(target.id);
    if (look == looks_s.end())
      throw InputError("the target " + target.id + " was never looked at", Cause::kMissing);
    errors.push_back((tip_at(tips, look->second).p - target.p_d).norm());
  }
  return errors;
}

}  // namespace planar::test

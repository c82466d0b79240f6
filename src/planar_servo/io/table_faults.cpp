#include "planar_servo/io/table_faults.h"

#include <algorithm>

namespace planar {
namespace {

/// Returns what faults of the same column for the same reason have in common.
std::string without_value(const Refusal& refusal) {
  return refusal.fault.substr(0, refusal.fault.find('\'')) + '\n' + refusal.remedy;
}

}  // namespace

void TableFaults::add(const Refusal& refusal) {
  constexpr std::size_t kMostKeptOfTable = 100;
  if (std::find(refusals_.begin(), refusals_.end(), refusal) != refusals_.end()) return;
  ++faults_;
  ++counts_[without_value(refusal)];
  if (refusals_.size() < kMostKeptOfTable) refusals_.push_back(refusal);
}

bool TableFaults::is_in_all_rows(const Refusal& refusal) const {
  return counts_.at(without_value(refusal)) >= rows_;
}

void TableFaults::throw_if_any() const {
  constexpr std::size_t kMostAlike = 3;
  if (refusals_.empty()) return;
  std::vector<Refusal> told;
  std::map<std::string, std::size_t> alike;
  for (const Refusal& refusal : refusals_)
    if (++alike[without_value(refusal)] <= kMostAlike || !is_in_all_rows(refusal))
      told.push_back(refusal);
  throw InputError(told, faults_ - told.size());
}

}  // namespace planar

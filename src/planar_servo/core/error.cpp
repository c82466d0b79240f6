#include "planar_servo/core/error.h"

#include <algorithm>
#include <utility>

namespace planar {
namespace {

std::string lines(const std::vector<Refusal>& refusals, std::size_t n_more) {
  std::string text;
  for (const Refusal& refusal : refusals) text += (text.empty() ? "" : "\n") + refusal.text();
  return n_more == 0 ? text : text + "\n... and " + std::to_string(n_more) + " more";
}

}  // namespace

std::string Refusal::text() const {
  return (where.empty() ? "" : where + ": ") + fault + (remedy.empty() ? "" : "; " + remedy);
}

Refusal Refusal::at(const std::string& place) const {
  return {fault, remedy, where.empty() ? place : place + ": " + where};
}

InputError::InputError(std::vector<Refusal> refusals, std::size_t n_more)
    : std::runtime_error(lines(refusals, n_more)), refusals_(std::move(refusals)) {}

void Faults::add(const Refusal& refusal) {
  constexpr std::size_t kMostKept = 100;
  if (std::find(refusals_.begin(), refusals_.end(), refusal) != refusals_.end()) return;
  if (refusals_.size() < kMostKept)
    refusals_.push_back(refusal);
  else
    ++n_more_;
}

void Faults::throw_if_any() const {
  if (!empty()) throw InputError(refusals_, n_more_);
}

}  // namespace planar

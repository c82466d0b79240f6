#include "planar_servo/base/core/error.h"

#include <algorithm>
#include <utility>

#include "planar_servo/base/core/text.h"

namespace planar {
namespace {

constexpr Named<Cause> kCauses[] = {{Cause::kInvalid, "invalid"},
                                    {Cause::kMissing, "missing"},
                                    {Cause::kExists, "exists"},
                                    {Cause::kForeign, "foreign"},
                                    {Cause::kContradiction, "contradiction"},
                                    {Cause::kInsufficient, "insufficient"},
                                    {Cause::kUnreachable, "unreachable"},
                                    {Cause::kBusy, "busy"},
                                    {Cause::kDevice, "device"},
                                    {Cause::kSystem, "system"},
                                    {Cause::kStopped, "stopped"}};

std::string lines(const std::vector<Refusal>& refusals, std::size_t n_more) {
  std::string text;
  for (const Refusal& refusal : refusals) text += (text.empty() ? "" : "\n") + refusal.text();
  return n_more == 0 ? text : text + "\n... and " + std::to_string(n_more) + " more";
}

}  // namespace

const char* to_text(Cause cause) {
  return name_in(kCauses, cause);
}

std::string Refusal::text() const {
  return (where.empty() ? "" : where + ": ") + fault + (remedy.empty() ? "" : "; " + remedy);
}

Refusal Refusal::at(const std::string& place) const {
  return {fault, remedy, where.empty() ? place : place + ": " + where, cause};
}

InputError::InputError(std::vector<Refusal> refusals, std::size_t n_more)
    : std::runtime_error(lines(refusals, n_more)), refusals_(std::move(refusals)) {}

void Faults::add(const Refusal& refusal, std::string_view column) {
  constexpr std::size_t kMostKept = 100;
  const auto is_same = [&](const Kept& kept) { return kept.refusal == refusal; };
  if (std::any_of(kept_.begin(), kept_.end(), is_same)) return;
  const std::string& rule = refusal.remedy.empty() ? refusal.fault : refusal.remedy;
  const std::string likeness = std::string(column) + '\n' + rule;
  ++count_;
  ++alike_[likeness];
  if (kept_.size() < kMostKept) kept_.push_back({refusal, likeness});
}

void Faults::throw_if_any(std::size_t rows) const {
  constexpr std::size_t kMostAlike = 3;
  if (empty()) return;
  std::vector<Refusal> told;
  std::map<std::string, std::size_t> alike;
  for (const auto& [refusal, likeness] : kept_)
    if (++alike[likeness] <= kMostAlike || alike_.at(likeness) < rows) told.push_back(refusal);
  throw InputError(told, count_ - told.size());
}

}  // namespace planar

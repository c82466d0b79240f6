#include "planar_servo/core/error.h"

#include <algorithm>

namespace planar {

std::string Refusal::text() const {
  return remedy.empty() ? fault : fault + "; " + remedy;
}

void Faults::add(const std::string& message) {
  constexpr std::size_t kMostKept = 100;
  if (std::find(messages_.begin(), messages_.end(), message) != messages_.end()) return;
  if (messages_.size() < kMostKept)
    messages_.push_back(message);
  else
    ++n_more_;
}

void Faults::throw_if_any() const {
  if (empty()) return;
  std::string text;
  for (const std::string& message : messages_) {
    if (!text.empty()) text += '\n';
    text += message;
  }
  if (n_more_ > 0) text += "\n... and " + std::to_string(n_more_) + " more";
  throw InputError(text);
}

}  // namespace planar

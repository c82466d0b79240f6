#include "core/error.h"

#include <algorithm>

namespace planar {

void Faults::throw_if_any() const {
  if (empty()) return;
  std::string text;
  for (auto message = messages_.begin(); message != messages_.end(); ++message) {
    if (std::find(messages_.begin(), message, *message) != message) continue;
    if (!text.empty()) text += '\n';
    text += *message;
  }
  throw InputError(text);
}

}  // namespace planar

#include "core/error.h"

namespace planar {

void Faults::throw_if_any() const {
  if (empty()) return;
  std::string text;
  for (const std::string& message : messages_) {
    if (!text.empty()) text += '\n';
    text += message;
  }
  throw InputError(text);
}

}  // namespace planar

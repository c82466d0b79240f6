#pragma once

#include <glib-object.h>

#include <memory>
#include <string>
#include <type_traits>

#include "planar_servo/core/error.h"

namespace planar {

struct Unref {
  void operator()(gpointer object) const { g_object_unref(object); }
};
template <typename T>
using GObjectPtr = std::unique_ptr<T, Unref>;

/// Makes a call that reports its failure by GError, and throws it as a WorkError that begins with
/// `what`.
template <typename Call>
auto ask(const std::string& what, Call call) {
  GError* error = nullptr;
  const auto refuse = [&] {
    if (error == nullptr) return;
    const std::string message = error->message;
    g_error_free(error);
    throw WorkError(what + ": " + message);
  };
  if constexpr (std::is_void_v<decltype(call(&error))>) {
    call(&error);
    refuse();
  } else {
    const auto answer = call(&error);
    refuse();
    return answer;
  }
}

}  // namespace planar

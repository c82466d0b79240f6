#pragma once

#include <functional>
#include <iterator>
#include <type_traits>
#include <vector>

namespace planar {

/// Returns `of` of every element: its member, or a function's value.
template <typename Elements, typename Of>
auto each(const Elements& elements, Of of) {
  std::vector<std::decay_t<decltype(std::invoke(of, *std::begin(elements)))>> all;
  all.reserve(std::size(elements));
  for (const auto& element : elements) all.push_back(std::invoke(of, element));
  return all;
}

}  // namespace planar

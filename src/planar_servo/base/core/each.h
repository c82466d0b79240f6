#pragma once

#include <cstddef>
#include <functional>
#include <iterator>
#include <type_traits>
#include <vector>

namespace planar {

/// Returns `of` of every element: its member, or a function's value.
template <typename Elements, typename Of>
auto each(const Elements& elements, Of of) {
  std::vector<std::decay_t<decltype(std::invoke(of, *std::begin(elements)))>> all;
  all.reserve(static_cast<std::size_t>(std::distance(std::begin(elements), std::end(elements))));
  for (const auto& element : elements) all.push_back(std::invoke(of, element));
  return all;
}

}  // namespace planar

#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"

namespace planar {

/// Returns the value of an order's word. Throws InputError, which names its key, for another one.
template <typename Enum, std::size_t N>
Enum value_in(const Named<Enum> (&table)[N], const std::string& word, const char* key) {
  const auto value = value_named(table, word);
  if (!value)
    throw InputError({fmt::format("is '{}'", word),
                      fmt::format("allowed are {}", fmt::join(names_of(table), ", ")), key});
  return *value;
}

/// Returns a number to four decimal places; null when it is not finite.
inline nlohmann::ordered_json json_number(double value) {
  constexpr double kPlaces = 1e4;
  if (!std::isfinite(value)) return nullptr;
  return std::round(value * kPlaces) / kPlaces + 0.0;
}

template <typename Items, typename ToJson>
nlohmann::ordered_json json_list(const Items& items, const ToJson& to_json) {
  auto list = nlohmann::ordered_json::array();
  for (const auto& item : items) list.push_back(to_json(item));
  return list;
}

inline nlohmann::ordered_json json_numbers(const Eigen::Ref<const Eigen::VectorXd>& values) {
  return json_list(values, json_number);
}

/// Returns a place in millimetres, `[x, y]`.
inline nlohmann::ordered_json json_mm(const Eigen::Vector2d& p) {
  return json_numbers(p / kMillimetre);
}

inline nlohmann::ordered_json refusal_json(const Refusal& refusal) {
  return {{"fault", refusal.fault},
          {"remedy", refusal.remedy},
          {"where", refusal.where},
          {"cause", to_text(refusal.cause)}};
}

/// Returns the first refusal, with all of several as `faults`.
inline nlohmann::ordered_json refusals_json(const std::vector<Refusal>& refusals) {
  nlohmann::ordered_json json = refusal_json(refusals.front());
  if (refusals.size() > 1) json["faults"] = json_list(refusals, refusal_json);
  return json;
}

/// Returns JSON in one line. What is no UTF-8 in its texts is replaced.
inline std::string json_text(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace planar

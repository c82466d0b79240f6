#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace planar {

/// Pairs a value of an enumeration with the word that stands for it in files, options and messages.
/// One constexpr array of these per enumeration serves reading and writing alike.
template <typename Enum>
struct Named {
  Enum value;
  const char* name;
};

/// Returns the word for `value`. Throws std::invalid_argument when the table has none.
template <typename Enum, std::size_t N>
const char* name_in(const Named<Enum> (&table)[N], Enum value) {
  for (const Named<Enum>& entry : table)
    if (entry.value == value) return entry.name;
  throw std::invalid_argument("an enumeration has a value without a name");
}

/// Returns the value that `name` stands for. Empty when the table does not have it.
template <typename Enum, std::size_t N>
std::optional<Enum> value_named(const Named<Enum> (&table)[N], std::string_view name) {
  for (const Named<Enum>& entry : table)
    if (entry.name == name) return entry.value;
  return std::nullopt;
}

/// Returns all values of the table, in its order.
template <typename Enum, std::size_t N>
std::vector<Enum> values_of(const Named<Enum> (&table)[N]) {
  std::vector<Enum> values;
  for (const Named<Enum>& entry : table) values.push_back(entry.value);
  return values;
}

/// Returns all words of the table, in its order.
template <typename Enum, std::size_t N>
std::vector<std::string> names_of(const Named<Enum> (&table)[N]) {
  std::vector<std::string> names;
  for (const Named<Enum>& entry : table) names.emplace_back(entry.name);
  return names;
}

/// Writes `value` with this many decimal places, never as a negative zero ("-0.000").
std::string fixed(double value, int places);

/// Writes each value with this many decimal places, with `separator` between them.
std::string fixed(const Eigen::Ref<const Eigen::VectorXd>& values, int places,
                  std::string_view separator);

/// Writes a position (metres) in millimetres to the micrometre: "(123.456, -7.000) mm".
std::string place_mm(const Eigen::Vector2d& p);

/// Writes a time as roughly as it can be estimated: "about 40 s", "about 2 h 10 min".
std::string about_time(double seconds);

/// Returns a text in UTF-8. One that is not is taken as Latin-1, in which spreadsheets and CAD
/// programs for Windows write.
std::string in_utf8(std::string_view text);

/// Returns the text for a terminal: every control character but the line end and the tabulator is
/// written as `\x1b`, so that what stands in a file or comes from a port controls no terminal.
std::string visible(std::string_view text);

/// Returns the word most similar to this one, the first of several; empty when they differ by more
/// than a letter in three or than two letters. Two letters in each other's place count once.
std::string nearest_word(std::string_view word, const std::vector<std::string>& words);

}  // namespace planar

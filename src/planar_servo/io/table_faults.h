#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "planar_servo/core/error.h"

namespace planar {

/// Collects the faults of a table's rows. Of one that all rows have in the same way, as with a
/// column in another form, the first three are told, else the first hundred of all.
class TableFaults {
 public:
  /// Counts a row, whether it has faults or not.
  void count_row() { ++rows_; }
  /// Adds a fault, which says where the row is.
  void add(const Refusal& refusal);

  /// Throws an InputError of all faults if there is any.
  void throw_if_any() const;

 private:
  bool is_in_all_rows(const Refusal& refusal) const;

  std::size_t rows_{0};
  std::size_t faults_{0};
  std::map<std::string, std::size_t> counts_;  ///< of the faults that differ by their values only
  std::vector<Refusal> refusals_;
};

}  // namespace planar

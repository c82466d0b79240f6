#pragma once

#include <cstddef>
#include <functional>
#include <iosfwd>
#include <nlohmann/json_fwd.hpp>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/files/tables/target_table.h"

namespace planar {

/// Returns the answer to one target.
using TargetAnswer = std::function<nlohmann::ordered_json(const TargetRow&)>;

/// Answers every target on `in` with one line of JSON on `out`, which is flushed at once. The key
/// `line` counts the lines of `in`. A bad line is answered with `error` and is not passed to
/// `answer`; the next line is waited for. Returns the number of bad lines. An exception of `answer`
/// and a header that cannot be used are answered with `error`, too, and then thrown on. Throws
/// WorkError when an answer cannot be written.
std::size_t answer_targets(std::istream& in, std::ostream& out, TargetLines& lines,
                           const TargetAnswer& answer);

/// Returns the outcome under the column names of results.csv. What is not known is left out.
nlohmann::ordered_json result_answer(const TargetResult& result);

/// Counts targets that were only planned.
struct PlannedStream {
  std::size_t targets{0}, refused{0}, bad_lines{0};
};

/// Answers every target on `in` with its first move, as plan_answer() writes it. Nothing moves.
PlannedStream plan_targets(std::istream& in, std::ostream& out, TargetLines& lines,
                           const CellSettings& cell);

}  // namespace planar

#pragma once

#include <cstddef>
#include <functional>
#include <iosfwd>
#include <nlohmann/json_fwd.hpp>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/files/tables/servo_tables.h"
#include "planar_servo/files/tables/target_table.h"

namespace planar {

/// What is told of one target.
using TargetAnswer = std::function<nlohmann::ordered_json(const TargetRow&)>;

/// Answers every target on `in` with one line of JSON on `out`, written out at once. `line` counts
/// the lines of `in`; a bad line is answered with `error`, asks nothing of `answer`, and the next
/// one is waited for. Returns the number of bad lines. An exception of `answer`, or a header that
/// cannot be used, is answered with `error` and goes on to the caller.
std::size_t answer_targets(std::istream& in, std::ostream& out, TargetLines& lines,
                           const TargetAnswer& answer);

/// The outcome under the columns of results.csv, but for what is not known.
nlohmann::ordered_json result_answer(const TargetResult& result);

/// What came of targets that were only planned.
struct PlannedStream {
  std::size_t targets{0}, refused{0}, bad_lines{0};
};

/// Answers every target on `in` with its first move, as plan_answer() has it; nothing moves.
PlannedStream plan_targets(std::istream& in, std::ostream& out, TargetLines& lines,
                           const CellSettings& cell);

}  // namespace planar

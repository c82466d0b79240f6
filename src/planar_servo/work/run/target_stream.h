#pragma once

#include <cstddef>
#include <functional>
#include <iosfwd>
#include <nlohmann/json_fwd.hpp>

#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/files/tables/target_table.h"

namespace planar {

using TargetAnswer = std::function<nlohmann::ordered_json(const TargetRow&)>;

/// Says how a stream of targets went.
struct StreamEnd {
  std::size_t bad_lines{0};
  bool was_said{false};  ///< by the line `end`, after which nothing is read
};

/// Answers every target on `in` with one line of JSON on `out`, which is flushed at once. The key
/// `line` counts the lines of `in`. A bad line is answered with `error` and is not passed to
/// `answer`; the next line is waited for. A line without an end is bad. An exception of `answer`
/// and a header that cannot be used are answered with `error`, too, and then rethrown. Throws
/// WorkError when an answer cannot be written.
StreamEnd answer_targets(std::istream& in, std::ostream& out, TargetLines& lines,
                         const TargetAnswer& answer);

/// Returns the outcome under the column names of results.csv. Unknown values are left out.
nlohmann::ordered_json result_answer(const TargetResult& result);

/// Counts targets that were only planned.
struct FirstMoveStream {
  std::size_t targets{0}, refused{0};
  StreamEnd end;
};

/// Answers every target on `in` with its first move, as first_move_answer() writes it, from
/// these joints on. Nothing moves.
FirstMoveStream answer_first_moves(std::istream& in, std::ostream& out, TargetLines& lines,
                                   const CalibratedCell& cell, const Joints& start,
                                   const std::function<TargetRow(const TargetRow&)>& in_base);

}  // namespace planar

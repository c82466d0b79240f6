#include "planar_servo/work/run/target_stream.h"

#include <istream>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/columns.h"
#include "planar_servo/base/io/csv_table.h"
#include "planar_servo/work/run/dry_run.h"

namespace planar {
namespace {

using Json = nlohmann::ordered_json;

void write_line(std::ostream& out, const Json& answer) {
  constexpr int kOneLine = -1;
  out << answer.dump(kOneLine, ' ', false, Json::error_handler_t::replace) << std::endl;
  if (!out)
    throw WorkError("the answers cannot be written; nobody would learn what moves", Cause::kSystem);
}

}  // namespace

StreamEnd answer_targets(std::istream& in, std::ostream& out, TargetLines& lines,
                         const TargetAnswer& answer) {
  StreamEnd end;
  std::string text;
  while (std::getline(in, text)) {
    const bool has_end = !in.eof();
    if (has_end && trimmed(text) == "end") {
      end.was_said = true;
      break;
    }
    std::optional<TargetRow> target;
    try {
      target = lines.next(text, has_end);
    } catch (const InputError& e) {
      write_line(out, {{"line", lines.line()}, {"error", e.what()}});
      if (!lines.has_columns()) throw;
      ++end.bad_lines;
      continue;
    }
    if (!target) continue;
    Json told{{"line", lines.line()}};
    try {
      told.update(answer(*target));
    } catch (const std::exception& e) {
      write_line(out, {{"line", lines.line()}, {"target", target->id}, {"error", e.what()}});
      throw;
    }
    write_line(out, told);
  }
  return end;
}

Json result_answer(const TargetResult& result) {
  const Columns row = result_columns(result);
  Json told;
  for (const WrittenField& field : row.written()) {
    const bool is_text = field.kind == FieldKind::kText;
    if (field.text.empty() && !(is_text && field.need == Column::kRequired)) continue;
    told[field.column] = is_text                    ? Json(field.text)
                         : Json::accept(field.text) ? Json::parse(field.text)
                                                    : Json();
  }
  return told;
}

FirstMoveStream answer_first_moves(std::istream& in, std::ostream& out, TargetLines& lines,
                                   const CalibratedCell& cell, const Joints& start,
                                   const std::function<TargetRow(const TargetRow&)>& in_base) {
  DryRun dry(cell, start);
  FirstMoveStream planned;
  planned.end = answer_targets(in, out, lines, [&](const TargetRow& target) {
    const DryRunRow row = dry.first_move(in_base(target));
    ++planned.targets;
    if (row.plan.refusal) ++planned.refused;
    return first_move_answer(row);
  });
  return planned;
}

}  // namespace planar

#include "planar_servo/jog/taught_targets.h"

#include <fmt/format.h>

#include <sstream>

#include "planar_servo/core/error.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/csv/csv_table.h"
#include "planar_servo/io/growing_file.h"

namespace planar {
namespace {

/// Returns the text of a table that is to grow; empty when there is no file.
std::string text_of(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return "";
  std::string text = read_file(path);
  if (!text.empty() && text.back() != '\n')
    throw InputError(path.string() +
                     ": the last line does not end with a newline; mend it or name another file");
  return text;
}

std::set<std::string> ids_in(const std::filesystem::path& path) {
  TargetLines lines(path.string());
  const std::string whole = text_of(path);
  std::istringstream text(whole);
  std::set<std::string> ids;
  Faults faults;
  for (std::string line; std::getline(text, line);) {
    const bool had_columns = lines.has_columns();
    try {
      if (const auto target = lines.next(line)) ids.insert(target->id);
    } catch (const InputError& e) {
      if (!lines.has_columns()) throw;
      faults.add(e.what());
    }
    if (lines.has_columns() && !had_columns &&
        split_fields(line) != std::vector<std::string_view>{"id", "x_mm", "y_mm", "phi_deg"})
      throw InputError(
          fmt::format("{}:{}: the header is '{}'; targets can only be added below "
                      "id,x_mm,y_mm,phi_deg; name another file",
                      path.string(), lines.line(), line));
  }
  faults.throw_if_any();
  if (!whole.empty() && !lines.has_columns())
    throw InputError(path.string() +
                     ": has no header; write id,x_mm,y_mm,phi_deg there or name another file");
  return ids;
}

}  // namespace

TaughtTargets::TaughtTargets(std::filesystem::path path)
    : path_(std::move(path)), ids_(ids_in(path_)) {
  require_growable(path_);
}

void TaughtTargets::append(const TargetRow& target) {
  if (target.id.empty()) throw InputError("the id is empty; every target needs one");
  if (ids_.count(target.id) != 0)
    throw InputError(fmt::format("the id '{}' is taken; ids must differ", target.id));
  // What a person has begun was read before and may begin otherwise than our own tables.
  const bool begun = std::filesystem::exists(path_) && !std::filesystem::is_empty(path_);
  GrowingFile(path_, begun ? "" : targets_header())
      .append(target_line(target), Durability::kPowerLoss);
  ids_.insert(target.id);
}

}  // namespace planar

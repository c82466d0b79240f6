#include "app/taught_targets.h"

#include <fmt/format.h>

#include <sstream>

#include "core/error.h"
#include "text/atomic_file.h"
#include "text/csv_table.h"

namespace planar {
namespace {

/// The lines of a table that is to grow; the text of an empty one when there is no file.
std::string text_of(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return targets_header();
  std::string text = read_file(path);
  if (text.empty() || text.back() != '\n')
    throw InputError(path.string() + ": its last line has no end; mend it or name another file");
  return text;
}

std::set<std::string> ids_in(const std::filesystem::path& path) {
  TargetLines lines(path.string());
  std::istringstream text(text_of(path));
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
      throw InputError(fmt::format(
          "{}:{}: the header is '{}'; only a table with the header id,x_mm,y_mm,phi_deg can be "
          "taught more: name another file",
          path.string(), lines.line(), line));
  }
  faults.throw_if_any();
  return ids;
}

}  // namespace

TaughtTargets::TaughtTargets(const std::filesystem::path& path)
    : ids_(ids_in(path)), file_(path, targets_header()) {}

void TaughtTargets::append(const TargetRow& target) {
  if (target.id.empty() || target.id[0] == '#' || target.id.find(',') != std::string::npos)
    throw InputError(
        fmt::format("the id '{}' cannot stand in a table: no comma, no '#' first", target.id));
  if (ids_.count(target.id) != 0)
    throw InputError(fmt::format("the id '{}' is taken; ids must differ", target.id));
  file_.append(target_line(target));
  ids_.insert(target.id);
}

}  // namespace planar

#include "planar_servo/jog/taught_targets.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <string_view>
#include <utility>

#include "planar_servo/core/error.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/csv_table.h"
#include "planar_servo/io/growing_file.h"

namespace planar {
namespace {

/// So many names of a long table are listed.
constexpr std::size_t kNamesTold = 20;

/// Returns the text of a table that is to grow; empty when there is no file.
std::string text_of(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return "";
  std::string text = read_file(path);
  if (!text.empty() && text.back() != '\n')
    throw InputError(
        {"the last line does not end with a newline", "mend it or name another file", path});
  return text;
}

bool lacks_phi(const std::string& header) {
  return split_fields(header) == std::vector<std::string_view>{"id", "x_mm", "y_mm"};
}

/// `has_phi` becomes false for a table without directions.
std::vector<TargetRow> targets_in(const std::filesystem::path& path, bool& has_phi) {
  TargetLines lines(path.string());
  const std::string whole = text_of(path);
  std::istringstream text(whole);
  std::vector<TargetRow> targets;
  Faults faults;
  for (std::string line; std::getline(text, line);) {
    const bool had_columns = lines.has_columns();
    try {
      if (auto target = lines.next(line)) targets.push_back(std::move(*target));
    } catch (const InputError& e) {
      if (!lines.has_columns()) throw;
      for (const Refusal& refusal : e.refusals()) faults.add(refusal);
    }
    if (lines.has_columns() && !had_columns) has_phi = !lacks_phi(line);
    if (lines.has_columns() && !had_columns && has_phi &&
        split_fields(line) != std::vector<std::string_view>{"id", "x_mm", "y_mm", "phi_deg"})
      throw InputError(
          {fmt::format("the header is '{}'; targets can only be added below id,x_mm,y_mm,phi_deg",
                       line),
           "name another file", fmt::format("{}:{}", path.string(), lines.line())});
  }
  faults.throw_if_any();
  if (!whole.empty() && !lines.has_columns())
    throw InputError(
        {"has no header", "write id,x_mm,y_mm,phi_deg there or name another file", path});
  return targets;
}

auto find_target(const std::vector<TargetRow>& targets, const std::string& id) {
  return std::find_if(targets.begin(), targets.end(),
                      [&](const TargetRow& target) { return target.id == id; });
}

std::string names_of(const std::vector<TargetRow>& targets) {
  if (targets.empty()) return "teach one first (command teach ID)";
  std::vector<std::string> names;
  for (const TargetRow& target : targets)
    if (names.size() < kNamesTold) names.push_back(target.id);
  const std::size_t left = targets.size() - names.size();
  return fmt::format("there are {}{}", fmt::join(names, ", "),
                     left > 0 ? fmt::format(" and {} more", left) : "");
}

}  // namespace

TaughtTargets::TaughtTargets(std::filesystem::path path)
    : path_(std::move(path)), targets_(targets_in(path_, has_phi_)) {
  require_growable(path_);
}

void TaughtTargets::append(const TargetRow& target) {
  if (target.id.empty()) throw InputError(Refusal{"the id is empty", "every target needs one"});
  if (find_target(targets_, target.id) != targets_.end())
    throw InputError({fmt::format("the id '{}' is taken", target.id), "ids must differ"});
  // A table begun by a person was read before and may begin unlike our own.
  const bool begun = std::filesystem::exists(path_) && !std::filesystem::is_empty(path_);
  std::string line = target_line(target);
  if (begun && !has_phi_) line = line.substr(0, line.rfind(',')) + '\n';
  GrowingFile(path_, begun ? "" : targets_header()).append(line, Durability::kPowerLoss);
  targets_.push_back(target);
  if (!has_phi_) targets_.back().phi_d.reset();
}

const TargetRow& TaughtTargets::at(const std::string& id) const {
  const auto target = find_target(targets_, id);
  if (target == targets_.end())
    throw InputError({fmt::format("no place '{}' is taught", id), names_of(targets_)});
  return *target;
}

}  // namespace planar

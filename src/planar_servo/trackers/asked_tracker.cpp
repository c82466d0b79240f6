#include "planar_servo/trackers/asked_tracker.h"

#include <fmt/format.h>

#include <utility>

#include "planar_servo/core/clock.h"
#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/io/csv_table.h"

namespace planar {

std::optional<bool> keeps_reading(Operator& person, const std::string& id) {
  if (!person.is_attended()) return std::nullopt;
  for (;;) {
    const std::string word = person.ask(
        fmt::format("press Enter to read '{}' again, or type k to keep this reading: ", id));
    if (word.empty()) return false;
    if (word == "k") return true;
  }
}

AskedTracker::AskedTracker(TrackerDialect dialect, std::shared_ptr<Operator> person)
    : dialect_(std::move(dialect)), person_(std::move(person)) {
  dialect_.csv.renamed_columns = {{"x_mm", "1"}, {"y_mm", "2"}, {"z_mm", "3"}};
}

TrackerAnswer AskedTracker::measure_tool(const std::string& place) {
  return ask(fmt::format("measure the reflector on the tool at '{}'", place));
}

TrackerAnswer AskedTracker::measure_monument(const std::string& id) {
  return ask(fmt::format("place the reflector on '{}', measure it", id));
}

void AskedTracker::await_tool() {
  if (person_->is_attended())
    person_->ask("place the reflector back on the tool and press Enter; the arm will move: ");
}

TrackerAnswer AskedTracker::ask(const std::string& what) {
  const std::string question = fmt::format(
      "{} and press Enter, or type x{}y{}z in {}; s skips, r repeats: ", what,
      dialect_.csv.separator, dialect_.csv.separator, dialect_.unit == kMillimetre ? "mm" : "m");
  for (std::string hint;;) {
    const std::string word = person_->ask(hint + question);
    if (word.empty()) return {TrackerStatus::kElsewhere};
    if (word == "s") return {TrackerStatus::kSkipped};
    if (word == "r") return {TrackerStatus::kRepeat};
    try {
      if (const auto reading = TrackerLines("typed", dialect_).next(word))
        return TrackerAnswer::of({SteadyClock().now_s(), reading->p_L});
    } catch (const InputError& error) {
      hint = fmt::format("{}\n", error.what());
    }
  }
}

}  // namespace planar

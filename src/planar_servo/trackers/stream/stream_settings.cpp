#include "planar_servo/trackers/stream/stream_settings.h"

#include "planar_servo/core/names.h"
#include "planar_servo/io/fields.h"

namespace planar {
namespace {

constexpr Named<double> kUnits[] = {{kMillimetre, "mm"}, {1.0, "m"}};
constexpr Named<bool> kYesOrNo[] = {{true, "true"}, {false, "false"}};

}  // namespace

void read_number_keys(Fields& tracker, TrackerDialect& dialect) {
  if (tracker.given("decimal_comma", false)) {
    tracker.choice("decimal_comma", dialect.csv.decimal_comma, kYesOrNo);
    if (dialect.csv.decimal_comma) dialect.csv.separator = ';';
  }
  if (tracker.given("separator", false)) {
    std::string separator;
    tracker.text("separator", separator);
    const bool one = separator.size() == 1;
    tracker.check(one && !(dialect.csv.decimal_comma && separator == ","),
                  "tracker.separator is '" + separator +
                      "'; one character is needed, and another than ',' with decimal_comma",
                  "separator");
    if (one) dialect.csv.separator = separator[0];
  }
  if (tracker.given("unit", false)) tracker.choice("unit", dialect.unit, kUnits);
}

void read_dialect(Fields& tracker, TrackerDialect& dialect) {
  read_number_keys(tracker, dialect);
  if (!tracker.given("columns", false)) return;
  tracker.map("columns", [&] {
    for (const auto& [word, column] : tracker_columns())
      if (tracker.given(word, false)) tracker.text(word, dialect.csv.renamed_columns[column]);
  });
}

const StreamDetails& stream_details(const CellSettings& cell) {
  return static_cast<const StreamDetails&>(*cell.tracker.details);
}

}  // namespace planar

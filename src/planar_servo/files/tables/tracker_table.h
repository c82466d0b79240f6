#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/csv_table.h"

namespace planar {

/// Holds one row of a recording's tracker.csv: the reflector's centre in the tracker's frame,
/// metres.
struct TrackerRow {
  std::string id;
  double t_s{0.0};
  Eigen::Vector3d p_L{0.0, 0.0, 0.0};
};

// The table grows: the header first, then a line at a time.
std::string tracker_header();
std::string tracker_line(const TrackerRow& row);

/// Maps the names that options and cell files have for the parts of a reading to our columns: "id",
/// "t", "x", "y" and "z".
const std::map<std::string, std::string>& tracker_columns();

/// Reads `x=X,y=Y` and returns for each of our columns the name that it has in the tracker's table.
/// Throws InputError for anything else.
std::map<std::string, std::string> renamed_tracker_columns(const std::string& text);

/// The units in which readings are written.
constexpr Named<double> kTrackerUnits[] = {{kMillimetre, "mm"}, {1.0, "m"}};

/// Says how another program writes readings. A column is named or, where x, y and z all are whole
/// numbers, counted from 1; the lines have no header then.
///
/// A blank as separator stands for any run of blanks and tabs. Lines that begin with `//` are
/// comments.
struct TrackerDialect {
  CsvDialect csv;
  double unit{kMillimetre};  ///< of x, y and z, metres

  /// Returns true when the lines say which point was read.
  bool has_ids() const { return csv.renamed_columns.count("id") != 0; }
};

/// Holds one reading as another program wrote it: the reflector's centre in the tracker's frame.
struct StreamedReading {
  std::string id;             ///< empty unless the dialect names its column
  std::optional<double> t_s;  ///< on the tracker's clock; empty unless the dialect names its column
  Eigen::Vector3d p_L{0.0, 0.0, 0.0};  ///< metres
  double resolution{0.0};              ///< the last digit that was written, metres
};

/// Reads RECORDING/tracker.csv, or another program's table of readings, in which lines of titles
/// may stand before the first reading. Only where they are to be paired `by_time` need they say
/// when they were made. Throws InputError naming FILE:LINE of each bad row, and for a table without
/// rows.
std::vector<TrackerRow> read_tracker(const std::filesystem::path& path,
                                     const TrackerDialect& dialect = {}, bool by_time = false);

/// Reads a tracker's lines as they arrive.
class TrackerLines {
 public:
  /// Begins before the first line. `source` stands in messages.
  TrackerLines(const std::string& source, TrackerDialect dialect);

  /// Returns the reading on the next line. Empty for a header, a comment and a blank line. Throws
  /// InputError with SOURCE:LINE, value and rule for a line that is no reading, such as one without
  /// coordinates while the beam is broken. The next line can be taken then.
  std::optional<StreamedReading> next(std::string_view line);

  bool has_columns() const { return table_.has_header(); }

 private:
  std::string counted_fields(std::string_view line) const;
  double resolution() const;

  TrackerDialect dialect_;
  std::size_t counted_{0};  ///< the last column that is counted; 0 where columns are named
  CsvTable table_;
  int line_{0};
};

}  // namespace planar

#pragma once

#include <string>
#include <vector>

#include "planar_servo/experiment/experiment.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// A table of the paper as it is shown.
struct ShownTable {
  TextTable table;
  std::string look_at;  ///< sentences that say what the table shows and what to look at
};

/// Lists the rows of the paper's tables, which have the keys `table1` to `table7`; the last without
/// the row of all circles.
ReportList tables_list(const PaperTables& tables);

/// Returns the tables that there are, in the paper's order.
std::vector<ShownTable> shown_tables(const ExperimentReport& report);

/// Explains the marks and letters in the tables, a line each: what the virtual cell was fitted to,
/// and what the paper's accuracy cannot see.
std::string marks_text(const ExperimentReport& report);

}  // namespace planar

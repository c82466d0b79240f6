#pragma once

#include <string>

#include "planar_servo/console/cell_jobs.h"
#include "planar_servo/console/page_operator.h"

namespace planar {

/// What a recording from the page is made by.
struct RecordingOrder {
  std::string plan, out;  ///< names in the cell's folder
  std::string board{};    ///< as --grid takes it; empty for none
  std::string on_bad_reading{"repeat"};
};

/// Records cells as planar-record does, with the person at a page. All functions may be called from
/// any thread.
class RecordingJob {
 public:
  /// All must outlive it.
  RecordingJob(const KnownCell& cell, StateBoard& board, CellJobs& jobs, PageSeat& seat)
      : cell_(cell), board_(board), jobs_(jobs), seat_(seat) {}

  /// Begins or continues a recording and returns the number of its job once its files are read.
  /// Throws as the functions of CellJobs do.
  int begin(const RecordingOrder& order, StopsKnown known);

 private:
  const KnownCell& cell_;
  StateBoard& board_;
  CellJobs& jobs_;
  PageSeat& seat_;
};

}  // namespace planar

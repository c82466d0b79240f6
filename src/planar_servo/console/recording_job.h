#pragma once

#include <memory>
#include <mutex>
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
  RecordingJob(const KnownCell& cell, StateBoard& board, CellJobs& jobs)
      : cell_(cell), board_(board), jobs_(jobs) {}

  /// Begins or continues a recording and returns the number of its job once its files are read.
  /// Throws as the functions of CellJobs do.
  int begin(const RecordingOrder& order);

  /// Answers the question of this number; confirms what is advised. Throw CellBusy where that is
  /// not asked for.
  void answer(int question, const std::string& text);
  void confirm();

 private:
  std::shared_ptr<PageOperator> person();
  void set_person(std::shared_ptr<PageOperator> person);

  const KnownCell& cell_;
  StateBoard& board_;
  CellJobs& jobs_;
  std::mutex mutex_;
  std::shared_ptr<PageOperator> person_;  ///< of the recording under way; null without one
};

}  // namespace planar

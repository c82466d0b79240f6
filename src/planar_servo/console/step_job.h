#pragma once

#include <functional>
#include <string>

#include "planar_servo/console/cell_jobs.h"

namespace planar {

/// Does what is next of the work on a cell, as `planar next` names it, where that only reads and
/// writes files, from the plan to the found arm. Makes experiments on virtual cells, too.
class StepJob {
 public:
  /// The worker's thread calls `changed` when a step has made new files. All must outlive it.
  StepJob(const KnownCell& cell, StateBoard& board, CellJobs& jobs, std::function<void()> changed)
      : cell_(cell), board_(board), jobs_(jobs), changed_(std::move(changed)) {}

  /// Begins the step that is next and returns the number of its job. `board` is the calibration
  /// board, as --grid takes it. Throws InputError where nothing is left, or a person must do it
  /// otherwise, and as the functions of CellJobs do.
  int begin(const std::string& board, StopsKnown known);
  /// Begins or continues planar-experiment on a copy of this virtual cell in the folder `name`
  /// beside the cell file, and returns as begin() does. Throws InputError for a real cell.
  int begin_experiment(const std::string& name, StopsKnown known);

 private:
  /// Begins a job that runs a command. `finish` makes the words of a good end from its last line.
  int follow(const std::string& kind, const std::string& name, const std::string& command,
             StopsKnown known, const std::function<std::string(const std::string& said)>& finish);

  const KnownCell& cell_;
  StateBoard& board_;
  CellJobs& jobs_;
  std::function<void()> changed_;
};

}  // namespace planar

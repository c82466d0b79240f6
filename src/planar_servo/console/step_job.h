#pragma once

#include <functional>
#include <string>

#include "planar_servo/console/cell_jobs.h"

namespace planar {

/// Does what is next of the work on a cell, as `planar next` names it, where that only reads and
/// writes files: the plan, and all from the camera to the found arm. Makes experiments on virtual
/// cells, too.
class StepJob {
 public:
  /// `changed` is called by the worker's thread when a step has made new files. All must outlive
  /// it.
  StepJob(const KnownCell& cell, StateBoard& board, CellJobs& jobs, std::function<void()> changed)
      : cell_(cell), board_(board), jobs_(jobs), changed_(std::move(changed)) {}

  /// Begins the step that is next and returns the number of its job. `board` is the calibration
  /// board, as --grid takes it. Throws InputError where nothing is left, or a person must do it
  /// otherwise, and as the functions of CellJobs do.
  int begin(const std::string& board, StopsKnown known);
  /// Begins or continues an experiment on a copy of this virtual cell, by planar-experiment in the
  /// folder `name` beside the cell file, and returns as begin() does. Throws InputError for a real
  /// cell.
  int begin_experiment(const std::string& name, StopsKnown known);

 private:
  /// Begins a job that runs a command. Once that has ended well, `finish` is told the last line and
  /// returns the words for the job's end.
  int follow(const std::string& kind, const std::string& name, const std::string& command,
             StopsKnown known, const std::function<std::string(const std::string& said)>& finish);

  const KnownCell& cell_;
  StateBoard& board_;
  CellJobs& jobs_;
  std::function<void()> changed_;
};

}  // namespace planar

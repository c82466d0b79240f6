#pragma once

#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/certificate/certify.h"
#include "planar_servo/console/cell_jobs.h"
#include "planar_servo/console/page_operator.h"
#include "planar_servo/work/run/path_run.h"

namespace planar {

/// What a recording from the page is made by.
struct RecordingOrder {
  std::string plan, out;  ///< names in the cell's folder
  std::string board{};    ///< as --grid takes it; empty for none
  std::string on_bad_reading{"repeat"};
};

/// Follows a path as planar-servo does. Any thread may call it.
class PathJob {
 public:
  /// All must outlive it.
  PathJob(const KnownCell& cell, CellJobs& jobs) : cell_(cell), jobs_(jobs) {}

  /// Keeps the rows of a table as the path that is followed next; none for an empty text. Throws
  /// InputError with every fault, and for a path that the arm cannot follow at any speed.
  void load(const std::string& csv);
  /// Returns the table with the path's length and its places, near enough to draw lines between.
  nlohmann::ordered_json json() const;

  /// Follows the path once at each speed under each guidance, in the folder `name` beside the cell
  /// file. Returns and throws as the functions of CellJobs do; throws InputError for speeds and
  /// ways that planar-servo refuses, too.
  int begin(const std::string& name, const std::vector<double>& speeds_mm_s,
            const std::vector<Guidance>& guidances, StopsKnown known);

 private:
  struct Table {
    std::string csv;
    Path path;
  };

  CellJobs::Ending follow(const ServoRequest& request, const PathRequest& path,
                          const std::string& csv, CellDevices& devices,
                          const CellJobs::Begun& begun);
  /// Shows a look, and how far the job has come after so many passes over the path.
  void show(const PathLookRow& row, const PathRequest& path, std::size_t passed);

  const KnownCell& cell_;
  CellJobs& jobs_;
  mutable std::mutex mutex_;
  std::optional<Table> table_;
};

/// The work that is begun at a console.
struct ConsoleJobs {
  // All must outlive it.
  const KnownCell& cell;
  StateBoard& board;
  CellWorker& worker;
  /// Is called by the worker's thread when a step has made new files.
  std::function<void()> changed;

  CellJobs places{cell, board, worker};
  PageOperator person{board};
  PathJob path{cell, places};
};

// Begin a job; return and throw as the functions of CellJobs do.
/// Begins or continues a recording as planar-record does.
int begin_recording(ConsoleJobs& jobs, const RecordingOrder& order, StopsKnown known);
/// Begins a certificate as planar-certify does in the folder `name` beside the cell file, or
/// continues the one that was broken off there. Throws InputError for sizes that planar-certify
/// refuses, too.
int begin_certificate(ConsoleJobs& jobs, const std::string& name, const CertificateSize& size,
                      StopsKnown known);
/// Begins what is next of the work, as `planar next` names it with this calibration board, where
/// that only makes files. Throws InputError where nothing is left or a person must do it, too.
int begin_step(ConsoleJobs& jobs, const std::string& board, StopsKnown known);
/// Begins or continues planar-experiment on a copy of this virtual cell in the folder `name` beside
/// the cell file. Throws InputError for a real cell, too.
int begin_experiment(ConsoleJobs& jobs, const std::string& name, StopsKnown known);

}  // namespace planar

#pragma once

#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/console/cell_jobs.h"
#include "planar_servo/work/run/path_run.h"

namespace planar {

/// Follows a path as planar-servo does. All functions may be called from any thread.
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
  /// file, and returns the number of the job once its files are read. Throws as the functions of
  /// CellJobs do, and InputError for speeds and ways that planar-servo refuses.
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

}  // namespace planar

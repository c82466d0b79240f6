#pragma once

#include <filesystem>
#include <vector>

#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/work/run/ready_cell.h"

namespace planar {

/// Removes the files and folders of a run that failed before it moved anything.
class RunFolder {
 public:
  /// Notes which of this folder, those above it and these files in it do not exist yet. Makes
  /// nothing.
  RunFolder(const std::filesystem::path& folder, const std::vector<const char*>& files);
  /// Removes what was noted, folders only if they are empty, when an exception ends the run, unless
  /// keep() was called.
  ~RunFolder();
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;

  void keep() { made_.clear(); }

 private:
  std::vector<std::filesystem::path> made_;  ///< the deepest first
  int exceptions_;                           ///< that were in flight at the beginning
};

/// Returns the table to which a request's run adds its results.
std::filesystem::path results_file(const ServoRequest& request);

/// Returns the files that a run is made with, and all tools of its cell.
std::vector<Origin> run_origins(const ServoRequest& request);

/// Returns these and the servo's settings as comment lines of the table of results.
std::vector<std::string> run_remarks(const ServoRequest& request);

/// Returns the run's folder, which exists then. Throws InputError when there is no run to continue,
/// and when the folder holds that of a path.
const std::filesystem::path& folder_for(const ServoRequest& request);

/// Returns the results that the folder holds. Throws InputError when it holds some although no run
/// is to be continued, and when they were made with other files or settings.
std::vector<TargetResult> results_so_far(const ServoRequest& request);

/// The files of a run over targets, open for what comes.
struct RunFiles {
  /// Throws as folder_for() and results_so_far() do, and when another program writes there.
  explicit RunFiles(const ServoRequest& request);

  RunFolder folder;
  FolderLock lock;
  std::vector<TargetResult> begun;  ///< results that the folder holds
  std::filesystem::path table_file;
  std::string table_header;
  GrowingFile steps;
  GrowingFile table;
};

/// Throws InputError when the target `id` has a result already, but of another place or direction
/// than its `goal`.
void require_same_goal(const std::string& id, const TipPose& goal,
                       const std::vector<TargetResult>& results);

}  // namespace planar

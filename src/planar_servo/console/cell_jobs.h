#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/console/cell_worker.h"
#include "planar_servo/console/known_cell.h"
#include "planar_servo/console/state_board.h"
#include "planar_servo/run/servo_run.h"
#include "planar_servo/tables/target_table.h"

namespace planar {

/// The work of a console that visits places by vision: a table of targets, one place, or the check
/// of the cell. All functions may be called from any thread; those that begin a job return its
/// number once its files are read, and throw InputError for files or targets that cannot be used,
/// CellBusy while the cell is at work.
class CellJobs {
 public:
  /// Begins with the targets that were taught. All must outlive the jobs.
  CellJobs(const KnownCell& cell, StateBoard& board, CellWorker& worker);

  /// Keeps the rows of a table as the targets of the next run. Throws InputError with every fault.
  void load_targets(const std::string& csv);
  /// Keeps the taught targets anew where no others were loaded.
  void read_taught();
  std::vector<TargetRow> targets() const;

  /// Runs over the targets kept, in the folder `name` beside the cell file.
  int run(const std::string& name, bool resume);
  int go(const TargetRow& target);
  int check();

 private:
  using Begun = std::function<void()>;
  using Stop = std::function<bool()>;
  struct Ending {
    std::string words;
    bool ok{false};
  };
  /// Calls `begun` once all is read. Returns how the job ended.
  using Work = std::function<Ending(CellDevices&, const Stop&, const Begun&)>;

  int begin(Doing doing, const std::string& kind, const std::string& name, std::size_t all,
            Work work);
  /// Shows a new job and returns its number.
  int begin_state(const std::string& kind, const std::string& name, std::size_t all);
  /// Shows what holds the cell; nothing for an empty reason.
  void hold(const std::string& reason);
  void end(const Ending& ending);
  void require_able() const;
  ServoRequest request(const Stop& stop) const;
  std::unique_ptr<ServoRun> opened(const ServoRequest& request, CellDevices& devices);
  void tell_result(const TargetResult& result, std::size_t done, std::size_t all, double each_s);

  const KnownCell& cell_;
  StateBoard& board_;
  CellWorker& worker_;
  SteadyClock clock_;

  mutable std::mutex mutex_;
  std::vector<TargetRow> targets_;
  bool loaded_{false};  ///< targets_ came by load_targets()
  // Of the worker's thread.
  int last_job_{0};
  std::optional<double> well_s_;  ///< when the cell was found well last
};

}  // namespace planar

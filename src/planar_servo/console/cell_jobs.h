#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planar_servo/console/cell_worker.h"
#include "planar_servo/console/known_cell.h"
#include "planar_servo/console/state_board.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/hardware/robot/homing.h"
#include "planar_servo/work/run/servo_run.h"

namespace planar {

/// The work of a console that visits places by vision: a table of targets, one place, or the check
/// of the cell. All functions may be called from any thread; those that begin a job return its
/// number once its files are read, and throw InputError for files or targets that cannot be used,
/// WorkError, kBusy, while the cell is at work.
class CellJobs {
 public:
  /// All must outlive the jobs.
  CellJobs(const KnownCell& cell, StateBoard& board, CellWorker& worker);

  /// Targets as they were loaded or taught: in the drawing of the works of a file of the cell's
  /// folder, or without one in the base frame; for a tool of the cell, or without one for P.
  struct Wanted {
    std::vector<TargetRow> drawn;
    std::string work{}, tool{};
  };
  /// Keeps the rows of a table as the targets of the next run; those that were taught for an empty
  /// text. Throws InputError with every fault.
  void load_targets(const std::string& csv, const std::string& work, const std::string& tool);
  /// Returns targets that were loaded, or else taught. Throws InputError for faults of the latter.
  Wanted wanted();
  /// Returns them in the base frame. Throws InputError for works and tools of other calibrations.
  std::vector<TargetRow> targets() { return placed(wanted()).targets; }
  /// Returns the names of the cell folder's files of works.
  std::vector<std::string> works() const;

  /// Adds a place that was just taught to the targets that were loaded, if any were.
  void take_taught(const std::string& id);
  /// Lets the next job check the cell first, because its zeros are new.
  void forget_check() { well_s_ = kNever; }
  /// Returns the results of the present or last job.
  std::vector<nlohmann::ordered_json> results();

  /// Runs over the targets kept, in the folder `name` beside the cell file.
  int run(const std::string& name, bool resume, StopsKnown known);
  /// Goes to a place of the base frame, with the tip of the tool that it names.
  int go(const TargetRow& place, StopsKnown known);
  int check(StopsKnown known);

  /// How a job ended, in words.
  struct Ending {
    std::string words;
    bool ok{false};
    const char* level{ok ? "info" : "error"};  ///< of the line that tells it
    std::optional<Cause> cause{};              ///< of the refusal that ended it
  };
  /// Says of how many places the job has done how many when it begins.
  using Begun = std::function<void(std::size_t done, std::size_t all)>;
  using Stop = std::function<bool()>;
  /// Calls it once all is read.
  using Work = std::function<Ending(CellDevices&, const Stop&, const Begun&)>;
  int begin(Doing doing, const std::string& kind, const std::string& name, StopsKnown known,
            const Work& work);

  // For jobs of other kinds.
  /// Is asked by jobs whether they may home drives, and says by a DriveError who does.
  static bool refuse_homing(Homing way, const std::string& unhomed);
  /// Throws InputError, at `where`, for a name that is long or has more than letters, digits and
  /// these marks, or begins with a dot.
  static void require_name(const std::string& name, std::string_view marks, const char* where);
  /// Returns the folder of this name beside the cell file. Throws InputError for another name.
  std::filesystem::path folder(const std::string& name) const;
  /// Returns how this cell moves by vision, learning nothing. It has no folder yet.
  ServoRequest request(const Stop& stop);
  /// Shows where vision sees the end point.
  void show_look(const TipMeasurement& seen, const Eigen::Vector2d& p_B);
  ServoRun::Observer watch();
  /// Tells a result of the job, an object.
  void tell_result(nlohmann::ordered_json result);
  void show_progress(std::size_t done, std::size_t all, std::optional<double> left_s);
  /// Shows the progress with the time left, as the places since the first one took.
  void show_progress(std::size_t done, std::size_t all);
  /// Shows what holds the cell; nothing for an empty reason.
  void hold(const std::string& reason);

 private:
  struct Placed {
    std::vector<TargetRow> targets;
    std::shared_ptr<const LaidWorks> works;
  };
  Placed placed(const Wanted& wanted) const;
  /// Shows a new job and returns its number.
  int begin_state(JobState job);
  void note_findings(const std::vector<HealthFinding>& found);
  void end(const Ending& ending);
  void require_able() const;
  ServoRequest request_for_targets(const Stop& stop, const std::filesystem::path& out);

  const KnownCell& cell_;
  StateBoard& board_;
  CellWorker& worker_;
  SteadyClock clock_;

  std::mutex mutex_;
  Wanted loaded_;  ///< without targets, those that were taught
  std::vector<nlohmann::ordered_json> results_;
  /// How many places a job has done at first, and when: checks before it are not in its time.
  struct FirstPlace {
    std::size_t done;
    double at_s;
  };

  // Of the worker's thread.
  int last_job_{0};
  std::optional<FirstPlace> first_{};

  static constexpr double kNever{-1e9};
  std::atomic<double> well_s_{kNever};  ///< when the cell was found well last
};

}  // namespace planar

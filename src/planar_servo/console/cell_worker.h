#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "planar_servo/console/known_cell.h"
#include "planar_servo/console/picture_watch.h"
#include "planar_servo/console/state_board.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/jog/jog_console.h"

namespace planar {

/// The stops of the cell that whoever gave an order knew of.
using StopsKnown = std::uint64_t;

/// Works a cell's devices on one thread, one task after the other; between tasks it takes pictures
/// while anybody watches. A stop ends what is under way and all that was ordered before it: what
/// begins a task takes the stops its order knew of, and throws WorkError, kStopped, once there were
/// more. All functions may be called from any thread.
class CellWorker {
 public:
  /// Opens the devices. `interrupted` is asked during every move. Throws as open_cell() and
  /// JogConsole() do.
  CellWorker(const KnownCell& cell, StateBoard& board, std::function<bool()> interrupted);
  /// Stops what moves and ends the thread.
  ~CellWorker();
  CellWorker(const CellWorker&) = delete;
  CellWorker& operator=(const CellWorker&) = delete;

  /// Performs a command of these words as JogConsole does. Throws WorkError, kBusy, while another
  /// task is not done.
  std::string command(const ArmCommand& command, const std::string& words, StopsKnown known);
  /// Begins a command that moves the arm as long as keep() is called every kHold_s; then it slows
  /// down to rest. Returns the number of the first state that says so. Throws as command() does,
  /// and InputError for a command that moves no joint and no end point.
  std::uint64_t hold(const ArmCommand& command, const std::string& words, StopsKnown known);
  /// Says that whoever holds the arm is still there. Returns false when nothing is held.
  bool keep();
  static constexpr double kHold_s{0.2};

  /// Work that takes the arm over from the jogging: it uses `devices`, and ends with an exception
  /// where `stop` returned true. What it returns tells of the end, and is called as the cell gets
  /// idle, so that whoever hears of it may order at once.
  using Tell = std::function<void()>;
  using Job = std::function<Tell(CellDevices& devices, const std::function<bool()>& stop)>;
  /// Begins a job and returns at once. Throws as command() does.
  void begin(Doing doing, const std::string& text, StopsKnown known, Job job);

  /// Shows what a check of the cell has found until the next one; for jobs.
  void note_findings(std::vector<Refusal> findings);

  /// Lets what moves slow down to rest and ends the task. Returns whether there was one.
  bool stop();
  /// The same for another operator, whose orders cannot have been on their way before it.
  bool hand_over();
  /// Returns the stops that an order knows of which comes now: `seen`, where its sender says so.
  /// Otherwise it may have been sent before a stop of the last moments.
  StopsKnown stops_known(std::optional<StopsKnown> seen);
  static constexpr double kOnItsWay_s{0.3};
  /// Takes no more tasks, because the cell is opened anew.
  void close() { closed_ = true; }
  /// Waits until nothing is under way, so long at most. Returns whether that is so.
  bool wait_for_rest(double most_s);

  /// Says that somebody looks at the pictures now.
  void watch() { watched_s_ = clock_.now_s(); }
  Pictures& pictures() { return pictures_.pictures(); }

 private:
  struct Task {
    Doing doing{Doing::kIdle};
    std::string text;
    std::function<void()> act;
    Tell at_end{};           ///< may be empty
    std::uint64_t begun{0};  ///< number of the first state that shows it
    std::atomic<bool> stopped{false};
    std::atomic<double> held_until_s;
  };

  void open_jog();
  std::shared_ptr<Task> post(Doing doing, const std::string& text, StopsKnown known,
                             std::function<void()> act, bool held = false);
  bool stop_locked();
  void work();
  std::shared_ptr<Task> next_task();
  void perform(const std::shared_ptr<Task>& task);
  void idle();
  /// Takes a picture, unless the camera is at fault.
  void look();
  bool is_watched() const;
  bool must_stop() const;
  /// Tells what `act` throws.
  void attempt(const std::function<void()>& act);
  /// Shows where arm and camera are.
  void note_devices();
  /// Shows that nothing is done, unless a task has come; `ended` has ended, if it is one.
  void note_idle(const std::shared_ptr<Task>& ended);
  void see_drives(const std::array<DriveStatus, 3>& drives);
  void see_fault(const std::optional<std::string>& fault);
  /// Looks again at the files that moves depend on.
  void read_doubts();
  void publish_doubts();

  const KnownCell& cell_;
  StateBoard& board_;
  std::function<bool()> interrupted_;
  SteadyClock clock_;
  PictureWatch pictures_;
  std::unique_ptr<CellDevices> devices_;
  std::unique_ptr<JogConsole> jog_;

  // Of the thread.
  std::shared_ptr<Task> performed_;
  std::array<DriveStatus, 3> drives_;
  std::optional<std::string> camera_fault_;
  std::vector<Refusal> file_doubts_, findings_;
  std::vector<Refusal> teach_doubts_;  ///< why nothing can be taught
  double idle_s_{0.0};                 ///< when the thread last looked

  std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<Task> task_;  ///< not done yet
  StopsKnown stops_;
  double stopped_s_{-1e9};  ///< by the steady clock
  std::atomic<double> watched_s_{-1e9};
  std::atomic<bool> ending_{false}, closed_{false};
  std::thread thread_;
};

}  // namespace planar

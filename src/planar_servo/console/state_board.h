#pragma once

#include <Eigen/Core>
#include <array>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/purpose.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/work/record/recording_state.h"

namespace planar {

/// Names the files of a cell's folder relative to it, in texts for those who do not see its disk.
class CellNames {
 public:
  /// Leaves all texts as they are.
  CellNames() = default;
  explicit CellNames(const std::filesystem::path& cell_file);

  std::string in(std::string text) const;

 private:
  std::vector<std::string> prefixes_;  ///< how the folder's files may be named, as JSON has it
};

enum class Doing {
  kIdle,
  kMoving,
  kLooking,
  kHoming,
  kWaiting,
  kRecording,
  kRunning,
  kChecking,
  kCalculating
};

constexpr Named<Doing> kDoings[] = {{Doing::kIdle, "idle"},
                                    {Doing::kMoving, "moving"},
                                    {Doing::kLooking, "looking"},
                                    {Doing::kHoming, "homing"},
                                    {Doing::kWaiting, "waiting"},
                                    {Doing::kRecording, "recording"},
                                    {Doing::kRunning, "running"},
                                    {Doing::kChecking, "checking"},
                                    {Doing::kCalculating, "calculating"}};

/// Where an arm stands. Lengths in metres, angles in radians.
struct ArmStand {
  Joints theta{0.0, 0.0, 0.0};
  Eigen::Vector2d elbow_B{0.0, 0.0};
  TipPose tip;
};

/// The arm as its drives report it.
struct ArmState {
  bool enabled{false};
  std::optional<ArmStand> stand{};  ///< none before all drives know their position
  std::string to_do{};              ///< what is to be done before it can move; empty when it can
};

/// A lamp of the tool in the last picture.
struct LampState {
  Eigen::Vector2d uv_px{0.0, 0.0};
  double edge_px{0.0};  ///< width of its edge
  bool saturated{false};
};

struct FixedLampState {
  std::string id;
  Eigen::Vector2d uv_px{0.0, 0.0};
  double moved_px{0.0};  ///< since the calibration
};

/// Work on more than one place, such as a table of targets.
struct JobState {
  int id{0};
  std::string kind, name;
  std::size_t done{0}, all{0};
  std::optional<double> left_s{};
  std::string ended{};           ///< how it ended, in words; empty while it runs
  bool ok{false};                ///< valid once it has ended
  std::optional<Cause> cause{};  ///< of a refusal that ended it
};

/// What a person at the page is asked.
struct PageQuestion {
  int id{0};
  std::string text;
};
/// All that the page shows of the moment.
struct CellState {
  int opened{0};           ///< how often the cell's files were read
  std::uint64_t stops{0};  ///< how often the cell was stopped
  Doing doing{Doing::kIdle};
  std::string text{"idle"};
  double since_s{0.0};  ///< by the steady clock
  /// The places of a check of the cell that is under way.
  std::optional<std::vector<Eigen::Vector2d>> checking_B{};
  std::string held_by{};
  std::string mover{};  ///< the client that moves the cell
  std::optional<ArmState> arm{};
  std::optional<Eigen::Vector2d> seen_B{};
  std::uint64_t picture{0};
  double picture_s{0.0};  ///< when it was taken, by the steady clock
  CameraExposure exposure{};
  std::optional<std::array<LampState, 2>> lamps{};
  std::optional<double> edge_px{}, best_edge_px{};
  std::vector<FixedLampState> fixed_lamps{};
  std::vector<Refusal> doubts{};
  std::optional<JobState> job{};
  std::optional<PageQuestion> question{};
  std::string advice{};  ///< what is the case for the person at the page; empty without one
  std::optional<RecordingState> recording{};
};

/// Holds the state of a cell and what has happened lately, for many readers and one who works the
/// cell. The text for all readers is made once.
class StateBoard {
 public:
  explicit StateBoard(CellNames names = {}) : names_(std::move(names)) {}

  /// Returns what is told to readers with the files of the cell's folder named relative to it.
  std::string named(std::string text) const { return names_.in(std::move(text)); }
  /// Returns the number of the state that the change makes.
  std::uint64_t change(const std::function<void(CellState&)>& change);
  /// Notes what is done now, and since when if that is new; returns as change() does.
  std::uint64_t note(Doing doing, const std::string& text);
  /// Tells all readers of events, as `event: NAME` with these data.
  void tell(const char* event, const nlohmann::ordered_json& data);
  void tell_line(const char* level, const std::string& text);

  CellState state() const;
  nlohmann::ordered_json json() const;

  /// Where a reader of events is.
  struct Reader {
    std::uint64_t event{0};    ///< the last one read
    std::uint64_t version{0};  ///< of the state read last
    double state_s{-1.0};      ///< when that was read
  };
  /// Returns the text of the events and of the state that this reader has not read; it waits for
  /// them, a second at most. Empty once close() was called.
  std::string next(Reader& reader);
  /// Ends all waiting, for good or until open().
  void close();
  /// Says that the cell's files were read anew.
  void open();

 private:
  std::string unread_events(Reader& reader) const;
  nlohmann::ordered_json json_locked() const;
  const std::string& state_event();

  std::string event_text(const char* event, const nlohmann::ordered_json& data) const;

  CellNames names_;
  mutable std::mutex mutex_;
  std::condition_variable changed_, told_;  ///< the state, and the events
  SteadyClock clock_;
  CellState state_;
  std::uint64_t version_{1};
  std::string text_;  ///< of the state, for all readers
  std::uint64_t text_version_{0};
  double text_s_{0.0};
  std::deque<std::pair<std::uint64_t, std::string>> events_;
  std::uint64_t last_event_{0};
  bool closed_{false};
};

}  // namespace planar

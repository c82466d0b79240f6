#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "planar_servo/base/core/operator.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/text.h"

namespace planar {

/// Who judges a cell: the truth of a virtual one, or the tracker of a real one.
enum class JudgeKind { kTruth, kTracker };

constexpr Named<JudgeKind> kJudgeKinds[] = {{JudgeKind::kTruth, "truth"},
                                            {JudgeKind::kTracker, "tracker"}};

/// How the arm stands, for all that is known without a judge.
struct Standing {
  Eigen::Vector3d theta_c{0.0, 0.0, 0.0};  ///< commanded joints, radians
  std::optional<TipPose> seen{};           ///< the tool by the cell's own vision, base frame
};

/// Where the tool is by somebody who is not the cell's own camera, base frame.
struct JudgedTip {
  std::optional<Eigen::Vector2d> p;  ///< the end point, metres; empty where nobody could tell
  double sigma{0.0};                 ///< of p per axis, without what all answers have in common
  std::string fault;                 ///< why nobody could tell; empty where somebody could
  std::optional<double> phi{};       ///< empty where the judge does not see the tool's direction
};

/// Says where the end point really is, by other means than the cell's own vision.
class Judge {
 public:
  virtual ~Judge() = default;
  virtual JudgeKind kind() const = 0;

  /// Judges the tool, which rests on its way to the target `id` or at it.
  virtual JudgedTip judge(const std::string& id, const Standing& standing) = 0;

  /// Returns the standard deviation per axis of the error that all answers have in common, metres.
  virtual double common_sigma() const = 0;
};

/// A tracker that measures by itself reads each monument so many times in a row.
constexpr int kMonumentReadings = 5;

struct TrackerReading {
  double t_s{0.0};                     ///< on the tracker's own clock, where it has one
  Eigen::Vector3d p_L{0.0, 0.0, 0.0};  ///< reflector's centre in the tracker's frame, metres
  int averaged{1};                     ///< so many independent readings it is the mean of
  double scatter{0.0};                 ///< of these per axis, metres
};

enum class TrackerStatus {
  kOk,
  kElsewhere,  ///< somebody has measured; the reading stands in a table of the tracker's own
  kSkipped,    ///< somebody chose to do without a reading
  kRepeat,     ///< somebody wants the place to be taken once more
  kFailed,     ///< there is no reading; `fault` says why
};

struct TrackerAnswer {
  TrackerStatus status{TrackerStatus::kFailed};
  TrackerReading reading{};  ///< valid only when status is kOk
  std::string fault{};       ///< in words, with sizes; empty unless status is kFailed

  static TrackerAnswer of(const TrackerReading& reading) { return {TrackerStatus::kOk, reading}; }
  static TrackerAnswer failed(const std::string& fault) {
    return {TrackerStatus::kFailed, {}, fault};
  }
};

/// A laser tracker. Its answer is a reading of the reflector at rest, or why there is none.
class Tracker {
 public:
  virtual ~Tracker() = default;

  /// Measures the reflector on the tool, which rests at `place`, an id of the plan.
  virtual TrackerAnswer measure_tool(const std::string& place) = 0;
  virtual TrackerAnswer measure_monument(const std::string& id) = 0;

  /// Asks who works the tracker whether the reading of a monument that contradicts others is kept;
  /// otherwise it is to be read again. Empty where nobody can be asked.
  virtual std::optional<bool> keeps(const std::string& /*id*/) { return std::nullopt; }

  /// Waits until somebody has put the reflector from a monument onto the tool, which may move then.
  /// Throws WorkError when that does not happen in time.
  virtual void await_tool() {}

  /// Gives up waiting, by a WorkError, once `stop` answers true; it is asked several times a second
  /// where a wait may last.
  virtual void stop_when(const std::function<bool()>& /*stop*/) {}

  /// Makes this person the one who is asked and told, instead of who sits at the terminal.
  virtual void ask_of(const std::shared_ptr<Operator>& /*person*/) {}

  virtual int readings_per_monument() const { return kMonumentReadings; }
};

}  // namespace planar

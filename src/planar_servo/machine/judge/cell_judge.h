#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/devices/tracker.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/calibration/tracker_registration.h"
#include "planar_servo/geometry/tool/tips.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/machine/device_kinds.h"

namespace planar {

struct MonumentSeen {
  std::string id;
  TrackerReading reading;
};

/// Returns the readings with the deviations that the cell states.
std::vector<MonumentReading> monument_readings(const CellSettings& cell,
                                               const std::vector<MonumentSeen>& seen);

/// A round over a cell's monuments, compared while it is made: with the round before, which shows
/// whether tracker or monuments moved, or, where there is none, with the cell file.
class MonumentRound {
 public:
  /// Continues a round that has `seen` some already. `before` is empty for the first round. The
  /// cell must outlive this.
  MonumentRound(const CellSettings& cell, const std::vector<MonumentSeen>& before,
                std::vector<MonumentSeen> seen);

  const std::vector<MonumentSeen>& seen() const { return seen_; }
  void add(const std::vector<MonumentSeen>& readings);

  /// Describes the readings of one monument that follow: how many, where they are in the tracker's
  /// frame, how they scatter, and how they differ from the round before or the cell file.
  std::string words(const std::vector<MonumentSeen>& readings) const;

  /// Says in which way readings of one monument contradict those that agreed so far: by more than a
  /// single reading is stated to deviate, see check_monuments() and check_drift(). Empty when they
  /// do not, and when the round was in contradiction before.
  Refusal contradiction(const std::vector<MonumentSeen>& readings) const;

  /// Says what noise does not explain about the round; empty when it explains all.
  Refusal doubt() const { return verdict(seen_).doubt; }

 private:
  std::vector<MonumentSight> sights(const std::vector<MonumentSeen>& seen) const;
  MonumentVerdict verdict(const std::vector<MonumentSeen>& seen) const;
  /// Returns the position that a monument's distances are compared by; null when it has none.
  const MonumentSight* reference(const std::string& id) const;
  std::string distance_words(const MonumentSight& monument) const;

  const CellSettings& cell_;
  std::vector<MonumentSeen> seen_;
  std::vector<MonumentSight> before_;
};

/// The fewest monuments that tie a tracker to the base.
constexpr std::size_t kLeastMonuments = 3;

/// Returns the error that ends a program whose tracker gives no reading of `what`, such as
/// "monument 'datum1'".
WorkError no_reading_of(const std::string& what, const std::string& fault);

/// Takes readings of the reflector: asks the tracker, checks its answer, and writes tracker.csv.
class ReflectorReadings {
 public:
  /// `table` is a tracker.csv. `stop` is asked between two attempts at a monument and while the
  /// tracker waits; it may be empty.
  ReflectorReadings(const CellSettings& cell, Tracker& tracker, GrowingFile& table,
                    std::function<bool()> stop);

  /// Reads every monument of the cell, but for what this round has `seen` already, and returns the
  /// whole round. Reports each reading at once and compares it with the round `before`, or else
  /// with the cell file; one that contradicts is taken again unless the person at the tracker keeps
  /// it, or nobody can be asked. Throws WorkError when one cannot be read in three attempts, when
  /// fewer than three are left because somebody skipped the others, and when asked to stop.
  std::vector<MonumentSeen> read_monuments(std::vector<MonumentSeen> seen = {},
                                           std::vector<MonumentSeen> before = {});

  /// Reads the tool, which stands at `tip` for the place `id`, once. A reading that has not moved
  /// although the tool has is a failed one.
  TrackerAnswer take_tool(const std::string& id, const TipPose& tip);

 private:
  /// Returns whether the monument was read; false when somebody skipped it.
  bool read_monument(const std::string& id, MonumentRound& round);
  /// Returns so many readings of a monument, none that stand in a table of the tracker's own; empty
  /// when somebody skipped it.
  std::optional<std::vector<MonumentSeen>> take_monument(const std::string& id, int count);
  bool is_kept(const std::string& id, const Refusal& contradiction);
  std::string fault_of(const TrackerReading& reading, const TipPose& tip) const;

  struct Taken {
    std::string id;
    TrackerReading reading;
    TipPose tip;
  };

  const CellSettings& cell_;
  Tracker& tracker_;
  GrowingFile& table_;
  std::function<bool()> stop_;
  std::optional<Taken> last_;  ///< reading of the tool
};

/// A tracker that was tied to the base by one round over the monuments, with what it knows about a
/// place.
class RegisteredTracker {
 public:
  /// Throws InputError as register_datum() does.
  RegisteredTracker(const CellSettings& cell, const std::vector<MonumentSeen>& seen);

  /// Returns where a reading lies in the base frame, metres.
  Eigen::Vector3d place(const TrackerReading& reading) const { return datum_.X_BL * reading.p_L; }

  /// Returns the standard deviation of that place in the base plane, per axis, metres: of the
  /// reading's own mean, and of the rigid motion that the monuments' means determine.
  double sigma(const TrackerReading& reading) const;

  /// Says what noise does not explain about the monuments; empty when it explains all.
  const Refusal& doubt() const { return datum_.doubt; }

 private:
  /// Returns the variance of one reading's mean per axis, m^2.
  double variance_of(const TrackerReading& reading) const;

  TrackerSettings tracker_;
  DatumRegistration datum_;
  Eigen::MatrixXd covariance_;  ///< 6 x 6, of the motion's shift (m) and turn (rad) about the base
};

/// Judges the end point by the cell's tracker: P = X_BL reading - R(phi) p_TS, where the tool is
/// supposed to have the direction phi.
class TrackerJudge final : public Judge {
 public:
  /// `tool` says where the reflector sits. What is read grows in `file`, a tracker.csv that is made
  /// with the first reading. `stop` is as in ReflectorReadings.
  TrackerJudge(const CellSettings& cell, const ToolOffsets& tool, Tracker& tracker,
               const std::filesystem::path& file, const std::function<bool()>& stop);

  /// Ties the tracker to the base by `seen`, which no fit has used, or, where that is empty, by a
  /// new round over the monuments. Then waits until the reflector is back on the tool. Throws what
  /// ReflectorReadings and RegisteredTracker throw, and what Tracker::await_tool() throws.
  void make_ready(const std::vector<MonumentSeen>& seen = {});

  /// Takes the tool to be where these place it at the commanded joints, not where it is seen: for
  /// loops whose vision is judged as well.
  void suppose(std::function<TipPose(const Eigen::Vector3d& theta_c)> forward) {
    forward_ = std::move(forward);
  }
  /// Prefixes a name to those of the places judged from now on.
  void name_loop(const std::string& loop) { loop_ = loop + " "; }

  JudgeKind kind() const override { return JudgeKind::kTracker; }
  /// Reads the reflector, up to three times until a reading is good: at rest, moved as the tool
  /// has, and near where the tool is supposed to be. A person who chose to do without is not asked
  /// again. Makes itself ready where make_ready() was not called.
  JudgedTip judge(const std::string& id, const Standing& standing) override;

  /// Returns the standard deviation of the reflector's offset, the larger one of both axes.
  double common_sigma() const override;

 private:
  JudgedTip tip_of(const TrackerReading& reading, const TipPose& supposed) const;

  CellSettings cell_;
  ToolOffsets tool_;
  Tracker& tracker_;
  std::filesystem::path file_;
  std::function<bool()> stop_;
  std::optional<GrowingFile> table_;
  std::optional<ReflectorReadings> readings_;
  std::optional<RegisteredTracker> registered_;
  std::function<TipPose(const Eigen::Vector3d& theta_c)> forward_;
  std::string loop_;
};

/// Returns why these monuments cannot tie a tracker to the base, as when they are too few, of one
/// name or on one line; empty when they can.
std::string fault_of_datum(const std::vector<Monument>& datum);

/// Throws InputError with a remedy when the tracker of a cell without a truth cannot judge it:
/// there is none, or its monuments do not tie it to the base.
void require_judging_tracker(const CellSettings& cell);

/// Returns who judges this cell: its truth if it is virtual, or else its tracker. Throws InputError
/// with a remedy when it has neither, or when its tracker cannot be tied to the end point.
JudgeKind judge_of(const CellSettings& cell, const ToolOffsets& tool);

/// Returns the judge, ready to be asked. A tracker's readings also go to the table `readings`,
/// which grows; its monuments are read first, see TrackerJudge::make_ready().
std::shared_ptr<Judge> make_judge(JudgeKind kind, const CellSettings& cell, const ToolOffsets& tool,
                                  CellDevices& devices, const std::filesystem::path& readings,
                                  const std::function<bool()>& stop);

}  // namespace planar

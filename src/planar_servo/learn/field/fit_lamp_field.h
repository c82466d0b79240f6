#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/operator.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/learn/error_map/fit_error_map.h"
#include "planar_servo/learn/field/held_out.h"
#include "planar_servo/learn/field/joint_estimate.h"
#include "planar_servo/learn/field/lamp_field.h"

namespace planar {

/// What can fix a field's scale, datum or turn about the base's axis.
enum class FieldSource {
  kTracker,
  kBoard,    ///< a board of known pitch that was laid on the plane
  kBar,      ///< a bar of certified length
  kMarks,    ///< marks of the base
  kArm,      ///< the cell file's links, and the axis of joint 1
  kNothing,  ///< turn is counted from the cell file's zero of joint 1
};

constexpr Named<FieldSource> kFieldSources[] = {
    {FieldSource::kTracker, "tracker"}, {FieldSource::kBoard, "board"},
    {FieldSource::kBar, "bar"},         {FieldSource::kMarks, "marks"},
    {FieldSource::kArm, "arm"},         {FieldSource::kNothing, "nothing"}};

struct FixedBy {
  FieldSource scale{FieldSource::kArm}, datum{FieldSource::kArm}, turn{FieldSource::kNothing};
};

/// Returns what fixes a field that is learned from so many readings and what lies on the plane. One
/// reading or mark fixes the datum, two at different places its turn; readings its scale, too.
FixedBy fixed_by(std::size_t n_readings, const LaidDots& laid);

/// Standard deviations of a field's compensated end points over a set of poses: of their common
/// scale, shift (metres per axis) and turn (radians), and of one by itself (metres per axis).
struct FieldCertainty {
  double scale{0.0}, shift{0.0}, turn{0.0}, end_point{0.0};
};

/// The worth of one source for an estimate.
struct SourceWorth {
  std::string name;               ///< of the source
  std::string amount;             ///< how much of it there was; empty for none
  double end_point_without{0.0};  ///< as in FieldCertainty, were it left out
};

/// A prediction of the vision error that was tried, and how well it meets places left out.
struct ComparedField {
  const char* name{""};
  double rms{0.0};  ///< metres
  double coverage_95{0.0};
  std::vector<double> misses{};  ///< of each place, ascending, metres
};

/// A field at the lamps with what was found together with it.
struct LampFieldFit {
  JointEstimate estimate;
  LampField field;
  FoundArm arm;
  HeldOut held_out;
  /// The field with the arm, the field without it and a map at the end point, where they could be
  /// fitted. The first is taken unless another is clearly better.
  std::vector<ComparedField> compared;
  std::optional<MapResult> end_point_map;      ///< where that was taken; the field is then unused
  std::size_t n_readings{0}, n_unattended{0};  ///< that were given
  std::vector<std::string> left_out;           ///< ids of poses that contradict the others
  FixedBy fixed_by;
  FieldCertainty certainty;
  std::vector<SourceWorth> sources;  ///< what it was learned from
  /// Between where the arm found puts the end point and where the field sees it, per axis.
  double landing_sigma{0.0};
  /// Largest per axis of a reading, its lamps and the air together, as the fit found them.
  double noise_sigma{0.0};

  /// Returns how the field or map that was taken does, and how far the poses agree.
  MapQuality quality() const {
    MapQuality quality = held_out.quality();
    quality.contradicting = estimate.contradicting;
    return quality;
  }
};

/// Estimates field, arm and tool, and judges them on places left out. Where a field that does not
/// trust the arm, or a map at the end point, meets these clearly better, it is taken instead; the
/// arm stays as it was found, without a covariance. Throws as estimate_jointly() does.
LampFieldFit fit_lamp_field(const ArmNominal& nominal, const std::vector<PoseSample>& samples,
                            const LaidDots& board = {}, const Progress& progress = {});

}  // namespace planar

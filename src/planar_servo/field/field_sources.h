#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/core/names.h"
#include "planar_servo/field/joint_estimate.h"
#include "planar_servo/field/lamp_field.h"

namespace planar {

/// What can tell a field its scale, its datum or its turn about the base's axis.
enum class FieldSource {
  kTracker,
  kBoard,    ///< a board of known pitch that was laid on the plane
  kArm,      ///< the cell file's links, and the axis of joint 1
  kNothing,  ///< turn is counted from the cell file's zero of joint 1
};

constexpr Named<FieldSource> kFieldSources[] = {{FieldSource::kTracker, "tracker"},
                                                {FieldSource::kBoard, "board"},
                                                {FieldSource::kArm, "arm"},
                                                {FieldSource::kNothing, "nothing"}};

struct FixedBy {
  FieldSource scale{FieldSource::kArm}, datum{FieldSource::kArm}, turn{FieldSource::kNothing};
};

/// Returns what fixes a field that is learned from so many readings and these lays. One reading
/// fixes the datum, two at different places its turn and scale.
FixedBy fixed_by(std::size_t n_readings, const LaidDots& board);

/// Standard deviations of a field's compensated end points over a set of poses: of their common
/// scale, shift (metres per axis) and turn (radians), and of one by itself (metres per axis).
struct FieldCertainty {
  double scale{0.0}, shift{0.0}, turn{0.0}, end_point{0.0};
};

FieldCertainty certainty_of(const LampField& field, const std::vector<PoseSample>& poses);

/// What one source adds to an estimate.
struct SourceWorth {
  std::string name;               ///< of the source
  std::string amount;             ///< how much of it there was; empty for none
  double end_point_without{0.0};  ///< as in FieldCertainty, were it left out
};

/// Returns the worth of readings, unattended poses and lays, each as far as there is any, by fits
/// with the estimate's priors in which one of them is left out.
std::vector<SourceWorth> worth_of_sources(const JointEstimate& estimate,
                                          const std::vector<PoseSample>& samples,
                                          const LaidDots& board);

}  // namespace planar

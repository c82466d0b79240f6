#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/calibration/pairing.h"
#include "planar_servo/calibration/readings/change_point.h"
#include "planar_servo/calibration/tracker_registration.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/hardware/cell/cell_settings.h"

namespace planar {

/// The axis of a turning joint.
struct AxisPlace {
  Eigen::Vector2d p{0.0, 0.0};  ///< metres, in the frame of the points
  Eigen::Matrix2d covariance{Eigen::Matrix2d::Zero()};
  double radius{0.0};
};

/// Fits a circle to points on a turning link, by Gauss-Newton on their distances from it. `sigma`
/// is the least standard deviation that is assumed for a point, per axis; the points' own scatter
/// may raise it. Empty for fewer than 6 points and for an arc that is too short.
std::optional<AxisPlace> fit_axis(const std::vector<Eigen::Vector2d>& points, double sigma);

// Compares a recording with what else is known about the cell. A contradiction throws InputError
// with sizes, uncertainties and the remedy; what is less certain becomes a doubt with sizes, causes
// and what to do.

/// A step in the vision error of the training pairs, in the order of time.
struct RecordedStep {
  std::string id;         ///< of the first place after it
  std::size_t places{0};  ///< training places in all
  ChangePoint change;

  /// Returns by how much a map of these pairs misses the end point, as a mean over the field and
  /// for the worse of the two states, metres.
  double cost() const { return change.cost(places); }
  /// Returns whether the pairs are to be used only when a person says so.
  bool needs_consent() const;
  Refusal doubt() const;
};

/// A trend of the vision error over the training pairs.
struct RecordedTrend {
  ErrorTrend trend;
  double duration_s{0.0};  ///< from the first place to the last; 0 where the times are not known

  /// Returns whether the pairs are to be used only when a person says so.
  bool needs_consent() const;
  Refusal doubt() const;
};

/// Looks for a step as find_change() does.
std::optional<RecordedStep> find_step(const std::vector<PairRow>& pairs);

/// Looks for a trend as find_trend() does. One that moves less over the whole recording than a
/// revisit of the calibration names as a change is none.
std::optional<RecordedTrend> find_trend(const std::vector<PairRow>& pairs);

/// The scatter of the vision errors of the training pairs about any smooth error, per axis, metres.
struct RecordedScatter {
  double found{0.0};
  double stated{0.0};  ///< of tracker and lamps together

  Refusal doubt() const;
};

/// Returns it where it is clearly more than is stated.
std::optional<RecordedScatter> find_scatter(const std::vector<PairRow>& pairs);

/// The sweep of joint 1 shows the base's axis without the monuments, which are to be given about
/// that axis. Throws when it lies off the origin by more than what readings and sweep leave open,
/// with a false alarm of kFalseAlarm. Arms whose other motors turn in this sweep show no circle and
/// are not checked.
void require_axis_in_origin(const CellSettings& cell, const std::vector<ToolSight>& sights);

/// Monuments in one plane fit a mirrored tracker frame as well, with the base's z axis turned
/// round. Throws when the tracker's z axis points down in the base and the reflector lies below the
/// monuments.
void require_upright_tracker(const DatumRegistration& datum, const ToolOffsets& tool);

/// Throws when the tool as seen points against the direction to which joint 3 was sent: lamps
/// exchanged.
void require_lamps_in_order(const CellSettings& cell, const std::vector<FrameRow>& frames,
                            const std::vector<PairRow>& pairs);

/// The scatter of readings of one place or monument, per axis.
struct RestSpread {
  double rms{0.0}, stated{0.0};  ///< metres
  int freedom{0};                ///< 0 where no two readings share a place

  /// Returns whether readings scatter by clearly more than the cell file states.
  bool is_shaking() const;
  Refusal doubt() const;
};

/// Returns the spread of readings that follow each other and share an id: a monument that is read
/// again at the end may have moved. Those of the tool that are paired by time may all have the same
/// id and are left out.
RestSpread rest_spread(const CellSettings& cell, const std::vector<TrackerRow>& readings,
                       PairBy by);

}  // namespace planar

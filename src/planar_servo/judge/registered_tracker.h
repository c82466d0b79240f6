#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/calibration/tracker_registration.h"
#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/judge/reflector_readings.h"

namespace planar {

/// A tracker that was tied to the base by one round over the monuments, with what it knows of a
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

  /// Says what noise does not explain of the monuments; empty when it explains all.
  const std::string& doubt() const { return datum_.doubt; }

 private:
  /// Returns the variance of one reading's mean per axis, m^2.
  double variance_of(const TrackerReading& reading) const;

  TrackerSettings tracker_;
  DatumRegistration datum_;
  Eigen::MatrixXd covariance_;  ///< 6 x 6, of the motion's shift (m) and turn (rad) about the base
};

}  // namespace planar

#pragma once

#include <optional>

#include "planar_servo/lens/camera_model.h"
#include "planar_servo/lens/mapped.h"

namespace planar::lens {

/// Ideal to distorted normalised image plane. Empty where the mapping, followed outwards from the
/// axis, stops being one-to-one.
std::optional<Mapped> distort(const Pinhole& camera, const Eigen::Vector2d& xy);
std::optional<Mapped> distort(const VispModel& camera, const Eigen::Vector2d& xy);
std::optional<Mapped> distort(const PlumbBob& camera, const Eigen::Vector2d& xy);
std::optional<Mapped> distort(const Rational& camera, const Eigen::Vector2d& xy);
std::optional<Mapped> distort(const KannalaBrandt& camera, const Eigen::Vector2d& xy);
std::optional<Mapped> distort(const OpenCv14& camera, const Eigen::Vector2d& xy);

/// Distorted to ideal: the inverse of `distort`, but for VispModel, which has a polynomial of its
/// own for this direction. Empty where no point of the one-to-one range maps to `xy`.
std::optional<Mapped> undistort(const Pinhole& camera, const Eigen::Vector2d& xy);
std::optional<Mapped> undistort(const VispModel& camera, const Eigen::Vector2d& xy);
std::optional<Mapped> undistort(const PlumbBob& camera, const Eigen::Vector2d& xy);
std::optional<Mapped> undistort(const Rational& camera, const Eigen::Vector2d& xy);
std::optional<Mapped> undistort(const KannalaBrandt& camera, const Eigen::Vector2d& xy);
std::optional<Mapped> undistort(const OpenCv14& camera, const Eigen::Vector2d& xy);

}  // namespace planar::lens

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "planar_servo/learn/error_map/error_sample.h"

namespace planar::test {

// Made-up vision errors over a disc of 480 mm about the base, metres: the fields by which error
// maps are compared.

/// Returns the vision error at a position on the plane; both in metres.
using ErrorField = std::function<Eigen::Vector2d(const Eigen::Vector2d&)>;

constexpr double kFieldRadius = 0.480;
/// The standard deviation per axis of one measured error: 0.010 mm of the tracker and 0.005 mm of
/// vision.
constexpr double kFieldNoise = 0.01118e-3;

/// f1: residuals of lens, tilt and focal length, and the parallax of a plane that is not flat.
Eigen::Vector2d lens_field(const Eigen::Vector2d& p);
/// f2: f1, the eccentricity of a tilted disc, and a glow with a knee at 11 degrees of view.
Eigen::Vector2d glow_field(const Eigen::Vector2d& p);
/// f3: 0.7 f1 and thirty Gaussian bumps of 60 to 100 mm.
Eigen::Vector2d bumpy_field(const Eigen::Vector2d& p);

/// Returns `count` positions drawn evenly over the disc.
std::vector<Eigen::Vector2d> random_positions(int count, std::uint32_t seed);
/// Returns `count` positions on eight rings with radii of 60 to 480 mm.
std::vector<Eigen::Vector2d> ring_positions(int count);

/// Samples the field at the positions with normal noise (metres per axis). The ids are "0", "1",
/// ...
std::vector<ErrorSample> measure(const ErrorField& field,
                                 const std::vector<Eigen::Vector2d>& positions, double noise,
                                 std::uint32_t seed);

}  // namespace planar::test

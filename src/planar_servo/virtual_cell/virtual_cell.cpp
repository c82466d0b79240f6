#include "planar_servo/virtual_cell/virtual_cell.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "planar_servo/base/core/units.h"
#include "planar_servo/virtual_cell/random.h"

namespace planar {
namespace {

/// Returns a systematic error that is smooth in space and never longer than `length`.
Eigen::Vector3d bias(const Eigen::Vector3d& p_B, double length, double wavelength) {
  const Eigen::Vector3d angles = 2.0 * kPi / wavelength * p_B;
  return length / std::sqrt(3.0) *
         Eigen::Vector3d(std::sin(angles.y() + 0.5), std::sin(angles.x() + 2.0),
                         std::sin(angles.x() - angles.y()));
}

double sum_at(const std::vector<Harmonic>& harmonics, double angle_rad) {
  double sum = 0.0;
  for (const Harmonic& h : harmonics)
    sum += h.amplitude * std::sin(h.order * angle_rad + h.phase_rad);
  return sum;
}

/// Returns a point as a tracker sees it whose angles have these errors.
Eigen::Vector3d misread(const Eigen::Vector3d& p_L, const TrackerTruth& truth) {
  if (truth.azimuth_errors.empty() && truth.elevation_errors.empty()) return p_L;
  const double azimuth = std::atan2(p_L.y(), p_L.x());
  const double elevation = std::atan2(p_L.z(), p_L.head<2>().norm());
  const double read_azimuth = azimuth + sum_at(truth.azimuth_errors, azimuth);
  const double read_elevation = elevation + sum_at(truth.elevation_errors, elevation);
  const Eigen::Vector2d level = std::cos(read_elevation) * rotation2d(read_azimuth).col(0);
  return p_L.norm() * Eigen::Vector3d(level.x(), level.y(), std::sin(read_elevation));
}

Eigen::Vector3d drifted_m(const StationDriftTruth& drift, double t_s) {
  return drift.velocity_m_s * t_s + drift.settling_m * (t_s / (t_s + drift.half_time_s));
}

Eigen::Vector3d off_by(double length, Random& random) {
  Eigen::Vector3d direction;
  for (double& coordinate : direction) coordinate = random.normal();
  return length * direction.normalized();
}

}  // namespace

VirtualTracker::VirtualTracker(const Truth& truth, const VirtualHardware& stated, VirtualArm& arm,
                               const Clock& clock)
    : truth_(truth.tracker),
      reflector_T_(truth.tool.reflector_m),
      outliers_(truth.outliers),
      seed_(truth.seed),
      monuments_B_(as_built(stated, truth.build).monuments_B),
      arm_(arm),
      clock_(clock) {}

TrackerAnswer VirtualTracker::measure_tool(const std::string& place) {
  if (places_B_.empty() || place != place_) places_B_.emplace_back();
  place_ = place;
  places_B_.back() = arm_.X_BT() * reflector_T_;
  return measure(places_B_[paired_place()], outliers_);
}

std::size_t VirtualTracker::paired_place() const {
  const std::size_t newest = places_B_.size() - 1;
  if (!truth_.mispaired_share) return newest;
  Random random(seed_, RandomStream::kMispaired, newest);
  if (random.uniform(0.0, 1.0) >= *truth_.mispaired_share) return newest;
  return static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(newest)));
}

TrackerAnswer VirtualTracker::measure_monument(const std::string& id) {
  const auto monument = std::find_if(monuments_B_.begin(), monuments_B_.end(),
                                     [&](const auto& entry) { return entry.first == id; });
  if (monument == monuments_B_.end())
    throw std::invalid_argument("the virtual cell has no monument '" + id + "'");
  return measure(monument->second, std::nullopt);
}

TrackerAnswer VirtualTracker::measure(const Eigen::Vector3d& p_B,
                                      const std::optional<OutlierTruth>& outliers) {
  Random random(seed_, RandomStream::kTracker, readings_++);
  Eigen::Vector3d p_L =
      misread(truth_.X_LB * (p_B + bias(p_B, truth_.bias_m, truth_.bias_wavelength_m)), truth_);
  if (truth_.drift) p_L += drifted_m(*truth_.drift, clock_.now_s());
  for (double& coordinate : p_L) coordinate += truth_.sigma_m * random.normal();
  if (outliers) p_L += off_by(stray_length(*outliers, random), random);
  return TrackerAnswer::of({clock_.now_s(), p_L});
}

namespace {

const VirtualHardware& checked(const VirtualHardware& hardware) {
  const auto positive = [](const auto& values) {
    return values.allFinite() && (values.array() > 0.0).all();
  };
  if (hardware.sensor_px.empty() || !(hardware.frame_rate_hz > 0.0) ||
      !std::isfinite(hardware.frame_rate_hz))
    throw std::invalid_argument("a virtual camera needs pixels and a frame rate");
  if (std::abs(hardware.sense) != 1.0)
    throw std::invalid_argument("a virtual arm's sense must be +1 or -1");
  if (!positive(hardware.pulses_per_rad().cwiseAbs()) || !positive(hardware.max_speed_rad_s) ||
      !positive(hardware.max_acceleration_rad_s2) || !hardware.home_rad.allFinite())
    throw std::invalid_argument("a virtual drive's scale and limits must be finite and not zero");
  return hardware;
}

}  // namespace

VirtualCell::VirtualCell(const Truth& truth, const VirtualHardware& hardware)
    : lens_(truth.camera, truth.seed),
      arm_(truth, checked(hardware), clock_),
      board_(truth, lens_, hardware.sensor_px),
      camera_(truth, hardware, lens_, arm_, board_, clock_),
      tracker_(truth, hardware, arm_, clock_),
      drives_({&arm_.drive(0), &arm_.drive(1), &arm_.drive(2)}) {}

bool VirtualCell::lay_work(const Eigen::Vector2d& p_B, double turn_rad) {
  if (camera_.works().empty()) return false;
  camera_.works().lay_last(p_B, turn_rad);
  return true;
}

}  // namespace planar

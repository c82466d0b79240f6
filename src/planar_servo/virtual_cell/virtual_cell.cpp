#include "planar_servo/virtual_cell/virtual_cell.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "planar_servo/base/core/units.h"
#include "planar_servo/virtual_cell/random.h"

namespace planar {
namespace {

constexpr std::size_t kQuantiles = 1U << 16;
constexpr int kBankSize = 1 << 20;

/// Returns the quantiles of the normal distribution at the midpoints of equal shares, so that an
/// entry picked by 16 random bits is a normal number. Newton's method finds each from its
/// neighbour, outwards from the median.
std::vector<float> normal_quantiles() {
  std::vector<float> quantiles(kQuantiles);
  double x = 0.0;
  for (std::size_t i = kQuantiles / 2; i < kQuantiles; ++i) {
    const double upper_tail = 1.0 - (static_cast<double>(i) + 0.5) / kQuantiles;
    for (int iteration = 0; iteration < 6; ++iteration) {
      const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * kPi);
      x += (0.5 * std::erfc(x / std::sqrt(2.0)) - upper_tail) / density;
    }
    quantiles[i] = static_cast<float>(x);
    quantiles[kQuantiles - 1 - i] = static_cast<float>(-x);
  }
  return quantiles;
}

/// Adds `factor` times a light to the levels of a part of the sensor.
void add(const Light& light, double factor, const cv::Rect& part_px, cv::Mat1f& levels) {
  const cv::Rect lit_px = light.window_px & part_px;
  if (lit_px.empty()) return;
  cv::Mat1f sum = levels(lit_px - part_px.tl());
  cv::scaleAdd(light.levels(lit_px - light.window_px.tl()), factor, sum, sum);
}

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

SensorNoise::SensorNoise(const NoiseTruth& truth, std::uint64_t seed)
    : truth_(truth), normals_(normal_quantiles()), bank_(kBankSize) {
  Random random(seed, RandomStream::kNoiseBank);
  expose(cv::Mat1f(1, kBankSize, 0.0F), cv::Mat(1, kBankSize, CV_8UC1, bank_.data()), random);
}

void SensorNoise::fill_dark(cv::Mat& image, Random& random) const {
  const std::size_t width = static_cast<std::size_t>(image.cols);
  for (int row = 0; row < image.rows; ++row) {
    const std::size_t offset = random.bits() % (bank_.size() - width + 1);
    std::memcpy(image.ptr(row), bank_.data() + offset, width);
  }
}

void SensorNoise::expose(const cv::Mat1f& levels, cv::Mat image, Random& random) const {
  const float background = static_cast<float>(truth_.background_level);
  const float shot = static_cast<float>(1.0 / truth_.gain_e_per_level);
  const float read = static_cast<float>(truth_.read_noise_levels * truth_.read_noise_levels);
  for (int row = 0; row < levels.rows; ++row) {
    const float* level = levels.ptr<float>(row);
    std::uint8_t* pixel = image.ptr(row);
    std::uint64_t bits = 0;
    for (int column = 0; column < levels.cols; ++column) {
      bits = column % 4 == 0 ? random.bits() : bits >> 16;
      const float light = level[column] + background;
      const float noise = std::sqrt(light * shot + read) * normals_[bits & 0xffff];
      const float rounded_up = light + noise + 0.5F;  // the cast below truncates
      pixel[column] = static_cast<std::uint8_t>(std::clamp(rounded_up, 0.0F, 255.0F));
    }
  }
}

VirtualCamera::VirtualCamera(const Truth& truth, const VirtualHardware& hardware,
                             const VirtualLens& lens, VirtualArm& arm, const VirtualBoard& board,
                             VirtualClock& clock)
    : sensor_px_(hardware.sensor_px),
      frame_rate_hz_(hardware.frame_rate_hz),
      seed_(truth.seed),
      lens_(lens),
      arm_(arm),
      board_(board),
      clock_(clock),
      lamps_(truth),
      works_(truth, lens, hardware.sensor_px),
      noise_(truth.noise, truth.seed),
      region_px_(cv::Point(), hardware.sensor_px) {}

void VirtualCamera::set_region(const cv::Rect& region_px) {
  require_region(region_px, sensor_px_);
  region_px_ = region_px;
}

void VirtualCamera::set_exposure(const CameraExposure& exposure) {
  require_exposure(exposure);
  exposure_ = exposure;
}

FrameResult VirtualCamera::next_frame() {
  const auto periods = static_cast<std::uint64_t>(std::ceil(clock_.now_s() * frame_rate_hz_));
  const std::uint64_t exposure = std::max(periods, next_exposure_);
  next_exposure_ = exposure + 1;
  const double t_s = static_cast<double>(exposure) / frame_rate_hz_;
  clock_.advance_to(std::max(t_s, clock_.now_s()));

  ++taken_;
  const double brightness =
      exposure_.time_s / kUsualTime_s * std::pow(10.0, exposure_.gain_db / 20.0);
  const cv::Mat image =
      arm_.moves() ? expose_moving(brightness, exposure) : expose(region_px_, brightness, exposure);
  return {FrameStatus::kOk, {image, region_px_, t_s, exposure}};
}

cv::Mat VirtualCamera::expose_moving(double brightness, std::uint64_t exposure) {
  const double begin_s = clock_.now_s();
  cv::Mat1f levels(region_px_.size(), 0.0F);
  for (int i = 0; i < kMomentsOfExposure; ++i) {
    clock_.advance_to(begin_s + (i + 0.5) / kMomentsOfExposure * exposure_.time_s);
    for (const Light& seen : lights(clock_.now_s()))
      add(seen, brightness / kMomentsOfExposure, region_px_, levels);
  }
  clock_.advance_to(begin_s + exposure_.time_s);
  cv::Mat image(region_px_.size(), CV_8UC1);
  Random random(seed_, RandomStream::kFrame, exposure);
  noise_.expose(levels, image, random);
  return image;
}

cv::Mat VirtualCamera::expose(const cv::Rect& region_px, double brightness,
                              std::uint64_t exposure) {
  require_region(region_px, sensor_px_);
  cv::Mat image(region_px.size(), CV_8UC1);
  Random random(seed_, RandomStream::kFrame, exposure);
  noise_.fill_dark(image, random);
  const std::vector<Light> all = lights(clock_.now_s());
  for (auto seen = all.begin(); seen != all.end(); ++seen) {
    const cv::Rect lit_px = seen->window_px & region_px;
    if (lit_px.empty()) continue;
    cv::Mat1f levels;
    seen->levels(lit_px - seen->window_px.tl()).convertTo(levels, CV_32F, brightness);
    // What was exposed before is exposed again with this light on it.
    for (auto below = all.begin(); below != seen; ++below) add(*below, brightness, lit_px, levels);
    noise_.expose(levels, image(lit_px - region_px.tl()), random);
  }
  return image;
}

std::vector<Light> VirtualCamera::lights(double t_s) {
  if (!board_.X_BG()) {
    const Pose X_BT = arm_.X_BT();
    std::vector<Light> all;
    if (!works_.empty()) all = works_.render(t_s, lamps_.housings_px(X_BT, lens_, t_s));
    for (Light& light : lamps_.render_all(X_BT, lens_, t_s)) all.push_back(std::move(light));
    return all;
  }
  const std::optional<Light> board = board_.render(t_s);
  return board ? std::vector<Light>{*board} : std::vector<Light>();
}

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

#include "lamps/cramer_rao.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

namespace planar::bench {
namespace {

constexpr double kStep = 0.02;  // step of the central differences, in pixels or grey levels
constexpr double kRounding = 1.0 / 12.0, kClipped = 255.0;
const cv::Size kWindow(128, 128);

// The unknowns are changes of the centre (2), of the axes (a symmetric deformation: along u, along
// v and oblique, each in pixels of the radius), of the background and of the amplitude. The change
// of the blur follows them.
constexpr int kUnknowns = 7;
using Change = Eigen::Matrix<double, kUnknowns + 1, 1>;

Eigen::Matrix2d turned(double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return (Eigen::Matrix2d() << c, -s, s, c).finished();
}

cv::Mat scene(test::RenderedLamp lamp, double background, const Change& change) {
  const double radius = 0.5 * lamp.diameter_px;
  Eigen::Matrix2d deform;
  deform << 1.0 + change[2] / radius, change[4] / radius, change[4] / radius,
      1.0 + change[3] / radius;
  const Eigen::Matrix2d axes = deform * turned(lamp.direction_rad) *
                               Eigen::Vector2d(radius, radius * lamp.axis_ratio).asDiagonal();
  const Eigen::Matrix2d moments = axes * axes.transpose();
  const double mean = 0.5 * moments.trace();
  const double half = 0.5 * (moments(0, 0) - moments(1, 1));
  const double spread = std::hypot(half, moments(0, 1));
  lamp.center_px += change.head<2>();
  lamp.diameter_px = 2.0 * std::sqrt(mean + spread);
  lamp.axis_ratio = std::sqrt((mean - spread) / (mean + spread));
  lamp.direction_rad = 0.5 * std::atan2(moments(0, 1), half);
  lamp.amplitude += change[6];
  lamp.blur_px += change[7];
  cv::Mat image = test::background(kWindow, background + change[5]);
  test::add_lamp(image, lamp);
  return image;
}

std::vector<cv::Mat> slopes(const test::RenderedLamp& lamp, double background, int unknowns) {
  std::vector<cv::Mat> result;
  for (int i = 0; i < unknowns; ++i) {
    const Change step = kStep * Change::Unit(i);
    result.push_back((scene(lamp, background, step) - scene(lamp, background, -step)) /
                     (2.0 * kStep));
  }
  return result;
}

/// Appends by how much the harmonics of both levels change a pixel of which the lamp covers the
/// share `cover`.
void append_harmonics(const FurtherUnknowns& further, double cover, double angle,
                      std::vector<double>& slope) {
  for (int k = 1; k <= further.inside_harmonics; ++k) {
    slope.push_back(cover * std::cos(k * angle));
    slope.push_back(cover * std::sin(k * angle));
  }
  for (int k = 1; k <= further.outside_harmonics; ++k) {
    slope.push_back((1.0 - cover) * std::cos(k * angle));
    slope.push_back((1.0 - cover) * std::sin(k * angle));
  }
}

}  // namespace

double cramer_rao_variance_px2(const test::RenderedLamp& lamp, double background,
                               const test::Sensor& sensor, const FurtherUnknowns& further) {
  const cv::Mat truth = scene(lamp, background, Change::Zero());
  const std::vector<cv::Mat> basic = slopes(lamp, background, kUnknowns + (further.blur ? 1 : 0));
  const double radius = 0.5 * lamp.diameter_px;
  const Eigen::Matrix2d to_axes = turned(-lamp.direction_rad);
  const std::size_t unknowns =
      basic.size() +
      2 * static_cast<std::size_t>(further.inside_harmonics + further.outside_harmonics);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(unknowns),
                                                      static_cast<Eigen::Index>(unknowns));
  std::vector<double> slope;
  for (int v = 0; v < truth.rows; ++v) {
    for (int u = 0; u < truth.cols; ++u) {
      const double level = truth.at<float>(v, u);
      Eigen::Vector2d d = to_axes * (Eigen::Vector2d(u, v) - lamp.center_px);
      d.y() /= lamp.axis_ratio;
      if (level >= kClipped || std::abs(d.norm() - radius) > further.band_px) continue;
      slope.clear();
      for (const cv::Mat& s : basic) slope.push_back(s.at<float>(v, u));
      append_harmonics(further, (level - background) / lamp.amplitude, std::atan2(d.y(), d.x()),
                       slope);
      const Eigen::Map<const Eigen::VectorXd> s(slope.data(),
                                                static_cast<Eigen::Index>(slope.size()));
      information.noalias() +=
          s * s.transpose() /
          (level / sensor.gain_e_per_level + sensor.read_noise * sensor.read_noise + kRounding);
    }
  }
  const Eigen::MatrixXd centre = Eigen::MatrixXd::Identity(static_cast<Eigen::Index>(unknowns), 2);
  return 0.5 * (centre.transpose() * information.ldlt().solve(centre)).trace();
}

}  // namespace planar::bench

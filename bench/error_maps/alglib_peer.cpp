#include "alglib_peer.h"

#include <libalglib/interpolation.h>

#include <array>
#include <limits>

#include "planar_servo/base/core/units.h"

namespace planar::bench {
namespace {

constexpr int kFolds = 5;
// Decimetres; the mean spacing of 200 pairs is 0.6.
constexpr std::array<double, 3> kWidths{0.5, 1.5, 4.5};
constexpr std::array<double, 5> kSmoothings{1e-6, 1e-5, 1e-4, 1e-3, 1e-2};

// Positions are given in decimetres and errors in millimetres, so that both are of order 1.
constexpr double kPositionUnit = 0.1;

struct Setting {
  double width;
  double smoothing;
};

}  // namespace

struct AlglibMap::Model {
  alglib::rbfmodel rbf;
  alglib::rbfcalcbuffer buffer;
  alglib::real_1d_array at;
  alglib::real_1d_array value;

  Model(const std::vector<ErrorSample>& samples, const Setting& setting) {
    alglib::real_2d_array rows;
    rows.setlength(static_cast<alglib::ae_int_t>(samples.size()), 4);
    alglib::ae_int_t row = 0;
    for (const ErrorSample& sample : samples) {
      for (int axis = 0; axis < 2; ++axis) {
        rows[row][axis] = sample.p_vision[axis] / kPositionUnit;
        rows[row][2 + axis] = sample.error[axis] / kMillimetre;
      }
      ++row;
    }
    alglib::rbfcreate(2, 2, rbf);
    alglib::rbfsetpoints(rbf, rows);
    alglib::rbfsetalgomultiquadricmanual(rbf, setting.width, setting.smoothing);
    alglib::rbfreport report;
    alglib::rbfbuildmodel(rbf, report);
    alglib::rbfcreatecalcbuffer(rbf, buffer);
    at.setlength(2);
    value.setlength(2);
  }

  Eigen::Vector2d predict(const Eigen::Vector2d& p) {
    at[0] = p.x() / kPositionUnit;
    at[1] = p.y() / kPositionUnit;
    alglib::rbftscalcbuf(rbf, buffer, at, value);
    return Eigen::Vector2d(value[0], value[1]) * kMillimetre;
  }
};

namespace {

template <typename Model>
double cross_validated(const std::vector<ErrorSample>& samples, const Setting& setting) {
  double sum = 0.0;
  for (std::size_t fold = 0; fold < kFolds; ++fold) {
    std::vector<ErrorSample> kept;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (i % kFolds != fold) kept.push_back(samples[i]);
    }
    Model model(kept, setting);
    for (std::size_t i = fold; i < samples.size(); i += kFolds)
      sum += (samples[i].error - model.predict(samples[i].p_vision)).squaredNorm();
  }
  return sum;
}

}  // namespace

AlglibMap::AlglibMap(const std::vector<ErrorSample>& samples) {
  Setting best{kWidths.front(), kSmoothings.front()};
  double least = std::numeric_limits<double>::infinity();
  for (const double width : kWidths) {
    for (const double smoothing : kSmoothings) {
      const double sum = cross_validated<Model>(samples, {width, smoothing});
      if (sum >= least) continue;
      least = sum;
      best = {width, smoothing};
    }
  }
  model_ = std::make_unique<Model>(samples, best);
}

AlglibMap::~AlglibMap() = default;

Eigen::Vector2d AlglibMap::predict(const Eigen::Vector2d& p) {
  return model_->predict(p);
}

}  // namespace planar::bench

#pragma once

namespace planar::bench {

/// What one method did with one draw.
struct Score {
  double error_over_noise{0.0};  ///< rms per axis against the noise-free field, over the noise
  double fit_s{0.0};             ///< with the choice of its parameters
  double predict_s{0.0};         ///< one position at a time
};

}  // namespace planar::bench

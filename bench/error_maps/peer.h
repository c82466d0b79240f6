#pragma once

namespace planar::bench {

/// Says what one method did with one draw.
struct Score {
  /// The rms error per axis against the noise-free field, divided by the noise.
  double error_over_noise{0.0};
  double fit_s{0.0};      ///< includes the choice of its parameters
  double predict_s{0.0};  ///< per position, one position at a time
};

}  // namespace planar::bench

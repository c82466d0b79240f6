// Learns the error of a vision system from pairs of positions and corrects positions never seen.
#include <planar_servo/learn/error_map/error_map.h>
#include <planar_servo/learn/error_map/fit_error_map.h>

#include <cmath>
#include <cstdio>
#include <random>

namespace {

/// What an uncorrected lens might do over a field of one metre, up to 0.4 mm.
Eigen::Vector2d true_error(const Eigen::Vector2d& p) {
  return {3e-4 * std::sin(5.0 * p.x()) + 1e-4 * p.y(), 2e-4 * std::cos(6.0 * p.y()) * p.x()};
}

/// `count` pairs at places of the field; vision and tracker together err by 5 um per axis.
std::vector<planar::ErrorSample> measure(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  std::normal_distribution<double> noise(0.0, 5e-6);
  std::vector<planar::ErrorSample> samples(count);
  for (std::size_t i = 0; i < count; ++i) {
    planar::ErrorSample& sample = samples[i];
    sample.id = "pair_" + std::to_string(i);
    sample.p_vision = {place(random), place(random)};
    sample.error = true_error(sample.p_vision) + Eigen::Vector2d(noise(random), noise(random));
  }
  return samples;
}

}  // namespace

int main() {
  planar::MapProblem problem;
  problem.samples = measure(120, 1);
  const planar::MapResult fit = planar::fit_error_map(problem);
  std::printf("%s map of %zu pairs: errors of %.1f um, %.1f um left out one by one\n",
              planar::name(planar::kind_of(fit.map)), fit.n_used, 1e6 * fit.raw_rms,
              1e6 * fit.loo_rms);

  double before = 0.0, after = 0.0;
  std::size_t inside = 0;
  for (const planar::ErrorSample& unseen : measure(500, 2)) {
    const planar::ErrorPrediction prediction = planar::predict(fit.map, unseen.p_vision);
    if (!prediction.inside) continue;  // beyond the pairs it only guesses, and says so
    const Eigen::Vector2d truth = true_error(unseen.p_vision);
    before += truth.squaredNorm();
    after += (truth - prediction.error).squaredNorm();
    ++inside;
  }
  const auto rms_um = [&](double sum) {
    return 1e6 * std::sqrt(sum / static_cast<double>(inside));
  };
  std::printf("%zu places inside the map: rms error %.1f um before, %.2f um after\n", inside,
              rms_um(before), rms_um(after));
  return 0;
}

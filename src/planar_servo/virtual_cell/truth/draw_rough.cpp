#include "planar_servo/core/units.h"
#include "planar_servo/virtual_cell/random.h"
#include "planar_servo/virtual_cell/truth/drawing.h"
#include "planar_servo/virtual_cell/truth/truth.h"

// This file holds every distribution in which a rough cell differs from one of the paper's kind.

namespace planar {
namespace {

void roughen(ArmTruth& arm, Random& random) {
  for (ReducerTruth& reducer : arm.reducers)
    reducer.eccentricity.push_back(harmonic(random, 3, 0.002 * kDegree, 0.004 * kDegree));
  arm.sag_m_per_m2 = 0.0;
  arm.beam_sag = {random.uniform(1.0, 2.0) * kMillimetre, random.uniform(2.0, 4.0) * kMillimetre};
  arm.axis_leans_rad = {any_direction(random, 0.02 * kDegree, 0.05 * kDegree),
                        any_direction(random, 0.005 * kDegree, 0.015 * kDegree),
                        any_direction(random, 0.005 * kDegree, 0.015 * kDegree)};
}

}  // namespace

Truth draw_rough_truth(std::uint32_t seed) {
  Truth truth = draw_truth(seed);
  Random random(seed, RandomStream::kRough);
  roughen(truth.arm, random);
  truth.outliers = OutlierTruth{0.02, 0.2 * kMillimetre, 3.0 * kMillimetre};
  return truth;
}

}  // namespace planar

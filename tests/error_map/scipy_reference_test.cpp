#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "planar_servo/learn/error_map/fit/rbf_fit.h"
#include "support/shared_data.h"

namespace planar {
namespace {

constexpr double kSameSolution = 1e-9;

// exp(-(eps r)^2) and -sqrt(1 + (eps r)^2) with eps = 5, on the unit square.
const RadialKernel kScipyGaussian{KernelShape::kGaussian, 1.0 / (5.0 * std::sqrt(2.0)), 0.0};
const RadialKernel kScipyMultiquadric{KernelShape::kMultiquadric, 1.0 / 5.0, 2.0};

Eigen::Matrix2Xd columns(const nlohmann::json& rows) {
  Eigen::Matrix2Xd result(2, rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    result.col(static_cast<Eigen::Index>(i)) << rows[i][0].get<double>(), rows[i][1].get<double>();
  return result;
}

struct Setting {
  const char* name;
  RadialKernel kernel;
  double ridge;
  int degree;
};

TEST_CASE("Maps agree with SciPy's where kernel and settings are the same") {
  const auto reference =
      nlohmann::json::parse(std::ifstream(test::test_data("rbf_scipy_franke40.json")));
  MapSites sites;
  sites.positions = columns(reference["nodes"]);
  sites.errors = columns(reference["values"]);
  sites.counts.setOnes(sites.positions.cols());
  sites.scatter.setZero(sites.positions.cols());

  const Setting setting =
      GENERATE(Setting{"gaussian|eps=5|smoothing=0|degree=-1", kScipyGaussian, 0.0, -1},
               Setting{"gaussian|eps=5|smoothing=1e-06|degree=-1", kScipyGaussian, 1e-6, -1},
               Setting{"gaussian|eps=5|smoothing=0|degree=0", kScipyGaussian, 0.0, 0},
               Setting{"multiquadric|eps=5|smoothing=0|degree=0", kScipyMultiquadric, 0.0, 0});
  TailBasis tail;
  tail.degree = setting.degree;
  const auto fit = fit_rbf(sites, tail, setting.kernel, setting.ridge);
  const Eigen::Matrix2Xd queries = columns(reference["queries"]);
  const Eigen::Matrix2Xd expected = columns(reference["results"][setting.name]);
  for (Eigen::Index i = 0; i < queries.cols(); ++i) {
    INFO(setting.name << ", query " << i);
    CHECK((fit.map.predict(queries.col(i)).error - expected.col(i)).norm() < kSameSolution);
  }
}

}  // namespace
}  // namespace planar

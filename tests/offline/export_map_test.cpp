#include "planar_servo/offline/map/export_map.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"
#include "support/error_fields.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

/// A folder with pairs.csv of a lens's error at 200 places, and map.yaml fitted to them.
struct FittedMap {
  explicit FittedMap(const test::ErrorField& field = test::lens_field,
                     MapMethod method = MapMethod::kAuto) {
    std::vector<PairRow> pairs;
    for (const ErrorSample& sample :
         test::measure(field, test::random_positions(200, 1), test::kFieldNoise, 1)) {
      PairRow pair;
      pair.id = sample.id;
      pair.p_vision = sample.p_vision;
      pair.p_tracker = sample.p_vision - sample.error;
      pairs.push_back(pair);
    }
    folder.write("pairs.csv", pairs_text(pairs));
    fit(folder / "pairs.csv", folder / "map.yaml", method);
  }

  static void fit(const std::filesystem::path& pairs, const std::filesystem::path& map,
                  MapMethod method = MapMethod::kAuto) {
    const FitErrorMapReport report = fit_error_map_to_pairs(read_training_pairs(pairs, {method}));
    write_file(map, map_text(report.result, pairs, "test"));
  }

  ExportRequest request(GridFormat format) const {
    ExportRequest request;
    request.map = folder / "map.yaml";
    request.format = format;
    return request;
  }

  ErrorMap read(const std::string& name = "map.yaml") const {
    return std::get<ErrorMap>(read_map(folder / name).map);
  }

  test::TemporaryFolder folder;
};

TEST_CASE("A map comes back from its grid within a tenth of its deviation") {
  const FittedMap fitted;
  const ExportedMap exported = export_map(fitted.request(GridFormat::kCsv));
  FittedMap::fit(fitted.folder.write("grid.csv", exported.text), fitted.folder / "back.yaml");
  const ErrorMap map = fitted.read(), back = fitted.read("back.yaml");
  double worst = 0.0;
  int n = 0;
  for (const Eigen::Vector2d& p : test::random_positions(500, 7)) {
    const ErrorPrediction there = predict(map, p);
    if (!there.inside || !predict(back, p).inside) continue;
    const Eigen::Vector2d miss = predict_error(back, p) - there.error;
    worst = std::max(worst, miss.cwiseAbs().maxCoeff() / there.sigma);
    ++n;
  }
  CHECK(n > 450);
  CHECK(worst < kInterpolationShare);
}

TEST_CASE("A file says its sign, its cost and the map that it was made from") {
  const FittedMap fitted;
  for (const GridFormat format : values_of(kGridFormats)) {
    const std::string text = export_map(fitted.request(format)).text;
    CHECK_THAT(text, Contains("error = seen - true, mm, base frame") &&
                         Contains("interpolation costs up to 0.0") && Contains("map.yaml ") &&
                         Contains(use_of(format).meaning));
  }
}

TEST_CASE("cv::remap() moves what is seen to where it is") {
  constexpr double kPixel = 1e-3;  // a step that makes pixels of the nodes
  const FittedMap fitted([](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(2e-3 + 1e-3 * std::sin(p.x() / 0.2), -3e-3 + 1e-3 * p.y());
  });
  ExportRequest request = fitted.request(GridFormat::kOpencvRemap);
  request.step = 4.0 * kPixel;
  const ExportedMap exported = export_map(request);
  const ErrorGrid& grid = exported.sampled.grid;
  cv::Mat map;
  cv::FileStorage(exported.text, cv::FileStorage::READ | cv::FileStorage::MEMORY)["map"] >> map;

  const Eigen::Vector2d p_true(0.1, -0.2);
  Eigen::Vector2d p_seen = p_true;
  for (int i = 0; i < 20; ++i) p_seen = p_true + predict_error(fitted.read(), p_seen);
  cv::Mat seen(map.size(), CV_32F), compensated;
  for (int v = 0; v < seen.rows; ++v)
    for (int u = 0; u < seen.cols; ++u) {
      const Eigen::Vector2d p = grid.origin + grid.step * Eigen::Vector2d(u, v);
      seen.at<float>(v, u) =
          static_cast<float>(std::exp(-(p - p_seen).squaredNorm() / (2.0 * 0.02 * 0.02)));
    }
  cv::remap(seen, compensated, map, cv::noArray(), cv::INTER_LINEAR);
  const cv::Moments spot = cv::moments(compensated);
  const Eigen::Vector2d found =
      grid.origin + grid.step * Eigen::Vector2d(spot.m10 / spot.m00, spot.m01 / spot.m00);
  CHECK((p_seen - p_true).norm() > 2e-3);
  CHECK((found - p_true).norm() < 0.1 * kPixel);
}

TEST_CASE("A map without deviations is sampled by its leave-one-out error") {
  const FittedMap fitted(test::lens_field, MapMethod::kIdw);
  const ExportedMap exported = export_map(fitted.request(GridFormat::kCsv));
  const double loo = read_map(fitted.folder / "map.yaml").loo_rms;
  CHECK(loo > 0.0);
  CHECK(exported.sampled.sigma_median == Approx(loo));
  CHECK_THAT(exported_map_list(exported).text(),
             Contains("left-out places, as the map states none"));
}

TEST_CASE("A direction that matters must be named") {
  test::TemporaryFolder folder;
  std::vector<PairRow> pairs;
  int i = 0;
  for (const ErrorSample& sample :
       test::measure(test::lens_field, test::random_positions(200, 1), test::kFieldNoise, 1)) {
    PairRow pair;
    pair.id = sample.id;
    pair.p_vision = sample.p_vision;
    pair.phi = 2.4 * i++;
    pair.p_tracker = sample.p_vision - sample.error -
                     Eigen::Vector2d(0.2e-3 * std::cos(*pair.phi), 0.2e-3 * std::sin(*pair.phi));
    pairs.push_back(pair);
  }
  FittedMap::fit(folder.write("pairs.csv", pairs_text(pairs)), folder / "map.yaml");
  ExportRequest request;
  request.map = folder / "map.yaml";
  CHECK_THROWS_MATCHES(export_map(request), InputError, Refused(Cause::kMissing, "0.39"));
  request.phi = 90.0 * kDegree;
  const ExportedMap exported = export_map(request);
  const ErrorGrid& grid = exported.sampled.grid;
  const ErrorMap map = std::get<ErrorMap>(read_map(request.map).map);
  const Eigen::Index middle = grid.nodes() / 2;
  CHECK((grid.errors.col(middle) - predict_error(map, grid.node(middle), request.phi)).norm() ==
        Approx(0.0).margin(1e-15));
  CHECK_THAT(exported.text, Contains("for a tool at phi = 90 deg"));
}

TEST_CASE("A map that its own fit rejects is exported only when it is accepted") {
  const FittedMap fitted([](const Eigen::Vector2d& p) { return 0.0 * p; });
  ExportRequest request = fitted.request(GridFormat::kCsv);
  CHECK_THROWS_MATCHES(export_map(request), InputError,
                       Refused(Cause::kInsufficient, "--accept-map"));
  request.accept_map = true;
  CHECK(export_map(request).sampled.grid.nodes() > 0);
}

}  // namespace
}  // namespace planar

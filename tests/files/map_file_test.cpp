#include "planar_servo/files/map_file.h"

#include <catch2/catch.hpp>
#include <regex>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/learn/error_map/fit/rbf_fit.h"
#include "support/error_fields.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

MapResult fitted(MapMethod method) {
  return fit_error_map(
      {test::measure(test::glow_field, test::ring_positions(60), test::kFieldNoise, 1), method,
       0.048});
}

struct Files {
  test::TemporaryFolder folder;
  std::filesystem::path pairs{folder.write("pairs.csv", "id\n")};

  std::filesystem::path write_map(const std::string& text) {
    return folder.write("map.yaml", with_checksum(text));
  }
  std::string map_text_of(MapMethod method) {
    return map_text(fitted(method), pairs, "planar-fit-error-map");
  }
};

MapResult multiquadric_on_quadratic_tail() {
  MapResult result = fitted(MapMethod::kRbf);
  const auto samples =
      test::measure(test::glow_field, test::ring_positions(60), test::kFieldNoise, 1);
  const MapSites sites = merge_samples(samples);
  result.map = fit_rbf(sites, tune(sites, {KernelShape::kMultiquadric, 2})).map;
  return result;
}

/// Of an error that turns with the tool.
MapResult of_directions() {
  auto samples = test::measure(test::glow_field, test::ring_positions(60), test::kFieldNoise, 1);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double phi = 2.4 * static_cast<double>(i * i);
    samples[i].phi = phi;
    samples[i].error += 1e-3 * Eigen::Vector2d(std::cos(phi), std::sin(phi));
  }
  return fit_error_map({samples});
}

MapResult sparse() {
  return fit_error_map(
      {test::measure(test::glow_field, test::random_positions(1200, 1), test::kFieldNoise, 1)});
}

TEST_CASE("A map read from its file predicts the same, bit for bit") {
  Files files;
  const MapResult result = GENERATE(as<MapResult>(), fitted(MapMethod::kRbf),
                                    fitted(MapMethod::kIdw), fitted(MapMethod::kHandWidth),
                                    multiquadric_on_quadratic_tail(), of_directions(), sparse());
  const ErrorMap back =
      std::get<ErrorMap>(read_map(files.write_map(map_text(result, files.pairs, "test"))).map);
  for (const Eigen::Vector2d& p : test::random_positions(200, 2)) {
    CHECK(depends_on_direction(back) == depends_on_direction(result.map));
    const ErrorPrediction expected = predict(result.map, p, p.x());
    const ErrorPrediction found = predict(back, p, p.x());
    CHECK(found.error == expected.error);
    CHECK((found.sigma == expected.sigma || std::isnan(expected.sigma)));
    CHECK(found.inside == expected.inside);
  }
}

TEST_CASE(
    "A map's file keeps what its fit says of it, and one of an earlier version says nothing") {
  Files files;
  for (const MapMethod method : {MapMethod::kRbf, MapMethod::kIdw, MapMethod::kHandWidth}) {
    const MapResult result = fitted(method);
    const std::string text = map_text(result, files.pairs, "test");
    const MapQuality back = read_map(files.write_map(text)).quality;
    CHECK(back.n == result.n_places);
    CHECK(back.worth_using == result.worth_using);
    CHECK(back.coverage_95 == result.coverage_95);
    const std::string earlier = std::regex_replace(text, std::regex("  coverage_95: [^\n]*\n"), "");
    CHECK(read_map(files.write_map(earlier)).quality.n == 0);
  }
}

TEST_CASE("A map's file names its program, its pairs with their hash, and its figures") {
  Files files;
  const std::string text = files.map_text_of(MapMethod::kRbf);
  CHECK_THAT(text, Contains("format: planar-servo/map/1") && Contains("pairs.csv") &&
                       Contains("method: gaussian_rbf") && Contains("loo_rms_mm") &&
                       Contains("noise_mm") && Contains("worth_using: true") &&
                       Contains("scale_um_per_m: ["));
}

TEST_CASE("Only a map that depends on the tool's direction has directions in its file") {
  Files files;
  CHECK_THAT(files.map_text_of(MapMethod::kAuto), !Contains("tool_directions"));
  std::string text = map_text(of_directions(), files.pairs, "test");
  CHECK_THAT(text, Contains("tool_directions:"));
  text = std::regex_replace(text, std::regex("(tool_directions:\n)[^\n]*\n"), "$1");
  CHECK_THROWS_MATCHES(read_map(files.write_map(text)), InputError,
                       Refused(Cause::kInvalid, "tool_directions has 59"));
  text = map_text(sparse(), files.pairs, "test") + "tool_directions: [[1, 0]]\n";
  CHECK_THROWS_MATCHES(read_map(files.write_map(text)), InputError,
                       Refused(Cause::kInvalid, "'tool_directions'"));
}

TEST_CASE("Faults of a map's file are named by their place, all at once") {
  Files files;
  std::string text = files.map_text_of(MapMethod::kRbf);
  text = std::regex_replace(text, std::regex("width_m: [^\n]*"), "width_m: -1");
  text = std::regex_replace(text, std::regex("ridge: [^\n]*"), "ridge: .nan\nrigde: 1");
  text = std::regex_replace(text, std::regex("pairs_per_center: \\[1"), "pairs_per_center: [0");
  const auto path = files.write_map(text);
  for (const char* name :
       {"map.yaml:", "width_m is -1", "ridge is '.nan'", "'rigde'", "pairs_per_center[0]"})
    CHECK_THROWS_MATCHES(read_map(path), InputError, Refused(Cause::kInvalid, name));
}

TEST_CASE("A map with more centres than its method takes is refused, not solved") {
  Files files;
  std::string centers = "centers_m:\n";
  for (int i = 0; i < 30000; ++i) centers += "  - [0.1, " + std::to_string(i) + "]\n";
  const std::string text = std::regex_replace(files.map_text_of(MapMethod::kRbf),
                                              std::regex("centers_m:\n(  - [^\n]*\n)*"), centers);
  CHECK_THROWS_MATCHES(read_map(files.write_map(text)), InputError,
                       Refused(Cause::kInvalid, "30000"));
}

TEST_CASE("A map of a method that does not exist is refused for that alone") {
  Files files;
  const std::string text =
      std::regex_replace(files.map_text_of(MapMethod::kRbf), std::regex("gaussian_rbf"), "gausian");
  CHECK_THROWS_MATCHES(read_map(files.write_map(text)), InputError,
                       Refused(Cause::kInvalid, "'gausian'"));
  CHECK_THROWS_WITH(read_map(files.write_map(text)), !Contains("\n"));
}

TEST_CASE("A map whose lists do not match is refused, not evaluated") {
  Files files;
  std::string text = files.map_text_of(MapMethod::kRbf);
  SECTION("a weight is missing") {
    text = std::regex_replace(text, std::regex("(weights_m:\n)[^\n]*\n"), "$1");
    CHECK_THROWS_MATCHES(read_map(files.write_map(text)), InputError,
                         Refused(Cause::kInvalid, "weights_m has 59"));
  }
  SECTION("the tail is of another degree") {
    text = std::regex_replace(text, std::regex("tail_degree: 1"), "tail_degree: -1");
    CHECK_THROWS_MATCHES(read_map(files.write_map(text)), InputError,
                         Refused(Cause::kInvalid, "tail_m has 3"));
  }
  SECTION("the kernel cannot be solved") {
    text = std::regex_replace(text, std::regex("ridge: [^\n]*"), "ridge: 0");
    text = std::regex_replace(text, std::regex("width_m: [^\n]*"), "width_m: 5");
    CHECK_THROWS_MATCHES(read_map(files.write_map(text)), InputError,
                         Refused(Cause::kInsufficient, "map.yaml"));
  }
}

}  // namespace
}  // namespace planar

#include <catch2/catch.hpp>
#include <regex>

#include "field/bent_cell.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/files/map_file.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

LampFieldFit fit_of_bent_cell() {
  const test::BentCell cell;
  std::mt19937 random(41);
  return fit_lamp_field(cell.nominal(), cell.samples(16, 8, random));
}

TEST_CASE("A field at the lamps read from its file compensates the same, bit for bit") {
  test::TemporaryFolder folder;
  const LampFieldFit fit = fit_of_bent_cell();
  const auto path = folder.write("map.yaml", lamp_field_text(fit, {}, "test"));
  const LampField back = std::get<LampField>(read_map(path).map);
  std::mt19937 random(42);
  std::uniform_real_distribution<double> place(-0.6, 0.6);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d first{place(random), place(random)}, second{place(random), place(random)};
    const CompensatedTip wanted = compensate(fit.field, {first, second});
    const CompensatedTip found = compensate(back, {first, second});
    CHECK(found.tip.p == wanted.tip.p);
    CHECK(found.tip.phi == wanted.tip.phi);
    CHECK(found.covariance == wanted.covariance);
    CHECK(found.inside == wanted.inside);
  }
}

TEST_CASE("Lamps whose height waves come back with their wave, bit for bit") {
  test::TemporaryFolder folder;
  LampFieldFit fit = fit_of_bent_cell();
  LampField& field = fit.field;
  const CompensatedTip without =
      compensate(field, {Eigen::Vector2d(0.3, 0.1), Eigen::Vector2d(0.3, 0.14)});
  const Eigen::MatrixXd found = field.factor;
  const Eigen::Index fields = 2 * field.basis.terms();
  field.height_form.wave = basis_over_disc(0.6, 0.25);
  field.height.conservativeResize(field.height_form.terms());
  field.height.tail(field.height_form.wave.centers.cols()).setConstant(0.3e-3);
  field.factor = Eigen::MatrixXd::Constant(field.unknowns(), found.cols(), 1e-6);
  field.factor.topRows(fields) = found.topRows(fields);
  field.factor.bottomRows(2) = found.bottomRows(2);
  const auto path = folder.write("map.yaml", lamp_field_text(fit, {}, "test"));
  const LampField back = std::get<LampField>(read_map(path).map);
  const std::array<Eigen::Vector2d, 2> seen{Eigen::Vector2d(0.3, 0.1), Eigen::Vector2d(0.3, 0.14)};
  CHECK(compensate(back, seen).tip.p == compensate(field, seen).tip.p);
  CHECK(compensate(back, seen).covariance == compensate(field, seen).covariance);
  CHECK((compensate(back, seen).tip.p - without.tip.p).norm() > 10e-6);
}

TEST_CASE("A field's file says what it was made from and what fixed it") {
  const std::string text =
      lamp_field_text(fit_of_bent_cell(), {{Role::kPairs, "pairs.csv", "ab"}}, "test");
  CHECK_THAT(text, Catch::Contains("method: lamp_field") && Catch::Contains("n_readings: 16") &&
                       Catch::Contains("n_unattended: 8") && Catch::Contains("scale: tracker") &&
                       Catch::Contains("loo_rms_mm") && Catch::Contains("pairs.csv"));
}

TEST_CASE("A damaged file of a field is refused by name") {
  test::TemporaryFolder folder;
  const std::string text = lamp_field_text(fit_of_bent_cell(), {}, "test");
  const auto refusal = [&](const char* wrong, const char* by) {
    return folder.write("map.yaml",
                        with_checksum(std::regex_replace(text, std::regex(wrong), by,
                                                         std::regex_constants::format_first_only)));
  };
  CHECK_THROWS_MATCHES(read_map(refusal("factor: \\[[^,]*, ", "factor: [")), InputError,
                       Refused(Cause::kInvalid, "factor"));
  CHECK_THROWS_MATCHES(read_map(refusal("width_m: .*", "width_m: -1")), InputError,
                       Refused(Cause::kInvalid, "width_m"));
  CHECK_THROWS_MATCHES(read_map(refusal("weights_m:\n *- [^\n]*\n", "weights_m:\n")), InputError,
                       Refused(Cause::kInvalid, "weights_m"));
  CHECK_THROWS_MATCHES(read_map(refusal("p_camera_B_m: .*", "p_camera_B_m: [0, 0, -1]")),
                       InputError, Refused(Cause::kInvalid, "p_camera_B_m"));
}

}  // namespace
}  // namespace planar

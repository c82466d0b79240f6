#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/certificate/certificate_report.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/silent_cell.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

TEST_CASE("A cell without a truth is certified by its tracker, whose uncertainty is stated") {
  const test::TemporaryFolder folder;
  const CellSettings whole = read_cell(test::workshop_cell_file());
  CertificateRequest request;
  CellSettings cell = whole;
  cell.truth.reset();
  request.servo.cell = std::make_shared<CalibratedCell>(read_calibrated_cell(cell));
  request.servo.folder.path = folder / "out";
  request.servo.policy.checks_health = false;
  request.size = {2, 2};
  int opened = 0;
  const auto open = [&](const CellSettings& /*cell*/) {
    ++opened;
    return std::make_unique<test::SilentCell>(whole);
  };
  const Certificate certificate = certificate_of(run_certificate(request, open));
  CHECK(certificate.run.judge == JudgeKind::kTracker);
  CHECK(certificate.all_count());
  CHECK(certificate.accuracy.judge_sigma >= whole.tracker.sigma_m);
  CHECK(certificate.accuracy.workspace.value().errors.max < 0.2e-3);
  CHECK_FALSE(certificate.accuracy.poses.at(0).turn);
  const auto json = certificate_list(certificate).json();
  CHECK(json.contains("poses_tracker"));
  CHECK_FALSE(json.contains("poses_truth"));
  const std::string page = certificate_page(certificate);
  CHECK_THAT(page, Catch::Contains("the cell's laser tracker") &&
                       Catch::Contains("mm of RP by itself; what all readings share makes none"));
  CHECK_THAT(page, Catch::Contains("Accuracy by ISO 9283:1998, judged by the cell's laser tracker: "
                                   "pose accuracy 0."));
  CHECK_THAT(page, !Catch::Contains("AP °"));

  // The same command again moves nothing and finds the same.
  const Certificate again = certificate_of(run_certificate(request, open));
  CHECK(opened == 1);
  CHECK(certificate_list(again).json() == json);
  request.size.cycles = 3;
  CHECK_THROWS_MATCHES(run_certificate(request, open), InputError,
                       test::Refused(Cause::kForeign, "cycles.csv"));
}

TEST_CASE("Lengths and intervals that round to zero are said in words") {
  CHECK(figure_mm(1.24e-5) == "0.0124");
  CHECK(figure_mm(4e-8) == "<0.0001");
  CHECK(figure_mm(std::nan("")) == "–");
  CHECK(interval_mm(Interval(1.5e-6, 4.7e-6)) == "0.0015 to 0.0047");
  CHECK(interval_mm(Interval(0.0, 3.1e-6)) == "below 0.0031");
  CHECK(interval_mm(Interval(0.0, 0.0)) == "no scatter seen");
  CHECK(interval_mm(std::nullopt) == "–");
}

}  // namespace
}  // namespace planar

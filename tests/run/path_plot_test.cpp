#include "planar_servo/run/path_report.h"

#include <catch2/catch.hpp>

#include "planar_servo/run/path_run.h"
#include "support/well_formed.h"

namespace planar {
namespace {

using Catch::Matchers::Contains;

/// A straight path of 200 mm along x.
Path straight_path() {
  return Path({{{{0.1, 0.2}, 0.0}, {}}, {{{0.3, 0.2}, 0.0}, {}}});
}

/// Looks all along the path, so far on its left.
std::vector<PathLookRow> looks_beside(Guidance guidance, double across_m, bool truth) {
  std::vector<PathLookRow> looks;
  for (double along_m = 0.0; along_m < 0.2; along_m += 0.05) {
    PathLookRow row;
    row.guidance = guidance;
    row.speed_m_s = 0.01;
    row.look.seen = {along_m, across_m};
    if (truth) row.truth = PathOffset{along_m, across_m};
    looks.push_back(row);
  }
  return looks;
}

std::string page_of(const std::vector<std::vector<PathLookRow>>& ways) {
  std::vector<PathLookRow> looks;
  std::vector<PathSpeedResult> results;
  for (const std::vector<PathLookRow>& way : ways) {
    looks.insert(looks.end(), way.begin(), way.end());
    results.push_back(path_figures(way));
    results.back().guidance = way.front().guidance;
    results.back().speed_m_s = way.front().speed_m_s;
  }
  HtmlPage page("a path");
  add_path_plots(page, straight_path(), looks, results);
  CHECK(test::fault_of_xml(page.text()).empty());
  return page.text();
}

TEST_CASE("The deviation from a path is drawn on its left, magnified by the factor that is said") {
  const std::string page = page_of({looks_beside(Guidance::kVision, 1e-5, false)});
  CHECK_THAT(page, Contains("deviation drawn 1000 times its size"));
  // The plot shows 232 mm by 32 mm on 290 by 40 units from (62, 34): the path at half its height,
  // 0.01 mm beside it 10 mm higher.
  CHECK_THAT(page, Contains("d=\"M82.0 41.5 L144.5 41.5"));
  CHECK_THAT(page_of({looks_beside(Guidance::kVision, -1e-5, false)}), Contains("M82.0 66.5 L"));
}

TEST_CASE("Guidances and judges have panels of their own, and what nobody saw has none") {
  const std::string seen = page_of({looks_beside(Guidance::kVision, 1e-5, false)});
  CHECK_THAT(seen, Contains("By vision, as seen") && !Contains("in truth<") &&
                       !Contains("By the arm alone"));
  const std::string both = page_of(
      {looks_beside(Guidance::kArm, 4e-5, true), looks_beside(Guidance::kVision, 1e-5, true)});
  CHECK_THAT(both, Contains("By vision, in truth") && Contains("By the arm alone, as seen") &&
                       Contains("Deviation by speed, in truth"));
  CHECK_THAT(page_of({}), !Contains("<svg"));
}

}  // namespace
}  // namespace planar

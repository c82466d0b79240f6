#include "planar_servo/work/run/path_report.h"

#include <catch2/catch.hpp>

#include "planar_servo/work/run/path_run.h"
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
  // The plot shows 261 mm by 61 mm on 290 by 68 units from (62, 34): the path at half its height,
  // 0.01 mm beside it 10 mm higher.
  CHECK_THAT(page, Contains("d=\"M96.0 56.9 L151.5 56.9"));
  CHECK_THAT(page_of({looks_beside(Guidance::kVision, -1e-5, false)}), Contains("M96.0 79.1 L"));
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

std::vector<PathSpeedResult> results_of(const std::vector<std::vector<PathLookRow>>& ways) {
  std::vector<PathSpeedResult> results;
  for (const std::vector<PathLookRow>& way : ways) {
    results.push_back(path_figures(way));
    results.back().guidance = way.front().guidance;
    results.back().status = ServoStatus::kReached;
  }
  return results;
}

TEST_CASE("The page of a path begins with whether it was followed, how near and who judged") {
  const PathRequest path{"path.csv", straight_path(), {Guidance::kVision}};
  auto results = results_of({looks_beside(Guidance::kArm, 4e-5, true),
                             looks_beside(Guidance::kVision, 1e-5, true),
                             looks_beside(Guidance::kVision, 2e-5, true)});
  CHECK_THAT(path_page(path, results, {}),
             Contains("<b>Good:</b> the path was followed to its end every time") &&
                 Contains("judged by the truth of the virtual cell: guided by vision 0.0100 to "
                          "0.0200 mm on average and 0.0200 mm at most; guided by the arm alone "
                          "0.0400 mm on average"));
  results.front().status = ServoStatus::kHeld;
  results.front().reason = "two lamps changed places";
  CHECK_THAT(path_page(path, results, {}),
             Contains("verdict bad") &&
                 Contains("guided by arm, the path was not followed to its "
                          "end: held") &&
                 Contains("two lamps changed places"));
}

TEST_CASE("The page of a path that no truth watched says whose estimate it has") {
  const PathRequest path{"path.csv", straight_path(), {Guidance::kVision}};
  CHECK_THAT(path_page(path, results_of({looks_beside(Guidance::kVision, 1e-5, false)}), {}),
             Contains("by vision's own estimate") && !Contains("true mean"));
}

}  // namespace
}  // namespace planar

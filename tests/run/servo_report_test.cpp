#include "planar_servo/work/run/servo_report.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "support/well_formed.h"

namespace planar {
namespace {

TargetResult reached(const std::string& id, double before_m, double after_m) {
  TargetResult result;
  result.id = id;
  result.status = ServoStatus::kReached;
  result.iterations = 2;
  result.seconds = 1.5;
  result.before_judged = Eigen::Vector2d(before_m, 0.0);
  result.after_judged = Eigen::Vector2d(0.0, after_m);
  result.before_own = result.before_judged;
  result.after_own = Eigen::Vector2d(1e-6, 0.0);
  return result;
}

std::string page_of(const std::vector<TargetResult>& results) {
  std::string page = servo_page("cell.yaml", figures_of(results), results);
  CHECK(test::fault_of_xml(page).empty());
  return page;
}

/// Returns how often a text stands in another.
std::size_t count_of(const std::string& text, const std::string& in) {
  std::size_t count = 0;
  for (std::size_t at = in.find(text); at != std::string::npos; at = in.find(text, at + 1)) ++count;
  return count;
}

TEST_CASE("The figures of a run carry the suffix of who judged them, in millimetres") {
  const auto json =
      servo_list(figures_of({reached("a", 1e-3, 1e-5), reached("b", 3e-3, 3e-5)})).json();
  CHECK(json["targets"] == 2);
  CHECK(json["reached"] == 2);
  CHECK(json["before_mean_mm_truth"].get<double>() == Approx(2.0));
  CHECK(json["after_mean_mm_truth"].get<double>() == Approx(0.02));
  CHECK(json["after_max_mm_truth"].get<double>() == Approx(0.03));
  CHECK(json["improvement_truth"].get<double>() == Approx(0.99));
  CHECK(json["after_mean_mm_own_view"].get<double>() == Approx(0.001));
  CHECK(json["iterations_median"] == 2.0);
  CHECK(json["seconds_per_target"] == 1.5);
}

TEST_CASE("The stated interval is compared with the truth, component by component") {
  TargetResult a = reached("a", 1e-3, 1e-5), b = reached("b", 1e-3, 1e-5);
  CHECK_FALSE(figures_of({a}).coverage_95);
  a.uncertainty_m = b.uncertainty_m = 1e-6;
  a.vision_compensated = Eigen::Vector2d(1.9e-6, -1.9e-6);
  b.vision_compensated = Eigen::Vector2d(-2.1e-6, 0.0);
  const ServoFigures figures = figures_of({a, b});
  CHECK(figures.coverage_95->share() == 0.75);
  CHECK(servo_list(figures).json()["coverage_95_truth"] == 0.75);
  CHECK_THAT(servo_list(figures).text(), Catch::Contains("75.0 % of the components"));
}

TEST_CASE("The interval is that of the place that the servo believed in, where it had one") {
  TargetResult a = reached("a", 1e-3, 1e-5);
  a.uncertainty_m = 1e-6;
  a.vision_compensated = Eigen::Vector2d(9e-6, 9e-6);
  a.believed = Eigen::Vector2d(0.5e-6, 9e-6);
  CHECK(figures_of({a}).coverage_95->share() == 0.5);
  a.believed = a.vision_compensated = std::nullopt;
  CHECK_THAT(landing_words(figures_of({a})), !Catch::Contains("intervals"));
}

TEST_CASE("A run says where the arm alone landed and what vision added, without a percentage") {
  const ServoFigures figures = figures_of({reached("a", 3.2e-6, 3.1e-6)});
  CHECK(
      landing_words(figures) ==
      "Judged by the truth of the virtual cell, the arm alone landed 0.0032 mm from its targets on "
      "average, with vision 0.0031 mm (0.0031 mm rms, 0.0031 mm at 95 %, 0.0031 mm at most)");
  CHECK_THAT(
      servo_list(figures).text(),
      Catch::Contains("against the truth: the arm alone 0.0032 mm mean; with vision 0.0031") &&
          !Catch::Contains("improvement"));
}

TEST_CASE("Vision that makes the arm worse by more than chance is a fault of the run") {
  std::vector<TargetResult> results;
  for (const double change_m : {1e-6, 2e-6, 3e-6, -0.5e-6, 2e-6})
    results.push_back(reached("a", 5e-6, 5e-6 + change_m));
  CHECK(figures_of(results).made_worse);
  CHECK_THAT(servo_list(figures_of(results)).text(), Catch::Contains("vision made the arm worse"));
  CHECK_THAT(page_of(results), Catch::Contains("verdict bad"));
  results.push_back(reached("b", 9e-6, 1e-6));
  CHECK_FALSE(figures_of(results).made_worse);
  CHECK_THAT(page_of(results), Catch::Contains("class=\"verdict\""));
}

TEST_CASE("A run in which targets were not reached is said to be one") {
  TargetResult missed = reached("far", 1e-3, 1e-3);
  missed.status = ServoStatus::kNotConverged;
  const ServoFigures figures = figures_of({reached("a", 1e-3, 1e-5), missed});
  const auto faults = run_faults(figures, "results.csv");
  REQUIRE(faults.size() == 1);
  CHECK(faults[0].fault == "1 of 2 targets were not reached");
  CHECK(faults[0].remedy == "results.csv has the reason of each");
}

TEST_CASE("Without a truth no figure claims one") {
  TargetResult result = reached("a", 1e-3, 1e-5);
  result.before_judged = result.after_judged = std::nullopt;
  const auto json = servo_list(figures_of({result})).json();
  CHECK_FALSE(json.contains("after_mean_mm_truth"));
  CHECK(json.contains("after_mean_mm_own_view"));
  CHECK_THAT(servo_list(figures_of({result})).text(), !Catch::Contains("truth"));
}

TEST_CASE("Where a tracker judges, its uncertainty stands beside the errors and is taken out") {
  TargetResult a = reached("a", 1e-3, 5e-5), b = reached("b", 1e-3, 5e-5), c = a;
  a.sigma_judged_m = b.sigma_judged_m = 3e-5;
  c.id = "c";
  c.before_judged = c.after_judged = std::nullopt;
  c.not_judged = "a broken beam";
  const ServoFigures figures = figures_of({a, b, c});
  const auto json = servo_list(figures).json();
  CHECK(json["after_rms_mm_truth"].get<double>() == Approx(0.05));
  CHECK(json["sigma_mm_truth"].get<double>() == Approx(0.03));
  CHECK(json["after_rms_net_mm_truth"].get<double>() ==
        Approx(0.01 * std::sqrt(7.0)));  // 25 - 2 x 9
  CHECK(json["judged"] == 2);
  CHECK(json["not_judged"] ==
        nlohmann::json::array({{{"target", "c"}, {"reason", "a broken beam"}}}));
  for (const char* key : {"after_rms_mm", "sigma_mm", "after_rms_net_mm", "improvement"})
    CHECK(json[key + std::string("_tracker")] == json[key + std::string("_truth")]);
  CHECK_THAT(servo_list(figures).text(), Catch::Contains("against the tracker: the arm alone") &&
                                             Catch::Contains("uncertain by 0.0300 mm per axis") &&
                                             Catch::Contains("not judged: c: a broken beam") &&
                                             !Catch::Contains("against the truth"));
  a.sigma_judged_m = 1e-4;
  CHECK(servo_list(figures_of({a})).json()["after_rms_net_mm_truth"] == 0.0);
  CHECK_THAT(servo_list(figures_of({a})).text(),
             Catch::Contains("which explains the errors with vision"));
}

TEST_CASE("The stated interval allows for the tracker that judges it") {
  TargetResult a = reached("a", 1e-3, 1e-5);
  a.uncertainty_m = 3e-6;
  a.vision_compensated = Eigen::Vector2d(9e-6, 0.0);
  CHECK(figures_of({a}).coverage_95->share() == 0.5);
  a.sigma_judged_m = 4e-6;
  CHECK(figures_of({a}).coverage_95->share() == 1.0);
}

TEST_CASE("Intervals are called too narrow or too wide where chance does not explain it") {
  const auto words = [](double off_m, std::size_t targets) {
    TargetResult a = reached("a", 1e-3, 1e-5);
    a.uncertainty_m = 1e-6;
    a.believed = Eigen::Vector2d(0.5e-6, off_m);
    return landing_words(figures_of(std::vector<TargetResult>(targets, a)));
  };
  CHECK_THAT(words(9e-6, 1), !Catch::Contains("intervals"));
  CHECK_THAT(words(9e-6, 5), Catch::Contains("intervals are too narrow"));
  CHECK_THAT(words(0.5e-6, 5), !Catch::Contains("intervals"));
  CHECK_THAT(words(0.5e-6, 100), Catch::Contains("intervals are wider than need be"));
}

TEST_CASE("A run says how many of the camera's frames it left out") {
  ServoFigures figures = figures_of({reached("a", 1e-3, 1e-5)});
  CHECK_THAT(servo_list(figures).text(), !Catch::Contains("camera"));
  figures.frames = FrameCounts{412, 3, 2, 1};
  CHECK_THAT(
      servo_list(figures).text(),
      Catch::Contains("camera: 412 whole frames; left out: 3 with parts missing, 2 repeated; "
                      "the camera was lost and found 1 time\n"));
  const auto json = servo_list(figures).json();
  CHECK(json["frames_complete"] == 412);
  CHECK(json["frames_incomplete"] == 3);
  CHECK(json["frames_frozen"] == 2);
  CHECK(json["camera_reopened"] == 1);
}

TEST_CASE("A refused target counts as a target that was not reached and has no error") {
  TargetResult refused;
  refused.id = "far";
  refused.reason = "too far";
  const ServoFigures figures = figures_of({reached("a", 1e-3, 1e-5), refused});
  CHECK(figures.targets == 2);
  CHECK(figures.reached == 1);
  CHECK(figures.after_judged->n == 1);
}

TEST_CASE("The page of a run says who judged it, though the first target was not judged") {
  TargetResult unseen = reached("a", 1e-3, 5e-5), seen = reached("b", 1e-3, 5e-5);
  unseen.before_judged = unseen.after_judged = std::nullopt;
  unseen.not_judged = "a broken beam";
  seen.sigma_judged_m = 3e-5;
  const std::string page = page_of({unseen, seen});
  CHECK_THAT(page, Catch::Contains("Errors against the tracker") &&
                       Catch::Contains("<th scope=\"col\">after tracker mm</th>") &&
                       Catch::Contains("Judged by the tracker, the arm alone") &&
                       !Catch::Contains("truth"));
  CHECK_THAT(page_of({reached("a", 1e-3, 1e-5)}), Catch::Contains("Errors against the truth") &&
                                                      Catch::Contains(">after truth mm</th>"));
}

TEST_CASE("The page of a run begins with targets reached and accuracy, and says no figure twice") {
  const std::vector<TargetResult> results{reached("a", 1e-3, 1e-5), reached("b", 3e-3, 4e-5)};
  const std::string page = page_of(results);
  CHECK_THAT(page,
             Catch::Contains("<b>Good:</b> 2 of 2 targets reached, 2 corrections and 1.50 s"));
  for (const char* figure :
       {"2.0000 mm from its targets", "0.0250 mm (", "0.0385 mm at 95", "2 of 2 targets", "1.50 s"})
    CHECK(count_of(figure, page) == 1);
  CHECK(count_of("0.0250", page) == 1);
}

TEST_CASE("The page of a run that nobody judged says so, and how to have it judged") {
  TargetResult result = reached("a", 1e-3, 1e-5);
  result.before_judged = result.after_judged = std::nullopt;
  CHECK_THAT(page_of({result}), Catch::Contains("By vision's own estimate, the arm alone landed") &&
                                    Catch::Contains("Nobody else judged this run") &&
                                    Catch::Contains("--judged") && !Catch::Contains("truth"));
}

TEST_CASE("The page of a run without a single measured target still has its verdict") {
  TargetResult refused;
  refused.id = "far";
  refused.reason = "too far";
  CHECK_THAT(page_of({refused}), Catch::Contains("1 of 1 targets were not reached") &&
                                     Catch::Contains("No end point was measured") &&
                                     Catch::Contains("too far") && !Catch::Contains("<svg"));
}

TEST_CASE("What ended a run early stands in the verdict of its page, with the remedy") {
  const std::vector<TargetResult> results{reached("a", 1e-3, 1e-5)};
  const auto page = [&](const std::string& ended_by, bool work_has_moved) {
    return servo_page("cell.yaml", figures_of(results), results,
                      early_end(ended_by, work_has_moved));
  };
  CHECK_THAT(page("b: held: two lamps changed places", false),
             Catch::Contains("verdict bad") &&
                 Catch::Contains("the run was ended at b: held: two lamps changed places") &&
                 Catch::Contains("--resume"));
  // A resumed run would refuse what lies elsewhere now.
  CHECK_THAT(page("a look at the cell: the work has moved", true),
             Catch::Contains("the work has moved") && !Catch::Contains("--resume"));
}

TEST_CASE("Errors share one scale of arrows unless some could not be seen at it") {
  CHECK_THAT(page_of({reached("a", 3e-5, 1e-5), reached("b", 3e-5, 1e-5)}),
             Catch::Contains("Both panels have the same scale"));
  CHECK_THAT(page_of({reached("a", 1e-3, 1e-5), reached("b", 1e-3, 1e-5)}),
             Catch::Contains("each panel has its own scale"));
}

}  // namespace
}  // namespace planar

#include "planar_servo/certificate/certificate_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/places.h"
#include "planar_servo/report/plot.h"

namespace planar {
namespace {

constexpr char kSheetStyle[] =
    R"(@page{size:A4;margin:9mm 11mm}
.sheet{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,24rem),1fr));column-gap:2rem}
.words :is(th,td):last-child{text-align:left}
.sign{display:grid;grid-template-columns:1fr 1fr 1fr;column-gap:2rem;margin-top:4rem}
.sign div{border-top:1px solid #333;padding-top:.2rem}
@media print{body{font:7.7pt/1.2 system-ui,sans-serif;max-width:none;padding:0}
h1{font-size:13pt;margin:0 0 .5mm}p{margin:.6mm 0;max-width:none}table,.wide table{margin:.8mm 0;width:100%}
caption{padding:.2mm 0}th,td{padding:.1mm 1mm}:is(th,td):first-child{padding-left:0}
.sheet{grid-template-columns:1.25fr 1fr;column-gap:6mm}
.verdict{padding:.6mm 3mm;margin:.8mm 0;border-left-width:2mm;max-width:none}
.panels{justify-content:space-evenly;margin:1mm 0}.panels>div{flex:none!important}
.panels svg{height:50mm;width:auto}.verdict.bad~.panels svg{height:40mm}
.sign{column-gap:6mm;margin-top:11mm}.sign div{padding-top:.6mm}}
)";

constexpr char kNone[] = "–";
constexpr std::size_t kDigitsOfHash = 16;
/// RP = mean + 3 S of distances that only normal scatter of unit deviation per axis makes: those of
/// Rayleigh's distribution, sqrt(pi / 2) + 3 sqrt(2 - pi / 2).
constexpr double kRepeatabilityOfScatter = 3.2187;
static_assert(std::size(kSeriesColors) >= std::tuple_size_v<CycleErrors>);  // P1 to P5

std::string judge_words(const Certificate& certificate) {
  if (certificate.run.judge == JudgeKind::kTruth)
    return "the truth of the virtual cell, which has no uncertainty";
  return fmt::format(
      "the cell's laser tracker, its reflector's reading moved to the end point by tool.yaml; "
      "standard uncertainty {} mm per axis, besides the errors of the monuments' places. All "
      "figures hold its noise, which makes up to {} mm of RP by itself",
      figure_mm(certificate.accuracy.judge_sigma),
      figure_mm(kRepeatabilityOfScatter * certificate.accuracy.judge_sigma));
}

void add_opening(HtmlPage& page, const Certificate& certificate) {
  const CertificateRun& run = certificate.run;
  const CellAccuracy& accuracy = certificate.accuracy;
  const std::string first = run.moves.empty() ? kNone : run.moves.front().utc;
  const std::string last = run.moves.empty() ? kNone : run.moves.back().utc;
  page.add_paragraph(fmt::format(
      "Measured {} to {} (UTC) by {}: {} cycles of the poses, {} targets, {} moves of {} s in the "
      "mean. Judged by {}.",
      first, last, certifying_program(), run.request.size.cycles, run.request.size.targets,
      accuracy.moves,
      fixed(accuracy.moves ? accuracy.seconds / static_cast<double>(accuracy.moves) : 0.0, 2),
      judge_words(certificate)));
}

/// Says what was found; a sentence without a full stop. Empty where nothing was judged.
std::string found_words(const Certificate& certificate) {
  const CellAccuracy& accuracy = certificate.accuracy;
  std::vector<std::string> found;
  for (const auto& [name, words] : worst_pose_figures(accuracy))
    found.push_back(fmt::format("{} {}", name, words));
  if (const auto& workspace = accuracy.workspace)
    found.push_back(fmt::format("over the workspace 95 % of {} targets within {} mm",
                                workspace->errors.n, figure_mm(workspace->errors.p95)));
  if (found.empty()) return "";
  return fmt::format("Accuracy by ISO 9283:1998, judged by the {}: {}",
                     certificate.run.judge == JudgeKind::kTruth ? "truth of the virtual cell"
                                                                : "cell's laser tracker",
                     fmt::join(found, "; "));
}

Verdict verdict_of(const Certificate& certificate) {
  const CellAccuracy& accuracy = certificate.accuracy;
  Verdict verdict;
  verdict.good = fmt::format("all {} moves reached their targets and were judged", accuracy.moves);
  verdict.found = found_words(certificate);
  if (!certificate.run.ended_by.empty())
    verdict.faults.push_back(
        {"the run was ended at " + certificate.run.ended_by,
         "mend the cell (planar-check-cell), then give the same command to continue"});
  if (accuracy.reached < accuracy.moves)
    verdict.faults.push_back(
        {fmt::format("{} of {} moves did not reach their targets and are in no figure",
                     accuracy.moves - accuracy.reached, accuracy.moves),
         "see the column status of cycles.csv, mend the cell, and certify it into another folder"});
  if (accuracy.judged < accuracy.reached)
    verdict.faults.push_back({fmt::format("{} moves were not judged and are in no figure",
                                          accuracy.reached - accuracy.judged),
                              "clear the tracker's view and certify the cell into another folder"});
  const std::vector<std::string>& accepted = certificate.run.accepted;
  if (!accepted.empty())
    verdict.faults.push_back(
        {fmt::format("objections to the files were accepted, {} in all: {}", accepted.size(),
                     accepted.front()),
         "make the cell's files anew from one another; certificate.json lists them"});
  return verdict;
}

std::string direction_table(const CellAccuracy& accuracy) {
  TextTable table("Variation with the approach vAP, drift over the run",
                  {"figure", "compared", "found mm", "chance alone mm"});
  for (const DirectionFigures& d : accuracy.directions)
    table.add_row({"vAP at " + d.name, fmt::format("{} × {} cycles", d.directions, d.cycles),
                   figure_mm(d.variation), figure_mm(d.chance)});
  if (!accuracy.drift) return table.html();
  const PoseDrift& drift = *accuracy.drift;
  const std::string cycles = fmt::format("first and last {}", drift.cycles);
  const auto change = [&](const char* what, const FirstAndLast& values) {
    table.add_row({what, fmt::format("{} → {}", figure_mm(values.first), figure_mm(values.last)),
                   figure_mm(std::abs(values.last - values.first)), figure_mm(values.chance)});
  };
  table.add_row({"shift", cycles, figure_mm(drift.shift), figure_mm(drift.shift_chance)});
  change("change of AP", drift.accuracy);
  if (drift.repeatability) change("change of RP", *drift.repeatability);
  return table.html();
}

std::string workspace_table(const WorkspaceFigures& workspace) {
  TextTable table(fmt::format("Positioning over the workspace, {} targets", workspace.errors.n),
                  {"error", "mm", "95 % interval"});
  table.add_row({"mean", figure_mm(workspace.errors.mean), interval_mm(workspace.mean)});
  table.add_row({"rms", figure_mm(workspace.errors.rms), interval_mm(workspace.rms)});
  table.add_row({"95 % are below", figure_mm(workspace.errors.p95), interval_mm(workspace.p95)});
  table.add_row({"largest", figure_mm(workspace.errors.max),
                 fmt::format("above {:.1f} % of all", 100.0 * workspace.below_max)});
  if (workspace.turn_rms)
    table.add_row(
        {"tool's direction, rms", fmt::format("{:.4f}°", *workspace.turn_rms / kDegree), kNone});
  return table.html();
}

std::string budget_table(const UncertaintyBudget& budget) {
  TextTable table = budget_list(budget).table(
      "Uncertainty budget over the workspace: per axis, and the share of the expected mean square",
      "terms");
  table.add_row({"root sum of squares × √2", figure_mm(budget.expected), "",
                 fmt::format("expected rms length; found {} ({})", figure_mm(budget.found),
                             interval_mm(budget.found_95))});
  return "<div class=\"words\">" + table.html() + "</div>";
}

std::string file_table(const CellSettings& cell) {
  TextTable table("Files", {"what", "file", "SHA-256 begins with"});
  for (const auto& [role, path] : certified_files(cell))
    table.add_row({role, path.filename().string(), content_sha256(path).substr(0, kDigitsOfHash)});
  return table.html();
}

std::string condition_table(const CellSettings& cell) {
  TextTable table("Conditions", {"", ""});
  const ServoSettings& servo = cell.servo;
  table.add_row(
      {"approach", servo.approach == Approach::kOneSide ? "every motor from one side" : "direct"});
  table.add_row({"measurement", fmt::format("{} frames after {:.2f} s of rest",
                                            servo.frames_per_measurement, servo.settle_s)});
  table.add_row({"tolerance", fmt::format("{:.4f} mm", mm(servo.tolerance_m))});
  std::string speeds;
  for (const MotorDrive& drive : cell.transmission.drives)
    speeds += fmt::format("{}{:.0f}", speeds.empty() ? "" : ", ", drive.max_speed_rad_s / kDegree);
  table.add_row({"speeds of the motors", speeds + " °/s"});
  table.add_row({"temperature, °C", "........................"});
  table.add_row({"load at the tool, kg", "........................"});
  return table.html();
}

/// Returns the colours and names of the poses.
std::vector<Panel::Key> pose_keys(const CertificateRun& run) {
  std::vector<Panel::Key> keys;
  for (std::size_t i = 0; i < run.places.poses.size(); ++i)
    keys.push_back({kSeriesColors[i], pose_name(i)});
  return keys;
}

Panel workspace_panel(const CertificateRun& run) {
  std::vector<Eigen::Vector2d> places, errors;
  for (const JudgedMove& move : run.moves) {
    if (move.move.part != CertificatePart::kWorkspace || !move.counts()) continue;
    places.push_back(move.move.p_d);
    errors.push_back(*move.error);
  }
  const double half = 0.5 * run.places.square.side;
  std::vector<Eigen::Vector2d> square;
  for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}, {-1, -1}})
    square.emplace_back(run.places.square.centre + half * Eigen::Vector2d(x, y));
  std::vector<Eigen::Vector2d> all = places;
  all.insert(all.end(), square.begin(), square.end());
  const FieldAxes axes = axes_over_places(in_mm(all));
  Panel panel("Errors over the workspace", axes.x, axes.y, Panel::Aspect::kEqual);
  panel.add_line(in_mm(square), Panel::Stroke::kDashed);
  if (!places.empty())
    panel.add_arrows(in_mm(places), in_mm(errors), arrows_over(in_mm(errors), "mm"));
  for (std::size_t i = 0; i < run.places.poses.size(); ++i)
    panel.add_dots(in_mm({run.places.poses[i]}), {kSeriesColors[i]}, 5.0);
  panel.add_keys(pose_keys(run));
  return panel;
}

/// Returns the errors of every cycle at a pose, millimetres.
std::vector<Eigen::Vector2d> errors_at(const std::string& pose, const CertificateRun& run) {
  std::vector<Eigen::Vector2d> errors;
  for (const JudgedMove& move : run.moves)
    if (move.move.part == CertificatePart::kPose && move.move.pose == pose && move.counts())
      errors.emplace_back(*move.error / kMillimetre);
  return errors;
}

/// Draws the errors of every cycle at each pose.
Panel pose_panel(const CertificateRun& run) {
  constexpr double kRoom = 1.1;
  std::vector<std::vector<Eigen::Vector2d>> errors;
  double most = 0.0;
  for (std::size_t i = 0; i < run.places.poses.size(); ++i) {
    errors.push_back(errors_at(pose_name(i), run));
    for (const Eigen::Vector2d& error : errors[i])
      most = std::max(most, error.cwiseAbs().maxCoeff());
  }
  most = most > 0.0 ? kRoom * most : 1.0;
  Panel panel("Errors at the poses, every cycle", {"x error, mm", -most, most},
              {"y error, mm", -most, most}, Panel::Aspect::kEqual);
  panel.add_line({{-most, 0.0}, {most, 0.0}}, Panel::Stroke::kDashed);
  panel.add_line({{0.0, -most}, {0.0, most}}, Panel::Stroke::kDashed);
  for (std::size_t i = 0; i < errors.size(); ++i)
    panel.add_dots(errors[i], {kSeriesColors[i]}, 3.0);
  panel.add_keys(pose_keys(run));
  return panel;
}

std::string place_words(const TestPlaces& places) {
  const std::string reached =
      places.usable < 1.0
          ? fmt::format("{:.1f} % of the workspace; the rest is not reached", 100.0 * places.usable)
          : "the whole workspace";
  return fmt::format(
      "P1 is the centre and P2 to P5 lie on the diagonals, a tenth of their length from the "
      "corners, of the largest square with sides along x and y of the base that arm, camera and "
      "error map reach: {:.0f} mm wide about ({:.0f}, {:.0f}) mm, on a raster of {:.0f} mm. "
      "They are visited in the order P1 to P5. The standard's cube is cut down to a square and "
      "z is left out, because the arm is planar. Targets are spread by Halton's sequence over {}.",
      mm(places.square.side), mm(places.square.centre.x()), mm(places.square.centre.y()),
      mm(places.raster), reached);
}

}  // namespace

std::string certificate_page(const Certificate& certificate) {
  const CertificateRun& run = certificate.run;
  const CellSettings& cell = run.request.servo.cell->settings;
  HtmlPage page("Accuracy of the cell " + cell.file.string());
  page.add_style(kSheetStyle);
  add_opening(page, certificate);
  page.add_verdict(verdict_of(certificate));
  if (!certificate.accuracy.poses.empty())
    page.add_html(
        certificate_list(certificate)
            .table("Pose accuracy AP and repeatability RP, ISO 9283, in the plane", "poses")
            .html());
  page.add_paragraph(
      "n: arrivals. AP: distance of their mean from the commanded pose. RP: radius about that "
      "mean, the mean distance from it plus three standard deviations. 95 % interval: the figure "
      "lies in it with 95 % confidence.");
  page.add_html("<div class=\"sheet\"><div>" + direction_table(certificate.accuracy) +
                "</div><div>");
  if (certificate.accuracy.workspace)
    page.add_html(workspace_table(*certificate.accuracy.workspace));
  page.add_html("</div></div>\n");
  page.add_paragraph(
      "vAP: largest distance between the mean errors of approaches along +x, -x, +y and -y. Chance "
      "alone: in 95 of 100 runs scatter alone stays below it; what was found above it is more.");
  page.add_html(plot_html({workspace_panel(run), pose_panel(run)}));
  page.add_paragraph(place_words(run.places));
  if (certificate.budget) {
    page.add_html(budget_table(*certificate.budget));
    page.add_paragraph(budget_words(*certificate.budget));
  }
  page.add_html("<div class=\"sheet\"><div>" + file_table(cell) + "</div><div>" +
                condition_table(cell) + "</div></div>\n");
  page.add_html(
      "<div class=\"sign\"><div>name</div><div>place and date</div><div>signature</div></div>\n");
  return page.text();
}

}  // namespace planar

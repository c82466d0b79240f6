#include "planar_servo/certificate/certificate_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/core/text.h"
#include "planar_servo/core/units.h"
#include "planar_servo/io/checksum.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/places.h"
#include "planar_servo/report/plot.h"
#include "planar_servo/report/text_table.h"

namespace planar {
namespace {

constexpr char kSheetStyle[] =
    R"(@page{size:A4;margin:9mm 11mm}body{font:7.7pt/1.2 system-ui,sans-serif;max-width:188mm;margin:4mm auto}
h1{font-size:13pt;margin:0 0 .5mm}p{margin:.6mm 0}table{margin:.8mm 0;width:100%}
caption{padding:.2mm 0}th,td{padding:.1mm 1mm}th:first-child,td:first-child{padding-left:0}
.sheet{display:grid;grid-template-columns:1.25fr 1fr;column-gap:6mm}
.verdict{padding:.6mm 3mm;margin:.8mm 0;border-left-width:2mm}
.words td:last-child,.words th:last-child{text-align:left}.figure{text-align:center}
.figure svg{height:66mm;width:auto}.verdict.bad~.figure svg{height:38mm}
.sign{display:grid;grid-template-columns:1fr 1fr 1fr;column-gap:6mm;margin-top:11mm}
.sign div{border-top:1px solid #333;padding-top:.6mm}@media print{body{margin:0}}
)";

constexpr char kNone[] = "–";
constexpr std::size_t kDigitsOfHash = 16;
/// RP = mean + 3 S of distances that only normal scatter of unit deviation per axis makes: those of
/// Rayleigh's distribution, sqrt(pi / 2) + 3 sqrt(2 - pi / 2).
constexpr double kRepeatabilityOfScatter = 3.2187;
/// Of P1 to P5; told apart by people who do not see all colours [Okabe and Ito 2008].
constexpr const char* kPoseColors[][2] = {{"#0072b2", "blue"},
                                          {"#e69f00", "orange"},
                                          {"#009e73", "green"},
                                          {"#d55e00", "red"},
                                          {"#cc79a7", "pink"}};

std::string mm_text(double metres) {
  return std::isfinite(metres) ? fmt::format("{:.4f}", mm(metres)) : kNone;
}

std::string range_mm(const std::optional<Interval>& interval) {
  return interval ? fmt::format("{} to {}", mm_text(interval->first), mm_text(interval->second))
                  : kNone;
}

std::string judge_words(const Certificate& certificate) {
  if (certificate.run.judge == JudgeKind::kTruth)
    return "the truth of the virtual cell, which has no uncertainty";
  return fmt::format(
      "the cell's laser tracker, its reflector's reading moved to the end point by tool.yaml; "
      "standard uncertainty {} mm per axis, besides what the monuments' places are wrong by. All "
      "figures hold its noise, which makes up to {} mm of RP by itself",
      mm_text(certificate.accuracy.judge_sigma),
      mm_text(kRepeatabilityOfScatter * certificate.accuracy.judge_sigma));
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

Verdict verdict_of(const Certificate& certificate) {
  const CellAccuracy& accuracy = certificate.accuracy;
  Verdict verdict;
  verdict.good = fmt::format("all {} moves reached their targets and were judged", accuracy.moves);
  if (!certificate.run.ended_by.empty())
    verdict.faults.push_back(
        {"the run was ended at " + certificate.run.ended_by,
         "mend the cell (planar-check-cell), then give the same command to go on"});
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
        {fmt::format("what speaks against the files was accepted, {} sentences in all: {}",
                     accepted.size(), accepted.front()),
         "make the cell's files anew from one another; certificate.json has every sentence"});
  return verdict;
}

std::string direction_table(const CellAccuracy& accuracy) {
  TextTable table("Variation with the approach vAP, drift over the run",
                  {"", "compared", "found mm", "by chance below mm"});
  for (const DirectionFigures& d : accuracy.directions)
    table.add_row({"vAP at " + d.name, fmt::format("{} × {} cycles", d.directions, d.cycles),
                   mm_text(d.variation), mm_text(d.chance)});
  if (!accuracy.drift) return table.html();
  const PoseDrift& drift = *accuracy.drift;
  const std::string cycles = fmt::format("first and last {}", drift.cycles);
  const auto change = [&](const char* what, const FirstAndLast& values) {
    table.add_row({what, fmt::format("{} → {}", mm_text(values.first), mm_text(values.last)),
                   mm_text(std::abs(values.last - values.first)), mm_text(values.chance)});
  };
  table.add_row({"shift", cycles, mm_text(drift.shift), mm_text(drift.shift_chance)});
  change("change of AP", drift.accuracy);
  if (drift.repeatability) change("change of RP", *drift.repeatability);
  return table.html();
}

std::string workspace_table(const WorkspaceFigures& workspace) {
  TextTable table(fmt::format("Positioning over the workspace, {} targets", workspace.errors.n),
                  {"error", "mm", "95 % interval"});
  table.add_row({"mean", mm_text(workspace.errors.mean), range_mm(workspace.mean)});
  table.add_row({"rms", mm_text(workspace.errors.rms), range_mm(workspace.rms)});
  table.add_row({"95 % are below", mm_text(workspace.errors.p95), range_mm(workspace.p95)});
  table.add_row({"largest", mm_text(workspace.errors.max),
                 fmt::format("above {:.1f} % of all", 100.0 * workspace.below_max)});
  if (workspace.turn_rms)
    table.add_row(
        {"tool's direction, rms", fmt::format("{:.4f}°", *workspace.turn_rms / kDegree), kNone});
  return table.html();
}

std::string budget_table(const UncertaintyBudget& budget) {
  TextTable table =
      budget_list(budget).table("Uncertainty budget over the workspace, per axis", "terms");
  table.add_row({"root sum of squares × √2", mm_text(budget.expected), "",
                 fmt::format("expected rms length; found {} ({})", mm_text(budget.found),
                             range_mm(budget.found_95))});
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
    panel.add_dots(in_mm({run.places.poses[i]}), {kPoseColors[i][0]}, 5.0);
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

/// Draws the errors of every cycle about the commanded pose.
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
  std::string note;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    panel.add_dots(errors[i], {kPoseColors[i][0]}, 3.0);
    note += fmt::format("{}{} {}", note.empty() ? "" : ", ", pose_name(i), kPoseColors[i][1]);
  }
  panel.add_note(note);
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
      "z is left out, because the arm is planar. vAP compares approaches along +x, -x, +y and "
      "-y. Targets are spread by Halton's sequence over {}. Intervals hold with 95 %, and "
      "chance alone keeps vAP and drift below their last column in 95 of 100 runs.",
      mm(places.square.side), mm(places.square.centre.x()), mm(places.square.centre.y()),
      mm(places.raster), reached);
}

}  // namespace

std::string certificate_page(const Certificate& certificate) {
  const CertificateRun& run = certificate.run;
  const CellSettings& cell = run.request.servo.cell;
  HtmlPage page("Accuracy of the cell " + cell.file.string());
  page.add_style(kSheetStyle);
  add_opening(page, certificate);
  page.add_verdict(verdict_of(certificate));
  if (!certificate.accuracy.poses.empty())
    page.add_html(
        certificate_list(certificate)
            .table("Pose accuracy AP and repeatability RP, ISO 9283, in the plane", "poses")
            .html());
  page.add_html("<div class=\"sheet\"><div>");
  page.add_html(direction_table(certificate.accuracy));
  page.add_html("</div><div>");
  if (certificate.accuracy.workspace)
    page.add_html(workspace_table(*certificate.accuracy.workspace));
  page.add_html("</div></div>\n<div class=\"figure\">");
  page.add_html(plot_svg({workspace_panel(run), pose_panel(run)}));
  page.add_html("</div>\n");
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

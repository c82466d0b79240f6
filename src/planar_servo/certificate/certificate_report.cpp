#include "planar_servo/certificate/certificate_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/places.h"
#include "planar_servo/report/plot.h"

namespace planar {
namespace {

constexpr char kProgram[] = "planar-certify " PLANAR_VERSION;
constexpr std::size_t kDigitsOfHash = 16;

/// Returns the files that a cell is certified with, each with what it is: the cell file first.
std::vector<std::pair<std::string, std::filesystem::path>> certified_files(
    const CellSettings& cell) {
  std::vector<std::pair<std::string, std::filesystem::path>> files{{"cell", cell.file}};
  for (const MadeFile& file : made_files(cell, true))
    if (std::filesystem::exists(file.path))
      files.emplace_back(name_in(kRoles, file.role), file.path);
  return files;
}

void list_run(ReportList& list, const CertificateRun& run) {
  list.unprinted("program", kProgram);
  list.unprinted("cell", run.request.servo.cell->settings.file.string());
  list.unprinted("cycles", run.request.size.cycles);
  list.unprinted("targets", run.request.size.targets);
  list.unprinted("ended_by", run.ended_by);
  list.unprinted("accepted_stale", run.accepted);
  ReportList square;
  square.unprinted("centre_mm", run.places.square.centre);
  square.unprinted("side_mm", run.places.square.side);
  square.unprinted("raster_mm", run.places.raster);
  square.unprinted("usable_share_of_workspace", run.places.usable);
  list.part("square", square);
  list.rows("files", certified_files(run.request.servo.cell->settings),
            [](ReportList& row, const auto& made) {
              const std::string sha256 = content_sha256(made.second);
              row.line("what", "{role}", made.first);
              row.line("file", made.second.filename().string());
              row.line("SHA-256 begins with", sha256.substr(0, kDigitsOfHash));
              row.unprinted("file", made.second.string());
              row.unprinted("sha256", sha256);
            });
  list.show("files", "Files");
  if (run.moves.empty()) return;
  list.unprinted("first_utc", run.moves.front().utc);
  list.unprinted("last_utc", run.moves.back().utc);
}

/// Lists one of the intervals.
void list_interval(ReportList& row, const std::string& key, const std::optional<PoseIntervals>& of,
                   Interval PoseIntervals::*part) {
  const std::optional<Interval> interval = part_of(of, part);
  row.unprinted(key, interval);
  row.line("95 % interval", interval_mm(interval));
}

void list_poses(ReportList& list, const CellAccuracy& accuracy) {
  const bool sees_turns = std::any_of(accuracy.poses.begin(), accuracy.poses.end(),
                                      [](const PoseFigures& pose) { return pose.turn; });
  list.rows("poses", accuracy.poses, [&](ReportList& row, const PoseFigures& pose) {
    row.line("pose", "{pose}", pose.name);
    row.line("x, y mm", "{place_mm:.1f}", pose.p);
    row.line("n", "{cycles}", pose.cycles);
    row.line("AP mm", "{ap_mm:.4f}", pose.position.accuracy);
    list_interval(row, "ap_95_mm", pose.intervals, &PoseIntervals::accuracy);
    row.line("RP mm", "{rp_mm:.4f}", pose.position.repeatability);
    list_interval(row, "rp_95_mm", pose.intervals, &PoseIntervals::repeatability);
    if (!sees_turns) return;
    row.line("AP °", "{ap_turn_deg:.4f}", part_of(pose.turn, &PoseAccuracy::accuracy));
    const auto turn = part_of(pose.turn, &PoseAccuracy::repeatability);
    row.line("RP °", "{rp_turn_deg:.4f}", turn && std::isfinite(*turn) ? turn : std::nullopt);
  });
  list.show("poses", "Pose accuracy AP and repeatability RP, ISO 9283, in the plane");
  for (const auto& [name, words] : worst_pose_figures(accuracy)) list.line(name, words);
}

/// Adds a row to the table of what was found beside what chance alone makes.
void list_beside_chance(ReportList& list, const std::string& figure, const std::string& compared,
                        double found, double chance) {
  list.row("variation", {{"figure", figure},
                         {"compared", compared},
                         {"found mm", figure_mm(found)},
                         {"chance alone mm", figure_mm(chance)}});
}

void list_directions(ReportList& list, const CellAccuracy& accuracy) {
  list.rows("directions", accuracy.directions, [&](ReportList& row, const DirectionFigures& found) {
    row.unprinted("pose", found.name);
    row.unprinted("directions", found.directions);
    row.unprinted("cycles", found.cycles);
    row.unprinted("vap_mm", found.variation);
    row.unprinted("chance_95_mm", found.chance);
    list_beside_chance(list, "vAP at " + found.name,
                       fmt::format("{} × {} cycles", found.directions, found.cycles),
                       found.variation, found.chance);
  });
  list.show("variation", "Variation with the approach vAP, drift over the run");
  if (accuracy.directions.empty()) return;
  const DirectionFigures& worst = accuracy.worst_variation();
  list.line(fmt::format("from {} directions", worst.directions),
            fmt::format("{:.4f} mm vAP at {}; scatter alone keeps it below {:.4f} mm",
                        mm(worst.variation), worst.name, mm(worst.chance)));
}

void list_drift(ReportList& list, const PoseDrift& drift) {
  ReportList part;
  part.line("drift",
            "{shift_mm:.4f} mm between the first and last thirds; chance alone keeps it below "
            "{shift_chance_95_mm:.4f} mm",
            drift.shift, drift.shift_chance);
  part.unprinted("cycles_compared", drift.cycles);
  list_beside_chance(list, "shift", fmt::format("first and last {}", drift.cycles), drift.shift,
                     drift.shift_chance);
  const auto add = [&](const char* key, const char* figure, const FirstAndLast& change) {
    ReportList ends;
    ends.unprinted("first_mm", change.first);
    ends.unprinted("last_mm", change.last);
    ends.unprinted("chance_95_mm", change.chance);
    part.part(key, ends);
    list_beside_chance(list, figure,
                       fmt::format("{} → {}", figure_mm(change.first), figure_mm(change.last)),
                       std::abs(change.last - change.first), change.chance);
  };
  add("ap", "change of AP", drift.accuracy);
  if (drift.repeatability) add("rp", "change of RP", *drift.repeatability);
  list.part("drift", part);
}

ReportList workspace_list(const WorkspaceFigures& workspace) {
  const Summary& errors = workspace.errors;
  ReportList list;
  list.line("whole workspace",
            "{mean_mm:.4f} mm mean, {rms_mm:.4f} rms, {p95_mm:.4f} at 95 %, {max_mm:.4f} max at "
            "{targets} targets",
            errors.mean, errors.rms, errors.p95, errors.max, errors.n);
  list.unprinted("share_below_max_95", workspace.below_max);
  list.unprinted("mean_95_mm", workspace.mean);
  list.unprinted("rms_95_mm", workspace.rms);
  list.unprinted("p95_95_mm", workspace.p95);
  list.unprinted("turn_rms_deg", workspace.turn_rms);
  const auto add = [&](const char* error, const std::string& found, const std::string& interval) {
    list.row("workspace", {{"error", error}, {"mm", found}, {"95 % interval", interval}});
  };
  add("mean", figure_mm(errors.mean), interval_mm(workspace.mean));
  add("rms", figure_mm(errors.rms), interval_mm(workspace.rms));
  add("95 % are below", figure_mm(errors.p95), interval_mm(workspace.p95));
  add("largest", figure_mm(errors.max),
      fmt::format("above {:.1f} % of all", 100.0 * workspace.below_max));
  if (workspace.turn_rms)
    add("tool's direction, rms", fmt::format("{:.4f}°", *workspace.turn_rms / kDegree), "–");
  list.show("workspace", fmt::format("Positioning over the workspace, {} targets", errors.n));
  return list;
}

ReportList budget_list(const UncertaintyBudget& budget) {
  const double whole = budget.expected * budget.expected;
  ReportList list;
  list.line("budget",
            "{expected_rms_mm:.4f} mm rms expected, {found_rms_mm:.4f} found; " +
                budget.largest().name() + " weighs most",
            budget.expected, budget.found);
  list.unprinted("words", budget_words(budget));
  list.rows("terms", budget.terms, [whole](ReportList& row, const BudgetTerm& term) {
    const double share = whole > 0.0 ? 200.0 * term.sigma * term.sigma / whole : 0.0;
    row.line("term", "{name}", term.name());
    row.line("mm", "{sigma_mm:.4f}", term.sigma);
    row.line("share", term.counts ? fmt::format("{:.0f} %", share) : "–");
    row.line("from", "{source}", term.source);
    row.unprinted("counts", term.counts);
  });
  list.row("terms", {{"", "root sum of squares × √2"},
                     {"", figure_mm(budget.expected)},
                     {"", ""},
                     {"", fmt::format("expected rms length; found {} ({})", figure_mm(budget.found),
                                      interval_mm(budget.found_95))}});
  list.show("terms",
            "Uncertainty budget over the workspace: per axis, and the share of the "
            "expected mean square");
  return list;
}

constexpr char kSheetStyle[] =
    R"(@page{size:A4;margin:9mm 11mm}
.sheet{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,24rem),1fr));column-gap:2rem}
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
      "figures hold its noise, which makes up to {} mm of RP by itself; what all readings share "
      "makes none",
      figure_mm(certificate.accuracy.judge_sigma),
      figure_mm(kRepeatabilityOfScatter * certificate.accuracy.judge_sigma));
}

void add_opening(HtmlPage& page, const Certificate& certificate) {
  const CertificateRun& run = certificate.run;
  const CellAccuracy& accuracy = certificate.accuracy;
  const std::string first = run.moves.empty() ? "–" : run.moves.front().utc;
  const std::string last = run.moves.empty() ? "–" : run.moves.back().utc;
  page.add_paragraph(fmt::format(
      "Measured {} to {} (UTC) by {}: {} cycles of the poses, {} targets, {} moves of {} s in the "
      "mean. Judged by {}.",
      first, last, kProgram, run.request.size.cycles, run.request.size.targets, accuracy.moves,
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
    verdict.doubt("the run was ended at " + certificate.run.ended_by,
                  "mend the cell (planar-check-cell), then give the same command to continue");
  if (accuracy.reached < accuracy.moves)
    verdict.doubt(
        fmt::format("{} of {} moves did not reach their targets and are in no figure",
                    accuracy.moves - accuracy.reached, accuracy.moves),
        "see the column status of cycles.csv, mend the cell, and certify it into another folder");
  if (accuracy.judged < accuracy.reached)
    verdict.doubt(fmt::format("{} moves were not judged and are in no figure",
                              accuracy.reached - accuracy.judged),
                  "clear the tracker's view and certify the cell into another folder");
  const std::vector<std::string>& accepted = certificate.run.accepted;
  if (!accepted.empty())
    verdict.doubt(fmt::format("objections to the files were accepted, {} in all: {}",
                              accepted.size(), accepted.front()),
                  "make the cell's files anew from one another; certificate.json lists them");
  return verdict;
}

ReportList condition_list(const CellSettings& cell) {
  const ServoSettings& servo = cell.servo;
  ReportList list;
  list.line("approach",
            servo.approach == Approach::kOneSide ? "every motor from one side" : "direct");
  list.line("measurement", "{frames} frames after {settle_s:.2f} s of rest",
            servo.frames_per_measurement, servo.settle_s);
  list.line("tolerance", "{tolerance_mm:.4f} mm", servo.tolerance_m);
  list.line("speeds of the motors", "{speeds_deg:.0f} °/s",
            each(cell.transmission.drives, &MotorDrive::max_speed_rad_s));
  list.line("temperature, °C", "........................");
  list.line("load at the tool, kg", "........................");
  return list;
}

/// Returns the colours and names of the poses.
std::vector<Panel::Key> pose_keys(const CertificateRun& run) {
  std::vector<Panel::Key> keys;
  for (std::size_t i = 0; i < run.places.poses.size(); ++i)
    keys.push_back({kSeriesColors[i], pose_name(i)});
  return keys;
}

Panel workspace_panel(const CertificateRun& run) {
  const auto moves = counted(run.moves, CertificatePart::kWorkspace);
  const auto places = each(moves, [](const JudgedMove* made) { return made->move.p_d; });
  const auto errors = each(moves, [](const JudgedMove* made) { return *made->error; });
  const double half = 0.5 * run.places.square.side;
  std::vector<Eigen::Vector2d> square;
  for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}, {-1, -1}})
    square.emplace_back(run.places.square.centre + half * Eigen::Vector2d(x, y));
  std::vector<Eigen::Vector2d> all = places;
  all.insert(all.end(), square.begin(), square.end());
  Panel panel("Errors over the workspace", axes_over_places(in_mm(all)));
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
  for (const JudgedMove* move : counted(run.moves, CertificatePart::kPose))
    if (move->move.pose == pose) errors.emplace_back(*move->error / kMillimetre);
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

Certificate certificate_of(CertificateRun run) {
  CellAccuracy accuracy = cell_accuracy(run.moves);
  std::optional<UncertaintyBudget> budget;
  const CalibratedCell& cell = *run.request.servo.cell;
  if (accuracy.workspace)
    budget = uncertainty_budget(cell.settings, cell.vision.value(), run.moves, accuracy);
  return {std::move(run), std::move(accuracy), std::move(budget)};
}

std::string figure_mm(double metres) {
  constexpr double kLeastShown_mm = 1e-4;
  if (!std::isfinite(metres)) return "–";
  return mm(metres) < 0.5 * kLeastShown_mm ? "<0.0001" : fixed(mm(metres), 4);
}

std::string interval_mm(const std::optional<Interval>& interval) {
  if (!interval) return "–";
  const std::string from = fixed(mm(interval->first), 4), to = fixed(mm(interval->second), 4);
  if (from == to) return "no scatter seen";
  return from == fixed(0.0, 4) ? "below " + to : from + " to " + to;
}

std::vector<std::pair<std::string, std::string>> worst_pose_figures(const CellAccuracy& accuracy) {
  if (accuracy.poses.empty()) return {};
  const PoseFigures &ap = accuracy.worst_accuracy(), &rp = accuracy.worst_repeatability();
  std::vector<std::pair<std::string, std::string>> figures{
      {"pose accuracy",
       fmt::format("{} mm AP at {}, the worst of {}", figure_mm(ap.position.accuracy), ap.name,
                   accuracy.poses.size())}};
  if (std::isfinite(rp.position.repeatability))
    figures.emplace_back("repeatability",
                         fmt::format("{} mm RP at {}, over {} cycles",
                                     figure_mm(rp.position.repeatability), rp.name, rp.cycles));
  return figures;
}

ReportList certificate_list(const Certificate& certificate) {
  const CellAccuracy& accuracy = certificate.accuracy;
  const std::string judge = name_in(kJudgeKinds, certificate.run.judge);
  ReportList list, found("_" + judge);
  list.line("moves", "{judged} of {moves} moves reached and judged by the {judge}", accuracy.judged,
            accuracy.moves, judge);
  list.unprinted("reached", accuracy.reached);
  list.unprinted("judge_sigma_mm", accuracy.judge_sigma);
  list_run(list, certificate.run);
  list_poses(found, accuracy);
  list_directions(found, accuracy);
  if (accuracy.drift) list_drift(found, *accuracy.drift);
  if (accuracy.workspace) found.part("workspace", workspace_list(*accuracy.workspace));
  if (certificate.budget) found.part("budget", budget_list(*certificate.budget));
  list.append(found);
  return list;
}

std::string certificate_page(const Certificate& certificate) {
  const CertificateRun& run = certificate.run;
  const CellSettings& cell = run.request.servo.cell->settings;
  HtmlPage page("Accuracy of the cell " + cell.file.string());
  page.add_style(kSheetStyle);
  add_opening(page, certificate);
  page.add_verdict(verdict_of(certificate));
  const ReportList list = certificate_list(certificate);
  page.add_html(list.table_html("poses"));
  page.add_paragraph(
      "n: arrivals. AP: distance of their mean from the commanded pose. RP: radius about that "
      "mean, the mean distance from it plus three standard deviations. 95 % interval: the figure "
      "lies in it with 95 % confidence.");
  page.add_html("<div class=\"sheet\"><div>" + list.table_html("variation") + "</div><div>" +
                list.table_html("workspace") + "</div></div>\n");
  page.add_paragraph(
      "vAP: largest distance between the mean errors of approaches along +x, -x, +y and -y. Chance "
      "alone: in 95 of 100 runs scatter alone stays below it; what was found above it is more.");
  page.add_html(plot_html({workspace_panel(run), pose_panel(run)}));
  page.add_paragraph(place_words(run.places));
  if (certificate.budget) {
    page.add_html("<div class=\"words\">" + list.table_html("terms") + "</div>");
    page.add_paragraph(budget_words(*certificate.budget));
  }
  page.add_html("<div class=\"sheet\"><div>" + list.table_html("files") + "</div><div>" +
                condition_list(cell).html("Conditions") + "</div></div>\n");
  page.add_html(
      "<div class=\"sign\"><div>name</div><div>place and date</div><div>signature</div></div>\n");
  return page.text();
}

void write_certificate(const Certificate& certificate) {
  const std::filesystem::path& out = certificate.run.request.servo.folder.path;
  write_file(out / "certificate.json",
             with_format_key("figures", certificate_list(certificate).json().dump(2)));
  write_file(out / "certificate.html", certificate_page(certificate));
}

}  // namespace planar

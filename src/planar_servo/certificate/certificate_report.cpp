#include "planar_servo/certificate/certificate_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/files/provenance.h"

namespace planar {
namespace {

/// Returns a member, or nothing where the whole is absent.
template <typename Whole, typename Part>
std::optional<Part> part_of(const std::optional<Whole>& whole, Part Whole::*part) {
  return whole ? std::optional(*whole.*part) : std::nullopt;
}

void list_run(ReportList& list, const CertificateRun& run) {
  list.unprinted("program", certifying_program());
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
              row.unprinted("role", made.first);
              row.unprinted("file", made.second.string());
              row.unprinted("sha256", content_sha256(made.second));
            });
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
  for (const auto& [name, words] : worst_pose_figures(accuracy)) list.line(name, words);
}

void list_directions(ReportList& list, const CellAccuracy& accuracy) {
  list.rows("directions", accuracy.directions, [](ReportList& row, const DirectionFigures& found) {
    row.unprinted("pose", found.name);
    row.unprinted("directions", found.directions);
    row.unprinted("cycles", found.cycles);
    row.unprinted("vap_mm", found.variation);
    row.unprinted("chance_95_mm", found.chance);
  });
  if (accuracy.directions.empty()) return;
  const DirectionFigures& worst = accuracy.worst_variation();
  list.line(fmt::format("from {} directions", worst.directions),
            fmt::format("{:.4f} mm vAP at {}; scatter alone keeps it below {:.4f} mm",
                        mm(worst.variation), worst.name, mm(worst.chance)));
}

ReportList drift_list(const PoseDrift& drift) {
  ReportList list;
  list.line("drift",
            "{shift_mm:.4f} mm between the first and last thirds; chance alone keeps it below "
            "{shift_chance_95_mm:.4f} mm",
            drift.shift, drift.shift_chance);
  list.unprinted("cycles_compared", drift.cycles);
  const auto add = [&list](const char* key, const FirstAndLast& change) {
    ReportList part;
    part.unprinted("first_mm", change.first);
    part.unprinted("last_mm", change.last);
    part.unprinted("chance_95_mm", change.chance);
    list.part(key, part);
  };
  add("ap", drift.accuracy);
  if (drift.repeatability) add("rp", *drift.repeatability);
  return list;
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
  return list;
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

std::vector<std::pair<std::string, std::filesystem::path>> certified_files(
    const CellSettings& cell) {
  std::vector<std::pair<std::string, std::filesystem::path>> files{{"cell", cell.file}};
  for (const MadeFile& file : made_files(cell, true))
    if (std::filesystem::exists(file.path))
      files.emplace_back(name_in(kRoles, file.role), file.path);
  return files;
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

std::string certifying_program() {
  return "planar-certify " PLANAR_VERSION;
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
  return list;
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
  if (accuracy.drift) found.part("drift", drift_list(*accuracy.drift));
  if (accuracy.workspace) found.part("workspace", workspace_list(*accuracy.workspace));
  if (certificate.budget) found.part("budget", budget_list(*certificate.budget));
  list.append(found);
  return list;
}

void write_certificate(const Certificate& certificate) {
  const std::filesystem::path& out = certificate.run.request.servo.folder.path;
  write_file(out / "certificate.json",
             with_format_key("figures", certificate_list(certificate).json().dump(2)));
  write_file(out / "certificate.html", certificate_page(certificate));
}

}  // namespace planar

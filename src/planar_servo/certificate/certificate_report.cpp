#include "planar_servo/certificate/certificate_report.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "planar_servo/certificate/certificate_page.h"
#include "planar_servo/core/units.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/format/format_line.h"
#include "planar_servo/io/sha256.h"

namespace planar {
namespace {

using Json = nlohmann::json;

double mm(double metres) {
  return metres / kMillimetre;
}

/// Returns a length as a number, or null where it is not known.
Json length_json(double metres) {
  return std::isfinite(metres) ? Json(mm(metres)) : Json();
}

void add_interval(Json& json, const char* key, const std::optional<Interval>& interval) {
  if (interval) json[key] = {mm(interval->first), mm(interval->second)};
}

Json place_json(const Eigen::Vector2d& p) {
  return {mm(p.x()), mm(p.y())};
}

Json pose_json(const PoseFigures& pose) {
  Json json{{"pose", pose.name},
            {"place_mm", place_json(pose.p)},
            {"cycles", pose.cycles},
            {"ap_mm", mm(pose.position.accuracy)},
            {"rp_mm", length_json(pose.position.repeatability)}};
  if (pose.intervals) {
    add_interval(json, "ap_95_mm", pose.intervals->accuracy);
    add_interval(json, "rp_95_mm", pose.intervals->repeatability);
  }
  if (!pose.turn) return json;
  json["ap_turn_deg"] = pose.turn->accuracy / kDegree;
  if (std::isfinite(pose.turn->repeatability))
    json["rp_turn_deg"] = pose.turn->repeatability / kDegree;
  return json;
}

Json change_json(const FirstAndLast& change) {
  return {{"first_mm", mm(change.first)},
          {"last_mm", mm(change.last)},
          {"chance_95_mm", mm(change.chance)}};
}

Json drift_json(const PoseDrift& drift) {
  Json json{{"cycles_compared", drift.cycles},
            {"shift_mm", mm(drift.shift)},
            {"shift_chance_95_mm", mm(drift.shift_chance)},
            {"ap", change_json(drift.accuracy)}};
  if (drift.repeatability) json["rp"] = change_json(*drift.repeatability);
  return json;
}

Json workspace_json(const WorkspaceFigures& workspace) {
  Json json{{"targets", workspace.errors.n},      {"mean_mm", mm(workspace.errors.mean)},
            {"rms_mm", mm(workspace.errors.rms)}, {"p95_mm", mm(workspace.errors.p95)},
            {"max_mm", mm(workspace.errors.max)}, {"share_below_max_95", workspace.below_max}};
  add_interval(json, "mean_95_mm", workspace.mean);
  add_interval(json, "rms_95_mm", workspace.rms);
  add_interval(json, "p95_95_mm", workspace.p95);
  if (workspace.turn_rms) json["turn_rms_deg"] = *workspace.turn_rms / kDegree;
  return json;
}

Json budget_json(const UncertaintyBudget& budget) {
  Json terms = Json::array();
  for (const BudgetTerm& term : budget.terms)
    terms.push_back({{"name", term.name},
                     {"sigma_mm", mm(term.sigma)},
                     {"counts", term.counts},
                     {"source", term.source}});
  return {{"terms", terms},
          {"expected_rms_mm", mm(budget.expected)},
          {"found_rms_mm", mm(budget.found)},
          {"words", budget_words(budget)}};
}

Json files_json(const CertificateRun& run) {
  Json files = Json::array();
  for (const auto& [role, path] : certified_files(run.request.servo.cell))
    files.push_back({{"role", role}, {"file", path.string()}, {"sha256", content_sha256(path)}});
  return files;
}

std::string vap_line(const CellAccuracy& accuracy) {
  if (accuracy.directions.empty()) return "";
  const DirectionFigures& worst = accuracy.worst_variation();
  return fmt::format("{:<20}{:.4f} mm vAP at {}; scatter alone keeps it below {:.4f} mm\n",
                     fmt::format("from {} directions", worst.directions), mm(worst.variation),
                     worst.name, mm(worst.chance));
}

std::string pose_lines(const CellAccuracy& accuracy) {
  if (accuracy.poses.empty()) return "";
  const PoseFigures &ap = accuracy.worst_accuracy(), &rp = accuracy.worst_repeatability();
  std::string text = fmt::format("{:<20}{:.4f} mm AP at {}, the worst of {}\n", "pose accuracy",
                                 mm(ap.position.accuracy), ap.name, accuracy.poses.size());
  if (std::isfinite(rp.position.repeatability))
    text += fmt::format("{:<20}{:.4f} mm RP at {}, over {} cycles\n", "repeatability",
                        mm(rp.position.repeatability), rp.name, rp.cycles);
  return text;
}

std::string drift_line(const CellAccuracy& accuracy) {
  if (!accuracy.drift) return "";
  return fmt::format(
      "{:<20}{:.4f} mm between the first and last thirds; chance alone keeps it below {:.4f} mm\n",
      "drift", mm(accuracy.drift->shift), mm(accuracy.drift->shift_chance));
}

std::string workspace_line(const CellAccuracy& accuracy) {
  if (!accuracy.workspace) return "";
  const Summary& errors = accuracy.workspace->errors;
  return fmt::format("{:<20}{:.4f} mm mean, {:.4f} rms, {:.4f} at 95 %, {:.4f} max at {} targets\n",
                     "whole workspace", mm(errors.mean), mm(errors.rms), mm(errors.p95),
                     mm(errors.max), errors.n);
}

}  // namespace

Certificate certificate_of(CertificateRun run) {
  CellAccuracy accuracy = cell_accuracy(run.moves);
  std::optional<UncertaintyBudget> budget;
  if (accuracy.workspace)
    budget = uncertainty_budget(run.request.servo.cell, run.vision, run.moves, accuracy);
  return {std::move(run), std::move(accuracy), std::move(budget)};
}

std::string certifying_program() {
  return "planar-certify " PLANAR_VERSION;
}

nlohmann::json certificate_json(const Certificate& certificate) {
  const CertificateRun& run = certificate.run;
  const CellAccuracy& accuracy = certificate.accuracy;
  const std::string judge = std::string("_") + name_in(kJudgeKinds, run.judge);
  const TestSquare& square = run.places.square;
  Json json{{"program", certifying_program()},
            {"cell", run.request.servo.cell.file.string()},
            {"judge", name_in(kJudgeKinds, run.judge)},
            {"judge_sigma_mm", mm(accuracy.judge_sigma)},
            {"cycles", run.request.size.cycles},
            {"targets", run.request.size.targets},
            {"moves", accuracy.moves},
            {"reached", accuracy.reached},
            {"judged", accuracy.judged},
            {"ended_by", run.ended_by},
            {"square",
             {{"centre_mm", place_json(square.centre)},
              {"side_mm", mm(square.side)},
              {"raster_mm", mm(run.places.raster)},
              {"usable_share_of_workspace", run.places.usable}}}};
  if (!run.moves.empty()) {
    json["first_utc"] = run.moves.front().utc;
    json["last_utc"] = run.moves.back().utc;
  }
  Json poses = Json::array(), directions = Json::array();
  for (const PoseFigures& pose : accuracy.poses) poses.push_back(pose_json(pose));
  for (const DirectionFigures& d : accuracy.directions)
    directions.push_back({{"pose", d.name},
                          {"directions", d.directions},
                          {"cycles", d.cycles},
                          {"vap_mm", mm(d.variation)},
                          {"chance_95_mm", mm(d.chance)}});
  json["poses" + judge] = poses;
  json["directions" + judge] = directions;
  if (accuracy.drift) json["drift" + judge] = drift_json(*accuracy.drift);
  if (accuracy.workspace) json["workspace" + judge] = workspace_json(*accuracy.workspace);
  if (certificate.budget) json["budget" + judge] = budget_json(*certificate.budget);
  json["files"] = files_json(run);
  json["accepted_stale"] = run.accepted;
  return json;
}

std::string certificate_text(const Certificate& certificate) {
  const CellAccuracy& accuracy = certificate.accuracy;
  std::string text =
      fmt::format("{:<20}{} of {} moves reached and judged by the {}\n", "moves", accuracy.judged,
                  accuracy.moves, name_in(kJudgeKinds, certificate.run.judge));
  text +=
      pose_lines(accuracy) + vap_line(accuracy) + drift_line(accuracy) + workspace_line(accuracy);
  if (certificate.budget)
    text += fmt::format("{:<20}{:.4f} mm rms expected, {:.4f} found; {} weighs most\n", "budget",
                        mm(certificate.budget->expected), mm(certificate.budget->found),
                        certificate.budget->largest().name);
  return text;
}

void write_certificate(const Certificate& certificate) {
  const std::filesystem::path& out = certificate.run.request.servo.out;
  write_file(out / "certificate.json",
             with_format_key("figures", certificate_json(certificate).dump(2)));
  write_file(out / "certificate.html", certificate_page(certificate));
}

}  // namespace planar

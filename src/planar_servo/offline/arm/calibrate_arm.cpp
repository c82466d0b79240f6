#include "planar_servo/offline/arm/calibrate_arm.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "planar_servo/arm/transmission.h"
#include "planar_servo/core/error.h"
#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"
#include "planar_servo/field/arm/arm_terms.h"
#include "planar_servo/files/tables/arm_sample_table.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/files/tool_file.h"

namespace planar {
namespace {

bool is_table_of_pairs(const std::filesystem::path& path) {
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);)
    if (!line.empty() && line[0] != '#') return line.find("x_vision_mm") != std::string::npos;
  return false;
}

ArmReading reading_of(const Transmission& transmission, const PairRow& pair) {
  if (!pair.theta || !pair.p_reflector || !pair.sigma_tracker)
    throw InputError(
        fmt::format("pair '{}' lacks its joints, its reflector or the tracker's standard "
                    "deviation; make the pairs with planar-pair-tracker",
                    pair.id));
  return {pair.id, pair.place, transmission.motors_from_joints(*pair.theta), *pair.p_reflector,
          *pair.sigma_tracker};
}

}  // namespace

std::vector<ArmReading> read_arm_readings(const CellSettings& cell,
                                          const std::filesystem::path& path) {
  const Transmission transmission(cell.transmission);
  std::vector<ArmReading> readings;
  if (is_table_of_pairs(path)) {
    for (const PairRow& pair : read_pairs(path))
      if (pair.is_attended()) readings.push_back(reading_of(transmission, pair));
  } else {
    for (const ArmSampleRow& row : read_arm_samples(path))
      readings.push_back(
          {row.id, "", transmission.motors_from_joints(row.theta), row.p_B, row.sigma});
  }
  return readings;
}

ArmNominal arm_of_files(const CellSettings& cell) {
  ArmNominal nominal;
  nominal.geometry = cell.arm.geometry;
  nominal.joints_per_motor = Transmission(cell.transmission).coupling_matrix().inverse();
  nominal.separation = cell.lamps.layout.separation_m;
  nominal.tool.reflector_known = false;
  if (std::filesystem::exists(cell.tool)) nominal.tool = read_tool(cell.tool);
  if (!nominal.tool.reflector_known) nominal.reflector_sigma = kSomewhereOnTool;
  return nominal;
}

std::string arm_terms_text(const JointEstimate& estimate) {
  std::string text = "what the poses say of the arm\n";
  for (const ArmTerm& term : arm_terms(estimate))
    text += fmt::format("{:<24} {:>11} +- {:<9} {}{}\n", term.label,
                        fixed(term.value / term.unit, 5), fixed(term.sigma / term.unit, 5),
                        term.unit_text, term.determined ? "" : "  not determined");
  return text;
}

nlohmann::json arm_terms_json(const JointEstimate& estimate) {
  nlohmann::json terms = nlohmann::json::object();
  for (const ArmTerm& term : arm_terms(estimate))
    terms[term.key] = {{"value", term.value / term.unit},
                       {"sigma", term.sigma / term.unit},
                       {"determined", term.determined}};
  return terms;
}

std::string arm_report_text(const ArmFit& fit) {
  std::string text;
  if (!fit.left_out.empty())
    text += fmt::format("left out            {}: they contradict the others\n",
                        fmt::join(fit.left_out, ", "));
  return text +
         fmt::format("readings met        {:.4f} mm rms, {} harmonics of each reducer\n",
                     fit.rms / kMillimetre, fit.estimate.size.harmonics) +
         fmt::format("places left out     {:.4f} mm rms\n\n", fit.held_out_rms / kMillimetre) +
         arm_terms_text(fit.estimate);
}

nlohmann::json arm_report_json(const ArmFit& fit) {
  nlohmann::json report = arm_terms_json(fit.estimate);
  report["held_out_rms_mm"] = fit.held_out_rms / kMillimetre;
  report["rms_mm"] = fit.rms / kMillimetre;
  report["harmonics"] = fit.estimate.size.harmonics;
  report["left_out"] = fit.left_out;
  return report;
}

}  // namespace planar

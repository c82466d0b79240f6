#include "planar_servo/offline/arm/calibrate_arm.h"

#include <fmt/format.h>

#include <fstream>

#include "planar_servo/arm/transmission.h"
#include "planar_servo/core/error.h"
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

ReportList arm_terms_list(const JointEstimate& estimate) {
  ReportList list;
  for (const ArmTerm& term : arm_terms(estimate)) {
    ReportList part;
    part.line(term.label,
              fmt::format("{{value:>16.5f}} +- {{sigma:<9.5f}} {}{}", term.unit_text,
                          term.determined ? "" : "  not determined"),
              term.value / term.unit, term.sigma / term.unit);
    part.unprinted("determined", term.determined);
    list.part(term.key, part);
  }
  return list;
}

ReportList arm_list(const ArmFit& fit) {
  ReportList list;
  list.unprinted("left_out", fit.left_out);
  if (!fit.left_out.empty())
    list.line("left out", "{left_out}: they contradict the others", fit.left_out);
  list.line("readings met", "{rms_mm:.4f} mm rms, {harmonics} harmonics of each reducer", fit.rms,
            fit.estimate.size.harmonics);
  list.line("places left out", "{held_out_rms_mm:.4f} mm rms", fit.held_out_rms);
  list.line("", "\nwhat the poses say of the arm");
  list.append(arm_terms_list(fit.estimate));
  return list;
}

}  // namespace planar

#include "planar_servo/offline/calibrate_arm.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/files/tables/table_columns.h"
#include "planar_servo/geometry/arm/transmission.h"
#include "planar_servo/offline/page_of_file.h"
#include "planar_servo/report/places.h"
#include "planar_servo/report/plot.h"

namespace planar {
namespace {

ArmReading reading_of(const Transmission& transmission, const PairRow& pair) {
  if (!pair.theta || !pair.p_reflector || !pair.sigma_tracker)
    throw InputError(
        {fmt::format(
             "pair '{}' lacks its joints, its reflector or the tracker's standard deviation",
             pair.id),
         "make the pairs with planar-pair-tracker", "", Cause::kMissing});
  return {pair.id, pair.place, transmission.motors_from_joints(*pair.theta), *pair.p_reflector,
          *pair.sigma_tracker};
}

/// Places left out may be met this many times worse than the readings fitted.
constexpr double kWorseAtPlacesLeftOut = 1.5;
/// Links, and zeros of the motors that carry them, come first among the terms.
constexpr std::size_t kLinksAndZeros = 4;

std::vector<Eigen::Vector2d> misses_mm(const ArmFit& fit) {
  return in_mm(each(fit.held_out, &ArmMiss::miss));
}

/// Misses over the angle of a motor; what is periodic there is a reducer's eccentricity that the
/// model lacks.
Panel motor_panel(const ArmFit& fit, int motor, const Axis& miss_axis) {
  const std::vector<double> angles =
      each(fit.held_out, [&](const ArmMiss& miss) { return miss.motors[motor] / kDegree; });
  return component_panel(fmt::format("Over the angle of motor {}", motor + 1),
                         axis_over(fmt::format("motor {}, deg", motor + 1), angles), miss_axis,
                         angles, misses_mm(fit));
}

std::string place_plot(const ArmFit& fit) {
  std::vector<Panel> panels =
      quiver_panels({{fmt::format("Places left out: {:.4f} mm rms", mm(fit.held_out_rms)),
                      each(fit.held_out, &ArmMiss::p_B), each(fit.held_out, &ArmMiss::miss)}});
  panels.push_back(histogram("Their components", "read minus predicted, mm",
                             components_of(misses_mm(fit)),
                             {mm(fit.stated_sigma), "the tracker's deviation"}));
  return plot_html(panels);
}

void doubt_open_terms(const ArmFit& fit, Verdict& verdict) {
  const std::vector<ArmTerm> terms = arm_terms(fit.estimate);
  std::vector<std::string> open;
  for (std::size_t i = 0; i < kLinksAndZeros; ++i)
    if (!terms[i].determined) open.push_back(terms[i].label);
  if (!open.empty())
    verdict.doubt(
        fmt::format("the readings do not determine {}", fmt::join(open, ", ")),
        "read places all over the workspace, with the joints in many different positions");
}

}  // namespace

std::vector<ArmReading> read_arm_readings(const CellSettings& cell,
                                          const std::filesystem::path& path) {
  const Transmission transmission(cell.transmission);
  std::vector<ArmReading> readings;
  if (is_table_with("x_vision_mm", path, "pairs")) {
    for (const PairRow& pair : read_pairs(path))
      if (pair.is_attended()) readings.push_back(reading_of(transmission, pair));
  } else {
    for (const ArmSampleRow& row : read_arm_samples(path))
      readings.push_back(
          {row.id, "", transmission.motors_from_joints(row.theta), row.p_B, row.sigma});
  }
  return readings;
}

ArmNominal arm_of_cell(const CellSettings& cell) {
  ArmNominal nominal;
  nominal.geometry = cell.arm.geometry;
  nominal.joints_per_motor = Transmission(cell.transmission).coupling_matrix().inverse();
  for (int i = 0; i < 3; ++i)
    nominal.gear_ratios[i] = cell.transmission.drives[static_cast<std::size_t>(i)].gear_ratio;
  nominal.separation = cell.lamps.layout.separation_m;
  return nominal;
}

ArmNominal arm_of_files(const CellSettings& cell) {
  ArmNominal nominal = arm_of_cell(cell);
  nominal.tool.reflector_known = false;
  if (std::filesystem::exists(cell.tool)) nominal.tool = read_tool(cell.tool);
  if (!nominal.tool.reflector_known) nominal.reflector_sigma = kSomewhereOnTool;
  return nominal;
}

ReportList arm_terms_list(const JointEstimate& estimate) {
  ReportList list;
  for (const ArmTerm& term : arm_terms(estimate)) {
    ReportList& row = list.row("terms");
    row.line("term", term.label);
    row.line("value", std::string("{value:.5f} +- {sigma:.5f} ") + term.unit_text,
             term.value / term.unit, term.sigma / term.unit);
    row.line("by the readings", term.determined ? "" : "not determined");
    row.unprinted("determined", term.determined);
    list.unprinted(term.key, row.json());
  }
  list.show("terms", "The arm, as found from the poses", ReportList::Shown::kAlsoInPrint);
  return list;
}

ReportList arm_list(const ArmFit& fit) {
  ReportList list;
  list.line_if(!fit.left_out.empty(), "left out", "{left_out}: they contradict the others",
               fit.left_out);
  list.line("readings met", "{rms_mm:.4f} mm rms, {harmonics} harmonics of each reducer", fit.rms,
            fit.estimate.size.harmonics);
  list.line("places left out", "{held_out_rms_mm:.4f} mm rms", fit.held_out_rms);
  list.append(arm_terms_list(fit.estimate));
  return list;
}

Verdict arm_verdict(const ArmFit& fit) {
  Verdict verdict;
  doubt_open_terms(fit, verdict);
  if (fit.held_out_rms > kWorseAtPlacesLeftOut * fit.rms)
    verdict.doubt(fmt::format("places left out are met to {:.4f} mm rms, those fitted to {:.4f} mm",
                              mm(fit.held_out_rms), mm(fit.rms)),
                  "read more places, spread all over the workspace");
  doubt_left_out(fit.left_out.size(), fit.held_out.size() + fit.left_out.size(),
                 "readings contradict the others and were", verdict);
  verdict.good = fmt::format(
      "{} readings are met to {:.4f} mm rms and places left out to {:.4f} mm, where the tracker's "
      "deviation is {:.4f} mm per axis; links and the zeros of motors 1 and 2 are determined",
      fit.held_out.size(), mm(fit.rms), mm(fit.held_out_rms), mm(fit.stated_sigma));
  return verdict;
}

std::string arm_page(const ArmFit& fit, const std::filesystem::path& file) {
  HtmlPage page = page_about("Arm", file, arm_verdict(fit));
  page.add_section(
      "Readings at places left out", place_plot(fit),
      "From each reading of the reflector, how far it lies from where the others predict it. Lines "
      "in all directions are noise; neighbours that point the same way show what the model of the "
      "arm lacks.");
  const Axis axis = axis_over("read minus predicted, mm", components_of(misses_mm(fit)));
  page.add_section(
      "Over the motors' angles",
      plot_html({motor_panel(fit, 0, axis), motor_panel(fit, 1, axis), motor_panel(fit, 2, axis)}),
      "A wave over the angle of a motor is an eccentricity of its reducer that the model lacks.");
  return ended_page(std::move(page), arm_list(fit), file);
}

}  // namespace planar

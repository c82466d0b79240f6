#include "planar_servo/offline/map/export_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/files/provenance.h"

namespace planar {
namespace {

/// Returns the cell's vision, by which a field at the lamps is one at the end point.
std::optional<VisionCalibration> read_view(const MapRecord& record, const ExportRequest& request) {
  if (!std::holds_alternative<LampField>(record.map)) return std::nullopt;
  if (!request.cell)
    throw InputError({"is a field at the lamps", "name the cell that has them with --cell",
                      request.map, Cause::kMissing});
  require_belonging(contradictions(
      {{Role::kErrorMap, request.map}},
      origins_in(*request.cell, calibration_files(*request.cell, false)), values_of(kRoles)));
  VisionCalibration vision = read_vision(*request.cell, false);
  vision.error_map = record.map;
  return vision;
}

ErrorField field_of(const ErrorMap& map, const std::optional<VisionCalibration>& /*vision*/,
                    double phi) {
  return {[&map, phi](const Eigen::Vector2d& p) { return predict(map, p, phi); },
          [&map, phi](const Eigen::Vector2d& p) { return predict_error(map, p, phi); },
          valid_region(map)};
}

/// The region of a field at the lamps is that of their middle, beside the end point.
ErrorField field_of(const LampField& field, const std::optional<VisionCalibration>& vision,
                    double phi) {
  ValidRegion region = field.region;
  for (Eigen::Vector2d& corner : region.hull) corner += rotation2d(phi) * vision->tool.p_TP;
  return {[&vision, phi](const Eigen::Vector2d& p) {
            return predict_error_at(*vision, {p, phi});
          },
          [&vision, &field, phi](const Eigen::Vector2d& p) {
            return Eigen::Vector2d(p - compensated_tip(field, lamps_at(*vision, {p, phi})).p);
          },
          std::move(region)};
}

ErrorField field_of(const MapRecord& record, const std::optional<VisionCalibration>& vision,
                    double phi) {
  ErrorField field =
      std::visit([&](const auto& map) { return field_of(map, vision, phi); }, record.map);
  field.sigma_if_unstated = record.loo_rms;
  return field;
}

std::string method_of(const VisionErrorMap& map) {
  const auto* at_end_point = std::get_if<ErrorMap>(&map);
  return at_end_point != nullptr ? name(kind_of(*at_end_point)) : kLampFieldMethod;
}

/// How much the tool's direction matters.
struct DirectionEffect {
  double change{0.0};  ///< largest change of the error, metres
  double sigma{0.0};   ///< median deviation where it was looked for, metres
};

DirectionEffect effect_of_direction(const MapRecord& record,
                                    const std::optional<VisionCalibration>& vision) {
  constexpr int kDirections = 12;
  const ErrorField first = field_of(record, vision, 0.0);
  std::vector<Eigen::Vector2d> places = first.region.hull;
  Eigen::Vector2d middle(0.0, 0.0);
  for (const Eigen::Vector2d& corner : first.region.hull)
    middle += corner / static_cast<double>(first.region.hull.size());
  places.push_back(middle);
  DirectionEffect effect;
  std::vector<double> sigmas;
  for (const Eigen::Vector2d& p : places) {
    const double stated = first.predict(p).sigma;
    sigmas.push_back(std::isfinite(stated) ? stated : first.sigma_if_unstated);
  }
  effect.sigma = median(sigmas);
  for (int k = 1; k < kDirections; ++k) {
    const ErrorField turned = field_of(record, vision, 2.0 * kPi * k / kDirections);
    for (const Eigen::Vector2d& p : places)
      effect.change = std::max(effect.change, (turned.error(p) - first.error(p)).norm());
  }
  return effect;
}

void require_direction(const DirectionEffect& effect, const ExportRequest& request) {
  if (request.phi || !(effect.change > effect.sigma)) return;
  throw InputError({fmt::format("its error changes with the tool's direction by up to {:.4f} mm, "
                                "more than its deviation of {:.4f} mm",
                                mm(effect.change), mm(effect.sigma)),
                    "name the direction for which it is exported with --phi-deg", request.map,
                    Cause::kMissing});
}

std::vector<std::string> remarks_of(const ExportedMap& exported, const ExportRequest& request) {
  const SampledError& sampled = exported.sampled;
  std::vector<std::string> remarks{
      fmt::format("# error = seen - true, mm, base frame; nodes are {}",
                  use_of(exported.format).meaning),
      fmt::format("# interpolation costs up to {:.5f} mm per axis, {:.3f} of the deviation there",
                  mm(sampled.interpolation_max), sampled.interpolation_share)};
  if (exported.change_with_phi > 0.0)
    remarks.push_back(fmt::format("# for a tool at phi = {:g} deg", exported.phi / kDegree));
  for (const std::string& line :
       csv_remarks(with_origins_of({origin_of({Role::kErrorMap, request.map})}, request.map)))
    remarks.push_back(line);
  return remarks;
}

}  // namespace

ExportedMap export_map(const ExportRequest& request) {
  const MapRecord record = read_map(request.map);
  accept_objection(objection(record.quality),
                   "record more places and fit again or, if you know better, continue with "
                   "--accept-map",
                   request.map, request.accept_map);
  const std::optional<VisionCalibration> vision = read_view(record, request);
  const DirectionEffect effect = effect_of_direction(record, vision);
  require_direction(effect, request);
  ExportedMap exported;
  exported.format = request.format;
  exported.method = method_of(record.map);
  exported.phi = request.phi.value_or(0.0);
  exported.change_with_phi = effect.change;
  ErrorField field = field_of(record, vision, exported.phi);
  if (use_of(request.format).over_true_places) field = over_true_places(field);
  try {
    exported.sampled = sample_error(field, request.step);
  } catch (const InputError& e) {
    throw InputError(e.refusal().at(request.map));
  }
  exported.text = grid_text(request.format, exported.sampled.grid, remarks_of(exported, request));
  return exported;
}

ReportList exported_map_list(const ExportedMap& exported) {
  const GridUse use = use_of(exported.format);
  const SampledError& sampled = exported.sampled;
  const ErrorGrid& grid = sampled.grid;
  const bool states_sigma = grid.sigmas.allFinite();
  ReportList list;
  list.line("map", "{method}", exported.method);
  list.line("format", name_in(kGridFormats, exported.format));
  list.line("grid", "{columns} x {rows} nodes, {step_mm:g} mm apart, {n_valid} valid", grid.columns,
            grid.rows, grid.step, grid.inside.count());
  list.line("nodes", use.meaning);
  list.line(
      "deviation",
      std::string("{sigma_min_mm:.4f} mm at least, {sigma_median_mm:.4f} mm median per axis") +
          (states_sigma ? "" : ": left-out places, as the map states none"),
      sampled.sigma_min, sampled.sigma_median);
  list.line("interpolation",
            "{interpolation_max_mm:.5f} mm at most, {interpolation_share:.1%} of the deviation "
            "there at most",
            sampled.interpolation_max, sampled.interpolation_share);
  list.line_if(exported.change_with_phi > 0.0, "direction",
               "tool at {phi_deg:.1f} deg; the error changes with it by up to "
               "{change_with_phi_mm:.4f} mm",
               exported.phi, exported.change_with_phi);
  list.line("read by", use.read_by);
  return list;
}

}  // namespace planar

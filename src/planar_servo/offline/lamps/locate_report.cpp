#include "planar_servo/offline/lamps/locate_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "planar_servo/core/numerics/statistics.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

std::optional<double> median_of(const std::vector<double>& values) {
  return values.empty() ? std::nullopt : std::optional<double>(median(values));
}

}  // namespace

LocateFigures figures_of(const LocateReport& report) {
  LocateFigures figures;
  std::vector<double> sigmas_phi;
  for (const LampRow& row : report.rows) {
    if (row.status == LampStatus::kOk)
      ++figures.ok;
    else
      ++figures.other_statuses[name(row.status)];
    if (row.sigma_phi) sigmas_phi.push_back(*row.sigma_phi);
  }
  figures.images = report.rows.size();
  figures.milliseconds_median = median_of(report.milliseconds);
  figures.sigma_phi_median = median_of(sigmas_phi);
  return figures;
}

std::string distance_doubt(const LocateReport& report, double separation) {
  const auto ratio = median_of(report.wrong_distances);
  if (!ratio) return "";
  return fmt::format(
      "in {} images the pair is {:.1f} mm apart, the cell says {:.4g} mm; measure the lamps and "
      "correct lamps.separation_mm in the cell file, or the link lengths if they are wrong",
      report.wrong_distances.size(), *ratio * separation / kMillimetre, separation / kMillimetre);
}

std::string locate_text(const LocateFigures& figures) {
  std::string text = fmt::format("{} images: {} ok", figures.images, figures.ok);
  for (const auto& [status, count] : figures.other_statuses)
    text += fmt::format(", {} {}", count, status);
  if (figures.milliseconds_median)
    text += fmt::format("; {:.2f} ms per image", *figures.milliseconds_median);
  if (figures.sigma_phi_median)
    text += fmt::format("; direction to {:.4f} deg", *figures.sigma_phi_median / kDegree);
  return text + "\n";
}

nlohmann::json locate_json(const LocateFigures& figures) {
  nlohmann::json json{{"images", figures.images},
                      {"ok", figures.ok},
                      {"not_ok", figures.images - figures.ok},
                      {"statuses", figures.other_statuses},
                      {"ms_per_image_median", nullptr},
                      {"sigma_phi_deg_median", nullptr}};
  if (figures.milliseconds_median) json["ms_per_image_median"] = *figures.milliseconds_median;
  if (figures.sigma_phi_median) json["sigma_phi_deg_median"] = *figures.sigma_phi_median / kDegree;
  return json;
}

}  // namespace planar

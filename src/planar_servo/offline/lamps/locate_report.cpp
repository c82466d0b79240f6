#include "planar_servo/offline/lamps/locate_report.h"

#include <fmt/format.h>

#include <limits>
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

ReportList locate_list(const LocateFigures& figures) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  std::string others;
  for (const auto& [status, count] : figures.other_statuses)
    others += fmt::format(", {} {}", count, status);
  ReportList list;
  list.line("images", "{images}: {ok} ok" + others, figures.images, figures.ok);
  list.unprinted("not_ok", figures.images - figures.ok);
  list.unprinted("statuses", figures.other_statuses);
  list.line("time", "{ms_per_image_median:.2f} ms per image",
            figures.milliseconds_median.value_or(kUnknown));
  list.line("direction", "known to {sigma_phi_deg_median:.4f} deg",
            figures.sigma_phi_median.value_or(kUnknown));
  return list;
}

}  // namespace planar

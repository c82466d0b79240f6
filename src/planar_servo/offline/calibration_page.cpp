#include "planar_servo/offline/calibration_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "planar_servo/core/statistics.h"
#include "planar_servo/core/units.h"
#include "planar_servo/offline/page_of_file.h"
#include "planar_servo/report/places.h"
#include "planar_servo/report/plot.h"

namespace planar {

namespace {

constexpr int kCellsAlongLongerSide = 20;
constexpr double kCorner = 0.2;

/// Sums of the residuals in each cell.
struct CellSums {
  Eigen::MatrixXd u, v, squares;
};

/// Returns the mean square, over the points, of what the residuals of a cell have in common. Of the
/// square of a mean of n, the n-th part of the variance is chance.
double common_square(const ImageCoverage& coverage, const CellSums& sums) {
  double common = 0.0, points = 0.0;
  for (Eigen::Index i = 0; i < coverage.points.size(); ++i) {
    const double n = coverage.points(i);
    if (n < 2.0) continue;
    const double of_mean = (sums.u(i) * sums.u(i) + sums.v(i) * sums.v(i)) / (n * n);
    const double variance = (sums.squares(i) - n * of_mean) / (n - 1.0);
    common += n * (of_mean - variance / n);
    points += n;
  }
  return points > 0.0 ? std::max(0.0, common / points) : 0.0;
}

}  // namespace

ImageCoverage coverage_of(const CameraCalibration& found) {
  ImageCoverage coverage;
  coverage.cell_px =
      static_cast<double>(std::max(found.width_px, found.height_px)) / kCellsAlongLongerSide;
  const auto cells = [&](int pixels) {
    return static_cast<Eigen::Index>(std::ceil(pixels / coverage.cell_px - 1e-9));
  };
  const Eigen::Index rows = cells(found.height_px), columns = cells(found.width_px);
  coverage.points = Eigen::MatrixXi::Zero(rows, columns);
  CellSums sums;
  sums.u = sums.v = sums.squares = Eigen::MatrixXd::Zero(rows, columns);
  for (const CalibratedView& view : found.views)
    for (std::size_t i = 0; i < view.pixels.size(); ++i) {
      const Eigen::Vector2d at = (view.pixels[i].array() + 0.5).matrix() / coverage.cell_px;
      const auto row = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(at.y()), 0, rows - 1);
      const auto column =
          std::clamp<Eigen::Index>(static_cast<Eigen::Index>(at.x()), 0, columns - 1);
      const Eigen::Vector2d& residual = view.residuals_px[i];
      ++coverage.points(row, column);
      sums.u(row, column) += residual.x();
      sums.v(row, column) += residual.y();
      sums.squares(row, column) += residual.squaredNorm();
    }
  coverage.common_px = std::sqrt(common_square(coverage, sums));
  return coverage;
}

double ImageCoverage::points_at(const Eigen::Vector2d& uv_px) const {
  const Eigen::Vector2d at = (uv_px.array() + 0.5).matrix() / cell_px;
  const auto row = static_cast<Eigen::Index>(at.y()), column = static_cast<Eigen::Index>(at.x());
  const bool seen = at.minCoeff() >= 0.0 && row < points.rows() && column < points.cols() &&
                    points(row, column) > 0;
  return seen ? points(row, column) : std::numeric_limits<double>::quiet_NaN();
}

double ImageCoverage::share() const {
  return static_cast<double>((points.array() > 0).count()) / static_cast<double>(points.size());
}

std::vector<std::string> ImageCoverage::empty_corners() const {
  const auto fifth = [](Eigen::Index cells) {
    return static_cast<Eigen::Index>(std::ceil(kCorner * static_cast<double>(cells)));
  };
  const Eigen::Index high = fifth(points.rows()), wide = fifth(points.cols());
  std::vector<std::string> empty;
  if (points.topLeftCorner(high, wide).sum() == 0) empty.emplace_back("upper left");
  if (points.topRightCorner(high, wide).sum() == 0) empty.emplace_back("upper right");
  if (points.bottomLeftCorner(high, wide).sum() == 0) empty.emplace_back("lower left");
  if (points.bottomRightCorner(high, wide).sum() == 0) empty.emplace_back("lower right");
  return empty;
}

namespace {

/// Views left out may be met so many times worse than those fitted.
constexpr double kWorseLeftOut = 1.5;
/// A view may have so many times the median residual.
constexpr double kUnusualView = 2.0;
constexpr double kMostRejected = 0.2;

std::vector<double> view_residuals(const CameraCalibration& found) {
  std::vector<double> rms;
  for (const CalibratedView& view : found.views) rms.push_back(view.rms_px);
  return rms;
}

void judge_views(const CameraCalibration& found, Verdict& verdict) {
  const double usual = median(view_residuals(found));
  for (const CalibratedView& view : found.views)
    if (view.rms_px > kUnusualView * usual)
      verdict.faults.push_back(
          {fmt::format("{} is met to {:.3f} px only, the others to {:.3f} px", view.name,
                       view.rms_px, usual),
           "look at " + view.name + ": if it is blurred or the board bent, leave it out"});
  const std::size_t pictures = found.views.size() + found.rejected.size();
  if (static_cast<double>(found.rejected.size()) > kMostRejected * static_cast<double>(pictures))
    verdict.faults.push_back(
        {fmt::format("{} of {} pictures were not used", found.rejected.size(), pictures),
         "take new pictures in place of those under 'Not used', which says why"});
}

void judge_left_out(const CameraCalibration& found, Verdict& verdict) {
  if (!found.held_out_rms_px)
    verdict.faults.push_back({fmt::format("{} views are too few to judge the camera by views left "
                                          "out of the fit",
                                          found.views.size()),
                              "take 10 or more views, tilted in different directions"});
  else if (*found.held_out_rms_px > kWorseLeftOut * found.rms_px)
    verdict.faults.push_back(
        {fmt::format("views left out of the fit are met to {:.3f} px, those fitted to {:.3f} px",
                     *found.held_out_rms_px, found.rms_px),
         "take more views, tilted in different directions, or a simpler --model"});
}

/// Lists what was found with what only the page shows.
ReportList page_list(const CameraCalibration& found, const ImageCoverage& coverage) {
  ReportList list = calibration_list(found);
  const auto& sigma = found.standard_deviations;
  list.line("its deviations", "{distortion_sigmas:.2g| }",
            std::vector<double>(sigma.begin() + 4, sigma.end()));
  list.line("common to neighbours", "{common_px:.3f} px rms of the residuals", coverage.common_px);
  list.line("that plane", "{plane_distance_mm:.1f} mm away", found.plane_error.distance);
  list.line("points", "in {seen_share:.0%} of the picture", coverage.share());
  return list;
}

/// A panel of the whole picture, as it is seen: u to the right, v down.
Panel picture_panel(const std::string& title, const CameraCalibration& found) {
  return {title,
          {"u, px", 0.0, static_cast<double>(found.width_px)},
          {"v, px", static_cast<double>(found.height_px), 0.0},
          Panel::Aspect::kEqual};
}

Panel residual_panel(const CameraCalibration& found) {
  std::vector<Eigen::Vector2d> pixels, residuals;
  for (const CalibratedView& view : found.views) {
    pixels.insert(pixels.end(), view.pixels.begin(), view.pixels.end());
    residuals.insert(residuals.end(), view.residuals_px.begin(), view.residuals_px.end());
  }
  Panel panel = picture_panel("Residuals", found);
  panel.add_arrows(pixels, residuals, arrows_over(residuals, "px"));
  return panel;
}

Panel coverage_panel(const CameraCalibration& found, const ImageCoverage& coverage) {
  Panel panel = picture_panel("Points seen", found);
  std::vector<double> counts;
  for (const Eigen::Vector2d& uv : panel.field_places()) counts.push_back(coverage.points_at(uv));
  const ColorScale colors("points in a cell", counts);
  panel.add_field(counts, colors);
  panel.add_color_bar(colors);
  return panel;
}

Panel plane_panel(const CameraCalibration& found) {
  Panel panel = picture_panel("Uncertainty over the plane", found);
  std::vector<double> sigmas;
  for (const Eigen::Vector2d& uv : panel.field_places())
    sigmas.push_back(found.plane_error.at(uv) / kMillimetre);
  const ColorScale colors("uncertainty, mm", sigmas);
  panel.add_field(sigmas, colors);
  panel.add_color_bar(colors);
  return panel;
}

Panel view_panel(const CameraCalibration& found) {
  std::vector<Eigen::Vector2d> dots;
  double most = found.held_out_rms_px.value_or(0.0);
  for (const CalibratedView& view : found.views) {
    dots.emplace_back(static_cast<double>(dots.size() + 1), view.rms_px);
    most = std::max(most, view.rms_px);
  }
  const double last = static_cast<double>(dots.size()) + 0.5;
  Panel panel("Residuals of each view", {"view, in the order of the table", 0.5, last},
              {"rms, px", 0.0, 1.1 * most});
  panel.add_dots(dots, {}, 4.0);
  if (found.held_out_rms_px) {
    panel.add_line({{0.5, *found.held_out_rms_px}, {last, *found.held_out_rms_px}},
                   Panel::Stroke::kDashed);
    panel.add_note("dashed: views left out of the fit");
  }
  return panel;
}

Panel residual_histogram(const CameraCalibration& found) {
  std::vector<double> components;
  for (const CalibratedView& view : found.views)
    for (const double component : components_of(view.residuals_px)) components.push_back(component);
  return histogram("Residuals of all coordinates", "residual, px", components,
                   {found.rms_px / std::sqrt(2.0), "their rms"});
}

void add_tables(HtmlPage& page, const ReportList& list, const CameraCalibration& found) {
  page.add_html(list.table("What was found").html());
  page.add_html(list.table("Views", "views").html());
  if (!found.rejected.empty()) page.add_html(list.table("Not used", "rejected").html());
}

}  // namespace

ReportList calibration_list(const CameraCalibration& found) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const Intrinsics k = intrinsics(found.camera);
  const auto& sigma = found.standard_deviations;
  ReportList list;
  list.line("images used", "{images_used} ({images_rejected} rejected)", found.views.size(),
            found.rejected.size());
  const auto list_rejected = [](ReportList& row, const RejectedView& rejected) {
    row.line("picture", "{image}", rejected.name);
    row.line("why", "{reason}", rejected.reason);
  };
  list.rows("rejected", found.rejected, list_rejected, "  ");
  list.line("model", "{model}", found.model);
  list.line("focal lengths",
            fmt::format("{:.2f} +- {:.2f}, {:.2f} +- {:.2f} px", k.fx, sigma[0], k.fy, sigma[1]));
  list.line("principal point",
            fmt::format("{:.2f} +- {:.2f}, {:.2f} +- {:.2f} px", k.cx, sigma[2], k.cy, sigma[3]));
  list.unprinted("camera_matrix",
                 std::array<double, 9>{k.fx, 0.0, k.cx, 0.0, k.fy, k.cy, 0.0, 0.0, 1.0});
  list.line("distortion", "{distortion_coefficients:.4g| }", distortion_coefficients(found.camera));
  list.unprinted("standard_deviations", sigma);
  list.line("residuals",
            "{rms_px:.3f} px rms, {held_out_rms_px:.3f} px in views left out of the fit",
            found.rms_px, found.held_out_rms_px.value_or(kUnknown));
  list.line_if(!found.held_out_rms_px, "residuals",
               "{rms_px:.3f} px rms; too few views to judge it on views left out of the fit",
               found.rms_px);
  list.line("expected error", "{expected_error_mm:.3f} mm in a plane at the grid's distance",
            found.expected_error.value_or(kUnknown));
  list.line(
      "over that plane",
      "{plane_error_mean_mm:.4f} mm by the camera's model, at most {plane_error_max_mm:.4f} mm",
      found.plane_error.mean(), found.plane_error.largest());
  const auto list_view = [](ReportList& row, const CalibratedView& view) {
    row.line("view", "{image}", view.name);
    row.line("rms", "{rms_px:.3f} px", view.rms_px);
  };
  list.rows("views", found.views, list_view, "  ");
  return list;
}

Verdict camera_verdict(const CameraCalibration& found) {
  Verdict verdict;
  judge_views(found, verdict);
  judge_left_out(found, verdict);
  const std::vector<std::string> corners = coverage_of(found).empty_corners();
  if (!corners.empty())
    verdict.faults.push_back(
        {fmt::format("no view reaches the picture's corner {}", fmt::join(corners, ", ")),
         "hold the board into these corners for two or three more views each, unless the lamps "
         "never come there"});
  if (verdict.faults.empty())
    verdict.good = fmt::format(
        "{} views agree to {:.3f} px, views left out of the fit to {:.3f} px, all corners of the "
        "picture are seen, and the camera's model places points of the plane to {:.4f} mm in "
        "the mean and {:.4f} mm at worst",
        found.views.size(), found.rms_px, *found.held_out_rms_px, mm(found.plane_error.mean()),
        found.plane_error.largest() / kMillimetre);
  return verdict;
}

std::string camera_page(const CameraCalibration& found, const std::filesystem::path& file,
                        const std::vector<std::filesystem::path>& inputs) {
  const ImageCoverage coverage = coverage_of(found);
  HtmlPage page = page_about("Camera", file);
  page.add_verdict(camera_verdict(found));
  page.add_heading("Where the boards were seen");
  page.add_html(plot_svg({residual_panel(found), coverage_panel(found, coverage)}));
  page.add_paragraph(
      "Left: how far each point of the boards was seen from where the model puts it; a line begins "
      "at the dot. Lines in all directions are noise; neighbours that point the same way show a "
      "lens that is not of this model, which the error map takes up. Right: how many points each "
      "part of the picture has; white has none.");
  page.add_heading("What it is worth");
  page.add_html(plot_svg({plane_panel(found), view_panel(found), residual_histogram(found)}));
  page.add_paragraph(fmt::format(
      "Left: how far a point of a plane {:.0f} mm away may be off because the camera's model is "
      "uncertain (one standard deviation, both axes together), once the plane's pose has been "
      "fitted; it is shown where boards were seen, beyond which the model extrapolates. Middle: a "
      "view far above the others is blurred, or its board bent.",
      found.plane_error.distance / kMillimetre));
  add_tables(page, page_list(found, coverage), found);
  add_provenance(page, file, input_records(inputs));
  return page.text();
}

}  // namespace planar

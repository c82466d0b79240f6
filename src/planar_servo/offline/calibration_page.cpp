#include "planar_servo/offline/calibration_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/offline/page_of_file.h"
#include "planar_servo/report/places.h"
#include "planar_servo/report/plot.h"

namespace planar {
namespace {

constexpr int kCellsAlongLongerSide = 20;
constexpr double kCorner = 0.2;

constexpr double kMostly = 0.5;
constexpr int kShuffles = 200;
constexpr double kChance = 0.95;
constexpr const char* kCorners[] = {"upper left", "upper right", "lower left", "lower right"};

using ViewResiduals = std::vector<std::vector<Eigen::Vector2d>>;

/// The cells of the image, and in which one each point of each view lies.
struct CellGrid {
  explicit CellGrid(const CameraCalibration& found)
      : size_px(static_cast<double>(std::max(found.width_px, found.height_px)) /
                kCellsAlongLongerSide) {
    const auto count = [&](int pixels) {
      return static_cast<Eigen::Index>(std::ceil(pixels / size_px - 1e-9));
    };
    rows = count(found.height_px);
    columns = count(found.width_px);
    const auto index = [&](double px, Eigen::Index number) {
      return std::clamp<Eigen::Index>(static_cast<Eigen::Index>((px + 0.5) / size_px), 0,
                                      number - 1);
    };
    for (const CalibratedView& view : found.views) {
      std::vector<Eigen::Index>& of_view = cells.emplace_back();
      for (const Eigen::Vector2d& uv : view.pixels)
        of_view.push_back(index(uv.x(), columns) * rows + index(uv.y(), rows));
    }
  }

  /// Returns the mean square, over the points, of what the residuals of a cell have in common. Of
  /// the square of a mean of n, the n-th part of the variance is chance.
  double common_square(const ViewResiduals& residuals_px) const {
    struct Sums {
      double n{0.0}, squares{0.0};
      Eigen::Vector2d sum{0.0, 0.0};
    };
    std::vector<Sums> sums(static_cast<std::size_t>(rows * columns));
    for (std::size_t view = 0; view < cells.size(); ++view)
      for (std::size_t i = 0; i < cells[view].size(); ++i) {
        Sums& cell = sums[static_cast<std::size_t>(cells[view][i])];
        cell.n += 1.0;
        cell.sum += residuals_px[view][i];
        cell.squares += residuals_px[view][i].squaredNorm();
      }
    double common = 0.0, points = 0.0;
    for (const Sums& cell : sums) {
      if (cell.n < 2.0) continue;
      const double of_mean = cell.sum.squaredNorm() / (cell.n * cell.n);
      const double variance = (cell.squares - cell.n * of_mean) / (cell.n - 1.0);
      common += cell.n * (of_mean - variance / cell.n);
      points += cell.n;
    }
    return points > 0.0 ? std::max(0.0, common / points) : 0.0;
  }

  double size_px;
  Eigen::Index rows, columns;
  std::vector<std::vector<Eigen::Index>> cells;
};

/// Returns the mean square that residuals have in common after shuffles within their views, which
/// kChance of the shuffles do not exceed.
double common_square_by_chance(const CellGrid& grid, ViewResiduals residuals_px) {
  std::mt19937 random(1);
  std::vector<double> squares;
  for (int i = 0; i < kShuffles; ++i) {
    for (auto& view : residuals_px) std::shuffle(view.begin(), view.end(), random);
    squares.push_back(grid.common_square(residuals_px));
  }
  return quantile(squares, kChance);
}

std::array<double, 4> corner_gaps_px(const CameraCalibration& found) {
  std::array<double, 4> gaps{};
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    const Eigen::Vector2d corner(i % 2 == 0 ? 0.0 : found.width_px, i < 2 ? 0.0 : found.height_px);
    gaps[i] = std::hypot(found.width_px, found.height_px);
    for (const CalibratedView& view : found.views)
      for (const Eigen::Vector2d& uv : view.pixels)
        gaps[i] = std::min(gaps[i], (uv - corner).norm());
  }
  return gaps;
}

/// Views left out may be met this many times worse than those fitted.
constexpr double kWorseLeftOut = 1.5;
/// A view may have this many times the median residual.
constexpr double kUnusualView = 2.0;
constexpr double kMostRejected = 0.2;

std::string per_cent(double share) {
  return fixed(100.0 * share, 0) + " %";
}

void judge_views(const CameraCalibration& found, Verdict& verdict) {
  const double usual = median(each(found.views, &CalibratedView::rms_px));
  for (const CalibratedView& view : found.views)
    if (view.rms_px > kUnusualView * usual)
      verdict.doubt(fmt::format("{} is met to {:.3f} px only, the others to {:.3f} px", view.name,
                                view.rms_px, usual),
                    "look at " + view.name + ": if it is blurred or the board bent, leave it out");
  const std::size_t pictures = found.views.size() + found.rejected.size();
  if (static_cast<double>(found.rejected.size()) > kMostRejected * static_cast<double>(pictures))
    verdict.doubt(fmt::format("{} of {} pictures were not used", found.rejected.size(), pictures),
                  "take new pictures in place of those under 'Not used', which says why");
}

void judge_left_out(const CameraCalibration& found, Verdict& verdict) {
  if (!found.held_out_rms_px)
    verdict.doubt(
        fmt::format("{} views are too few to judge the camera by views left out of the fit",
                    found.views.size()),
        "take 10 or more views, tilted in different directions");
  else if (*found.held_out_rms_px > kWorseLeftOut * found.rms_px)
    verdict.doubt(
        fmt::format("views left out of the fit are met to {:.3f} px, those fitted to {:.3f} px",
                    *found.held_out_rms_px, found.rms_px),
        "take more views, tilted in different directions, or a simpler --model");
}

void judge_image(const CameraCalibration& found, const ImageCoverage& coverage, Verdict& verdict) {
  const std::vector<std::string> corners = coverage.empty_corners();
  if (!corners.empty())
    verdict.doubt(
        fmt::format("{} of the image {} not seen: {}", corners.size() == 1 ? "a corner" : "corners",
                    corners.size() == 1 ? "was" : "were", fmt::join(corners, ", ")),
        "hold the board into these corners for two or three more views each, unless the lamps "
        "never come there");
  if (!coverage.is_systematic()) return;
  const std::string what = fmt::format(
      "the residuals are mostly systematic, not noise: neighbouring points have {} of their mean "
      "square in common, chance makes {} of it",
      per_cent(coverage.systematic), per_cent(coverage.by_chance));
  if (found.is_auto)
    verdict.found = fmt::format(
        "No model fits this lens better: {}. The error map takes up what the model leaves; a board "
        "that is not flat looks the same",
        what);
  else
    verdict.doubt(what, "calibrate with --model auto");
}

/// Lists what was found with what only the page shows.
ReportList page_list(const CameraCalibration& found, const ImageCoverage& coverage) {
  ReportList list = calibration_list(found);
  const auto& sigma = found.standard_deviations;
  list.line("its deviations", "{distortion_sigmas:.2g| }",
            std::vector<double>(sigma.begin() + 4, sigma.end()));
  list.line("common to neighbours",
            "{common_px:.3f} px rms of the residuals: {systematic:.0%} of their mean square, where "
            "chance makes {by_chance:.0%}",
            coverage.common_px, coverage.systematic, coverage.by_chance);
  list.line("that plane", "{plane_distance_mm:.1f} mm away", found.plane_error.distance);
  list.line("points", "in {seen_share:.0%} of the image", coverage.share());
  list.line(
      "nearest points",
      "{corner_gaps_px:.0f} px from the corners " + fmt::format("{}", fmt::join(kCorners, ", ")),
      coverage.corner_gaps_px);
  list.show("views", "Views");
  list.show("rejected", "Not used");
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

/// Fills the picture with the colours of a value at each pixel; `label` says what it is.
template <typename ValueAt>
Panel field_panel(const std::string& title, const CameraCalibration& found,
                  const std::string& label, const ValueAt& value_at) {
  Panel panel = picture_panel(title, found);
  const std::vector<double> values = each(panel.field_places(), value_at);
  const ColorScale colors(label, values);
  panel.add_field(values, colors);
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

/// Returns a deviation; "?" of a parameter that the views do not tell by itself.
std::string deviation(double sigma_px) {
  return std::isnan(sigma_px) ? "?" : fmt::format("{:.2f}", sigma_px);
}

}  // namespace

ImageCoverage coverage_of(const CameraCalibration& found) {
  const CellGrid grid(found);
  const ViewResiduals residuals_px = each(found.views, &CalibratedView::residuals_px);
  const double common = grid.common_square(residuals_px);
  ImageCoverage coverage;
  coverage.cell_px = grid.size_px;
  coverage.points = Eigen::MatrixXi::Zero(grid.rows, grid.columns);
  for (const auto& view : grid.cells)
    for (const Eigen::Index cell : view) ++coverage.points(cell);
  coverage.common_px = std::sqrt(common);
  coverage.corner_gaps_px = corner_gaps_px(found);
  if (const double square = found.rms_px * found.rms_px; square > 0.0) {
    coverage.systematic = std::min(1.0, common / square);
    coverage.by_chance = common_square_by_chance(grid, residuals_px) / square;
  }
  return coverage;
}

bool ImageCoverage::is_systematic() const {
  return systematic > kMostly && systematic > by_chance;
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
  if (points.topLeftCorner(high, wide).sum() == 0) empty.emplace_back(kCorners[0]);
  if (points.topRightCorner(high, wide).sum() == 0) empty.emplace_back(kCorners[1]);
  if (points.bottomLeftCorner(high, wide).sum() == 0) empty.emplace_back(kCorners[2]);
  if (points.bottomRightCorner(high, wide).sum() == 0) empty.emplace_back(kCorners[3]);
  return empty;
}

ReportList calibration_list(const CameraCalibration& found) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const Intrinsics k = intrinsics(found.camera);
  const auto& sigma = found.standard_deviations;
  ReportList list;
  list.line("images used", "{images_used} ({images_rejected} rejected)", found.views.size(),
            found.rejected.size());
  const auto list_rejected = [](ReportList& row, const Rejection& rejected) {
    row.line("picture", "{image}", rejected.id);
    row.line("why", "{reason}", rejected.reason);
  };
  list.rows("rejected", found.rejected, list_rejected, "  ");
  list.line("model", "{model}", found.model);
  const auto pair = [&](double a, double b, std::size_t i) {
    return fmt::format("{:.2f} +- {}, {:.2f} +- {} px", a, deviation(sigma[i]), b,
                       deviation(sigma[i + 1]));
  };
  list.line("focal lengths", pair(k.fx, k.fy, 0));
  list.line("principal point", pair(k.cx, k.cy, 2));
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
  const ImageCoverage coverage = coverage_of(found);
  judge_image(found, coverage, verdict);
  if (verdict.faults.empty())
    verdict.good = fmt::format(
        "{} views agree to {:.3f} px, views left out of the fit to {:.3f} px, {} of their square "
        "is systematic, points come within {:.0f} px of every corner of the image, and the "
        "camera's model places points of the plane to {:.4f} mm on average and {:.4f} mm at worst",
        found.views.size(), found.rms_px, *found.held_out_rms_px, per_cent(coverage.systematic),
        *std::max_element(coverage.corner_gaps_px.begin(), coverage.corner_gaps_px.end()),
        mm(found.plane_error.mean()), mm(found.plane_error.largest()));
  return verdict;
}

std::string camera_page(const CameraCalibration& found, const std::filesystem::path& file,
                        const std::vector<std::filesystem::path>& inputs) {
  const ImageCoverage coverage = coverage_of(found);
  HtmlPage page = page_about("Camera", file, camera_verdict(found));
  const auto points_at = [&](const Eigen::Vector2d& uv) { return coverage.points_at(uv); };
  page.add_section(
      "Where the boards were seen",
      plot_html({residual_panel(found),
                 field_panel("Points seen", found, "points in a cell", points_at)}),
      "First: how far each point of the boards was seen from where the model puts it; a line "
      "begins at the dot. Lines in all directions are noise; neighbours that point the same way "
      "show a lens that is not of this model, which the error map takes up. Second: how many "
      "points each part of the image has; white has none.");
  page.add_paragraph(
      "Residuals are called mostly systematic where points of the same part of the image have more "
      "than half of the mean square in common, and more than in 95 of 100 shuffles of the "
      "residuals among the points of their views.");
  const auto error_mm = [&](const Eigen::Vector2d& uv) { return mm(found.plane_error.at(uv)); };
  page.add_section(
      "Accuracy of the calibration",
      plot_html({field_panel("Uncertainty over the plane", found, "uncertainty, mm", error_mm),
                 view_panel(found), residual_histogram(found)}),
      fmt::format(
          "First: how far a point of a plane {:.0f} mm away may be off because the camera's model "
          "is uncertain (one standard deviation, both axes together), once the plane's pose has "
          "been fitted; it is shown where boards were seen, beyond which the model extrapolates. "
          "Second: a view far above the others is blurred, or its board bent.",
          mm(found.plane_error.distance)));
  return ended_page(std::move(page), page_list(found, coverage), file, input_records(inputs));
}

}  // namespace planar

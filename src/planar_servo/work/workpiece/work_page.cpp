#include "planar_servo/work/workpiece/work_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "planar_servo/base/core/units.h"
#include "planar_servo/report/html_page.h"

namespace planar {
namespace {

std::string base64(const std::vector<std::uint8_t>& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63U];
  }
  return text;
}

/// Returns the part of the picture that shows these marks, with room around.
cv::Rect part_round(const FoundWork& work, const cv::Size& image) {
  std::vector<cv::Point2f> places;
  for (const FoundFiducial& mark : work.fiducials)
    places.emplace_back(static_cast<float>(mark.uv_px.x()), static_cast<float>(mark.uv_px.y()));
  cv::Rect box = cv::boundingRect(places);
  const int margin = 40 + std::max(box.width, box.height) / 6;
  box -= cv::Point(margin, margin);
  box += cv::Size(2 * margin, 2 * margin);
  return box & cv::Rect({}, image);
}

/// Returns the affine map from the drawing to the picture that the marks show.
Eigen::Matrix<double, 3, 2> drawing_to_picture(const FoundWork& work) {
  const auto n = static_cast<Eigen::Index>(work.fiducials.size());
  Eigen::Matrix2Xd p_W(2, n), uv_px(2, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    p_W.col(i) = work.fiducials[static_cast<std::size_t>(i)].fiducial.p_W;
    uv_px.col(i) = work.fiducials[static_cast<std::size_t>(i)].uv_px;
  }
  // The camera looks down: y of the picture points against y of the drawing.
  const double scale =
      (uv_px.col(n - 1) - uv_px.col(0)).norm() / (p_W.col(n - 1) - p_W.col(0)).norm();
  Eigen::Matrix2Xd flipped = scale * p_W;
  flipped.row(1) *= -1.0;
  const Eigen::Isometry2d X = fit_rigid_2d(uv_px, flipped);
  Eigen::Matrix<double, 3, 2> map;
  map.row(0) = X.translation().transpose();
  map.row(1) = scale * X.linear().col(0).transpose();
  map.row(2) = -scale * X.linear().col(1).transpose();
  return map;
}

/// Returns the picture with its overlay, at most `kWidth` wide.
std::string picture_svg(const FoundWork& work, const cv::Mat& image) {
  constexpr int kWidth = 900;
  const cv::Rect part = part_round(work, image.size());
  const double scale = std::min(1.0, 1.0 * kWidth / part.width);
  cv::Mat shown;
  cv::resize(image(part), shown, {}, scale, scale, cv::INTER_AREA);
  cv::normalize(shown, shown, 0, 255, cv::NORM_MINMAX);
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", shown, jpeg, {cv::IMWRITE_JPEG_QUALITY, 85});
  const auto at = [&](const Eigen::Vector2d& uv_px) {
    return Eigen::Vector2d(scale * (uv_px - Eigen::Vector2d(part.x, part.y)));
  };
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
      "height=\"{1}\" role=\"img\">\n<title>The picture, with a circle around each mark that "
      "was found and the drawing's axes</title>\n"
      "<image width=\"{0}\" height=\"{1}\" href=\"data:image/jpeg;base64,{2}\"/>",
      shown.cols, shown.rows, base64(jpeg));
  const auto line = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to, const char* color) {
    svg += fmt::format(
        "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" "
        "stroke-width=\"2\"/>",
        from.x(), from.y(), to.x(), to.y(), color);
  };
  const auto label = [&](const Eigen::Vector2d& place, const std::string& text, const char* color) {
    svg += fmt::format(
        "<text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"{}\" stroke=\"#000\" stroke-width=\"3\" "
        "paint-order=\"stroke\" font-size=\"14\">{}</text>",
        place.x(), place.y(), color, html_escaped(text));
  };
  const Eigen::Matrix<double, 3, 2> map = drawing_to_picture(work);
  const Eigen::Vector2d origin = at(map.row(0).transpose());
  const double length_px = 0.15 * std::max(shown.cols, shown.rows);
  for (const auto& [row, color, name] : {std::tuple{1, "#ff5252", "x"}, {2, "#69f0ae", "y"}}) {
    const Eigen::Vector2d end = origin + length_px * map.row(row).normalized().transpose();
    line(origin, end, color);
    label(end, name, color);
  }
  for (const FoundFiducial& mark : work.fiducials) {
    const Eigen::Vector2d place = at(mark.uv_px);
    const double radius = 4.0 + 0.6 * scale * mark.fiducial.size * map.row(1).norm();
    svg += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\" fill=\"none\" stroke=\"#ffd740\" "
        "stroke-width=\"2\"/>",
        place.x(), place.y(), radius);
    label(place + Eigen::Vector2d(radius + 2.0, -radius), mark.fiducial.id, "#ffd740");
  }
  return svg + "</svg>";
}

ReportList list_of(const FoundWork& work) {
  double largest_residual = 0.0, sigma = 0.0;
  for (const FoundFiducial& mark : work.fiducials) {
    largest_residual = std::max(largest_residual, mark.residual.norm());
    sigma = std::max(sigma, per_axis(work.pose.covariance_at(mark.fiducial.p_W)));
  }
  ReportList list;
  if (!work.id.empty()) list.line("work", "{work}", work.id);
  list.line("origin", "({origin_mm:.3f}) mm", work.pose.t);
  list.line("turned by", "{turn_deg:.4f} deg", work.pose.turn());
  list.line_if(work.pose.map != WorkMap::kRigid, "scale", "{scale:.5f}, by {map}",
               work.pose.scale(), std::string(name_in(kWorkMaps, work.pose.map)));
  list.line("marks", "{marks}, up to {largest_residual_mm:.4f} mm from the fit",
            work.fiducials.size(), largest_residual);
  list.line("deviation", "{sigma_mm:.4f} mm per axis at the marks", sigma);
  list.unprinted("chance", work.chance);
  list.unprinted("remarks", work.remarks);
  for (const FoundFiducial& mark : work.fiducials)
    list.row("marks", {{"mark", mark.fiducial.id},
                       {"drawn mm", fixed(mark.fiducial.p_W / kMillimetre, 3, ", ")},
                       {"seen at mm", fixed(mark.p_B / kMillimetre, 3, ", ")},
                       {"from the fit mm", fixed(mark.residual / kMillimetre, 4, ", ")},
                       {"deviation mm", fixed(mm(mark.sigma), 4)},
                       {"diameter mm", mark.diameter > 0.0 ? fixed(mm(mark.diameter), 2) : "–"}});
  list.show("marks", "Marks");
  return list;
}

}  // namespace

ReportList work_list(const std::vector<FoundWork>& works) {
  ReportList list;
  list.line("works", "{found}", works.size());
  if (works.size() == 1) {
    list.append(list_of(works.front()));
    return list;
  }
  list.rows(
      "works", works, [](ReportList& row, const FoundWork& work) { row.append(list_of(work)); },
      "  ", ", ");
  return list;
}

std::string work_page(const std::vector<FoundWork>& works, const cv::Mat& image,
                      const std::filesystem::path& file) {
  HtmlPage page("Workpiece " + file.filename().string());
  page.add_verdict({works.size() == 1 ? "The work was found, and its marks fit the drawing"
                                      : fmt::format("{} works were found, and the marks of each "
                                                    "fit the drawing",
                                                    works.size())});
  for (const FoundWork& work : works) {
    if (!work.id.empty()) page.add_heading("Work " + work.id);
    page.add_html(picture_svg(work, image));
    for (const std::string& remark : work.remarks) page.add_paragraph(remark + ".");
    page.add_html(list_of(work).html("Where it lies in the base frame"));
  }
  return page.text();
}

}  // namespace planar

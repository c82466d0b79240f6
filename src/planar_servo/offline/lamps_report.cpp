#include "planar_servo/offline/lamps_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/offline/page_of_file.h"
#include "planar_servo/report/places.h"
#include "planar_servo/report/plot.h"

namespace planar {
namespace {

std::optional<double> median_of(const std::vector<double>& values) {
  return values.empty() ? std::nullopt : std::optional<double>(median(values));
}

/// Returns the number of images of each status.
std::map<LampStatus, std::size_t> counts_of(const LocateReport& report) {
  std::map<LampStatus, std::size_t> counts;
  for (const LampRow& row : report.rows) ++counts[row.status];
  return counts;
}

/// More images without lamps than this share are a fault ...
constexpr double kFewFailures = 0.02;
/// ... and so is a scatter at rest of this many times the stated one.
constexpr double kUnrest = 1.5;
constexpr char kFailure[] = "#c0392b";

/// Says what to do about images of a status.
std::string remedy_for(LampStatus status) {
  switch (status) {
    case LampStatus::kNoLamp:
    case LampStatus::kOneLamp:
      return "check whether something hides the lamps there, or one is off or too dark: expose "
             "longer";
    case LampStatus::kWrongDistance:
      return "measure the lamps' distance and correct lamps.separation_mm in the cell file, or the "
             "link lengths";
    case LampStatus::kSaturated:
      return "expose shorter, until no lamp is at the highest grey level";
    case LampStatus::kAtBorder:
      return "enlarge camera.follow_region_px, or correct the arm that predicts where the lamps "
             "are";
    case LampStatus::kAmbiguous:
      return "give --cell, so that the commanded pose tells which lamp is which, or take away "
             "other lights";
    case LampStatus::kNotRound:
      return "look for reflections, and for motion while the camera exposes";
    case LampStatus::kLowContrast:
      return "expose longer, or keep other light away";
    default:
      return "look at these images; the table says which they are";
  }
}

double sigma_of(const LampRow& row) {
  double variance = 0.0;
  for (const Eigen::Matrix2d& covariance : row.covariance_px2)
    variance += 0.5 * covariance.trace() / static_cast<double>(row.covariance_px2.size());
  return std::sqrt(variance);
}

/// What the pictures show, one entry for each image that shows the lamps.
struct SeenLamps {
  std::vector<Eigen::Vector2d> pixels;  ///< of every lamp
  std::vector<double> sigmas;           ///< of every lamp
  std::vector<Eigen::Vector2d> series;  ///< image and its lamps' deviation
  std::vector<Eigen::Vector2d> failed;  ///< image, and zero
};

SeenLamps seen_lamps(const std::vector<LampRow>& rows) {
  SeenLamps seen;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const LampRow& row = rows[i];
    const auto image = static_cast<double>(i + 1);
    if (row.status != LampStatus::kOk) {
      if (row.status != LampStatus::kBoardView) seen.failed.emplace_back(image, 0.0);
      continue;
    }
    for (const Eigen::Vector2d& uv : row.uv_px) seen.pixels.push_back(uv);
    seen.sigmas.insert(seen.sigmas.end(), row.uv_px.size(), sigma_of(row));
    seen.series.emplace_back(image, sigma_of(row));
  }
  return seen;
}

Panel place_panel(const SeenLamps& seen, const std::optional<cv::Size>& sensor_px) {
  Axis u{"u, px", 0.0, 1.0}, v{"v, px", 1.0, 0.0};
  for (const Eigen::Vector2d& uv : seen.pixels) {
    u.to = std::max(u.to, uv.x());
    v.from = std::max(v.from, uv.y());
  }
  if (sensor_px) {
    u.to = sensor_px->width;
    v.from = sensor_px->height;
  }
  const ColorScale colors("stated deviation, px", seen.sigmas);
  Panel panel("Where the lamps were seen", u, v, Panel::Aspect::kEqual);
  panel.add_dots(seen.pixels, {"", &colors, seen.sigmas}, 2.6);
  panel.add_color_bar(colors);
  return panel;
}

Axis image_axis(std::size_t images) {
  return {"image, in the order of the table", 0.0, static_cast<double>(images) + 1.0};
}

Panel deviation_panel(const SeenLamps& seen, std::size_t images) {
  const double most = *std::max_element(seen.sigmas.begin(), seen.sigmas.end());
  Panel panel("Stated deviation of a lamp", image_axis(images),
              {"deviation per axis, px", 0.0, 1.1 * most});
  panel.add_dots(seen.series);
  panel.add_dots(seen.failed, {kFailure}, 3.0);
  if (!seen.failed.empty())
    panel.add_key(kFailure,
                  fmt::format("at the bottom: {} images without lamps", seen.failed.size()));
  return panel;
}

std::string repeat_plot(const std::vector<RepeatedSight>& sights, std::size_t images) {
  const std::vector<Eigen::Vector2d> offs_px = each(sights, &RepeatedSight::off_px);
  return plot_html({component_panel("Scatter at rest", image_axis(images),
                                    axis_over("from the place's mean, px", components_of(offs_px)),
                                    each(sights, &RepeatedSight::at), offs_px),
                    histogram("Scatter over what is stated", "pull, in stated deviations",
                              components_of(each(sights, &RepeatedSight::pull)),
                              {1.0, "the stated deviation"})});
}

std::optional<double> pull_rms(const std::vector<RepeatedSight>& sights) {
  if (sights.empty()) return std::nullopt;
  return rms(components_of(each(sights, &RepeatedSight::pull)));
}

void add_failures(const LocateReport& report, Verdict& verdict) {
  auto counts = counts_of(report);
  const std::size_t images = report.rows.size() - counts[LampStatus::kBoardView];
  for (const LampStatus fine : {LampStatus::kOk, LampStatus::kBoardView}) counts.erase(fine);
  for (const auto& [status, count] : counts)
    if (static_cast<double>(count) > kFewFailures * static_cast<double>(images))
      verdict.doubt(fmt::format("{} of {} images are {}", count, images, name(status)),
                    remedy_for(status));
}

/// Lists what was found and names the images without lamps, the first ones of many.
ReportList page_list(const LocateReport& report) {
  constexpr std::size_t kMostNamed = 50;
  ReportList list = locate_list(report);
  std::size_t failures = 0;
  for (const LampRow& row : report.rows)
    if (row.status != LampStatus::kOk && row.status != LampStatus::kBoardView)
      if (++failures <= kMostNamed)
        list.row("failures", {{"image", row.image}, {"status", name(row.status)}});
  if (failures > kMostNamed)
    list.row("failures", {{"", fmt::format("and {} more", failures - kMostNamed)},
                          {"", "see the table itself"}});
  list.show("failures", "Images without lamps");
  return list;
}

}  // namespace

bool shows_any(const LocateReport& report) {
  const auto counts = counts_of(report);
  return counts.count(LampStatus::kOk) + counts.count(LampStatus::kAmbiguous) > 0;
}

std::optional<Refusal> distance_doubt(const LocateReport& report, double separation) {
  const auto ratio = median_of(report.wrong_distances);
  if (!ratio) return std::nullopt;
  return Refusal{
      fmt::format("in {} images the pair is {:.1f} mm apart, the cell says {:.4g} mm",
                  report.wrong_distances.size(), mm(*ratio * separation), mm(separation)),
      "measure the lamps and correct lamps.separation_mm in the cell file, or the link "
      "lengths if they are wrong",
      "", Cause::kContradiction};
}

ReportList locate_list(const LocateReport& report) {
  std::map<std::string, std::size_t> statuses;
  for (const auto& [status, count] : counts_of(report)) statuses[name(status)] = count;
  const std::size_t images = report.rows.size(), ok = statuses[name(LampStatus::kOk)];
  statuses.erase(name(LampStatus::kOk));
  std::vector<double> sigmas_phi;
  for (const LampRow& row : report.rows)
    if (row.sigma_phi) sigmas_phi.push_back(*row.sigma_phi);
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  std::string others;
  for (const auto& [status, count] : statuses) others += fmt::format(", {} {}", count, status);
  ReportList list;
  list.line("images", "{images}: {ok} ok" + others, images, ok);
  list.unprinted("not_ok", images - ok);
  list.unprinted("statuses", statuses);
  list.line("time", "{ms_per_image_median:.2f} ms per image",
            median_of(report.milliseconds).value_or(kUnknown));
  list.line("direction", "known to {sigma_phi_deg_median:.4f} deg",
            median_of(sigmas_phi).value_or(kUnknown));
  return list;
}

std::vector<RepeatedSight> repeated_sights(const std::vector<LampRow>& rows) {
  std::map<std::string, std::vector<std::size_t>> places;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i].status == LampStatus::kOk) places[rows[i].id].push_back(i);
  std::vector<RepeatedSight> sights;
  for (const auto& [id, images] : places) {
    const auto n = static_cast<double>(images.size());
    if (images.size() < 2) continue;
    for (std::size_t lamp = 0; lamp < rows[images.front()].uv_px.size(); ++lamp) {
      Eigen::Vector2d mean(0.0, 0.0);
      for (const std::size_t i : images) mean += rows[i].uv_px[lamp] / n;
      for (const std::size_t i : images) {
        const Eigen::Vector2d off = std::sqrt(n / (n - 1.0)) * (rows[i].uv_px[lamp] - mean);
        const Eigen::Vector2d sigma = rows[i].covariance_px2[lamp].diagonal().cwiseSqrt();
        sights.push_back({static_cast<double>(i + 1), off, off.cwiseQuotient(sigma)});
      }
    }
  }
  return sights;
}

Verdict lamps_verdict(const LocateReport& report) {
  Verdict verdict;
  add_failures(report, verdict);
  const auto pulls = pull_rms(repeated_sights(report.rows));
  if (pulls && *pulls > kUnrest)
    verdict.doubt(
        fmt::format("images of one place scatter by {:.1f} times what is stated", *pulls),
        "find what moves while the arm should rest: let it settle longer (servo.settle_ms), "
        "fasten the camera");
  if (!verdict.faults.empty()) return verdict;
  auto counts = counts_of(report);
  verdict.good = fmt::format("{} of {} images show the lamps{}", counts[LampStatus::kOk],
                             report.rows.size() - counts[LampStatus::kBoardView],
                             pulls ? fmt::format(", and at rest they scatter by {:.2f} times what "
                                                 "is stated",
                                                 *pulls)
                                   : "");
  return verdict;
}

std::string lamps_page(const LocateReport& report, const std::filesystem::path& file,
                       const std::optional<cv::Size>& sensor_px) {
  HtmlPage page = page_about("Lamps", file, lamps_verdict(report));
  const SeenLamps seen = seen_lamps(report.rows);
  if (!seen.series.empty())
    page.add_section(
        "Where the lamps were seen",
        plot_html({place_panel(seen, sensor_px), deviation_panel(seen, report.rows.size())}),
        "First: every lamp in the whole image; places that the arm reaches but no mark shows were "
        "not recorded. Second: how well the lamps of an image are known, as the image itself "
        "says.");
  const std::vector<RepeatedSight> sights = repeated_sights(report.rows);
  if (!sights.empty())
    page.add_section(
        "Several images of one place", repeat_plot(sights, report.rows.size()),
        "First: how far a lamp is seen from its mean over the images of its place; a growing band "
        "shows that something has come loose. Second: the same in stated deviations, which is as "
        "wide as the curve where the stated ones are right.");
  return ended_page(std::move(page), page_list(report), file);
}

}  // namespace planar

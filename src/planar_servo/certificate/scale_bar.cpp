#include "planar_servo/certificate/scale_bar.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/work_file.h"
#include "planar_servo/report/html_page.h"

namespace planar {

ScaleBar read_scale_bar(const std::filesystem::path& path, double sigma) {
  ScaleBar bar{read_bar(path), 0.0, sigma};
  bar.length = (bar.marks[1].p_W - bar.marks[0].p_W).norm();
  return bar;
}

double ScaleBarResult::largest() const {
  double largest = 0.0;
  for (const LengthError& length : lengths) largest = std::max(largest, std::abs(length.error));
  return largest;
}

std::size_t ScaleBarResult::within_95() const {
  return static_cast<std::size_t>(std::count_if(
      lengths.begin(), lengths.end(),
      [](const LengthError& length) { return std::abs(length.error) < 1.96 * length.sigma; }));
}

std::size_t ScaleBarResult::places() const {
  const auto lies_as = [&](const LengthError& a, const LengthError& b) {
    const double turned = 0.5 * bar.length * std::abs(std::remainder(a.turn - b.turn, kPi));
    return std::hypot((a.middle_B - b.middle_B).norm(), turned) < bar.marks.front().size;
  };
  std::size_t places = 0;
  for (auto length = lengths.begin(); length != lengths.end(); ++length)
    if (std::none_of(lengths.begin(), length,
                     [&](const LengthError& before) { return lies_as(*length, before); }))
      ++places;
  return places;
}

std::optional<Refusal> ScaleBarResult::fault() const {
  constexpr std::size_t kLeastPlaces = 7;
  if (places() < kLeastPlaces)
    return Refusal{fmt::format("{} places are too few", places()),
                   fmt::format("lay the bar in {} or more, over the whole workspace and at "
                               "different turns",
                               kLeastPlaces),
                   "", Cause::kInsufficient};
  const auto all = static_cast<int>(lengths.size()), within = static_cast<int>(within_95());
  if (binomial_tail(within, all, 0.95) > kFalseAlarm) return std::nullopt;
  return Refusal{fmt::format("only {} of {} errors are within the stated 95 %", within, all),
                 "measure the bar's height (z_mm), compare its certificate and temperature, or "
                 "calibrate anew",
                 "", Cause::kContradiction};
}

void add_lengths(ScaleBarResult& result, const std::vector<Frame>& frames,
                 const VisionCalibration& vision) {
  for (const BarSight& seen : see_bars(frames, vision, result.bar.marks)) {
    const Eigen::Vector2d along = seen.p_B[1] - seen.p_B[0];
    result.lengths.push_back({0.5 * (seen.p_B[0] + seen.p_B[1]), std::atan2(along.y(), along.x()),
                              seen.length - result.bar.length,
                              std::hypot(seen.sigma, result.bar.sigma)});
  }
}

std::string length_words(const LengthError& length) {
  return fmt::format("at {}, turned by {:.0f} deg: {:+.4f} mm, +- {:.4f} mm stated",
                     place_mm(length.middle_B), length.turn / kDegree, mm(length.error),
                     mm(length.sigma));
}

ReportList scale_bar_list(const ScaleBarResult& result) {
  ReportList list;
  list.line("bar", "{bar_mm:.4f} mm, +- {bar_sigma_mm:.4f}", result.bar.length, result.bar.sigma);
  list.line("places", "{places} places and turns of the bar", result.places());
  list.line("length errors",
            "up to {largest_error_mm:.4f} mm, {within_95} within their stated 95 %",
            result.largest(), result.within_95());
  list.rows("lengths", result.lengths, [](ReportList& row, const LengthError& length) {
    row.line("place mm", "{middle_mm:.1f}", length.middle_B);
    row.line("turn deg", "{turn_deg:.1f}", length.turn);
    row.line("error mm", "{error_mm:.4f}", length.error);
    row.line("stated deviation mm", "{sigma_mm:.4f}", length.sigma);
  });
  list.show("lengths", "Length errors");
  return list;
}

std::string scale_bar_page(const ScaleBarResult& result, const std::filesystem::path& cell) {
  HtmlPage page("Lengths measured by " + cell.filename().string());
  Verdict verdict{
      fmt::format("Over {} places and turns, a length of {:.3f} mm is measured within "
                  "{:.4f} mm",
                  result.places(), mm(result.bar.length), mm(result.largest()))};
  if (const auto fault = result.fault()) verdict.faults.push_back(*fault);
  page.add_verdict(verdict);
  page.add_html(scale_bar_list(result).table_html("lengths"));
  page.add_paragraph(
      "The bar was not used for the calibration. Its lengths say how well vision measures between "
      "two places; that the arm goes where vision sees is judged by moves.");
  return page.text();
}

}  // namespace planar

#include "planar_servo/work/run/path_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/yaml_writer.h"
#include "planar_servo/report/places.h"
#include "planar_servo/report/plot.h"
#include "planar_servo/work/run/servo_report.h"

namespace planar {
namespace {

using Points = std::vector<Eigen::Vector2d>;

constexpr int kDrawnPlaces = 500;         // of the path's line
constexpr double kDrawnDeviation = 0.07;  // the largest, as a share of the path's extent

/// The looks of one way along the path.
struct DrawnWay {
  Guidance guidance;
  double speed_m_s;
  Points seen, truth;  ///< millimetres along the path and across it
};

/// Who says where the end point was.
struct Witness {
  const char* words;
  Points DrawnWay::*points;
  std::optional<PathErrors> PathSpeedResult::*errors;
};

constexpr Witness kWitnesses[] = {{"as seen", &DrawnWay::seen, &PathSpeedResult::own_view},
                                  {"in truth", &DrawnWay::truth, &PathSpeedResult::truth}};

/// The names and colours of a guidance: for where 95 % are below and for the mean.
struct DrawnGuidance {
  Guidance guidance;
  const char* words;
  const char* clause;  ///< before a deviation
  const char* p95_color;
  const char* mean_color;
};

constexpr DrawnGuidance kDrawnGuidances[] = {
    {Guidance::kVision, "By vision", "guided by vision", kSeriesColors[0], kSeriesColors[1]},
    {Guidance::kArm, "By the arm alone", "guided by the arm alone", kSeriesColors[2],
     kSeriesColors[3]}};

Eigen::Vector2d point_mm(const PathOffset& offset) {
  return Eigen::Vector2d(offset.along_m, offset.across_m) / kMillimetre;
}

std::vector<DrawnWay> ways_along(const std::vector<PathLookRow>& looks) {
  std::vector<DrawnWay> ways;
  for (const PathLookRow& row : looks) {
    if (ways.empty() || ways.back().guidance != row.guidance ||
        ways.back().speed_m_s != row.speed_m_s)
      ways.push_back({row.guidance, row.speed_m_s, {}, {}});
    if (row.look.measurement.ok()) ways.back().seen.push_back(point_mm(row.look.seen));
    if (row.truth) ways.back().truth.push_back(point_mm(*row.truth));
  }
  return ways;
}

std::vector<double> deviations_mm(const std::vector<DrawnWay>& ways) {
  std::vector<double> deviations;
  for (const DrawnWay& way : ways)
    for (const Witness& witness : kWitnesses)
      for (const Eigen::Vector2d& point : way.*witness.points) deviations.push_back(point.y());
  return deviations;
}

/// Draws on `blank` a panel for each witness of each guidance, with a line for each speed: `placed`
/// says where points along and across the path lie in it.
std::string panels_of(const std::vector<DrawnWay>& ways,
                      const std::function<Panel(const std::string& title)>& blank,
                      const std::function<Points(const Points&)>& placed) {
  std::string html;
  for (const DrawnGuidance& drawn : kDrawnGuidances) {
    std::vector<Panel> panels;
    for (const Witness& witness : kWitnesses) {
      Panel panel = blank(fmt::format("{}, {}", drawn.words, witness.words));
      std::size_t speeds = 0;
      for (const DrawnWay& way : ways) {
        if (way.guidance != drawn.guidance || (way.*witness.points).empty()) continue;
        const char* color = kSeriesColors[speeds++ % std::size(kSeriesColors)];
        panel.add_line(placed(way.*witness.points), Panel::Stroke::kSolid, color);
        panel.add_key(color, fmt::format("{:g} mm/s", mm(way.speed_m_s)), Panel::Sample::kLine);
      }
      if (speeds > 0) panels.push_back(panel);
    }
    if (!panels.empty()) html += plot_html(panels);
  }
  return html;
}

/// The path's own line, and looks drawn beside it.
class Map {
 public:
  Map(const Path& path, const std::vector<double>& deviations) : path_(path) {
    for (int i = 0; i <= kDrawnPlaces; ++i)
      line_.push_back(path.at(path.length_m() * i / kDrawnPlaces).pose.p / kMillimetre);
    axes_ = axes_over_places(line_);
    const double extent = std::max(axes_.x.to - axes_.x.from, axes_.y.to - axes_.y.from);
    double largest = 0.0;
    for (const double deviation : deviations) largest = std::max(largest, std::abs(deviation));
    if (largest > 0.0)
      magnification_ = std::max(1.0, round_length(kDrawnDeviation * extent / largest));
  }

  Panel blank(const std::string& title) const {
    Panel panel(title, axes_);
    panel.add_line(line_);
    panel.add_note(
        fmt::format("black: the path; deviation drawn {:g} times its size", magnification_));
    return panel;
  }

  Points placed(const Points& along_across) const {
    Points placed;
    for (const Eigen::Vector2d& point : along_across) {
      const PathPlace place = path_.at(point.x() * kMillimetre);
      const Eigen::Vector2d left(-place.tangent.y(), place.tangent.x());
      placed.emplace_back(place.pose.p / kMillimetre + magnification_ * point.y() * left);
    }
    return placed;
  }

 private:
  const Path& path_;
  Points line_;
  FieldAxes axes_;
  double magnification_{1.0};
};

/// Draws one figure of a guidance's deviation over speed.
void add_curve(Panel& panel, const DrawnGuidance& drawn, const Witness& witness,
               const std::vector<PathSpeedResult>& results, double Summary::*figure,
               const char* color, const char* what) {
  Points points;
  for (const PathSpeedResult& result : results)
    if (const auto& errors = result.*witness.errors; errors && result.guidance == drawn.guidance)
      points.emplace_back(mm(result.speed_m_s), mm(errors->across_m.*figure));
  if (points.empty()) return;
  std::sort(points.begin(), points.end(),
            [](const auto& a, const auto& b) { return a.x() < b.x(); });
  panel.add_line(points, Panel::Stroke::kSolid, color);
  panel.add_dots(points, {color}, 3.0);
  panel.add_key(color, fmt::format("{}, {}", drawn.words, what));
}

std::string speed_plot(const std::vector<PathSpeedResult>& results) {
  std::vector<double> speeds, deviations{0.0};
  for (const PathSpeedResult& result : results)
    for (const Witness& witness : kWitnesses)
      if (const auto& errors = result.*witness.errors) {
        speeds.push_back(mm(result.speed_m_s));
        deviations.push_back(mm(errors->across_m.p95));
      }
  std::vector<Panel> panels;
  for (const Witness& witness : kWitnesses) {
    const auto judged = [&](const PathSpeedResult& r) { return (r.*witness.errors).has_value(); };
    if (std::none_of(results.begin(), results.end(), judged)) continue;
    Panel panel(fmt::format("Deviation by speed, {}", witness.words),
                decades_over("speed, mm/s", speeds),
                axis_over("distance from the path, mm", deviations));
    for (const DrawnGuidance& drawn : kDrawnGuidances) {
      add_curve(panel, drawn, witness, results, &Summary::p95, drawn.p95_color, "95 % are below");
      add_curve(panel, drawn, witness, results, &Summary::mean, drawn.mean_color, "mean");
    }
    panels.push_back(panel);
  }
  return panels.empty() ? "" : plot_html(panels);
}

/// Returns the range of the mean deviations.
std::string range_mm(const std::vector<double>& means_m) {
  const auto [least, most] = std::minmax_element(means_m.begin(), means_m.end());
  const std::string from = fmt::format("{:.4f}", mm(*least)), to = fmt::format("{:.4f}", mm(*most));
  return from == to ? from : from + " to " + to;
}

/// Says how far the end point left the path under a guidance; empty where nobody saw it.
std::string deviation_words(const DrawnGuidance& drawn, const Witness& witness,
                            const std::vector<PathSpeedResult>& results) {
  std::vector<double> means_m;
  double most_m = 0.0;
  for (const PathSpeedResult& result : results)
    if (const auto& errors = result.*witness.errors; errors && result.guidance == drawn.guidance) {
      means_m.push_back(errors->across_m.mean);
      most_m = std::max(most_m, errors->across_m.max);
    }
  if (means_m.empty()) return "";
  return fmt::format("{} {} mm on average and {:.4f} mm at most", drawn.clause, range_mm(means_m),
                     mm(most_m));
}

Verdict path_verdict(const std::vector<PathSpeedResult>& results) {
  Verdict verdict;
  verdict.good = "the path was followed to its end every time";
  for (const PathSpeedResult& result : results)
    if (result.status != ServoStatus::kReached)
      verdict.faults.push_back(
          {fmt::format("at {:g} mm/s, guided by {}, the path was not followed to its end: {}",
                       mm(result.speed_m_s), name_in(kGuidances, result.guidance),
                       name(result.status)),
           result.reason + "; path_looks.csv has the looks until then", "", Cause::kInsufficient});
  const bool judged = is_judged(results);
  for (const DrawnGuidance& drawn : kDrawnGuidances)
    if (const std::string words = deviation_words(drawn, kWitnesses[judged ? 1 : 0], results);
        !words.empty())
      verdict.found += (verdict.found.empty() ? "" : "; ") + words;
  if (verdict.found.empty()) return verdict;
  verdict.found =
      (judged ? "Distance from the path, judged by the truth of the virtual cell: "
              : "Distance from the path by vision's own estimate, which cannot see what "
                "the calibration gets wrong: ") +
      verdict.found;
  return verdict;
}

void list_errors(ReportList& row, const std::string& judge, const std::string& suffix,
                 const std::optional<PathErrors>& errors) {
  const auto across_m = part_of(errors, &PathErrors::across_m);
  ReportList list(suffix);
  list.line(judge + " mean", "{deviation_mean_mm:.4f}", part_of(across_m, &Summary::mean));
  list.line(judge + " 95 %", "{deviation_p95_mm:.4f}", part_of(across_m, &Summary::p95));
  list.line(judge + " max", "{deviation_max_mm:.4f}", part_of(across_m, &Summary::max));
  list.line(judge + " lag", "{lag_mean_mm:.4f}", part_of(errors, &PathErrors::lag_mean_m));
  list.unprinted("lag_max_mm", part_of(errors, &PathErrors::lag_max_m));
  row.append(list);
}

std::string headline(const PathRequest& path) {
  return fmt::format("{}: {:.1f} mm", path.file.string(), mm(path.path.length_m()));
}

}  // namespace

void add_path_plots(HtmlPage& page, const Path& path, const std::vector<PathLookRow>& looks,
                    const std::vector<PathSpeedResult>& results) {
  const std::vector<DrawnWay> ways = ways_along(looks);
  const std::vector<double> deviations = deviations_mm(ways);
  if (deviations.empty()) return;
  page.add_section(
      "Deviation by speed", speed_plot(results),
      "Distance of all looks from the path at each speed. Where one speed is off by more than the "
      "others, go slower.");
  const Map map(path, deviations);
  page.add_section(
      "The end point beside the path",
      panels_of(
          ways, [&](const std::string& title) { return map.blank(title); },
          [&](const Points& points) { return map.placed(points); }),
      "The panels share their scale. Deviation that is the same at every speed is the arm's or the "
      "calibration's; it is in truth alone where vision cannot see it.");
  const Axis along{"along the path, mm", 0.0, mm(path.length_m())};
  const Axis across = axis_over("deviation to the left, mm", deviations);
  const auto level = [&](const std::string& title) {
    Panel panel(title, along, across);
    panel.add_line({{along.from, 0.0}, {along.to, 0.0}});
    return panel;
  };
  page.add_section(
      "Deviation along the path",
      panels_of(ways, level, [](const Points& points) { return points; }),
      "Positive is on the left of the way. Steps and spikes are mostly where a motor reverses and "
      "its gear crosses its play.");
}

std::string path_page(const PathRequest& path, const std::vector<PathSpeedResult>& results,
                      const std::vector<PathLookRow>& looks) {
  HtmlPage page("Following the path " + path.file.filename().string());
  page.add_verdict(path_verdict(results));
  page.add_html(path_list(path, results).table_html("speeds"));
  page.add_paragraph(
      "Every look has its distance from the path: seen by vision itself, and true by a virtual "
      "cell's truth. Lag is how far the end point was behind its time.");
  add_path_plots(page, path.path, looks, results);
  return page.text();
}

ReportList path_demand_list(const PathRequest& path, const std::vector<PathDemand>& demands) {
  ReportList list;
  list.line("", headline(path));
  list.unprinted("path_length_mm", path.path.length_m());
  const auto list_demand = [&, i = 0U](ReportList& row, const PathDemand& demand) mutable {
    const double speed_m_s = path.speeds_m_s[i++];
    row.line("",
             "at {speed_mm_s:g} mm/s: {seconds:.1f} s; motor {fastest_motor} needs "
             "{speed_share:.0%} of its speed",
             speed_m_s, PathTiming(path.path, speed_m_s).duration_s(), demand.fastest_motor + 1,
             demand.speed_share);
  };
  list.rows("speeds", demands, list_demand, "");
  return list;
}

bool is_judged(const std::vector<PathSpeedResult>& results) {
  return std::any_of(results.begin(), results.end(),
                     [](const PathSpeedResult& result) { return result.truth.has_value(); });
}

ReportList path_list(const PathRequest& path, const std::vector<PathSpeedResult>& results) {
  ReportList list;
  list.unprinted("path_length_mm", path.path.length_m());
  const bool judged = is_judged(results);
  list.rows("speeds", results, [&](ReportList& row, const PathSpeedResult& result) {
    row.line("mm/s", "{speed_mm_s:g}", result.speed_m_s);
    row.line("guided by", "{guided_by}", name_in(kGuidances, result.guidance));
    row.line("looks", "{looks}", result.looks);
    list_errors(row, "seen", "_own_view", result.own_view);
    if (judged) list_errors(row, "true", "_truth", result.truth);
    row.line("status", "{status}", name(result.status));
    row.unprinted("reason", result.reason);
    row.unprinted("seconds", result.seconds);
  });
  list.show("speeds", headline(path) + "; deviation from the path, mm",
            ReportList::Shown::kAlsoInPrint);
  return list;
}

void write_path_run(const ServoRequest& request, const PathRequest& path, const PathRun& run) {
  YamlWriter yaml("run", "planar-servo");
  add_used(yaml, request, run.cell(), path.file);
  for (const PathSpeedResult& result : run.results())
    yaml.add(fmt::format("status_by_{}_at_{:g}_mm_s", name_in(kGuidances, result.guidance),
                         mm(result.speed_m_s)),
             name(result.status));
  write_file(request.folder.path / "run.yaml", yaml.text());
  write_file(request.folder.path / "report.html", path_page(path, run.results(), run.looks()));
}

}  // namespace planar

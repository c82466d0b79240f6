#include "planar_servo/run/path/path_report.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/yaml_writer.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/text_table.h"
#include "planar_servo/run/path/path_drawing.h"
#include "planar_servo/run/servo_report.h"

namespace planar {
namespace {

double in_mm(double metres) {
  return metres / kMillimetre;
}

std::string headline(const PathRequest& path) {
  return fmt::format("{}: {:.1f} mm", path.file.string(), in_mm(path.path.length_m()));
}

TextTable speed_table(const PathRequest& path, const std::vector<PathSpeedResult>& results) {
  TextTable table(headline(path) + "; deviation from the path, mm",
                  {"mm/s", "guided by", "looks", "own view: mean", "95 %", "max", "lag",
                   "truth: mean", "95 %", "max", "lag", "status"});
  for (const PathSpeedResult& result : results) {
    std::vector<std::string> cells{fmt::format("{:g}", in_mm(result.speed_m_s)),
                                   name_in(kGuidances, result.guidance),
                                   std::to_string(result.looks)};
    for (const auto& errors : {result.own_view, result.truth})
      for (const double value :
           errors ? std::vector<double>{errors->across_m.mean, errors->across_m.p95,
                                        errors->across_m.max, errors->lag_mean_m}
                  : std::vector<double>(4, std::numeric_limits<double>::quiet_NaN()))
        cells.push_back(std::isnan(value) ? "–" : fixed(in_mm(value), 4));
    cells.emplace_back(name(result.status));
    table.add_row(cells);
  }
  return table;
}

void add_errors(nlohmann::json& json, const std::string& judge,
                const std::optional<PathErrors>& errors) {
  if (!errors) return;
  json["deviation_mean_mm" + judge] = in_mm(errors->across_m.mean);
  json["deviation_p95_mm" + judge] = in_mm(errors->across_m.p95);
  json["deviation_max_mm" + judge] = in_mm(errors->across_m.max);
  json["lag_mean_mm" + judge] = in_mm(errors->lag_mean_m);
  json["lag_max_mm" + judge] = in_mm(errors->lag_max_m);
}

}  // namespace

std::string path_demand_text(const PathRequest& path, const std::vector<PathDemand>& demands) {
  std::string text = headline(path) + "\n";
  for (std::size_t i = 0; i < demands.size(); ++i)
    text += fmt::format("at {:g} mm/s: {:.1f} s; motor {} needs {:.0f} % of its speed\n",
                        in_mm(path.speeds_m_s[i]),
                        PathTiming(path.path, path.speeds_m_s[i]).duration_s(),
                        demands[i].fastest_motor + 1, 100.0 * demands[i].speed_share);
  return text;
}

nlohmann::json path_demand_json(const PathRequest& path, const std::vector<PathDemand>& demands) {
  nlohmann::json speeds = nlohmann::json::array();
  for (std::size_t i = 0; i < demands.size(); ++i)
    speeds.push_back({{"speed_mm_s", in_mm(path.speeds_m_s[i])},
                      {"seconds", PathTiming(path.path, path.speeds_m_s[i]).duration_s()},
                      {"fastest_motor", demands[i].fastest_motor + 1},
                      {"speed_share", demands[i].speed_share}});
  return {{"path_length_mm", in_mm(path.path.length_m())}, {"speeds", speeds}};
}

std::string path_text(const PathRequest& path, const std::vector<PathSpeedResult>& results) {
  return speed_table(path, results).plain_text();
}

nlohmann::json path_json(const PathRequest& path, const std::vector<PathSpeedResult>& results) {
  nlohmann::json speeds = nlohmann::json::array();
  for (const PathSpeedResult& result : results) {
    nlohmann::json row{{"guided_by", name_in(kGuidances, result.guidance)},
                       {"speed_mm_s", in_mm(result.speed_m_s)},
                       {"status", name(result.status)},
                       {"reason", result.reason},
                       {"looks", result.looks},
                       {"seconds", result.seconds}};
    add_errors(row, "_own_view", result.own_view);
    add_errors(row, "_truth", result.truth);
    speeds.push_back(row);
  }
  return {{"path_length_mm", in_mm(path.path.length_m())}, {"speeds", speeds}};
}

void write_path_run(const ServoRequest& request, const PathRequest& path, const PathRun& run) {
  YamlWriter yaml = YamlWriter::with_header("run", "planar-servo");
  yaml.add_inputs(input_records(run_inputs(request, path.file)));
  yaml.add("error_map_used", request.use_error_map);
  if (!run.accepted_stale().empty()) yaml.add("accepted_stale", run.accepted_stale());
  if (run.accepted_map()) yaml.add("accepted_map", *run.accepted_map());
  for (const PathSpeedResult& result : run.results())
    yaml.add(fmt::format("status_by_{}_at_{:g}_mm_s", name_in(kGuidances, result.guidance),
                         in_mm(result.speed_m_s)),
             name(result.status));
  HtmlPage page("planar-servo: " + path.file.filename().string());
  page.add_html(speed_table(path, run.results()).html());
  for (const PathSpeedResult& result : run.results())
    if (!result.reason.empty())
      page.add_paragraph(fmt::format("At {:g} mm/s, guided by {}: {}: {}.", in_mm(result.speed_m_s),
                                     name_in(kGuidances, result.guidance), name(result.status),
                                     result.reason));
  add_path_figures(page, path.path, run.looks(), run.results());
  write_file(request.out / "run.yaml", yaml.text());
  write_file(request.out / "report.html", page.text());
}

}  // namespace planar

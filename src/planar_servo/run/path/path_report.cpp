#include "planar_servo/run/path/path_report.h"

#include <fmt/format.h>

#include "planar_servo/core/units.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/yaml_writer.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/run/path/path_drawing.h"
#include "planar_servo/run/servo_report.h"

namespace planar {
namespace {

double in_mm(double metres) {
  return metres / kMillimetre;
}

void list_errors(ReportList& row, const std::string& judge, const std::string& suffix,
                 const std::optional<PathErrors>& errors) {
  const auto known = [&errors](double value) {
    return errors ? std::optional(value) : std::nullopt;
  };
  const auto& [across_m, lag_mean_m, lag_max_m] = errors.value_or(PathErrors());
  ReportList list(suffix);
  list.line(judge + ": mean", "{deviation_mean_mm:.4f}", known(across_m.mean));
  list.line("95 %", "{deviation_p95_mm:.4f}", known(across_m.p95));
  list.line("max", "{deviation_max_mm:.4f}", known(across_m.max));
  list.line("lag", "{lag_mean_mm:.4f}", known(lag_mean_m));
  list.unprinted("lag_max_mm", known(lag_max_m));
  row.append(list);
}

std::string headline(const PathRequest& path) {
  return fmt::format("{}: {:.1f} mm", path.file.string(), in_mm(path.path.length_m()));
}

}  // namespace

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

ReportList path_list(const PathRequest& path, const std::vector<PathSpeedResult>& results) {
  ReportList list;
  list.unprinted("path_length_mm", path.path.length_m());
  list.rows("speeds", results, [](ReportList& row, const PathSpeedResult& result) {
    row.line("mm/s", "{speed_mm_s:g}", result.speed_m_s);
    row.line("guided by", "{guided_by}", name_in(kGuidances, result.guidance));
    row.line("looks", "{looks}", result.looks);
    list_errors(row, "own view", "_own_view", result.own_view);
    list_errors(row, "truth", "_truth", result.truth);
    row.line("status", "{status}", name(result.status));
    row.unprinted("reason", result.reason);
    row.unprinted("seconds", result.seconds);
  });
  return list;
}

TextTable path_table(const PathRequest& path, const std::vector<PathSpeedResult>& results) {
  const ReportList list = path_list(path, results);
  return list.table(headline(path) + "; deviation from the path, mm", "speeds");
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
  page.add_html(path_table(path, run.results()).html());
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

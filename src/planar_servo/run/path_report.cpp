#include "planar_servo/run/path_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "planar_servo/core/units.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/yaml_writer.h"
#include "planar_servo/run/pages/path_page.h"
#include "planar_servo/run/servo_report.h"

namespace planar {
namespace {

void list_errors(ReportList& row, const std::string& judge, const std::string& suffix,
                 const std::optional<PathErrors>& errors) {
  const auto known = [&errors](double value) {
    return errors ? std::optional(value) : std::nullopt;
  };
  const auto& [across_m, lag_mean_m, lag_max_m] = errors.value_or(PathErrors());
  ReportList list(suffix);
  list.line(judge + " mean", "{deviation_mean_mm:.4f}", known(across_m.mean));
  list.line(judge + " 95 %", "{deviation_p95_mm:.4f}", known(across_m.p95));
  list.line(judge + " max", "{deviation_max_mm:.4f}", known(across_m.max));
  list.line(judge + " lag", "{lag_mean_mm:.4f}", known(lag_mean_m));
  list.unprinted("lag_max_mm", known(lag_max_m));
  row.append(list);
}

std::string headline(const PathRequest& path) {
  return fmt::format("{}: {:.1f} mm", path.file.string(), mm(path.path.length_m()));
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
  return list;
}

TextTable path_table(const PathRequest& path, const std::vector<PathSpeedResult>& results) {
  const ReportList list = path_list(path, results);
  return list.table(headline(path) + "; deviation from the path, mm", "speeds");
}

void write_path_run(const ServoRequest& request, const PathRequest& path, const PathRun& run) {
  YamlWriter yaml("run", "planar-servo");
  yaml.add_inputs(input_records(run_inputs(request, path.file)));
  yaml.add("error_map_used", request.use_error_map);
  if (!run.accepted_stale().empty()) yaml.add("accepted_stale", run.accepted_stale());
  if (run.accepted_map()) yaml.add("accepted_map", *run.accepted_map());
  for (const PathSpeedResult& result : run.results())
    yaml.add(fmt::format("status_by_{}_at_{:g}_mm_s", name_in(kGuidances, result.guidance),
                         mm(result.speed_m_s)),
             name(result.status));
  write_file(request.out / "run.yaml", yaml.text());
  write_file(request.out / "report.html", path_page(path, run.results(), run.looks()));
}

}  // namespace planar

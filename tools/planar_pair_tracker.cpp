#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "planar_servo/core/error.h"
#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"
#include "planar_servo/files/camera/camera_file.h"
#include "planar_servo/files/tables/plans.h"
#include "planar_servo/files/tool_file.h"
#include "planar_servo/files/workplane_file.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/offline/pairs/pair_tracker.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-pair-tracker",
    "Pairs what the camera saw with what a laser tracker measured; finds workplane and tool.",
    "planar-pair-tracker --cell cell.yaml --lamps lamps.csv --recording RECORDING "
    "[--workplane-from pairs|grid] --workplane-out workplane.yaml --tool-out tool.yaml "
    "-o pairs.csv",
    "  datum      3 monuments, rms 0.004 mm\n"
    "  workplane  6 degrees of freedom fitted to 247 places, rms 0.312 mm\n"
    "  tool       end point (0.402, -0.698) mm, reflector (12.001, 31.004) mm\n"
    "  rejected   train_017: vision and tracker differ by 3.214 mm; the limit is 1.820 mm\n"
    "  raw error  train: 199 pairs, mean 0.301 mm, rms 0.343 mm, max 0.912 mm"};

constexpr double kDatumSigmas = 5.0;  // of one reading; what noise alone never reaches

struct Options {
  std::filesystem::path cell, lamps, recording, tracker, workplane_out, tool_out, pairs_out;
  std::string workplane_from{"pairs"}, grid, pair_by{"id"}, columns;
  char separator{','};
  bool decimal_comma{false};
};

void add_options(CLI::App& app, Options& options) {
  app.add_option("--cell", options.cell, "the cell")->required()->type_name("FILE");
  app.add_option("--lamps", options.lamps, "lamps.csv made by planar-locate-lamps")
      ->required()
      ->type_name("FILE");
  app.add_option("--recording", options.recording, "folder made by planar-record")
      ->required()
      ->type_name("DIR");
  app.add_option("--workplane-from", options.workplane_from,
                 "what gives the plane's height and tilt")
      ->check(CLI::IsMember({"pairs", "grid"}))
      ->capture_default_str();
  app.add_option("--grid", options.grid, "board on the plane, circles:COLSxROWS:PITCHmm")
      ->type_name("BOARD");
  app.add_option("--pair-by", options.pair_by, "how frames and readings belong together")
      ->check(CLI::IsMember({"id", "time"}))
      ->capture_default_str();
  app.add_option("--tracker", options.tracker, "readings; without it RECORDING/tracker.csv")
      ->type_name("FILE");
  app.add_option("--tracker-columns", options.columns, "names in that table: x=X,y=Y,z=Z,id=NAME");
  app.add_option("--separator", options.separator, "between the columns of that table")
      ->capture_default_str();
  app.add_flag("--decimal-comma", options.decimal_comma, "numbers of that table are like 1,5");
  app.add_option("--workplane-out", options.workplane_out, "workplane.yaml to write")
      ->required()
      ->type_name("FILE");
  app.add_option("--tool-out", options.tool_out, "tool.yaml to write")
      ->required()
      ->type_name("FILE");
  app.add_option("-o,--out", options.pairs_out, "pairs.csv to write")
      ->required()
      ->type_name("FILE");
}

/// x=X,y=Y: our column (with its unit, if it has one) -> theirs.
std::map<std::string, std::string> renamed_columns(const std::string& text) {
  static const std::map<std::string, std::string> ours{
      {"id", "id"}, {"t", "t_s"}, {"x", "x_mm"}, {"y", "y_mm"}, {"z", "z_mm"}};
  std::map<std::string, std::string> renamed;
  for (const std::string& item : CLI::detail::split(text, ',')) {
    const std::size_t equals = item.find('=');
    const auto known = ours.find(item.substr(0, equals));
    if (item.empty()) continue;
    if (equals == std::string::npos || known == ours.end()) {
      throw InputError("--tracker-columns has '" + item +
                       "'; items like x=X are needed, of id, t, x, y, z");
    }
    renamed[known->second] = item.substr(equals + 1);
  }
  return renamed;
}

/// The cell's camera, when it was calibrated for images of the cell's size.
CameraModel read_cell_camera(const CellSettings& cell) {
  const CameraRecord record =
      read_camera(require_made(cell.camera_model, "planar-calibrate-camera"));
  if (record.width_px != cell.camera.width_px || record.height_px != cell.camera.height_px) {
    throw InputError(fmt::format("{}: is of a camera with {} x {} px; the cell's has {} x {} px",
                                 cell.camera_model.string(), record.width_px, record.height_px,
                                 cell.camera.width_px, cell.camera.height_px));
  }
  return record.camera;
}

std::vector<std::filesystem::path> inputs_of(const Options& options, const CellSettings& cell) {
  return {options.cell, cell.camera_model, options.lamps, options.recording / "frames.csv",
          options.tracker.empty() ? options.recording / "tracker.csv" : options.tracker};
}

void require_outputs(const Options& options, const CellSettings& cell) {
  if (options.workplane_out == options.tool_out || options.workplane_out == options.pairs_out ||
      options.tool_out == options.pairs_out) {
    throw InputError("--workplane-out, --tool-out and -o name the same file; give each its own");
  }
  for (const auto& output : {options.workplane_out, options.tool_out, options.pairs_out}) {
    require_writable(output);
    for (const auto& input : inputs_of(options, cell)) require_not_input(output, input);
  }
}

PairTrackerRequest read_request(const Options& options) {
  if (options.decimal_comma && options.separator == ',')
    throw InputError("--decimal-comma needs another --separator than ',', such as ';'");
  PairTrackerRequest request;
  request.cell = read_cell(options.cell);
  require_outputs(options, request.cell);
  request.camera = read_cell_camera(request.cell);
  request.lamps = read_lamps(options.lamps);
  request.frames = read_frames(options.recording);
  request.tracker =
      read_tracker(options.tracker.empty() ? options.recording / "tracker.csv" : options.tracker,
                   {options.separator, options.decimal_comma, renamed_columns(options.columns)});
  request.by = options.pair_by == "time" ? PairBy::kTime : PairBy::kId;
  if (options.workplane_from == "grid") {
    if (options.grid.empty()) {
      throw InputError("--workplane-from grid needs --grid circles:COLSxROWS:PITCHmm");
    }
    request.boards_on_plane = boards_on_plane(options.recording, request.frames, request.camera,
                                              parse_board(options.grid));
  }
  return request;
}

void write_files(const Options& options, const CellSettings& cell, const WorkplaneFit& fit,
                 const std::vector<PairRow>& pairs) {
  const std::vector<std::filesystem::path> inputs = inputs_of(options, cell);
  write_file(options.workplane_out,
             workplane_text({fit.X_WC, fit.covariance, options.workplane_from, fit.absorbed,
                             static_cast<int>(fit.n_used), fit.rms},
                            kText.name, inputs));
  write_file(options.tool_out, tool_text(fit.tool, kText.name, inputs));
  write_file(options.pairs_out, pairs_text(pairs));
}

void print_raw_errors(const std::vector<PairRow>& pairs) {
  for (const std::string& plan : plan_names()) {
    if (std::none_of(pairs.begin(), pairs.end(),
                     [&](const PairRow& pair) { return pair.plan == plan; })) {
      continue;
    }
    const Summary raw = raw_error(pairs, plan);
    fmt::print("raw error  {}: {} pairs, mean {:.3f} mm, rms {:.3f} mm, max {:.3f} mm\n", plan,
               raw.n, raw.mean / kMillimetre, raw.rms / kMillimetre, raw.max / kMillimetre);
  }
}

nlohmann::json print(const PairTrackerReport& report) {
  const WorkplaneFit& fit = report.workplane;
  const Eigen::Vector2d p_TP = fit.tool.p_TP / kMillimetre;
  const Eigen::Vector3d p_TS = fit.tool.p_TS / kMillimetre;
  fmt::print("datum      {} monuments, rms {:.3f} mm\n", report.datum.residuals.size(),
             report.datum.rms / kMillimetre);
  fmt::print("workplane  {} degrees of freedom fitted to {} places, rms {:.3f} mm\n", fit.absorbed,
             fit.n_used, fit.rms / kMillimetre);
  fmt::print("tool       end point ({}) mm, reflector ({}) mm\n", fixed(p_TP, 3, ", "),
             fixed(p_TS.head<2>(), 3, ", "));
  fmt::print("lamps      eccentricity of their discs up to {:.4f} px, taken off\n",
             report.largest_eccentricity_px);
  auto rejected = nlohmann::json::array();
  for (const Rejection& rejection : report.rejected) {
    fmt::print("rejected   {}: {}\n", rejection.id, rejection.reason);
    rejected.push_back({{"id", rejection.id}, {"reason", rejection.reason}});
  }
  print_raw_errors(report.pairs);
  const Summary raw = raw_error(report.pairs);
  return {{"pairs", report.pairs.size()},
          {"rejected", rejected},
          {"datum_rms_mm", report.datum.rms / kMillimetre},
          {"workplane_rms_mm", fit.rms / kMillimetre},
          {"workplane_absorbed", fit.absorbed},
          {"eccentricity_px_max", report.largest_eccentricity_px},
          {"p_TP_mm", {p_TP.x(), p_TP.y()}},
          {"p_TS_mm", {p_TS.x(), p_TS.y(), p_TS.z()}},
          {"raw_mean_mm", raw.mean / kMillimetre},
          {"raw_rms_mm", raw.rms / kMillimetre}};
}

void warn_of_moved_monuments(const PairTrackerRequest& request, double datum_rms) {
  double sigma = 0.0;
  for (const TrackerRow& row : request.tracker)
    sigma = std::max(sigma, request.cell.tracker_sigma_at(row.p_L.norm()));
  if (datum_rms > kDatumSigmas * sigma)
    spdlog::warn(
        "datum: {:.3f} mm rms is more than the tracker's noise of {:.3f} mm explains; has "
        "a monument moved?",
        datum_rms / kMillimetre, sigma / kMillimetre);
}

Outcome pair(const Options& options) {
  const PairTrackerRequest request = read_request(options);
  const PairTrackerReport report = pair_tracker(request);
  write_files(options, request.cell, report.workplane, report.pairs);
  warn_of_moved_monuments(request, report.datum.rms);
  return {print(report)};
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::pair);
}

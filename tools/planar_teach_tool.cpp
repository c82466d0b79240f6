#include "jog_session.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/tool_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/grey_image.h"
#include "planar_servo/work/workpiece/seen_tip.h"
#include "program.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

const ProgramText kText{
    "planar-teach-tool",
    "planar-teach-tool --cell cell.yaml -o tool.yaml [--poses taught.csv] [--sigma-mm S]\n"
    "       planar-teach-tool --cell cell.yaml --check tool.yaml [--poses taught.csv]\n"
    "       planar-teach-tool --cell cell.yaml -o tool.yaml --seen bright_disc|dark_disc --size-mm "
    "D\n"
    "                         --height-mm H [--height-sigma-mm S] --poses taught.csv --image "
    "FILE...",
    R"(tip                 (29.997, 0.012) mm from the end point, in the tool's frame
deviation           (0.0141, 0.0143) mm
poses               4, up to 0.0210 mm from the mark
mark                (250.004, 120.013) mm)"};

struct Options {
  fs::path cell, out, check, poses;
  double sigma_mm{0.02};
  std::string seen;  ///< the kind of a disc at the tip; empty: none is seen
  double size_mm{0.0}, height_mm{0.0}, height_sigma_mm{0.1};
  std::vector<fs::path> images;
};

void add_disc_options(CLI::App& app, Options& options, CLI::Option* check) {
  auto* seen = add_value(app, "--seen", options.seen, "KIND",
                         "the tip shows this disc to the camera: its place follows from "
                         "pictures, and no mark is needed")
                   ->check(CLI::IsMember({"bright_disc", "dark_disc"}))
                   ->excludes(check);
  const auto add = [&](const char* name, double& value, const char* type, const char* text) {
    return add_value(app, name, value, type, text)->needs(seen);
  };
  seen->needs(
      add("--size-mm", options.size_mm, "D", "the disc's diameter")->check(CLI::PositiveNumber));
  seen->needs(add("--height-mm", options.height_mm, "H",
                  "the disc's height over the lamps, negative below them"));
  add("--height-sigma-mm", options.height_sigma_mm, "S", "standard deviation of that height")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  seen->needs(add_value(app, "--image", options.images, "FILE",
                        "a whole picture of each pose, in the order of the table, as planar-jog "
                        "saves it")
                  ->needs(seen));
}

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "cell.yaml", "the cell");
  auto* what = app.add_option_group("what to do");
  add_value(*what, "-o,--out", options.out, "tool.yaml",
            "find the tip, and write its file, which the cell names under tools");
  CLI::Option* check = add_value(
      *what, "--check", options.check, "tool.yaml",
      "say whether the tip still is where this file has it, by one pose at the same mark");
  what->require_option(1);
  add_value(app, "--poses", options.poses, "taught.csv",
            "places that planar-jog taught with the tip at one mark, in three directions or more; "
            "without it commands as planar-jog has them are read now, and 'teach ID' takes a pose");
  add_default(app, "--sigma-mm", options.sigma_mm, "S",
              "standard deviation per axis with which the tip was brought to the mark; 0.02 is "
              "that of a person with a magnifier")
      ->check(CLI::PositiveNumber);
  add_disc_options(app, options, check);
}

/// Returns the poses of a table, or of a session that begins now and keeps them beside the file.
std::vector<TipAtMark> poses_of(const Options& options, const CellSettings& cell) {
  fs::path table = options.poses;
  if (table.empty()) {
    table = (options.out.empty() ? options.check : options.out).string() + ".poses.csv";
    if (fs::exists(table))
      throw InputError({"exists already", "give it with --poses, or take it away to begin anew",
                        table, Cause::kExists});
    if (!jog_by_lines(cell, table).success)
      throw WorkError("a command failed, so the poses before it are not used",
                      Cause::kInsufficient);
    if (!fs::exists(table))
      throw InputError({"no pose was taught", "bring the tip to the mark, then 'teach ID'", "",
                        Cause::kMissing});
  }
  std::vector<TipAtMark> poses;
  for (const TargetRow& row : read_targets(table)) {
    if (!row.phi_d)
      throw InputError({"has a place without a direction", "teach places with planar-jog", table,
                        Cause::kMissing});
    poses.push_back({row.id, {row.p_d, *row.phi_d}});
  }
  return poses;
}

/// Returns the tip, by a mark to which it was brought or by a disc that it shows.
TaughtTip taught_by(const Options& options, const CellSettings& cell) {
  const std::vector<TipAtMark> poses = poses_of(options, cell);
  if (options.seen.empty()) return teach_tip(poses, options.sigma_mm * kMillimetre);
  Fiducial disc;
  disc.id = "the tip";
  disc.kind = value_named(kFiducialKinds, options.seen).value();
  disc.size = options.size_mm * kMillimetre;
  disc.z = options.height_mm * kMillimetre;
  disc.sigma_z = options.height_sigma_mm * kMillimetre;
  const bool has_map = fs::exists(cell.error_map);
  require_belonging(stale_files(cell, has_map));
  const VisionCalibration vision = read_vision(cell, has_map);
  const SeenTip seen = see_tip(saved_frames(options.images, cell), poses, vision, disc);
  TaughtTip taught = teach_tip(seen.poses, seen.sigma);
  require_height(taught, seen, vision, poses);
  add_height_doubt(taught, vision, disc);
  return taught;
}

Outcome teach(const Options& options, const CellSettings& cell) {
  require_writable(options.out, "tool_tip");
  if (!options.seen.empty() && options.poses.empty())
    throw InputError(Refusal{"--seen needs --poses", "name the table that planar-jog taught"});
  const std::vector<Origin> origins = tool_tip_origins(cell);
  const TaughtTip taught = taught_by(options, cell);
  write_file(options.out, tool_tip_text(taught, origins, kText.name));
  double farthest = 0.0;
  for (const Eigen::Vector2d& residual : taught.residuals)
    farthest = std::max(farthest, residual.norm());
  ReportList list;
  list.line("tip", "({p_TE_mm:.3f}) mm from the end point, in the tool's frame", taught.tip.p_TE);
  list.line("deviation", "({deviation_mm:.4f}) mm",
            Eigen::Vector2d(taught.tip.covariance.diagonal().cwiseSqrt()));
  list.line("poses", "{poses}, up to {largest_residual_mm:.4f} mm from the mark",
            taught.residuals.size(), farthest);
  list.line(options.seen.empty() ? "mark" : "common to all", "({mark_mm:.3f}) mm", taught.mark_B);
  return told(list);
}

Outcome check(const Options& options, const CellSettings& cell) {
  constexpr double kSigmas = 3.0;
  const TaughtTip taught = read_tool_tip(options.check);
  require_made_with({Role::kToolTip, options.check}, tool_tip_origins(cell), false);
  bool is_there = true;
  ReportList list;
  std::vector<std::pair<std::string, TipMiss>> misses;
  for (const TipAtMark& at : poses_of(options, cell)) {
    misses.emplace_back(at.id, miss_of(taught, at.pose));
    const TipMiss& miss = misses.back().second;
    is_there = is_there && miss.off.cwiseAbs().maxCoeff() < kSigmas * miss.sigma;
  }
  list.rows(
      "poses", misses,
      [](ReportList& row, const std::pair<std::string, TipMiss>& at) {
        row.line("pose", "{pose}", at.first);
        row.line("off", "the tip is off by ({off_mm:.4f}) mm", at.second.off);
        row.line("deviation", "+- {sigma_mm:.4f} mm per axis", at.second.sigma);
      },
      "", ": ");
  list.unprinted("is_there", is_there);
  say("{}{}\n", list.text(),
      is_there ? "the tip is where its file has it"
               : "the tip is no longer where its file has it: teach it again");
  return {list.json(), is_there};
}

Outcome work(const Options& options) {
  const CellSettings cell = read_cell(options.cell);
  return options.check.empty() ? teach(options, cell) : check(options, cell);
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::work);
}

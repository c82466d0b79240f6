#include "planar_servo/console/doctor/doctor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/files/tool_file.h"
#include "planar_servo/geometry/lens/workplane.h"
#include "planar_servo/lamps/lamp_center.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/machine/plausibility.h"
#include "planar_servo/work/jog/lamp_finder.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

/// Returns the different programs of this name in the folders, in their order, without links.
std::vector<std::string> programs_named(const fs::path& name, const std::string& folders) {
  std::vector<std::string> programs;
  std::istringstream rest(folders);
  for (std::string folder; std::getline(rest, folder, ':');) {
    std::error_code absent;
    const std::string program = fs::canonical(fs::path(folder) / name, absent).string();
    if (!absent && std::find(programs.begin(), programs.end(), program) == programs.end())
      programs.push_back(program);
  }
  return programs;
}

constexpr int kPlaces = 500;
constexpr char kSubject[] = "camera's field";

bool is_seen(const CameraSettings& camera, const Workplane& workplane, const Eigen::Vector2d& p_B) {
  const auto uv_px = workplane.pixel_from_plane(p_B);
  return uv_px && uv_px->minCoeff() >= 0.0 && uv_px->x() <= camera.width_px - 1.0 &&
         uv_px->y() <= camera.height_px - 1.0;
}

std::vector<Finding> question_field(const CellSettings& cell, const Workplane& workplane) {
  const std::vector<Eigen::Vector2d> places = reachable_places(cell);
  std::vector<Eigen::Vector2d> unseen;
  unseen.reserve(places.size());
  for (const Eigen::Vector2d& p_B : places)
    if (!is_seen(cell.camera, workplane, p_B)) unseen.push_back(p_B);
  if (unseen.empty()) return {};
  const double percent =
      100.0 * static_cast<double>(unseen.size()) / static_cast<double>(places.size());
  const Eigen::Vector2d example_mm = unseen.front() / kMillimetre;
  return {{{fmt::format("the camera does not see {:.0f} % of the places that workspace and joints "
                        "allow, such as ({:.0f}, {:.0f}) mm",
                        std::ceil(percent), example_mm.x(), example_mm.y()),
            "make workspace.radius_max_mm smaller, or raise the camera and calibrate again",
            kSubject, Cause::kUnreachable},
           Finding::Verdict::kDoubtful}};
}

using Verdict = Finding::Verdict;

std::string origin_text(const fs::path& file) {
  const std::string maker = read_maker(file);
  if (maker.empty()) return "its origin is unknown";
  std::vector<std::string> names;
  for (const Origin& origin : read_origins(file)) names.push_back(origin.name);
  if (names.empty()) return fmt::format("made by {}", maker);
  return fmt::format("made by {} from {}", maker, fmt::join(names, ", "));
}

Finding examine_file(const MadeFile& file, const std::vector<Finding>& reasons) {
  const std::string name = file.path.filename().string();
  if (!fs::exists(file.path))
    return {{fmt::format("does not exist yet; {} makes it", program_for(file.role)), "", name},
            Verdict::kWell};
  if (reasons.empty()) return {{origin_text(file.path), "", name}, Verdict::kWell};
  return {{origin_text(file.path), "", name, reasons.front().cause}, Verdict::kFaulty};
}

/// Reads a file as the programs that use it do, which throws InputError where they would. Some
/// accept an error map that its own fit rejects; the reason is returned.
std::optional<Refusal> objection_of(const CellSettings& cell, const MadeFile& file) {
  switch (file.role) {
    case Role::kCamera:
      read_cell_camera(cell);
      break;
    case Role::kWorkplane:
      require_reference_lamps(cell, read_workplane(file.path).reference_lamps);
      break;
    case Role::kTool:
      read_tool(file.path);
      break;
    case Role::kToolTip:
      read_tool_tip(file.path);
      require_made_with(file, tool_tip_origins(cell), false);
      break;
    case Role::kErrorMap:
      return objection(read_map(file.path).quality);
    case Role::kHealth:
      read_health(file.path);
      break;
    case Role::kArmFound:
      read_found_arm(file.path);
      break;
    default:
      throw std::logic_error("the doctor reads calibration files only");
  }
  return std::nullopt;
}

/// Says what is wrong in a file itself.
std::vector<Finding> examine_content(const CellSettings& cell, const MadeFile& file) {
  const std::string name = file.path.filename().string();
  if (!fs::exists(file.path)) return {};
  if (const auto change = later_change(file.path, read_file(file.path)))
    return {faulty(name, *change)};
  try {
    const auto against = objection_of(cell, file);
    if (!against) return {};
    return {faulty(
        name, *against,
        "record more places and fit again; planar-servo moves by it only with --accept-map")};
  } catch (const InputError& error) {
    return {{{error.what(), fmt::format("make it again with {}", program_for(file.role)), name,
              error.refusal().cause},
             Verdict::kFaulty}};
  }
}

constexpr Named<Verdict> kVerdicts[] = {
    {Verdict::kWell, "well"}, {Verdict::kDoubtful, "doubtful"}, {Verdict::kFaulty, "faulty"}};

}  // namespace

std::vector<Finding> question_installations(const fs::path& own, const std::string& folders) {
  if (own.empty()) return {};
  std::vector<std::string> others = programs_named(own.filename(), folders);
  others.erase(std::remove(others.begin(), others.end(), own.string()), others.end());
  if (others.empty()) return {};
  return {
      {{fmt::format("this is {}, but PATH also finds {}: without a folder a command may start a "
                    "program of another version",
                    own.string(), fmt::join(others, " and ")),
        "name the folder in each command, or remove one: apt remove planar-servo removes the "
        "package, and what a checkout installed is listed in build/release/install_manifest.txt",
        "programs", Cause::kExists},
       Finding::Verdict::kDoubtful}};
}

std::vector<Eigen::Vector2d> reachable_places(const CellSettings& cell) {
  const JointPlanner planner = joint_planner(cell);
  const Eigen::Matrix2Xd all = spiral_over_disc(cell.workspace.radius_max_m, kPlaces);
  std::vector<Eigen::Vector2d> places;
  for (const Eigen::Vector2d p_B : all.colwise())
    if (!planner.plan({p_B, cell.tool_orientation}, cell.arm.home).refusal) places.push_back(p_B);
  return places;
}

std::vector<Finding> examine_files(const CellSettings& cell) {
  std::vector<Finding> findings;
  const std::vector<StaleFile> all_stale = stale_files(cell, true);
  std::vector<MadeFile> files = made_files(cell, true);
  for (const auto& [name, tip] : cell.tools) files.push_back({Role::kToolTip, tip});
  for (const MadeFile& file : files) {
    std::vector<Finding> reasons = examine_content(cell, file);
    for (const StaleFile& stale : all_stale)
      if (stale.path == file.path) reasons.push_back(faulty(file.path.filename().string(), stale));
    findings.push_back(examine_file(file, reasons));
    findings.insert(findings.end(), reasons.begin(), reasons.end());
  }
  return findings;
}

std::vector<Finding> question_camera_field(const CellSettings& cell) {
  if (!fs::exists(cell.camera_model) || !fs::exists(cell.workplane)) return {};
  try {
    return question_field(cell, {read_cell_camera(cell), read_workplane(cell.workplane).X_WC});
  } catch (const InputError& error) {
    return {{{error.what(), "make the file again, or name another one in the cell file", kSubject,
              error.refusal().cause},
             Finding::Verdict::kFaulty}};
  }
}

std::vector<Finding> examine_lamps(FrameSource& camera) {
  camera.set_region({{}, camera.sensor_size_px()});
  const FrameResult seen = camera.next_frame();
  if (seen.status != FrameStatus::kOk)
    return {{{fmt::format("no picture: {}", name(seen.status)), "look at the camera again", "lamps",
              Cause::kDevice},
             Finding::Verdict::kDoubtful}};
  const auto lamps = sight_lamps(seen.frame, {});
  if (!lamps)
    return {{{"no two lamps are in view, whose levels would be shown here", "", "lamps"},
             Finding::Verdict::kWell}};
  std::vector<Finding> findings;
  for (const LampCenter& lamp : lamps->lamps) {
    const cv::Mat& image = seen.frame.image;
    const cv::Rect around =
        window_round(lamp.uv_px, 1.5 * lamp.diameter_px) & cv::Rect({}, image.size());
    const LampLevels levels = read_lamp_levels(image(around));
    findings.push_back(
        {{levels.text(), levels.remedy(),
          fmt::format("lamp at ({:.0f}, {:.0f}) px", lamp.uv_px.x(), lamp.uv_px.y())},
         levels.remedy().empty() ? Finding::Verdict::kWell : Finding::Verdict::kDoubtful});
  }
  return findings;
}

std::vector<Finding> examine_cell(const fs::path& cell_file) {
  const CellSettings cell = read_cell(cell_file);
  require_devices(cell);
  std::vector<Finding> findings{
      {{cell_file.string() + " is in order", "", "cell file"}, Finding::Verdict::kWell}};
  const auto add = [&](const std::vector<Finding>& more) {
    findings.insert(findings.end(), more.begin(), more.end());
    return is_sound(more);
  };
  add(question_values(cell));
  add(examine_files(cell));
  if (is_sound(findings)) add(question_camera_field(cell));
  add(cell.drives[0].kind->examine(cell));
  const CameraKind& camera = *cell.camera.kind;
  if (add(camera.examine(cell)) && !camera.is_virtual() && !camera.refusal()) try {
      add(examine_lamps(*camera.open(cell)));
    } catch (const WorkError& error) {
      add({faulty("lamps", error.refusal())});
    }
  add(cell.tracker.kind->examine(cell));
  return findings;
}

bool is_sound(const std::vector<Finding>& findings) {
  return std::none_of(findings.begin(), findings.end(), [](const Finding& finding) {
    return finding.verdict == Finding::Verdict::kFaulty;
  });
}

std::string findings_text(const std::vector<Finding>& findings) {
  std::string text;
  for (const Finding& finding : findings) {
    text += fmt::format("{:9} {}: {}\n", name_in(kVerdicts, finding.verdict), finding.where,
                        finding.fault);
    if (!finding.remedy.empty()) text += fmt::format("          -> {}\n", finding.remedy);
  }
  return text;
}

nlohmann::json findings_json(const std::vector<Finding>& findings) {
  nlohmann::json rows = nlohmann::json::array();
  for (const Finding& finding : findings) {
    rows.push_back({{"verdict", name_in(kVerdicts, finding.verdict)},
                    {"subject", finding.where},
                    {"what", finding.fault},
                    {"remedy", finding.remedy}});
    if (finding.verdict != Finding::Verdict::kWell) rows.back()["cause"] = to_text(finding.cause);
  }
  return {{"findings", rows}};
}

}  // namespace planar

#include "planar_servo/doctor/camera_field.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "planar_servo/core/error.h"
#include "planar_servo/core/plane_geometry.h"
#include "planar_servo/core/units.h"
#include "planar_servo/files/vision_files.h"
#include "planar_servo/files/workplane_file.h"
#include "planar_servo/lens/workplane.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

constexpr int kPlaces = 500;
constexpr char kSubject[] = "camera's field";

/// Returns places that fill the workspace evenly, as far as the arm reaches.
std::vector<Eigen::Vector2d> reachable_places(const CellSettings& cell) {
  const JointPlanner planner = joint_planner(cell);
  const double golden_turn = kPi * (3.0 - std::sqrt(5.0));
  std::vector<Eigen::Vector2d> places;
  places.reserve(kPlaces);
  for (int i = 0; i < kPlaces; ++i) {
    const double radius_m = cell.workspace.radius_max_m * std::sqrt((i + 0.5) / kPlaces);
    const Eigen::Vector2d p_B = radius_m * rotation2d(i * golden_turn).col(0);
    if (!planner.plan({p_B, cell.tool_orientation}, cell.arm.home).refusal) places.push_back(p_B);
  }
  return places;
}

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
  return {{Finding::Verdict::kDoubtful, kSubject,
           fmt::format("the camera does not see {:.0f} % of the places that workspace and joints "
                       "allow, such as ({:.0f}, {:.0f}) mm",
                       std::ceil(percent), example_mm.x(), example_mm.y()),
           "make workspace.radius_max_mm smaller, or raise the camera and calibrate again"}};
}

}  // namespace

std::vector<Finding> question_camera_field(const CellSettings& cell) {
  if (!fs::exists(cell.camera_model) || !fs::exists(cell.workplane)) return {};
  try {
    return question_field(cell, {read_cell_camera(cell), read_workplane(cell.workplane).X_WC});
  } catch (const InputError& error) {
    return {{Finding::Verdict::kFaulty, kSubject, error.what(),
             "make the file again, or name another one in the cell file"}};
  }
}

}  // namespace planar

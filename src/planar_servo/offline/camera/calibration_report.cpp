#include "planar_servo/offline/camera/calibration_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

nlohmann::json number_or_null(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

std::string judged_text(const CameraCalibration& found) {
  if (!found.held_out_rms_px) return "; too few views to judge it on views left out of the fit\n";
  return fmt::format(
      ", {:.3f} px in views left out of the fit\n"
      "expected error      {:.3f} mm in a plane at the grid's distance\n",
      *found.held_out_rms_px, *found.expected_error / kMillimetre);
}

}  // namespace

std::string calibration_text(const CameraCalibration& found) {
  const Intrinsics k = intrinsics(found.camera);
  const auto& sigma = found.standard_deviations;
  std::string text = fmt::format("images used         {} ({} rejected)\n", found.views.size(),
                                 found.rejected.size());
  for (const auto& [name, reason] : found.rejected) text += fmt::format("  {}: {}\n", name, reason);
  text += fmt::format("model               {}\n", found.model);
  text += fmt::format("focal lengths       {:.2f} +- {:.2f}, {:.2f} +- {:.2f} px\n", k.fx, sigma[0],
                      k.fy, sigma[1]);
  text += fmt::format("principal point     {:.2f} +- {:.2f}, {:.2f} +- {:.2f} px\n", k.cx, sigma[2],
                      k.cy, sigma[3]);
  text += "distortion         ";
  for (const double c : distortion_coefficients(found.camera)) text += fmt::format(" {:.4g}", c);
  text += fmt::format("\nresiduals           {:.3f} px rms", found.rms_px) + judged_text(found);
  text += fmt::format("over that plane     {:.4f} mm by the camera's model, at most {:.4f} mm\n",
                      found.plane_error.mean() / kMillimetre,
                      found.plane_error.largest() / kMillimetre);
  for (const CalibratedView& view : found.views)
    text += fmt::format("  {:<18}  {:.3f} px\n", view.name, view.rms_px);
  return text;
}

nlohmann::json calibration_json(const CameraCalibration& found) {
  const Intrinsics k = intrinsics(found.camera);
  nlohmann::json views = nlohmann::json::array();
  for (const CalibratedView& view : found.views)
    views.push_back({{"image", view.name}, {"rms_px", view.rms_px}});
  nlohmann::json rejected = nlohmann::json::array();
  for (const auto& [name, reason] : found.rejected)
    rejected.push_back({{"image", name}, {"reason", reason}});
  auto expected_error_mm = found.expected_error;
  if (expected_error_mm) *expected_error_mm /= kMillimetre;
  return {{"rms_px", found.rms_px},
          {"images_used", found.views.size()},
          {"images_rejected", found.rejected.size()},
          {"model", found.model},
          {"camera_matrix", {k.fx, 0.0, k.cx, 0.0, k.fy, k.cy, 0.0, 0.0, 1.0}},
          {"distortion_coefficients", distortion_coefficients(found.camera)},
          {"standard_deviations", found.standard_deviations},
          {"held_out_rms_px", number_or_null(found.held_out_rms_px)},
          {"expected_error_mm", number_or_null(expected_error_mm)},
          {"plane_error_mean_mm", found.plane_error.mean() / kMillimetre},
          {"plane_error_max_mm", found.plane_error.largest() / kMillimetre},
          {"views", views},
          {"rejected", rejected}};
}

}  // namespace planar
